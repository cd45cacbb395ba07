//! Divide: cuts the plane into the cells of a k-d tree with at most `tile_vertices` points each.
//!
//! The longer side of the bounding box of a cell's points is cut; a coordinate up to and including
//! the cut goes left. The cut is chosen so that tiles are full: a cell for k tiles is cut at the
//! share of ⌊k/2⌋ of them. It is lowered below the maximum, so that neither half is empty. Points
//! at the same position are never separated, so a leaf may exceed `tile_vertices` if all its points
//! are equal.

use std::ops::Range;
use std::thread;

use parking_lot::Mutex;

use crate::geometry::{Point, Rect};
use crate::io::start_scoped;
use crate::store::format::ids::TileId;
use crate::store::format::kd_tree::{KdNode, KdTree};

/// Cells with fewer points than this are not worth a thread.
const PARALLEL_POINTS: usize = 1 << 15;

/// A point and its position: in a build, its index into the arrays of attributes.
///
/// Packed, because otherwise a sixth of the memory of a build would be padding.
#[derive(Clone, Copy, Debug)]
#[repr(C, packed(4))]
pub(crate) struct Item {
    pub(crate) point: Point,
    pub(crate) position: u32,
}

/// The cells, and the range of the reordered points in each.
#[derive(Debug)]
pub(crate) struct Division {
    pub(crate) tree: KdTree,
    pub(crate) leaves: Vec<Range<usize>>,
}

/// Cuts until no cell has more than `tile_vertices` points, and reorders the points by cell.
pub(crate) fn divide(items: &mut [Item], tile_vertices: usize, threads: usize) -> Division {
    if items.is_empty() {
        return Division {
            tree: KdTree::default(),
            leaves: Vec::new(),
        };
    }
    let mut subtree = cut_all(items, tile_vertices, threads);
    let mut tiles = 0..;
    for node in &mut subtree.nodes {
        if let KdNode::Leaf(tile) = node {
            *tile = TileId(tiles.next().expect("tiles are counted by u32"));
        }
    }
    let mut start = 0;
    let leaves = subtree.counts.iter().map(|&count| {
        start += count;
        start - count..start
    });
    Division {
        leaves: leaves.collect(),
        tree: KdTree::new(subtree.nodes).expect("the cuts make a tree in preorder"),
    }
}

/// A subtree: its nodes, numbered from 0, and the number of points in each of its leaves.
struct Subtree {
    nodes: Vec<KdNode>,
    counts: Vec<usize>,
}

fn cut_all(items: &mut [Item], tile_vertices: usize, threads: usize) -> Subtree {
    let cut = if items.len() > tile_vertices {
        cut(items, tile_vertices)
    } else {
        None
    };
    let Some((axis, cut, middle)) = cut else {
        return Subtree {
            nodes: vec![KdNode::Leaf(TileId(0))],
            counts: vec![items.len()],
        };
    };
    let total = items.len();
    let (left, right) = items.split_at_mut(middle);
    let (mut left, right) = if threads > 1 && total >= PARALLEL_POINTS {
        let half = threads / 2;
        let left = Mutex::new(Some(left));
        let cut_left = || left.lock().take().map(|left| cut_all(left, tile_vertices, half));
        thread::scope(|scope| {
            let thread = start_scoped(scope, "tile-divide", cut_left);
            let right = cut_all(right, tile_vertices, threads - half);
            // If no thread can be started, this thread does the work.
            let left = thread.map_or_else(|_| cut_left(), |thread| thread.join().expect("cutting does not panic"));
            (left.expect("it is cut once"), right)
        })
    } else {
        (cut_all(left, tile_vertices, 1), cut_all(right, tile_vertices, 1))
    };
    let first_right = left.nodes.len() as u32 + 1;
    let root = match axis {
        Axis::X => KdNode::X {
            cut,
            right: first_right,
        },
        Axis::Y => KdNode::Y {
            cut,
            right: first_right,
        },
    };
    let mut nodes = Vec::with_capacity(1 + left.nodes.len() + right.nodes.len());
    nodes.push(root);
    nodes.extend(left.nodes.into_iter().map(|node| shifted(node, 1)));
    nodes.extend(right.nodes.into_iter().map(|node| shifted(node, first_right)));
    left.counts.extend(right.counts);
    Subtree {
        nodes,
        counts: left.counts,
    }
}

