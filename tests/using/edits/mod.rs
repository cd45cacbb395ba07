//! The promise: an edit of a file takes effect as a whole or not at all, in a crash too. A reader
//! that has the file open keeps its old content. A compacted file has the same content.
//! `constraints` and `regions` promise that edits give the triangles of a build.

mod line_sequences;
mod lines;
mod log;
mod points;
mod rebuilds;
mod scene;
mod sizes;
mod space;
mod spilled;
mod z;

use std::fs::{self, File};

use crate::support::{Scratch, built, open_bytes, runtime};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::{PointBatch, SegmentBatch};
use delaunay_tiles::io::ThreadsFile;
use delaunay_tiles::store::{Digest, LineKind, LineSource};
use delaunay_tiles::{BuildOptions, EditError, EditOptions, EditSummary, Editor, OpenOptions, TileReader, Transaction};

const ENOUGH: u64 = 64 << 20;

/// Makes changes of a file in one transaction.
async fn edited(
    scratch: &Scratch,
    memory: u64,
    change: impl FnOnce(&mut Transaction),
) -> Result<EditSummary, EditError> {
    let editor = Editor::open(&scratch.path, EditOptions::default().memory(memory)).await?;
    let mut transaction = editor.begin().await?;
    change(&mut transaction);
    transaction.commit().await
}

/// Returns a batch of points without z.
fn batch(points: &[Point]) -> PointBatch {
    PointBatch {
        records: (0..points.len() as u64).collect(),
        points: points.to_vec(),
        z: Vec::new(),
    }
}

/// Builds a grid of 30 by 30 points in tiles of at most 60.
async fn grid() -> Scratch {
    grid_in_tiles_of(60).await
}

async fn grid_in_tiles_of(tile_vertices: usize) -> Scratch {
    let points: Vec<Point> = (0..900)
        .map(|i| Point::new(f64::from(i % 30), f64::from(i / 30)))
        .collect();
    let options = BuildOptions::default().tile_vertices(tile_vertices);
    built(&points, options).await.0
}

fn segment(from: (f64, f64), to: (f64, f64)) -> SegmentBatch {
    SegmentBatch {
        ends: vec![[Point::new(from.0, from.1), Point::new(to.0, to.1)]],
        lines: vec![0],
        ..SegmentBatch::default()
    }
}

/// Inserts segments, each as a line of its own.
async fn edit(scratch: &Scratch, memory: u64, segments: &[SegmentBatch]) -> Result<(), EditError> {
    let mut transaction = Editor::open(&scratch.path, EditOptions::default().memory(memory))
        .await?
        .begin()
        .await?;
    for (batch, number) in segments.iter().zip(0..) {
        transaction.constrain(LineKind::Wall, number, batch)?;
    }
    transaction.add_sources(vec![LineSource {
        name: "walls".to_owned(),
        kind: LineKind::Wall,
        first: 0,
        lines: segments.len() as u64,
        edit: 0,
    }]);
    transaction.commit().await.map(|_| ())
}

async fn digest(scratch: &Scratch) -> Digest {
    scratch.open().await.recompute_digest().await.unwrap()
}

/// Returns the digest of a file with these bytes, or `None` if reading it returns an error.
async fn digest_of(bytes: Vec<u8>) -> Option<Digest> {
    open_bytes(bytes).await.ok()?.recompute_digest().await.ok()
}

fn walls() -> Vec<SegmentBatch> {
    vec![
        segment((0.0, 1.0), (29.0, 12.0)),
        segment((3.0, 25.0), (28.0, 20.0)),
        segment((5.0, 0.0), (5.0, 1.0)),
    ]
}

