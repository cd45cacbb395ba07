//! The k-d tree: the partition of the plane into cells, the order of the tiles, the index of the directory.

use crate::geometry::{Point, Rect, segment_meets};
use crate::store::format::damage::Damage;
use crate::store::format::ids::TileId;

/// A node of the k-d tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KdNode {
    /// Points with x up to and including `cut` are in the left child, which is the next node; others in node `right`.
    X {
        /// Where the cell is cut.
        cut: f64,
        /// The number of the right child.
        right: u32,
    },
    /// The same with y.
    Y {
        /// Where the cell is cut.
        cut: f64,
        /// The number of the right child.
        right: u32,
    },
    /// A cell that is not cut.
    Leaf(TileId),
}

/// A k-d tree in preorder: node 0 is the root, the left child follows its parent. Without tiles it is empty.
///
/// Cells are half-open: a cell owns its right and top side, not its left and bottom one. Outermost cells reach to infinity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KdTree {
    nodes: Vec<KdNode>,
    tiles: u32,
}

impl KdTree {
    /// The borders between cells, as far as they lie in a rectangle: a segment for each cut.
    pub(crate) fn borders(&self, within: Rect) -> Vec<[Point; 2]> {
        let mut borders = Vec::new();
        let mut open = vec![(0, within)];
        while let Some((node, cell)) = open.pop() {
            let Some(&cut) = self.nodes.get(node as usize) else {
                continue;
            };
            let (lower, upper, right, is_within) = match cut {
                KdNode::X { cut, right } => (
                    Rect { max_x: cut, ..cell },
                    Rect { min_x: cut, ..cell },
                    right,
                    cell.min_x < cut && cut < cell.max_x,
                ),
                KdNode::Y { cut, right } => (
                    Rect { max_y: cut, ..cell },
                    Rect { min_y: cut, ..cell },
                    right,
                    cell.min_y < cut && cut < cell.max_y,
                ),
                KdNode::Leaf(_) => continue,
            };
            if is_within {
                borders.push([
                    Point::new(upper.min_x, upper.min_y),
                    Point::new(lower.max_x, lower.max_y),
                ]);
            }
            // What lies beyond the rectangle has nothing of it.
            open.extend(
                [(right, upper), (node + 1, lower)]
                    .into_iter()
                    .filter(|(_, cell)| !cell.is_empty()),
            );
        }
        borders
    }

    /// Checks that `nodes` are a tree in preorder with leaves numbered from left to right; an error says what is wrong.
    pub(crate) fn new(nodes: Vec<KdNode>) -> Result<Self, Damage> {
        let mut tiles = 0;
        if nodes.is_empty() {
            return Ok(Self::default());
        }
        // The right children that are still to come, innermost last, and before them the end.
        let mut expected = vec![nodes.len() as u32];
        for (number, node) in (0u32..).zip(&nodes) {
            match *node {
                KdNode::X { cut, right } | KdNode::Y { cut, right } => {
                    if !cut.is_finite() {
                        return Err(Damage::new(format!("node {number} is cut at {cut}")));
                    }
                    expected.push(right);
                }
                KdNode::Leaf(tile) => {
                    if tile.0 != tiles {
                        return Err(Damage::new(format!("leaf {number} is tile {tile}, not {tiles}")));
                    }
                    tiles += 1;
                    if expected.pop() != Some(number + 1) {
                        return Err(Damage::new(format!(
                            "node {} does not belong behind node {number}",
                            number + 1
                        )));
                    }
                }
            }
        }
        if expected.is_empty() {
            Ok(Self { nodes, tiles })
        } else {
            Err(Damage::new(format!("node {} is missing", expected[expected.len() - 1])))
        }
    }

    /// The nodes in preorder.
    #[must_use]
    pub fn nodes(&self) -> &[KdNode] {
        &self.nodes
    }

    /// How many leaves there are.
    #[must_use]
    pub fn tiles(&self) -> u32 {
        self.tiles
    }

    /// How many cuts lie above the lowest leaf.
    pub(crate) fn depth(&self) -> usize {
        let mut depths = vec![0; self.nodes.len()];
        for (number, node) in self.nodes.iter().enumerate() {
            if let KdNode::X { right, .. } | KdNode::Y { right, .. } = *node {
                let below = depths[number] + 1;
                (depths[number + 1], depths[right as usize]) = (below, below);
            }
        }
        depths.into_iter().max().unwrap_or(0)
    }

