use std::collections::HashMap;
use std::os::unix::fs::FileExt;

use proptest::prelude::*;

use crate::constraints::segments::spool::*;

/// An operation of a build on a spool.
#[derive(Clone, Debug)]
enum SpoolStep {
    /// Adds segments by their ends, of this kind, with or without z.
    ByEnds(Vec<[Point; 2]>, LineKind, bool),
    /// Adds segments between records, given by their ranks.
    Between(Vec<[u64; 2]>, LineKind),
    /// Adds points with these records, given by their ranks.
    Points(Vec<u64>),
}

/// A model of the spool, with all segments in memory.
#[derive(Default)]
struct Model {
    by_ends: Vec<Segment>,
    z: Vec<[f64; 2]>,
    has_z: bool,
    /// The records, the ends that were found, and the source.
    between: Vec<([u64; 2], [Option<Point>; 2], EdgeSource)>,
    lines: u64,
    batches: u64,
}

/// Returns the z of the ends of a line.
fn z_of(line: u64) -> [f64; 2] {
    [line as f64 * 0.5, -(line as f64)]
}

impl Model {
    fn lines(&mut self, count: usize) -> Vec<u64> {
        // Most lines are consecutive; a few are far away.
        let lines = (self.lines..).take(count).map(|line| match line % 97 {
            96 => EdgeSource::MAX_NUMBER - line,
            _ => line / 2,
        });
        self.lines += count as u64;
        lines.collect()
    }

    fn step(&mut self, spool: &mut SegmentSpool, step: &SpoolStep, record: impl Fn(u64) -> u64) {
        match step {
            SpoolStep::ByEnds(ends, kind, has_z) => {
                let lines = self.lines(ends.len());
                let z: Vec<_> = lines.iter().copied().filter(|_| *has_z).map(z_of).collect();
                spool.push(ends, &z, *kind, &lines).unwrap();
                self.has_z |= !z.is_empty();
                for (at, (ends, &line)) in ends.iter().zip(&lines).enumerate() {
                    let source = EdgeSource::new(*kind, line).into();
                    let ends = ends.map(Point::normalized);
                    self.by_ends.push(Segment { ends, source });
                    self.z.push(z.get(at).copied().unwrap_or_default());
                }
            }
            SpoolStep::Between(ranks, kind) => {
                let lines = self.lines(ranks.len());
                let records: Vec<_> = ranks.iter().map(|ranks| ranks.map(&record)).collect();
                spool.push_between(&records, *kind, &lines).unwrap();
                let its = records.iter().zip(&lines);
                self.between
                    .extend(its.map(|(&records, &line)| (records, [None; 2], EdgeSource::new(*kind, line))));
            }
            SpoolStep::Points(ranks) => {
                self.batches += 1;
                let batch = self.batch(ranks, record);
                spool.resolve(&batch).unwrap();
                let positions: HashMap<u64, Point> = batch.records.iter().copied().zip(batch.points).collect();
                for (records, ends, _) in &mut self.between {
                    for (record, end) in records.iter().zip(ends) {
                        *end = positions.get(record).map(|p| p.normalized()).or(*end);
                    }
                }
            }
        }
        let between = self.between.len();
        assert_eq!(spool.len(), (self.by_ends.len() + between) as u64);
    }

    /// Makes points at other positions than in the batch before.
    fn batch(&self, ranks: &[u64], record: impl Fn(u64) -> u64) -> PointBatch {
        let position = |(rank, at): (&u64, usize)| match rank % 4 {
            0 => Point::new(-0.0, *rank as f64),
            1 => Point::new(3.0, 4.0),
            _ => Point::new(*rank as f64, (self.batches * 1000) as f64 + at as f64),
        };
        PointBatch {
            points: ranks.iter().zip(0..).map(position).collect(),
            z: Vec::new(),
            records: ranks.iter().map(|&rank| record(rank)).collect(),
        }
    }

