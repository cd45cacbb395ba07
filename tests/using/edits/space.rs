//! The promise: a file that is changed again and again does not grow without end, and nobody who
//! reads an earlier state of it is disturbed.

use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::PointBatch;
use delaunay_tiles::store::TileReader;
use delaunay_tiles::{EditOptions, Editor};

use crate::edits::{ENOUGH, digest, grid};
use crate::support::{Random, Scratch, runtime};

/// Moves a few points of the grid a little, or back. Returns the length of the file.
async fn change(scratch: &Scratch, random: &mut Random) -> u64 {
    let mut transaction = Editor::open(&scratch.path, EditOptions::default().memory(ENOUGH))
        .await
        .unwrap()
        .begin()
        .await
        .unwrap();
    for _ in 0..1 + random.below(4) {
        let place = Point::new(random.below(30) as f64, random.below(30) as f64);
        let beside = Point::new(place.x + 0.25, place.y + 0.125);
        let pair = [place, beside];
        let there = PointBatch {
            points: vec![pair[random.below(2)]],
            records: vec![0],
            z: Vec::new(),
        };
        transaction.insert(&there).unwrap();
        transaction.skip_missing(true);
        transaction.delete(&[pair[random.below(2)]]).unwrap();
    }
    transaction.commit().await.unwrap().file_bytes
}

async fn compact_length(scratch: &Scratch) -> u64 {
    let copy = Scratch::new();
    scratch.open().await.compact(&copy.path).await.unwrap()
}

#[test]
fn a_file_under_steady_change_stays_within_twice_its_compact_size() {
    runtime().block_on(async {
        let scratch = grid().await;
        let mut random = Random(5);
        for commit in 0..300 {
            let length = change(&scratch, &mut random).await;
            if commit % 50 == 49 {
                let reader = scratch.open().await;
                reader.verify(true).await.unwrap();
                let compact = compact_length(&scratch).await;
                assert!(
                    length <= 2 * compact,
                    "{length} bytes after {commit} commits, compact {compact}"
                );
            }
        }
    });
}

#[test]
fn readers_of_earlier_states_keep_what_they_read() {
    runtime().block_on(async {
        let scratch = grid().await;
        let mut random = Random(6);
        let mut readers: Vec<(TileReader, _)> = Vec::new();
        for commit in 0..60 {
            if commit % 7 == 3 {
                readers.push((scratch.open().await, digest(&scratch).await));
            }
            change(&scratch, &mut random).await;
            // Some end, in any order.
            if commit % 11 == 10 {
                readers.swap_remove(random.below(readers.len()));
            }
            for (reader, before) in &readers {
                assert_eq!(reader.recompute_digest().await.unwrap(), *before, "{commit}");
                reader.verify(true).await.unwrap();
            }
        }
        // A clone protects what it reads when the first reader has ended, and so does a pass.
        let (reader, before) = readers.pop().unwrap();
        readers.clear();
        let clone = reader.clone();
        drop(reader);
        let grown: Vec<u64> = [change(&scratch, &mut random).await, change(&scratch, &mut random).await].into();
        assert_eq!(clone.recompute_digest().await.unwrap(), before);
        clone.verify(true).await.unwrap();
        assert!(grown[0] < grown[1], "with a reader, nothing is overwritten: {grown:?}");
        // Without readers, the file grows no more.
        drop(clone);
        for _ in 0..10 {
            assert_eq!(change(&scratch, &mut random).await, grown[1]);
        }
        scratch.open().await.verify(true).await.unwrap();
    });
}