    /// The tree with another in the place of each leaf; the leaves of these are numbered anew, from left to right.
    pub(crate) fn with_leaves_cut(&self, subtrees: &[Self]) -> Self {
        fn graft(tree: &KdTree, from: u32, subtrees: &[KdTree], out: &mut Vec<KdNode>, tiles: &mut u32) {
            match tree.nodes[from as usize] {
                node @ (KdNode::X { right, .. } | KdNode::Y { right, .. }) => {
                    let place = out.len();
                    out.push(node);
                    graft(tree, from + 1, subtrees, out, tiles);
                    let moved = out.len() as u32;
                    if let KdNode::X { right, .. } | KdNode::Y { right, .. } = &mut out[place] {
                        *right = moved;
                    }
                    graft(tree, right, subtrees, out, tiles);
                }
                KdNode::Leaf(leaf) => {
                    let (first, before) = (out.len() as u32, *tiles);
                    let subtree = &subtrees[leaf.0 as usize];
                    out.extend(subtree.nodes.iter().map(|&node| match node {
                        KdNode::X { cut, right } => KdNode::X {
                            cut,
                            right: right + first,
                        },
                        KdNode::Y { cut, right } => KdNode::Y {
                            cut,
                            right: right + first,
                        },
                        KdNode::Leaf(tile) => KdNode::Leaf(TileId(before + tile.0)),
                    }));
                    *tiles += subtree.tiles;
                }
            }
        }
        let (mut nodes, mut tiles) = (Vec::new(), 0);
        if !self.nodes.is_empty() {
            graft(self, 0, subtrees, &mut nodes, &mut tiles);
        }
        Self { nodes, tiles }
    }

    /// The tile whose cell contains `p`, or none if there are no tiles.
    #[must_use]
    pub fn tile_at(&self, p: Point) -> Option<TileId> {
        let mut node = 0u32;
        loop {
            node = match *self.nodes.get(node as usize)? {
                KdNode::X { cut, right } => {
                    if p.x <= cut {
                        node + 1
                    } else {
                        right
                    }
                }
                KdNode::Y { cut, right } => {
                    if p.y <= cut {
                        node + 1
                    } else {
                        right
                    }
                }
                KdNode::Leaf(tile) => return Some(tile),
            };
        }
    }

    /// Gives the tiles whose closed cells a segment meets, if the root's cell is this one.
    pub(crate) fn tiles_along(&self, root: Rect, ends: [Point; 2], mut take: impl FnMut(TileId)) {
        let [a, b] = ends;
        let mut open = Vec::new();
        if !self.nodes.is_empty() && segment_meets(ends, root) {
            open.push((0u32, root));
        }
        while let Some((node, cell)) = open.pop() {
            let (cut, right, [from, to], low, high) = match self.nodes[node as usize] {
                KdNode::X { cut, right } => {
                    let (low, high) = (Rect { max_x: cut, ..cell }, Rect { min_x: cut, ..cell });
                    (cut, right, [a.x, b.x], low, high)
                }
                KdNode::Y { cut, right } => {
                    let (low, high) = (Rect { max_y: cut, ..cell }, Rect { min_y: cut, ..cell });
                    (cut, right, [a.y, b.y], low, high)
                }
                KdNode::Leaf(tile) => {
                    take(tile);
                    continue;
                }
            };
            // It meets this cell. If it lies on one side of the cut, then also that side's cell.
            let is_parted = from.min(to) <= cut && cut <= from.max(to);
            for (child, cell, is_reached) in [(right, high, from.max(to) >= cut), (node + 1, low, from.min(to) <= cut)]
            {
                if is_reached && (!is_parted || segment_meets(ends, cell)) {
                    open.push((child, cell));
                }
            }
        }
    }

    /// The cell of every node, in preorder. Outer sides are infinite.
    #[must_use]
    pub fn node_cells(&self) -> Vec<Rect> {
        self.node_cells_within(Rect::PLANE)
    }