    fn check(&self, spool: &mut SegmentSpool) {
        let batches: Vec<PointBatch> = spool.ends(7).collect::<Result<_, _>>().unwrap();
        let points: Vec<Point> = batches.iter().flat_map(|batch| batch.points.clone()).collect();
        let ends: Vec<Point> = self.by_ends.iter().flat_map(|segment| segment.ends).collect();
        assert_eq!(bits(&points), bits(&ends));
        assert!(
            batches
                .iter()
                .flat_map(|batch| &batch.records)
                .copied()
                .eq(7..7 + ends.len() as u64)
        );
        let mut z = Vec::new();
        for batch in &batches {
            assert!(!batch.is_empty() && (batch.z.is_empty() || batch.z.len() == batch.len()));
            z.extend_from_slice(&batch.z);
            z.resize(z.len() + batch.len() - batch.z.len(), 0.0);
        }
        // Segments that came without z have none.
        let z: Vec<f64> = z.into_iter().map(|z| if z.is_nan() { 0.0 } else { z }).collect();
        assert_eq!(z, self.z.as_flattened());
        assert_eq!(batches.iter().any(|batch| !batch.z.is_empty()), self.has_z);

        for _ in 0..2 {
            let mut found = Vec::new();
            let given = spool.for_each_chunk(|segments| {
                assert!(!segments.is_empty());
                found.extend_from_slice(segments);
                Ok(())
            });
            match self.segments() {
                Ok(segments) => {
                    given.unwrap();
                    assert_eq!(found, segments);
                    let (found, expected) = (found.iter(), segments.iter());
                    assert!(found.zip(expected).all(|(a, b)| bits(&a.ends) == bits(&b.ends)));
                }
                Err(missing) => match given {
                    Err(ConstraintError::NoSuchRecord { segment, record }) => assert_eq!((segment, record), missing),
                    given => panic!("{given:?}"),
                },
            }
        }
    }

    /// Returns all segments of nonzero length, or the first segment with a missing end, and its
    /// record.
    fn segments(&self) -> Result<Vec<Segment>, (u64, u64)> {
        let mut all = self.by_ends.clone();
        for ((records, ends, source), number) in self.between.iter().zip(0..) {
            let missing = records.iter().zip(ends).find(|(_, end)| end.is_none());
            if let Some((&record, _)) = missing {
                return Err((number, record));
            }
            let ends = ends.map(Option::unwrap);
            all.push(Segment {
                ends,
                source: (*source).into(),
            });
        }
        all.retain(|segment| segment.ends[0] != segment.ends[1]);
        Ok(all)
    }
}

fn bits(points: &[Point]) -> Vec<[u64; 2]> {
    points.iter().map(|p| [p.x.to_bits(), p.y.to_bits()]).collect()
}

/// Number of records.
const RANKS: u64 = 60;

fn kind() -> impl Strategy<Value = LineKind> {
    prop::sample::select(vec![LineKind::BreakLine, LineKind::Wall, LineKind::Obstacle])
}

fn step() -> impl Strategy<Value = SpoolStep> {
    let point = (-2i32..3, -2i32..3).prop_map(|(x, y)| Point::new(f64::from(x) * -0.0 + f64::from(x), f64::from(y)));
    let ends = prop::collection::vec([point.clone(), point], 0..30);
    let between = prop::collection::vec([0..RANKS, 0..RANKS], 0..120);
    let points = prop_oneof![
        prop::collection::vec(0..RANKS, 0..80),
        (0..RANKS, 0..RANKS).prop_map(|(first, end)| (first..end).collect()),
        (0..RANKS, 1usize..5).prop_map(|(end, step)| (0..end).step_by(step).collect()),
    ];
    prop_oneof![
        (ends, kind(), any::<bool>()).prop_map(|(ends, kind, has_z)| SpoolStep::ByEnds(ends, kind, has_z)),
        (between, kind()).prop_map(|(between, kind)| SpoolStep::Between(between, kind)),
        points.prop_map(SpoolStep::Points),
    ]
}