#[test]
fn a_crash_leaves_the_old_file_or_the_new_one() {
    runtime().block_on(async {
        let scratch = grid().await;
        let (old, before) = (digest(&scratch).await, fs::read(&scratch.path).unwrap());
        edit(&scratch, ENOUGH, &walls()).await.unwrap();
        let (new, after) = (digest(&scratch).await, fs::read(&scratch.path).unwrap());
        assert_ne!(old, new);
        assert!(before[..4096] == after[..4096], "the superblock in force has changed");
        let directory = open_bytes(before.clone()).await.unwrap().directory().await.unwrap();
        let extents = directory.tiles.iter().flat_map(|entry| [entry.core, entry.border]);
        for range in extents.map(|extent| extent.range()) {
            let range = range.start as usize..range.end as usize;
            assert!(
                before[range.clone()] == after[range],
                "what readers look at has changed"
            );
        }

        // Before the superblock is written: the file is cut off at any length, and any sectors are
        // missing.
        for end in (before.len()..after.len()).step_by(4999) {
            let mut bytes = after[..end].to_vec();
            bytes[..8192].copy_from_slice(&before[..8192]);
            // Of the bytes before the former end, too, any sectors may be new.
            for sector in (8192..before.len())
                .step_by(512)
                .filter(|sector| (sector + end) % 5 < 2)
            {
                let sector = sector..before.len().min(sector + 512);
                bytes[sector.clone()].copy_from_slice(&before[sector]);
            }
            assert_eq!(digest_of(bytes.clone()).await, Some(old), "cut off at {end}");
            for sector in bytes[before.len()..].chunks_mut(512).step_by(3) {
                sector.fill(0);
            }
            assert_eq!(
                digest_of(bytes).await,
                Some(old),
                "with sectors missing, cut off at {end}"
            );
        }
        // A superblock that is only partly written, from the front or from the back.
        let mut seen = [false; 2];
        for cut in (0..=4096).step_by(61).chain([4095, 4096]) {
            for is_front in [true, false] {
                let mut bytes = after.clone();
                let torn = if is_front { 4096 + cut..8192 } else { 4096..8192 - cut };
                bytes[torn.clone()].copy_from_slice(&before[torn]);
                let found = digest_of(bytes).await;
                assert!(found == Some(old) || found == Some(new), "torn at {cut}");
                seen[usize::from(found == Some(new))] = true;
            }
        }
        assert_eq!(seen, [true; 2]);
        // A medium that breaks its promise, so the superblock is there before the rest: an error or
        // the right answer.
        for sector in (before.len()..after.len()).step_by(512) {
            let mut bytes = after.clone();
            let end = after.len().min(sector + 512);
            bytes[sector..end].fill(0);
            let found = digest_of(bytes).await;
            assert!(found.is_none_or(|found| found == new), "sector at {sector}");
        }
    });
}

#[test]
fn an_edit_overwrites_what_an_unfinished_edit_left() {
    runtime().block_on(async {
        let (scratch, other) = (grid().await, grid().await);
        edit(&scratch, ENOUGH, &walls()).await.unwrap();
        let mut bytes = fs::read(&other.path).unwrap();
        bytes.extend((0..1_000_000u32).map(|i| i as u8));
        fs::write(&other.path, bytes).unwrap();
        edit(&other, ENOUGH, &walls()).await.unwrap();
        let reader = other.open().await;
        assert_eq!(reader.recompute_digest().await.unwrap(), digest(&scratch).await);
        assert_eq!(reader.file_length(), scratch.open().await.file_length());
    });
}

#[test]
fn an_open_reader_sees_no_edits_and_a_new_reader_sees_all() {
    runtime().block_on(async {
        let (scratch, other) = (grid().await, grid().await);
        let first = scratch.open().await;
        let old = first.recompute_digest().await.unwrap();
        for wall in walls() {
            edit(&scratch, ENOUGH, &[wall]).await.unwrap();
        }
        assert_eq!(first.recompute_digest().await.unwrap(), old);
        assert_eq!(first.generation(), 1);
        let reader = scratch.open().await;
        assert_eq!(reader.generation(), 4);
        edit(&other, ENOUGH, &walls()).await.unwrap();
        assert_eq!(reader.recompute_digest().await.unwrap(), digest(&other).await);
        let lists = reader.lists().await.unwrap();
        assert_eq!(
            lists.lines.iter().map(|lines| lines.first).collect::<Vec<_>>(),
            [0, 1, 2]
        );
        reader.verify(true).await.unwrap();

        let length = reader.compact(&scratch.path).await.unwrap();
        assert!(length < reader.file_length());
        let compacted = scratch.open().await;
        assert_eq!(compacted.file_length(), length);
        compacted.verify(true).await.unwrap();
        let all = [&compacted, &reader, &scratch.open().await];
        for reader in all {
            assert_eq!(reader.recompute_digest().await.unwrap(), digest(&other).await);
        }
        // The compacted file can be edited.
        edit(&scratch, ENOUGH, &[segment((0.0, 29.0), (1.0, 29.0))])
            .await
            .unwrap();
        scratch.open().await.verify(true).await.unwrap();
    });
}

