use std::os::unix::fs::FileExt;
use std::path::Path;

use proptest::prelude::*;

use crate::constraints::segments::blocks::*;
use crate::constraints::segments::cells::tests::{meets, segments, tree};
use crate::constraints::segments::spool::SegmentSpool;
use crate::geometry::Point;
use crate::input::PointBatch;
use crate::store::{EdgeSource, KdNode, LineKind, TileId};

/// Distributes all segments to blocks through a spool. Every third one is given by the records of
/// its ends.
fn distributed(folder: &Path, all: &[Segment], tree: &KdTree, memory: [u64; 2]) -> BlockSegments {
    let mut spool = SegmentSpool::new(folder, memory[0]);
    let mut points = PointBatch::default();
    for (segment, number) in all.iter().zip(0..) {
        let (kind, lines) = (segment.source.kind(), [segment.source.number()]);
        if number % 3 == 1 {
            let records = [2 * number, 2 * number + 1];
            spool.push_between(&[records], kind, &lines).unwrap();
            points.points.extend(segment.ends);
            points.records.extend(records);
        } else {
            spool.push(&[segment.ends], &[], kind, &lines).unwrap();
        }
    }
    spool.resolve(&points).unwrap();
    let threads = 1 + all.len() % 2;
    spool
        .distribute(tree, memory[1], None, threads)
        .unwrap()
        .blocks
        .unwrap()
}

/// Returns the segments in the order of a spool: first those that came by their ends.
fn in_order(all: &[Segment]) -> Vec<Segment> {
    let (between, by_ends): (Vec<_>, Vec<_>) = all.iter().zip(0..).partition(|(_, number)| number % 3 == 1);
    by_ends
        .into_iter()
        .chain(between)
        .map(|(segment, _)| *segment)
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn blocks_have_the_segments_that_meet_them(
        tree in tree(),
        mut all in segments(),
        copies in 1usize..20,
        spool_memory in prop::sample::select(vec![0, 3000, 20_000, 1 << 30]),
        memory in prop::sample::select(vec![0, 3000, 1 << 30]),
    ) {
        all = all.repeat(copies);
        let folder = tempfile::tempdir().unwrap();
        let blocks = distributed(folder.path(), &all, &tree, [spool_memory, memory]);
        let spilled: u64 = (0..tree.tiles()).map(|block| blocks.count(block)).sum();
        // Lists of chunks take memory too.
        prop_assert!(blocks.byte_size() <= memory + 4 * 24 * (spilled / 16 + u64::from(tree.tiles())));
        let all = in_order(&all);
        // Take each block once, in reverse order.
        for (block, cell) in tree.cells().into_iter().map(|(block, cell)| (block.0, cell)).rev() {
            let has = |segment: &&Segment| segment.ends[0] != segment.ends[1] && meets(segment.ends, cell);
            let expected: Vec<Segment> = all.iter().filter(has).copied().collect();
            prop_assert_eq!(blocks.count(block), expected.len() as u64);
            prop_assert_eq!(blocks.take(block).unwrap(), expected);
            prop_assert_eq!(blocks.take(block).unwrap_err().kind(), io::ErrorKind::NotFound);
        }
        prop_assert_eq!(blocks.byte_size(), 0);
        prop_assert!(blocks.take(tree.tiles()).is_err());
    }
}

fn chain(length: u32) -> Vec<Segment> {
    let at = |i: u32| Point::new(f64::from(i % 100), f64::from(i / 100));
    let segment = |i| Segment {
        ends: [at(i), at(i + 1)],
        source: EdgeSource::new(LineKind::Obstacle, i.into()).into(),
    };
    (0..length).map(segment).collect()
}

#[test]
fn a_block_that_fits_takes_its_exact_size_until_it_is_taken() {
    let folder = tempfile::tempdir().unwrap();
    let tree = KdTree::new(vec![KdNode::Leaf(TileId(0))]).unwrap();
    let all = chain(3000);
    let blocks = distributed(folder.path(), &all, &tree, [1 << 20, 3000 * SEGMENT_BYTES]);
    let all = in_order(&all);
    assert!(blocks.store().file().is_none());
    assert_eq!(blocks.byte_size(), 3000 * SEGMENT_BYTES);
    assert_eq!(blocks.take(0).unwrap(), all);
    assert_eq!(blocks.byte_size(), 0);
    // One byte less is not enough.
    let blocks = distributed(folder.path(), &chain(3000), &tree, [1 << 20, 3000 * SEGMENT_BYTES - 1]);
    assert!(blocks.store().file().is_some());
    assert!(blocks.byte_size() < 1000);
    assert_eq!(blocks.take(0).unwrap(), all);
}

#[test]
fn a_tree_without_leaves_has_no_segments() {
    let folder = tempfile::tempdir().unwrap();
    let blocks = distributed(folder.path(), &chain(100), &KdTree::default(), [0, 0]);
    assert_eq!((blocks.count(0), blocks.byte_size()), (0, 0));
    assert!(blocks.take(0).is_err());
}

#[test]
fn damaged_chunks_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let tree = KdTree::new(vec![
        KdNode::X { cut: 50.0, right: 2 },
        KdNode::Leaf(TileId(0)),
        KdNode::Leaf(TileId(1)),
    ]);
    let tree = tree.unwrap();
    for at in (0..7000).step_by(211) {
        let blocks = distributed(folder.path(), &chain(200), &tree, [1 << 20, 0]);
        let file = blocks.store().file().unwrap();
        let mut byte = [0];
        file.read_exact_at(&mut byte, at).unwrap();
        file.write_all_at(&[!byte[0]], at).unwrap();
        let taken = [0, 1].map(|block| blocks.take(block));
        let damaged = taken.iter().flat_map(|taken| taken.as_ref().err());
        assert!(damaged.map(io::Error::kind).eq([io::ErrorKind::InvalidData]), "at {at}");
    }
}
