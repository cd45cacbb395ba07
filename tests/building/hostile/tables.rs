//! Component tables that say what is not so, in pages and apart. Readers show what tables say, and
//! edits rely on them, so `verify` must find every fault.

use std::fs;

use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::SegmentBatch;
use delaunay_tiles::store::{Digest, LineKind, TileReader};
use delaunay_tiles::{EditError, EditOptions, Editor};
use futures::stream::TryStreamExt;

use super::digest::fix_digest;
use super::surgery::Patient;
use super::town::town;
use super::{digest_of, message};
use crate::support::cases::by_turns;
use crate::support::{Random, Scratch, open_bytes, runtime};

/// The offset of the checksum in an extent.
const CRC: usize = 12;

/// Returns the offsets of all bytes that say what tables there are, and what they say, but not of
/// the checksums of extents, which are made right.
fn bytes_of_tables(patient: &Patient) -> Vec<usize> {
    let tables = patient.tables.iter().map(|part| part.at..part.at + part.length);
    let in_pages = [&patient.tables_in_pages, &patient.table_lengths].into_iter().flatten();
    let extents = patient.tables_apart.iter().flat_map(|all| all.clone().step_by(16));
    let extents = extents.map(|at| at..at + CRC);
    tables.chain(in_pages.cloned()).chain(extents).flatten().collect()
}

/// Returns region, depth and hole flag of each triangle.
async fn labels(reader: &TileReader) -> Vec<(u64, i32, bool)> {
    let mut labels = Vec::new();
    let mut tiles = reader.tiles();
    while let Some(tile) = tiles.try_next().await.unwrap() {
        let of = |triangle| (tile.region(triangle), tile.depth(triangle), tile.is_hole(triangle));
        labels.extend(tile.triangle_ids().map(of));
    }
    labels
}

#[test]
fn changed_bytes_of_component_tables_in_pages_are_found() {
    let patient = runtime().block_on(town().build());
    assert!(
        patient
            .tables_in_pages
            .iter()
            .map(ExactSizeIterator::len)
            .sum::<usize>()
            > 300
    );
    changed_bytes_are_found(&patient);
}

#[test]
fn changed_bytes_of_component_tables_that_lie_apart_are_found() {
    let patient = runtime().block_on(town().build_in_tiles_of(30));
    assert!(patient.tables.len() > 1);
    changed_bytes_are_found(&patient);
}

fn changed_bytes_are_found(patient: &Patient) {
    let (town, runtime) = (town(), runtime());
    let right = runtime.block_on(digest_of(patient.bytes.clone())).unwrap();
    let right_labels = runtime.block_on(async { labels(&open_bytes(patient.bytes.clone()).await.unwrap()).await });
    let mut outcomes = [0; 3];
    for at in bytes_of_tables(patient) {
        for mask in by_turns(&[1u8, 0x02, 0x80, 0xff], at) {
            let mut mutated = patient.clone();
            mutated.bytes[at] ^= mask;
            mutated.sew();
            if mask % 2 == 1 {
                runtime.block_on(fix_digest(&mut mutated));
            }
            let story = format!("byte {at}, mask {mask}");
            let outcome = runtime.block_on(town.use_all(mutated.bytes.clone(), &right, &story));
            outcomes[outcome.map_or(0, |is_right| 1 + usize::from(is_right))] += 1;
            if outcome == Some(true) {
                let found = runtime.block_on(async { labels(&open_bytes(mutated.bytes).await.unwrap()).await });
                assert_eq!(found, right_labels, "{story}");
            }
        }
    }
    println!("refused, found, same: {outcomes:?}");
    // A flag may say that a seed lies in a component that it only touches.
    assert!(outcomes[0] + outcomes[1] > 500 && outcomes[2] < 10, "{outcomes:?}");
}

/// Makes a wall of a town.
async fn edit(scratch: &Scratch) -> Result<(), EditError> {
    let mut transaction = Editor::open(&scratch.path, EditOptions::default().memory(64 << 20))
        .await?
        .begin()
        .await?;
    let wall = SegmentBatch {
        ends: vec![[Point::new(4.5, 0.5), Point::new(4.75, 3.0)]],
        lines: vec![0],
        ..SegmentBatch::default()
    };
    transaction.constrain(LineKind::Wall, transaction.first_line(), &wall)?;
    transaction.commit().await.map(|_| ())
}

/// Returns the digest of a file after an edit, and the numbers of its regions and holes, if
/// everything succeeds.
async fn edited(scratch: &Scratch, bytes: &[u8], story: &str) -> Option<(Digest, u64, u64)> {
    fs::write(&scratch.path, bytes).unwrap();
    if let Err(error) = edit(scratch).await {
        // A thread that panicked is gone.
        assert!(!error.to_string().contains("gone"), "{story}: {error}");
        if let EditError::Read(error) = error {
            message(error);
        }
        let after = fs::read(&scratch.path).unwrap();
        assert!(after[..8192] == bytes[..8192], "{story}");
        // Only what the file does not refer to may be other.
        assert_eq!(digest_of(after).await, digest_of(bytes.to_vec()).await, "{story}");
        return None;
    }
    let reader = open_bytes(fs::read(&scratch.path).unwrap()).await.ok()?;
    let digest = reader.recompute_digest().await.ok()?;
    reader.verify(true).await.ok()?;
    let metadata = reader.metadata();
    Some((digest, metadata.regions, metadata.hole_regions))
}