    /// The cell of every node, in preorder, if the root's is this one.
    pub(crate) fn node_cells_within(&self, root: Rect) -> Vec<Rect> {
        let mut cells = vec![root; self.nodes.len()];
        for (number, node) in self.nodes.iter().enumerate() {
            let cell = cells[number];
            let (mut low, mut high) = (cell, cell);
            let right = match *node {
                KdNode::X { cut, right } => {
                    (low.max_x, high.min_x) = (cut, cut);
                    right
                }
                KdNode::Y { cut, right } => {
                    (low.max_y, high.min_y) = (cut, cut);
                    right
                }
                KdNode::Leaf(_) => continue,
            };
            cells[number + 1] = low;
            cells[right as usize] = high;
        }
        cells
    }

    /// The cell of every tile, in order. Outer sides are infinite.
    #[must_use]
    pub fn cells(&self) -> Vec<Rect> {
        self.cells_within(Rect::PLANE)
    }

    /// The cell of every tile, in order, if the root's is this one.
    pub(crate) fn cells_within(&self, root: Rect) -> Vec<Rect> {
        let cells = self.node_cells_within(root).into_iter().zip(&self.nodes);
        cells
            .filter(|(_, node)| matches!(node, KdNode::Leaf(_)))
            .map(|(cell, _)| cell)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tree() -> Vec<KdNode> {
        vec![
            KdNode::X { cut: 1.0, right: 2 },
            KdNode::Leaf(TileId(0)),
            KdNode::Y { cut: 5.0, right: 4 },
            KdNode::Leaf(TileId(1)),
            KdNode::Leaf(TileId(2)),
        ]
    }

    #[test]
    fn points_on_a_cut_are_left_of_it() {
        let tree = KdTree::new(tree()).unwrap();
        let at = |x, y| tree.tile_at(Point::new(x, y)).unwrap().0;
        assert_eq!([at(1.0, 9.0), at(1.5, 5.0), at(1.5, 5.5)], [0, 1, 2]);
        assert_eq!(tree.cells()[1], Rect::new(1.0, f64::NEG_INFINITY, f64::INFINITY, 5.0));
        assert_eq!(KdTree::default().tile_at(Point::new(0.0, 0.0)), None);
    }

    #[test]
    fn leaves_are_cut() {
        let top = KdTree::new(tree()).unwrap();
        let leaf = KdTree::new(vec![KdNode::Leaf(TileId(0))]).unwrap();
        let whole = top.with_leaves_cut(&[leaf.clone(), top.clone(), leaf]);
        assert_eq!(KdTree::new(whole.nodes().to_vec()), Ok(whole.clone()));
        assert_eq!((whole.tiles(), whole.depth(), top.depth()), (5, 4, 2));
        // Left of the upper tree's second leaf's cuts.
        assert_eq!(whole.tile_at(Point::new(1.5, 4.0)), Some(TileId(2)));
        assert_eq!(whole.tile_at(Point::new(1.5, 6.0)), Some(TileId(4)));
    }

    #[test]
    fn segments_meet_the_tiles_whose_cells_they_touch() {
        let tree = KdTree::new(tree()).unwrap();
        let root = Rect::new(-4.0, 0.0, 6.0, 10.0);
        let cells = tree.cells_within(root);
        let mut most = 0;
        for number in 0..9u32.pow(4) {
            let at = |place: u32| f64::from(number / 9u32.pow(place) % 9) * 2.0 - 5.0;
            let ends = [Point::new(at(0), at(1) + 5.0), Point::new(at(2), at(3) + 5.0)];
            let mut found = Vec::new();
            tree.tiles_along(root, ends, |tile| found.push(tile.0));
            let touched = (0..).zip(&cells).filter(|(_, cell)| segment_meets(ends, **cell));
            let touched: Vec<u32> = touched.map(|(tile, _)| tile).collect();
            assert_eq!(found, touched, "{ends:?}");
            most = most.max(found.len());
        }
        assert_eq!(most, 3);
        KdTree::default().tiles_along(root, [Point::default(); 2], |_| panic!("there are no tiles"));
    }

    #[test]
    fn broken_trees_are_refused() {
        for broken in 0..5 {
            let mut nodes = tree();
            nodes.remove(broken);
            assert!(KdTree::new(nodes).is_err());
            let mut nodes = tree();
            nodes[broken] = KdNode::X {
                cut: f64::NAN,
                right: 9,
            };
            assert!(KdTree::new(nodes).is_err());
        }
        let mut nodes = tree();
        nodes[0] = KdNode::X { cut: 1.0, right: 0 };
        assert!(KdTree::new(nodes).is_err());
    }
}
