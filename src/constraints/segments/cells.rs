//! The cells of a k-d tree that a segment meets.
//!
//! A cell does not own its left and its bottom side. A segment that lies beside the cell and
//! touches one of these sides does not meet the cell. Such a segment may lie within the cell of its
//! ends, and then no other leaf may take it for a segment that passes through.

use crate::constraints::segment::Segment;
use crate::geometry::{Point, Rect, segment_meets};
use crate::store::format::cell_index::CellIndex;
use crate::store::{KdNode, KdTree};

/// Returns, for each leaf of a tree below a cell, the indices of the segments that meet the leaf's
/// cell, in ascending order. If the cell is infinite, some more may be among them.
pub(crate) fn segments_of_leaves(tree: &KdTree, cell: Rect, segments: &[Segment]) -> Vec<Vec<u32>> {
    /// Number of segments at a time.
    const SOME: usize = 1024;
    let mut leaves = vec![Vec::new(); tree.tiles() as usize];
    let mut cells = SegmentCells::new(tree, cell);
    for (segments, first) in segments.chunks(SOME).zip((0..).step_by(SOME)) {
        cells.for_each(segments, |leaf, at| leaves[leaf as usize].push(first + at as u32));
    }
    leaves
}

/// A search for the leaves of a k-d tree below a cell that segments meet.
#[derive(Debug)]
pub(crate) struct SegmentCells<'a> {
    tree: &'a KdTree,
    cell: Rect,
    index: CellIndex,
    /// The cell of each leaf.
    cells: Vec<Rect>,
    /// Nodes that are still to be examined.
    open: Vec<OpenNode>,
    /// The ends of segments, and the leaves that contain them.
    ends: Vec<Point>,
    leaves: Vec<u32>,
}

/// A node that a segment meets.
#[derive(Clone, Copy, Debug)]
struct OpenNode {
    node: u32,
    cell: Rect,
    /// Whether both ends are in the closed cell. Then the positions of the ends determine which
    /// children the segment meets.
    has_ends: bool,
}

impl<'a> SegmentCells<'a> {
    /// Prepares a tree whose root has the cell `cell`.
    pub(crate) fn new(tree: &'a KdTree, cell: Rect) -> Self {
        let cells = tree.node_cells_within(cell).into_iter().zip(tree.nodes());
        let of_leaves = cells.filter(|(_, node)| matches!(node, KdNode::Leaf(_)));
        Self {
            tree,
            cell,
            index: CellIndex::new(tree),
            cells: of_leaves.map(|(cell, _)| cell).collect(),
            open: Vec::new(),
            ends: Vec::new(),
            leaves: Vec::new(),
        }
    }

    /// Passes each leaf whose cell a segment meets to `take`, with the index of the segment.
    /// Indices ascend. All segments must meet the root's cell.
    pub(crate) fn for_each(&mut self, segments: &[Segment], mut take: impl FnMut(u32, usize)) {
        if self.cells.is_empty() {
            return;
        }
        self.ends.clear();
        self.ends.extend(segments.iter().flat_map(|segment| segment.ends));
        self.leaves.clear();
        self.index.cells_of(&self.ends, &mut self.leaves);
        for (index, segment) in segments.iter().enumerate() {
            // Most segments lie within a cell and touch none of its sides.
            let [leaf, other] = [self.leaves[2 * index], self.leaves[2 * index + 1]];
            let cell = self.cells[leaf as usize];
            let is_within = |p: Point| cell.min_x < p.x && p.x < cell.max_x && cell.min_y < p.y && p.y < cell.max_y;
            if leaf == other && is_within(segment.ends[0]) && is_within(segment.ends[1]) {
                take(leaf, index);
            } else {
                self.descend(segment.ends, |leaf| take(leaf, index));
            }
        }
    }

    fn descend(&mut self, ends: [Point; 2], mut take: impl FnMut(u32)) {
        let [a, b] = ends;
        self.open.push(OpenNode {
            node: 0,
            cell: self.cell,
            has_ends: self.cell.contains(a) && self.cell.contains(b),
        });
        while let Some(OpenNode { node, cell, has_ends }) = self.open.pop() {
            let (cut, low, high, right, along) = match self.tree.nodes()[node as usize] {
                KdNode::X { cut, right } => {
                    let (low, high) = (Rect { max_x: cut, ..cell }, Rect { min_x: cut, ..cell });
                    (cut, low, high, right, [a.x, b.x])
                }
                KdNode::Y { cut, right } => {
                    let (low, high) = (Rect { max_y: cut, ..cell }, Rect { min_y: cut, ..cell });
                    (cut, low, high, right, [a.y, b.y])
                }
                KdNode::Leaf(leaf) => {
                    take(leaf.0);
                    continue;
                }
            };
            let (least, most) = (along[0].min(along[1]), along[0].max(along[1]));
            let children = [
                (right, high, most > cut, least >= cut),
                (node + 1, low, least <= cut, most <= cut),
            ];
            for (node, cell, is_reached, has_both) in children {
                if is_reached && (has_ends || segment_meets(ends, cell)) {
                    self.open.push(OpenNode {
                        node,
                        cell,
                        has_ends: has_ends && has_both,
                    });
                }
            }
        }
    }
}

#[cfg(test)]
pub(crate) mod tests;