/// Returns the record number of a rank. The numberings are close together, beyond 32 bits, too far
/// apart for a word, from one end of the range to the other, and descending.
fn record(numbering: usize, rank: u64) -> u64 {
    match numbering {
        0 => rank,
        1 => (1 << 33) + 3 * rank,
        2 => rank << 43,
        3 => rank * (u64::MAX / (RANKS - 1)),
        _ => u64::MAX - rank,
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn segments_come_back_in_their_order(
        steps in prop::collection::vec(step(), 0..16),
        memory in prop::sample::select(vec![0, 500, 4000, 20_000, 1 << 20]),
        numbering in 0usize..5,
        all_points in any::<bool>(),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let mut spool = SegmentSpool::new(folder.path(), memory);
        let mut model = Model::default();
        for step in &steps {
            model.step(&mut spool, step, |rank| record(numbering, rank));
        }
        if all_points {
            model.step(&mut spool, &SpoolStep::Points((0..RANKS).collect()), |rank| record(numbering, rank));
        }
        model.check(&mut spool);
        prop_assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "a file without a name");
    }
}

/// Adds segments between distant records. Returns the points in batches.
fn long_chain(spool: &mut SegmentSpool, records: u64) -> Vec<PointBatch> {
    for first in (0..records).step_by(500) {
        let pairs: Vec<[u64; 2]> = (first..first + 500).map(|a| [a, (a * 7919 + 13) % records]).collect();
        let lines: Vec<u64> = (first..first + 500).collect();
        spool.push_between(&pairs, LineKind::Wall, &lines).unwrap();
    }
    let batch = |first: u64| PointBatch {
        points: (first..first + 250)
            .map(|r| Point::new(r as f64, (r % 10) as f64))
            .collect(),
        z: Vec::new(),
        records: (first..first + 250).collect(),
    };
    (0..records).step_by(250).map(batch).collect()
}

#[test]
fn memory_is_bounded_and_reported() {
    const MEMORY: u64 = 256 << 10;
    const RECORDS: u64 = 40_000;
    for order in 0..3 {
        let folder = tempfile::tempdir().unwrap();
        let mut spool = SegmentSpool::new(folder.path(), MEMORY);
        let mut batches = long_chain(&mut spool, RECORDS);
        assert!(
            (MEMORY / 4..MEMORY).contains(&spool.byte_size()),
            "{}",
            spool.byte_size()
        );
        match order {
            0 => {}
            1 => batches.reverse(),
            _ => batches.sort_by_key(|batch| batch.records[0].wrapping_mul(0x9E37_79B9_7F4A_7C15)),
        }
        for batch in &batches {
            spool.resolve(batch).unwrap();
            assert!(spool.byte_size() < MEMORY, "{}", spool.byte_size());
        }
        let mut next = 0;
        let given = spool.for_each_chunk(|segments| {
            for segment in segments {
                // A segment in between may join a point with itself.
                while (next * 7919 + 13) % RECORDS == next {
                    next += 1;
                }
                let xs = [next, (next * 7919 + 13) % RECORDS].map(|record| record as f64);
                assert_eq!(segment.ends.map(|end| end.x), xs);
                assert_eq!(segment.source, EdgeSource::new(LineKind::Wall, next).into());
                next += 1;
            }
            Ok(())
        });
        given.unwrap();
        assert_eq!(next, RECORDS);
        assert!(spool.byte_size() < MEMORY);
    }
}

#[test]
fn all_segments_may_share_a_record() {
    let folder = tempfile::tempdir().unwrap();
    let mut spool = SegmentSpool::new(folder.path(), 2000);
    let mut model = Model::default();
    let star: Vec<[u64; 2]> = (0..3000).map(|rank| [5, rank % RANKS]).collect();
    model.step(&mut spool, &SpoolStep::Between(star, LineKind::Wall), |rank| rank);
    for first in (0..RANKS).step_by(4) {
        model.step(&mut spool, &SpoolStep::Points((first..first + 4).collect()), |rank| {
            rank
        });
    }
    model.check(&mut spool);
}

