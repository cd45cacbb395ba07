//! The k-d tree. It partitions the plane into cells, orders the tiles, and is the index of the
//! directory.

use std::hint::select_unpredictable;

use crate::geometry::{Point, Rect, segment_meets};
use crate::store::format::damage::Damage;
use crate::store::format::ids::TileId;

/// A node of a k-d tree whose leaves have a value of type `L`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KdNode<L = TileId> {
    /// A cut by x. Points with x up to and including `cut` are in the left child, which is the next
    /// node; other points are in node `right`.
    X {
        /// The coordinate of the cut.
        cut: f64,
        /// The number of the right child.
        right: u32,
    },
    /// A cut by y, with the same meaning as in [`X`](Self::X).
    Y {
        /// The coordinate of the cut.
        cut: f64,
        /// The number of the right child.
        right: u32,
    },
    /// A leaf, with the value of its cell.
    Leaf(L),
}

/// A k-d tree in preorder: node 0 is the root, and the left child follows its parent. Without
/// tiles, it is empty.
///
/// Leaves have a value of type `L`: in the tree of a whole file, the tile of the cell.
///
/// Cells are half-open: a cell contains its right and top boundary, but not its left and bottom
/// one. Outermost cells extend to infinity.
#[derive(Clone, Debug, PartialEq)]
pub struct KdTree<L = TileId> {
    nodes: Vec<KdNode<L>>,
    tiles: u32,
}

impl<L> Default for KdTree<L> {
    fn default() -> Self {
        Self {
            nodes: Vec::new(),
            tiles: 0,
        }
    }
}