#[test]
fn a_file_that_becomes_longer_while_it_is_opened_is_not_cut_off() {
    runtime().block_on(async {
        let scratch = grid().await;
        let file = ThreadsFile::open(&scratch.path).unwrap();
        let length = fs::metadata(&scratch.path).unwrap().len();
        edit(&scratch, ENOUGH, &walls()).await.unwrap();
        assert!(fs::metadata(&scratch.path).unwrap().len() > length);
        let opening = TileReader::open_source(file, "longer", OpenOptions::default());
        let reader = opening.await.unwrap();
        assert_eq!(reader.recompute_digest().await.unwrap(), digest(&scratch).await);
        reader.verify(true).await.unwrap();
    });
}

#[test]
fn a_reader_that_is_refreshed_sees_the_edits_and_its_clones_do_not() {
    runtime().block_on(async {
        let scratch = grid().await;
        let mut reader = scratch.open().await;
        let old = reader.recompute_digest().await.unwrap();
        assert!(!reader.refresh().await.unwrap());
        let clone = reader.clone();
        for wall in walls() {
            edit(&scratch, ENOUGH, &[wall]).await.unwrap();
            assert!(reader.refresh().await.unwrap());
            assert_eq!(reader.recompute_digest().await.unwrap(), digest(&scratch).await);
        }
        // The file is another one after this, with the same content.
        reader.compact(&scratch.path).await.unwrap();
        edit(&scratch, ENOUGH, &[segment((0.0, 29.0), (1.0, 29.0))])
            .await
            .unwrap();
        assert!(reader.refresh().await.unwrap());
        assert_eq!(reader.recompute_digest().await.unwrap(), digest(&scratch).await);
        assert_eq!(clone.recompute_digest().await.unwrap(), old);
        // If the file is gone, the reader keeps what it has.
        fs::remove_file(&scratch.path).unwrap();
        assert!(reader.refresh().await.is_err());
        reader.verify(true).await.unwrap();
    });
}

#[test]
fn refused_edits_change_nothing() {
    runtime().block_on(async {
        let scratch = grid().await;
        edit(&scratch, ENOUGH, &walls()[..1]).await.unwrap();
        let before = fs::read(&scratch.path).unwrap();
        let refused = async |memory, batch: &SegmentBatch| {
            let error = edit(&scratch, memory, std::slice::from_ref(batch)).await.unwrap_err();
            let after = fs::read(&scratch.path).unwrap();
            assert_eq!(after[..before.len()], before, "{error}");
            error
        };
        let error = refused(ENOUGH, &segment((10.0, 0.0), (11.0, 29.0))).await;
        let EditError::Crossed { line, other, edge, .. } = error else {
            panic!("{error}")
        };
        assert_eq!((line.number(), other.map(|other| other.number())), (1, Some(0)));
        assert_eq!(edge.map(|end| end.x), [0.0, 29.0]);
        let records = SegmentBatch {
            records: vec![[0, 1]],
            lines: vec![0],
            ..SegmentBatch::default()
        };
        assert!(matches!(refused(ENOUGH, &records).await, EditError::Records));
        let error = refused(100, &segment((0.0, 0.0), (0.0, 1.0))).await;
        assert!(matches!(error, EditError::Memory(_)), "{error}");
        let lock = File::open(&scratch.path).unwrap();
        lock.lock().unwrap();
        let error = refused(ENOUGH, &segment((0.0, 0.0), (0.0, 1.0))).await;
        assert!(matches!(error, EditError::Busy(_)), "{error}");
        drop(lock);
        // New lines get the numbers after those in the file, so these must not change during an
        // edit.
        let first = Editor::open(&scratch.path, EditOptions::default().memory(ENOUGH))
            .await
            .unwrap()
            .begin()
            .await
            .unwrap();
        let second = Editor::open(&scratch.path, EditOptions::default().memory(ENOUGH))
            .await
            .err();
        assert!(matches!(second, Some(EditError::Busy(_))), "{second:?}");
        drop(first);
        edit(&scratch, ENOUGH, &[segment((0.0, 0.0), (0.0, 1.0))])
            .await
            .unwrap();
    });
}