/// An edit reads the tables of tiles that it does not read, so a damaged table is an error, or is
/// in the edited file too, where `verify` finds it.
#[test]
fn edits_of_files_with_changed_component_tables_give_errors_or_the_right_file() {
    let runtime = runtime();
    for tile_vertices in [8, 30] {
        edits_give_errors_or_the_right_file(&runtime.block_on(town().build_in_tiles_of(tile_vertices)));
    }
}

fn edits_give_errors_or_the_right_file(patient: &Patient) {
    let runtime = runtime();
    let scratch = Scratch::new();
    let right = runtime.block_on(edited(&scratch, &patient.bytes, "as it was built"));
    assert!(right.is_some());
    let mut random = Random(9);
    let mut outcomes = [0; 2];
    for at in bytes_of_tables(patient) {
        let mut mutated = patient.clone();
        let mask = [1, 2, 4, 8, 0x40, 0x80, 0xff][random.below(7)];
        mutated.bytes[at] ^= mask;
        mutated.sew();
        let story = format!("byte {at}, mask {mask}");
        let found = runtime.block_on(edited(&scratch, &mutated.bytes, &story));
        if found.is_some() {
            // An edit writes the tables of changed tiles anew.
            assert_eq!(found, right, "{story}");
        }
        outcomes[usize::from(found.is_some())] += 1;
    }
    println!("an error, right: {outcomes:?}");
    assert!(outcomes[0] > 200, "{outcomes:?}");
}

/// The extent of another table is one that is well formed and has its checksum.
#[test]
fn component_tables_of_other_tiles_are_found() {
    let (town, runtime) = (town(), runtime());
    let patient = runtime.block_on(town.build_in_tiles_of(30));
    let right = runtime.block_on(digest_of(patient.bytes.clone())).unwrap();
    let extents = patient.tables_apart.iter().flat_map(|all| all.clone().step_by(16));
    let extents: Vec<usize> = extents.collect();
    assert!(extents.len() > 1);
    for pair in extents.windows(2) {
        for swapped in [false, true] {
            let mut mutated = patient.clone();
            let [first, second] = [pair[0], pair[1]].map(|at| patient.bytes[at..at + 16].to_vec());
            mutated.put(pair[1], &first);
            if swapped {
                mutated.put(pair[0], &second);
            }
            // These are right already.
            mutated.tables.clear();
            mutated.sew();
            runtime.block_on(fix_digest(&mut mutated));
            let story = format!("extent {}", pair[1]);
            let outcome = runtime.block_on(town.use_all(mutated.bytes, &right, &story));
            assert_ne!(outcome, Some(true), "{story}");
        }
    }
}

/// Lists of tables whose lengths do not fit together are refused by whoever reads the page.
#[test]
fn lists_of_component_tables_of_wrong_lengths_are_refused() {
    let runtime = runtime();
    let patient = runtime.block_on(town().build());
    let lists = [&patient.tables_in_pages, &patient.table_lengths, &patient.tables_apart];
    for (list, what) in lists.into_iter().zip(["tables", "lengths", "extents"]) {
        for first in list.iter().map(|list| list.start) {
            // The number of elements stands before the first one. One less is no fault of the
            // FlatBuffer.
            let at = first - 4;
            let count = crate::support::flat::u32_at(&patient.bytes, at);
            let mut mutated = patient.clone();
            mutated.put(at, &(count - 1).to_le_bytes());
            mutated.sew();
            let found = runtime.block_on(digest_of(mutated.bytes)).unwrap_err();
            let says = "a page has lists of component tables of wrong lengths";
            assert!(found.contains(says), "{what}: {found}");
        }
    }
    for lengths in &patient.table_lengths {
        for (at, length) in lengths.clone().flat_map(|at| [57, 200, 254].map(|length| (at, length))) {
            let mut mutated = patient.clone();
            mutated.put(at, &[length]);
            mutated.sew();
            assert!(runtime.block_on(digest_of(mutated.bytes)).is_err(), "length {length}");
        }
    }
}

/// Tables that lie apart, but out of the file or over the superblocks.
#[test]
fn extents_of_component_tables_beyond_the_limits_are_refused() {
    let runtime = runtime();
    let patient = runtime.block_on(town().build_in_tiles_of(30));
    let end = patient.bytes.len() as u64;
    for at in patient.tables_apart.iter().flat_map(|all| all.clone().step_by(16)) {
        for (offset, length) in [
            (0, 100),
            (8191, 100),
            (end - 99, 100),
            (end + 1, 0),
            (u64::MAX - 50, 100),
            (8192, u32::MAX),
            (8192, (64 << 20) + 1),
        ] {
            let mut mutated = patient.clone();
            mutated.put(at, &offset.to_le_bytes());
            mutated.put(at + 8, &length.to_le_bytes());
            mutated.sew();
            let found = runtime.block_on(digest_of(mutated.bytes)).unwrap_err();
            assert!(found.contains("a component table: the extent of"), "{found}");
        }
    }
}
