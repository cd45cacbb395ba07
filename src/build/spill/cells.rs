//! The cells that points are distributed to, and the way to find a point's cell.

use crate::geometry::Point;
use crate::store::{KdNode, KdTree};

/// Finds cells in a k-d tree with the same steps for every point, so that a processor need not guess where they lead and
/// works on several points at a time.
#[derive(Debug)]
pub(super) struct CellIndex {
    nodes: Vec<Step>,
    depth: usize,
}

/// A node. A leaf leads to itself.
#[derive(Clone, Copy, Debug)]
struct Step {
    cut: f64,
    is_y: bool,
    children: [u32; 2],
    cell: u32,
}

impl CellIndex {
    pub(super) fn new(tree: &KdTree) -> Self {
        let step = |(number, node): (u32, &KdNode)| {
            let (cut, is_y, children, cell) = match *node {
                KdNode::X { cut, right } => (cut, false, [number + 1, right], 0),
                KdNode::Y { cut, right } => (cut, true, [number + 1, right], 0),
                KdNode::Leaf(tile) => (0.0, false, [number; 2], tile.0),
            };
            Step {
                cut,
                is_y,
                children,
                cell,
            }
        };
        Self {
            nodes: (0..).zip(tree.nodes()).map(step).collect(),
            depth: tree.depth(),
        }
    }

    /// The number of the leaf whose cell has this point.
    #[inline]
    pub(super) fn cell_of(&self, point: Point) -> u32 {
        let mut step = &self.nodes[0];
        for _ in 0..self.depth {
            let coordinate = if step.is_y { point.y } else { point.x };
            step = &self.nodes[step.children[usize::from(coordinate > step.cut)] as usize];
        }
        step.cell
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::divide::divide;
    use super::super::super::point_store::Item;
    use super::*;

    #[test]
    fn the_cell_is_that_of_the_tree() {
        let points = (0u32..900).map(|i| Point::new(f64::from(i * 7919 % 83), f64::from(i * 104_729 % 31)));
        let mut items: Vec<_> = points.clone().map(|point| Item { point, position: 0 }).collect();
        let tree = divide(&mut items, 20, 1).tree;
        let index = CellIndex::new(&tree);
        for point in points {
            assert_eq!(Some(index.cell_of(point)), tree.tile_at(point).map(|t| t.0));
        }
    }
}
