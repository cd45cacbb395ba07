use proptest::prelude::*;

use crate::constraints::segments::cells::*;
use crate::store::divide::Item;
use crate::store::divide::divide;
use crate::store::{EdgeSource, LineKind};

/// Generates a tree over points on a small grid, so that cuts go through points and ends.
pub(crate) fn tree() -> impl Strategy<Value = KdTree> {
    (prop::collection::vec((0i32..12, 0i32..12), 0..60), 1usize..9).prop_map(|(points, per_leaf)| {
        let mut items: Vec<Item> = points.iter().map(|&p| item(p)).collect();
        divide(&mut items, per_leaf, 1).tree
    })
}

fn item((x, y): (i32, i32)) -> Item {
    Item {
        point: Point::new(f64::from(x), f64::from(y)),
        position: 0,
    }
}

/// Generates segments on the grid, between its points, and beyond it.
pub(crate) fn segments() -> impl Strategy<Value = Vec<Segment>> {
    let end = (-4i32..30, -4i32..30).prop_map(|(x, y)| Point::new(f64::from(x) / 2.0, f64::from(y) / 2.0));
    let ends = prop::collection::vec([end.clone(), end], 0..60);
    ends.prop_map(|all| {
        let segment = |(ends, number)| Segment {
            ends,
            source: EdgeSource::new(LineKind::Wall, number).into(),
        };
        all.into_iter().zip(0..).map(segment).collect()
    })
}

/// Returns whether clipping leaves a part of a segment in a cell. Computes with rational numbers;
/// the segment's coordinates must be halves of integers.
fn clips([a, b]: [Point; 2], cell: Rect) -> bool {
    let whole = |v: f64| (v * 2.0) as i128;
    let (mut from, mut to) = ((0, 1), (1, 1));
    let axes = [(a.x, b.x, cell.min_x, cell.max_x), (a.y, b.y, cell.min_y, cell.max_y)];
    for (a, b, min, max) in axes {
        let (a, b, min, max) = (whole(a), whole(b), whole(min), whole(max));
        if a == b {
            if a < min || a > max {
                return false;
            }
            continue;
        }
        // Positions along the segment where it enters and where it leaves the strip.
        let (enter, leave) = if a < b { (min, max) } else { (max, min) };
        let positive = |n: i128, d: i128| if d < 0 { (-n, -d) } else { (n, d) };
        let (enter, leave) = (positive(enter - a, b - a), positive(leave - a, b - a));
        if enter.0 * from.1 > from.0 * enter.1 {
            from = enter;
        }
        if leave.0 * to.1 < to.0 * leave.1 {
            to = leave;
        }
    }
    from.0 * to.1 <= to.0 * from.1
}

/// Returns whether a segment meets a cell, other than by touching its left or bottom side from
/// outside.
pub(crate) fn meets([a, b]: [Point; 2], cell: Rect) -> bool {
    segment_meets([a, b], cell) && a.x.max(b.x) > cell.min_x && a.y.max(b.y) > cell.min_y
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn a_segment_meets_a_cell_unless_clipping_removes_it(
        segments in segments(),
        (x, y) in (-2i32..12, -2i32..12),
        (width, height) in (0i32..8, 0i32..8),
    ) {
        let [x, y, right, top] = [x, y, x + width, y + height].map(f64::from);
        let cell = Rect::new(x, y, right, top);
        for segment in segments {
            prop_assert_eq!(segment_meets(segment.ends, cell), clips(segment.ends, cell), "{:?} {:?}", segment.ends, cell);
        }
    }

    #[test]
    fn leaves_have_the_segments_that_meet_them(
        tree in tree(),
        segments in segments(),
        is_within in any::<bool>(),
    ) {
        let cell = if is_within { Rect::new(1.0, 2.0, 9.5, 9.0) } else { Rect::PLANE };
        // The cells of a tree lie within its root's cell.
        let fits = |node: &KdNode| match *node {
            KdNode::X { cut, .. } => cell.min_x <= cut && cut <= cell.max_x,
            KdNode::Y { cut, .. } => cell.min_y <= cut && cut <= cell.max_y,
            KdNode::Leaf(_) => true,
        };
        prop_assume!(tree.nodes().iter().all(fits));
        let segments: Vec<Segment> = segments.into_iter().filter(|segment| meets(segment.ends, cell)).collect();
        let cells = tree.node_cells_within(cell).into_iter().zip(tree.nodes());
        let cells = cells.filter(|(_, node)| matches!(node, KdNode::Leaf(_)));
        let expected: Vec<Vec<u32>> = cells
            .map(|(cell, _)| (0..).zip(&segments).filter(|(_, s)| meets(s.ends, cell)).map(|(n, _)| n).collect())
            .collect();
        prop_assert_eq!(segments_of_leaves(&tree, cell, &segments), expected);
    }
}

#[test]
fn segment_numbers_continue_from_batch_to_batch() {
    let mut items: Vec<Item> = (0..64).map(|i| item((i % 8, i / 8))).collect();
    let tree = divide(&mut items, 4, 1).tree;
    let all: Vec<Segment> = (0..5000)
        .map(|i| {
            let x = f64::from(i % 83) / 10.0;
            Segment {
                ends: [
                    Point::new(x, f64::from(i % 7)),
                    Point::new(x + 0.125, f64::from(i % 11)),
                ],
                source: EdgeSource::new(LineKind::BreakLine, 0).into(),
            }
        })
        .collect();
    let leaves = segments_of_leaves(&tree, Rect::PLANE, &all);
    for (leaf, (_, cell)) in leaves.iter().zip(tree.cells()) {
        let expected = (0..)
            .zip(&all)
            .filter(|(_, s)| meets(s.ends, cell))
            .map(|(number, _)| number);
        assert!(leaf.iter().copied().eq(expected));
    }
}