fn shifted(node: KdNode, by: u32) -> KdNode {
    match node {
        KdNode::X { cut, right } => KdNode::X { cut, right: right + by },
        KdNode::Y { cut, right } => KdNode::Y { cut, right: right + by },
        leaf @ KdNode::Leaf(_) => leaf,
    }
}

#[derive(Clone, Copy)]
enum Axis {
    X,
    Y,
}

impl Axis {
    fn of(self, item: &Item) -> f64 {
        match self {
            Self::X => item.point.x,
            Self::Y => item.point.y,
        }
    }
}

/// Cuts once. Returns the axis, the cut, and the number of points left of it, which are moved to
/// the front. Returns `None` if all points are equal.
fn cut(items: &mut [Item], tile_vertices: usize) -> Option<(Axis, f64, usize)> {
    let bounds = Rect::around(items.iter().map(|item| item.point));
    let (width, height) = bounds.size();
    let (axis, min, max) = if width >= height {
        (Axis::X, bounds.min_x, bounds.max_x)
    } else {
        (Axis::Y, bounds.min_y, bounds.max_y)
    };
    if min == max {
        return None;
    }
    let tiles = items.len().div_ceil(tile_vertices);
    let share = (items.len() as u128 * (tiles / 2) as u128 / tiles as u128) as usize;
    let last = share.max(1) - 1;
    let (_, at, _) = items.select_nth_unstable_by(last, |a, b| axis.of(a).total_cmp(&axis.of(b)));
    let mut cut = axis.of(at);
    let mut middle = last + 1;
    if cut == max {
        let below = items[..middle].iter().map(|item| axis.of(item)).filter(|&v| v < max);
        cut = below.max_by(f64::total_cmp).expect("all below the maximum precede it");
        middle = 0;
    }
    let mut index = middle;
    while index < items.len() {
        if axis.of(&items[index]) <= cut {
            items.swap(index, middle);
            middle += 1;
        }
        index += 1;
    }
    Some((axis, cut, middle))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::format::cell_index::CellIndex;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

        #[test]
        fn every_point_lies_in_the_cell_of_its_leaf(
            points in prop::collection::vec((0i32..6, 0i32..40), 0..300),
            tile_vertices in 4usize..40,
            threads in 1usize..4,
        ) {
            let mut items: Vec<_> = points.iter().zip(0..)
                .map(|(&(x, y), position)| Item { point: Point::new(x.into(), y.into()), position })
                .collect();
            let division = divide(&mut items, tile_vertices, threads);
            prop_assert_eq!(division.leaves.len(), division.tree.tiles() as usize);
            prop_assert_eq!(division.leaves.last().map_or(0, |leaf| leaf.end), items.len());
            for (leaf, tile) in division.leaves.iter().zip(0..) {
                let leaf = &items[leaf.clone()];
                prop_assert!(!leaf.is_empty());
                let first = leaf[0].point;
                let equal = leaf.iter().map(|item| item.point).all(|p| p == first);
                prop_assert!(leaf.len() <= tile_vertices || equal);
                for item in leaf {
                    prop_assert_eq!(division.tree.tile_at(item.point), Some(TileId(tile)));
                }
            }
            let mut positions: Vec<_> = items.iter().map(|item| item.position).collect();
            positions.sort_unstable();
            prop_assert_eq!(positions, (0..points.len() as u32).collect::<Vec<_>>());
        }
    }

    #[test]
    fn the_cell_index_finds_the_cell_of_the_tree() {
        let points = (0u32..900).map(|i| Point::new(f64::from(i * 7919 % 83), f64::from(i * 104_729 % 31)));
        let mut items: Vec<_> = points.clone().map(|point| Item { point, position: 0 }).collect();
        let tree = divide(&mut items, 20, 1).tree;
        let index = CellIndex::new(&tree);
        let points: Vec<Point> = points.collect();
        let mut cells = Vec::new();
        index.cells_of(&points[1..], &mut cells);
        for (&point, cell) in points[1..].iter().zip(cells) {
            assert_eq!(Some(cell), tree.tile_at(point).map(|t| t.0));
        }
    }
}