#[test]
fn bad_input_is_rejected_and_not_added() {
    let folder = tempfile::tempdir().unwrap();
    let mut spool = SegmentSpool::new(folder.path(), 1 << 20);
    let ends = [[Point::new(0.0, 0.0), Point::new(1.0, 1.0)]; 3];
    spool.push(&ends, &[], LineKind::BreakLine, &[0, 1, 2]).unwrap();
    let mut push = |bad: Point, z: &[[f64; 2]], lines: &[u64]| {
        let mut ends = ends;
        ends[1][1] = bad;
        let refused = spool.push(&ends, z, LineKind::Wall, lines);
        assert_eq!(spool.len(), 3);
        refused.unwrap_err()
    };
    let good = ends[0][1];
    for bad in [f64::NAN, f64::INFINITY, 1e300, 1e-300] {
        let refused = push(Point::new(1.0, bad), &[], &[3, 4, 5]);
        assert!(
            matches!(refused, ConstraintError::InvalidEnd { segment: 4, point } if point.y.to_bits() == bad.to_bits())
        );
    }
    let refused = push(good, &[[0.0; 2], [0.0; 2], [1.0, f64::INFINITY]], &[3, 4, 5]);
    assert!(matches!(refused, ConstraintError::InvalidEndZ { segment: 5, .. }));
    let refused = push(good, &[[0.0; 2]], &[3, 4, 5]);
    assert!(matches!(
        refused,
        ConstraintError::SegmentBatch {
            segments: 3,
            z: 1,
            lines: 3
        }
    ));
    let refused = push(good, &[], &[3, 4]);
    assert!(matches!(
        refused,
        ConstraintError::SegmentBatch {
            segments: 3,
            z: 0,
            lines: 2
        }
    ));
    let line = EdgeSource::MAX_NUMBER + 1;
    let refused = push(good, &[], &[3, 4, line]);
    assert!(matches!(refused, ConstraintError::LineNumber { segment: 5, line: l } if l == line));
    let refused = spool.push_between(&[[0, 1]], LineKind::Wall, &[line]);
    assert!(matches!(refused, Err(ConstraintError::LineNumber { segment: 3, .. })));
    let refused = spool.push_between(&[[0, 1]], LineKind::Wall, &[]);
    assert!(matches!(
        refused,
        Err(ConstraintError::SegmentBatch { segments: 1, .. })
    ));
    assert_eq!(spool.len(), 3);
}

/// Flips a bit of a file.
fn damage(file: &std::fs::File, at: u64) {
    let mut byte = [0];
    file.read_exact_at(&mut byte, at).unwrap();
    file.write_all_at(&[byte[0] ^ 1 << (at % 8)], at).unwrap();
}

#[test]
fn damaged_chunks_are_found() {
    let whole = |at: Option<(u64, bool)>| -> Result<Vec<Segment>, ConstraintError> {
        let folder = tempfile::tempdir().unwrap();
        let mut spool = SegmentSpool::new(folder.path(), 0);
        let ends = [[Point::new(0.0, 0.0), Point::new(1.0, 1.0)]; 8];
        spool
            .push(&ends, &[[1.0, 2.0]; 8], LineKind::BreakLine, &[7; 8])
            .unwrap();
        let batches = long_chain(&mut spool, 500);
        let damage_if = |spool: &SegmentSpool, is_early: bool| {
            let at = at.filter(|&(_, early)| early == is_early).map(|(at, _)| at);
            let file = spool.store().file().unwrap();
            at.into_iter()
                .for_each(|at| damage(file, at % file.metadata().unwrap().len()));
        };
        damage_if(&spool, true);
        for batch in &batches {
            spool.resolve(batch)?;
        }
        damage_if(&spool, false);
        let mut all = Vec::new();
        spool.for_each_chunk(|segments| {
            all.extend_from_slice(segments);
            Ok(())
        })?;
        Ok(all)
    };
    let right = whole(None).unwrap();
    assert!(right.len() > 500);
    let mut found = [0, 0];
    for at in (0..31_000).step_by(499) {
        for is_early in [true, false] {
            match whole(Some((at, is_early))) {
                Err(ConstraintError::Io { source, .. }) => {
                    assert_eq!(source.kind(), io::ErrorKind::InvalidData);
                    found[usize::from(is_early)] += 1;
                }
                Err(other) => panic!("{other}"),
                // Pairs are not read again once their points were seen.
                Ok(all) => assert!(!is_early && all == right, "at {at}"),
            }
        }
    }
    assert!(found[0] > 40 && found[1] > 60, "{found:?}");
}
