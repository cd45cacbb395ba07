//! Finds the cell of a point.

use crate::geometry::Point;
use crate::store::format::kd_tree::{KdNode, KdTree};

/// An index that finds cells in a k-d tree. Every lookup takes the same steps, so there are no
/// unpredictable branches. Several points are looked up at a time, so that their memory accesses
/// overlap.
#[derive(Debug)]
pub(crate) struct CellIndex {
    nodes: Vec<CellNode>,
    depth: usize,
}

/// A node. Both children of a leaf are the leaf itself.
#[derive(Clone, Copy, Debug)]
struct CellNode {
    cut: f64,
    /// 0 for x, 1 for y.
    axis: u32,
    children: [u32; 2],
    cell: u32,
}

/// The number of points looked up at a time.
const LANES: usize = 8;

impl CellIndex {
    pub(crate) fn new(tree: &KdTree) -> Self {
        let node = |(number, node): (u32, &KdNode)| {
            let (cut, axis, children, cell) = match *node {
                KdNode::X { cut, right } => (cut, 0, [number + 1, right], 0),
                KdNode::Y { cut, right } => (cut, 1, [number + 1, right], 0),
                KdNode::Leaf(tile) => (0.0, 0, [number; 2], tile.0),
            };
            CellNode {
                cut,
                axis,
                children,
                cell,
            }
        };
        Self {
            nodes: (0..).zip(tree.nodes()).map(node).collect(),
            depth: tree.depth(),
        }
    }

    /// Appends to `cells`, for each point, the number of the leaf whose cell contains it.
    pub(crate) fn cells_of(&self, points: &[Point], cells: &mut Vec<u32>) {
        let (lanes, rest) = points.as_chunks::<LANES>();
        for points in lanes {
            cells.extend(self.descend(points));
        }
        cells.extend(rest.iter().flat_map(|&point| self.descend(&[point])));
    }

    #[inline]
    fn descend<const N: usize>(&self, points: &[Point; N]) -> [u32; N] {
        let mut at = [0u32; N];
        for _ in 0..self.depth {
            for (at, point) in at.iter_mut().zip(points) {
                let node = &self.nodes[*at as usize];
                let right = [point.x, point.y][(node.axis & 1) as usize] > node.cut;
                *at = node.children[usize::from(right)];
            }
        }
        at.map(|node| self.nodes[node as usize].cell)
    }
}
