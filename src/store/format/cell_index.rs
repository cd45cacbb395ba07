//! The cells that points are distributed to, and the way to find a point's cell.

use crate::geometry::Point;
use crate::store::format::kd_tree::{KdNode, KdTree};

/// Finds cells in a k-d tree with the same steps for every point, so that a processor need not guess where they lead, and for
/// several points at a time, so that it need not wait for one.
#[derive(Debug)]
pub(crate) struct CellIndex {
    nodes: Vec<Step>,
    depth: usize,
}

/// A node. A leaf leads to itself.
#[derive(Clone, Copy, Debug)]
struct Step {
    cut: f64,
    /// 0 for x, 1 for y.
    axis: u32,
    children: [u32; 2],
    cell: u32,
}

/// Points at a time.
const LANES: usize = 8;

impl CellIndex {
    pub(crate) fn new(tree: &KdTree) -> Self {
        let step = |(number, node): (u32, &KdNode)| {
            let (cut, axis, children, cell) = match *node {
                KdNode::X { cut, right } => (cut, 0, [number + 1, right], 0),
                KdNode::Y { cut, right } => (cut, 1, [number + 1, right], 0),
                KdNode::Leaf(tile) => (0.0, 0, [number; 2], tile.0),
            };
            Step {
                cut,
                axis,
                children,
                cell,
            }
        };
        Self {
            nodes: (0..).zip(tree.nodes()).map(step).collect(),
            depth: tree.depth(),
        }
    }

    /// Appends the number of the leaf whose cell has each point.
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
                let step = &self.nodes[*at as usize];
                let right = [point.x, point.y][(step.axis & 1) as usize] > step.cut;
                *at = step.children[usize::from(right)];
            }
        }
        at.map(|node| self.nodes[node as usize].cell)
    }

    /// The number of the leaf whose cell has this point.
    pub(crate) fn cell_of(&self, point: Point) -> u32 {
        self.descend(&[point])[0]
    }
}