/// Reads ahead of an edit that failed may still be in progress.
#[test]
fn an_edit_that_failed_leaves_the_file_unlocked() {
    runtime().block_on(async {
        let scratch = grid_in_tiles_of(20).await;
        for _ in 0..300 {
            let missing = edited(&scratch, ENOUGH, |transaction| {
                let line = segment((0.0, 1.0), (29.0, 12.0));
                transaction.unconstrain(LineKind::Wall, 0, &line).unwrap();
            });
            let error = missing.await.unwrap_err();
            assert!(matches!(error, EditError::NoLine { .. }), "{error}");
        }
    });
}

/// An edit reads the tiles that a line crosses and their neighbours, and writes the former: the
/// component tables say what it must know of the others.
#[test]
fn an_edit_reads_and_writes_only_tiles_near_its_lines() {
    runtime().block_on(async {
        let points: Vec<Point> = (0..40_000)
            .map(|i| Point::new(f64::from(i % 200), f64::from(i / 200)))
            .collect();
        let scratch = built(&points, BuildOptions::default().tile_vertices(100)).await.0;
        let tiles = scratch.open().await.metadata().tiles;
        assert!(tiles >= 400, "{tiles}");
        // Lines without and with an obstacle that divides the plane, far apart.
        let square = [(50.5, 50.5), (57.5, 50.5), (57.5, 57.5), (50.5, 57.5), (50.5, 50.5)];
        let square = SegmentBatch {
            ends: square
                .windows(2)
                .map(|ends| [ends[0], ends[1]].map(|(x, y)| Point::new(x, y)))
                .collect(),
            lines: vec![0; 4],
            ..SegmentBatch::default()
        };
        for (kind, batch) in [
            (LineKind::Wall, segment((120.0, 130.5), (122.5, 131.0))),
            (LineKind::Obstacle, square.clone()),
            (LineKind::BreakLine, segment((10.0, 190.5), (12.5, 191.0))),
        ] {
            let mut transaction = Editor::open(&scratch.path, EditOptions::default().memory(ENOUGH))
                .await
                .unwrap()
                .begin()
                .await
                .unwrap();
            let before = scratch.open().await.file_length();
            transaction.constrain(kind, 0, &batch).unwrap();
            let summary = transaction.commit().await.unwrap();
            // A cell has at most 8 neighbours, and four cells meet where the square is.
            assert!((1..=9).contains(&summary.tiles_written), "{summary:?}");
            assert!((1..=40).contains(&summary.tile_reads), "{summary:?}");
            assert!(summary.file_bytes - before < 200_000, "{summary:?}");
            let reader = scratch.open().await;
            reader.verify(true).await.unwrap();
            assert_eq!(reader.recompute_digest().await.unwrap(), reader.metadata().digest);
        }
        let metadata = scratch.open().await.metadata().clone();
        assert_eq!((metadata.regions, metadata.hole_regions), (2, 1));
    });
}

#[test]
fn tiles_that_are_evicted_repeatedly_do_not_make_the_file_grow() {
    runtime().block_on(async {
        // Lines across all tiles, in an order that loads each tile again and again into a small
        // cache.
        let walls: Vec<SegmentBatch> = (1..14)
            .map(|i| {
                segment(
                    (0.0, f64::from(2 * (i * 5 % 14))),
                    (29.0, f64::from(2 * (i * 5 % 14) + 1)),
                )
            })
            .collect();
        let (scratch, other) = (grid_in_tiles_of(120).await, grid_in_tiles_of(120).await);
        let before = scratch.open().await.file_length();
        edit(&scratch, 113 << 10, &walls).await.unwrap();
        edit(&other, ENOUGH, &walls).await.unwrap();
        let reader = scratch.open().await;
        assert_eq!(reader.recompute_digest().await.unwrap(), digest(&other).await);
        reader.verify(true).await.unwrap();
        let grown = [&reader, &other.open().await].map(|reader| reader.file_length() - before);
        assert!(grown[0] < 2 * grown[1], "{grown:?}");
    });
}