impl<L: Copy> KdTree<L> {
    /// Returns the borders between cells within a rectangle, one segment per cut.
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
            // A cell outside the rectangle contains none of it.
            open.extend(
                [(right, upper), (node + 1, lower)]
                    .into_iter()
                    .filter(|(_, cell)| !cell.is_empty()),
            );
        }
        borders
    }

    /// Creates a tree from `nodes`, which must be in preorder. The error says what is wrong.
    pub(crate) fn new(nodes: Vec<KdNode<L>>) -> Result<Self, Damage> {
        let mut tiles = 0;
        if nodes.is_empty() {
            return Ok(Self::default());
        }
        // The right children that are still expected, innermost last, and first of all the end of
        // the nodes.
        let mut expected = vec![nodes.len() as u32];
        for (number, node) in (0u32..).zip(&nodes) {
            match *node {
                KdNode::X { cut, right } | KdNode::Y { cut, right } => {
                    if !cut.is_finite() {
                        return Err(Damage::new(format!(
                            "node {number} has the cut {cut}, which is not finite"
                        )));
                    }
                    expected.push(right);
                }
                KdNode::Leaf(_) => {
                    tiles += 1;
                    if expected.pop() != Some(number + 1) {
                        return Err(Damage::new(format!(
                            "node {} must not follow node {number}",
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

    /// Returns the nodes in preorder.
    #[must_use]
    pub fn nodes(&self) -> &[KdNode<L>] {
        &self.nodes
    }

    /// Returns the number of leaves.
    #[must_use]
    pub fn tiles(&self) -> u32 {
        self.tiles
    }

    /// Returns the number of cuts above the deepest leaf.
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

    /// Returns the values of the leaves from left to right.
    pub fn leaves(&self) -> impl Iterator<Item = L> {
        self.nodes.iter().filter_map(|node| match *node {
            KdNode::Leaf(leaf) => Some(leaf),
            _ => None,
        })
    }

    /// Returns the value of the leaf whose cell contains `p`, or `None` if there are no leaves.
    pub(crate) fn leaf_at(&self, p: Point) -> Option<L> {
        let mut node = 0u32;
        loop {
            // Half of the guesses would be wrong if the side were a branch.
            node = match *self.nodes.get(node as usize)? {
                KdNode::X { cut, right } => select_unpredictable(p.x <= cut, node + 1, right),
                KdNode::Y { cut, right } => select_unpredictable(p.y <= cut, node + 1, right),
                KdNode::Leaf(leaf) => return Some(leaf),
            };
        }
    }

    /// Returns the cell of every node, in preorder. Outer boundaries are infinite.
    #[must_use]
    pub fn node_cells(&self) -> Vec<Rect> {
        self.node_cells_within(Rect::PLANE)
    }

    /// Returns the cell of every node, in preorder. `root` is the cell of the root.
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

    /// Returns each leaf's value with its cell, from left to right. Outer boundaries are infinite.
    #[must_use]
    pub fn cells(&self) -> Vec<(L, Rect)> {
        self.leaves().zip(self.cells_within(Rect::PLANE)).collect()
    }

    /// Returns the cell of every leaf, from left to right. `root` is the cell of the root.
    pub(crate) fn cells_within(&self, root: Rect) -> Vec<Rect> {
        let cells = self.node_cells_within(root).into_iter().zip(&self.nodes);
        cells
            .filter(|(_, node)| matches!(node, KdNode::Leaf(_)))
            .map(|(cell, _)| cell)
            .collect()
    }
}

impl KdTree {
    /// Returns the tile whose cell contains `p`, or `None` if there are no tiles.
    #[must_use]
    pub fn tile_at(&self, p: Point) -> Option<TileId> {
        self.leaf_at(p)
    }

    /// Returns the tree with the value `values[i]` in leaf i.
    pub(crate) fn with_values(mut self, values: &[TileId]) -> Self {
        for node in &mut self.nodes {
            if let KdNode::Leaf(leaf) = node {
                *leaf = values[leaf.0 as usize];
            }
        }
        self
    }

    /// Returns the pairs of leaves that are the two children of a node.
    pub(crate) fn sibling_leaves(&self) -> impl Iterator<Item = [TileId; 2]> {
        self.nodes.windows(3).filter_map(|nodes| match *nodes {
            [
                KdNode::X { .. } | KdNode::Y { .. },
                KdNode::Leaf(left),
                KdNode::Leaf(right),
            ] => Some([left, right]),
            _ => None,
        })
    }

    /// Returns the tree with leaf i replaced by `subtrees[i]`, whose leaves are numbered from the given
    /// tile on.
    pub(crate) fn with_leaves_cut(&self, subtrees: &[(u32, Self)]) -> Self {
        fn graft(tree: &KdTree, from: u32, subtrees: &[(u32, KdTree)], out: &mut Vec<KdNode>, tiles: &mut u32) {
            match tree.nodes[from as usize] {
                node @ (KdNode::X { right, .. } | KdNode::Y { right, .. }) => {
                    let index = out.len();
                    out.push(node);
                    graft(tree, from + 1, subtrees, out, tiles);
                    let moved = out.len() as u32;
                    if let KdNode::X { right, .. } | KdNode::Y { right, .. } = &mut out[index] {
                        *right = moved;
                    }
                    graft(tree, right, subtrees, out, tiles);
                }
                KdNode::Leaf(leaf) => {
                    let first = out.len() as u32;
                    let (before, subtree) = &subtrees[leaf.0 as usize];
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

    /// Calls `take` for each tile whose closed cell the segment meets. `root` is the cell of the
    /// root.
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
            // The segment meets this cell. If it is on one side of the cut only, it also meets the
            // cell on that side.
            let straddles_cut = from.min(to) <= cut && cut <= from.max(to);
            for (child, cell, is_reached) in [(right, high, from.max(to) >= cut), (node + 1, low, from.min(to) <= cut)]
            {
                if is_reached && (!straddles_cut || segment_meets(ends, cell)) {
                    open.push((child, cell));
                }
            }
        }
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
    fn points_on_a_cut_are_in_the_left_child() {
        let tree = KdTree::new(tree()).unwrap();
        let at = |x, y| tree.tile_at(Point::new(x, y)).unwrap().0;
        assert_eq!([at(1.0, 9.0), at(1.5, 5.0), at(1.5, 5.5)], [0, 1, 2]);
        assert_eq!(
            tree.cells()[1],
            (TileId(1), Rect::new(1.0, f64::NEG_INFINITY, f64::INFINITY, 5.0))
        );
        assert_eq!(KdTree::default().tile_at(Point::new(0.0, 0.0)), None);
    }

    #[test]
    fn leaves_are_replaced_by_subtrees() {
        let top = KdTree::new(tree()).unwrap();
        let leaf = KdTree::new(vec![KdNode::Leaf(TileId(0))]).unwrap();
        let whole = top.with_leaves_cut(&[(0, leaf.clone()), (1, top.clone()), (4, leaf)]);
        assert_eq!(KdTree::new(whole.nodes().to_vec()), Ok(whole.clone()));
        assert_eq!((whole.tiles(), whole.depth(), top.depth()), (5, 4, 2));
        // The subtree cuts the second leaf of the upper tree. The third leaf is replaced by a leaf.
        assert_eq!(whole.tile_at(Point::new(1.5, 4.0)), Some(TileId(2)));
        assert_eq!(whole.tile_at(Point::new(1.5, 6.0)), Some(TileId(4)));
    }

    #[test]
    fn tiles_along_finds_all_tiles_whose_closed_cells_a_segment_touches() {
        let tree = KdTree::new(tree()).unwrap();
        let root = Rect::new(-4.0, 0.0, 6.0, 10.0);
        let cells = tree.cells_within(root);
        let mut most = 0;
        for number in 0..9u32.pow(4) {
            let at = |digit: u32| f64::from(number / 9u32.pow(digit) % 9) * 2.0 - 5.0;
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
    fn broken_trees_are_rejected() {
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
