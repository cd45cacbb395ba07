//! The promise: after lines were removed, and sites changed, the file is the one that a build of the
//! others gives, whatever the tiles, and whether the lines were given by geometry or by number.

use std::ops::Range;

use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::SiteBatch;
use delaunay_tiles::store::{EdgeSource, LineBatch, LineKind, LinePart};
use delaunay_tiles::{EditOptions, Editor, Transaction};

use crate::edits::scene::{
    Line, Scene, batch_of_line, batch_of_sites, checked, checked_outcome, random_line, random_scene, random_site,
    source,
};
use crate::support::cases::seeds;
use crate::support::{Random, Scratch, runtime};

/// So little memory that tiles must leave the cache and come back.
const LITTLE: u64 = 256 << 10;

/// Removes some lines of a random scene a few times, while others come and points change. Returns
/// the number of edits that were made.
async fn check_sequence(seed: u64, kinds: Range<usize>) -> u64 {
    let mut random = Random(seed);
    let (mut scene, at) = random_scene(&mut random, kinds).await;
    let scratch = scene.build(4 + random.below(60)).await.unwrap();
    // Of equal lines, the one with the smallest number goes, which the scene does not tell apart.
    let mut are_numbers_known = true;
    let mut edits = 0;
    for _ in 0..1 + random.below(4) {
        let before = checked(&scratch).await;
        let former = scene.clone();
        let mut transaction = Editor::open(&scratch.path, EditOptions::default().memory(LITTLE))
            .await
            .unwrap()
            .begin()
            .await
            .unwrap();
        transaction.prefer_build(random.below(4) == 0);
        let by_number = are_numbers_known && random.below(2) == 0;
        are_numbers_known &= by_number;
        let gone = scene.lines.len().min(1 + random.below(scene.lines.len().max(1)));
        for number in 0..gone as u64 {
            let line = scene.lines.swap_remove(random.below(scene.lines.len()));
            if by_number {
                transaction.remove_lines(&[line.number]);
            } else {
                // The direction does not matter, but to obstacles.
                let mut corners = line.corners;
                if line.kind != LineKind::Obstacle && random.below(2) == 0 {
                    corners.reverse();
                }
                transaction
                    .unconstrain(line.kind, number, &batch_of_line(&corners))
                    .unwrap();
            }
        }
        let mut come = 0;
        for _ in 0..random.below(3) {
            let (kind, corners) = random_line(&mut random, &at);
            let number = transaction.first_line() + come;
            let batch = batch_of_line(&corners);
            scene.lines.push(Line { kind, corners, number });
            if scene.build(16).await.is_err() {
                scene.lines.pop();
                continue;
            }
            transaction.constrain(kind, come, &batch).unwrap();
            transaction.add_sources(vec![source(kind, come)]);
            come += 1;
        }
        for _ in 0..random.below(4) {
            scene.change(&mut transaction, &mut random, &at);
        }
        change_sites(&mut scene, &mut transaction, &mut random, &at);
        match checked_outcome(transaction.commit().await, &scratch, &scene, before, seed).await {
            Some(_) => {
                edits += 1;
                compare_lines(&scratch, &scene, seed).await;
            }
            None => scene = former,
        }
    }
    edits
}

/// Inserts and deletes some sites, in an editor and in a scene.
fn change_sites(
    scene: &mut Scene,
    transaction: &mut Transaction,
    random: &mut Random,
    at: &dyn Fn(&mut Random) -> Point,
) {
    for _ in 0..random.below(4) {
        if random.below(2) == 0 || scene.sites.is_empty() {
            let site = random_site(random, at);
            transaction
                .insert_sites(&batch_of_sites(std::slice::from_ref(&site)))
                .unwrap();
            scene.sites.push(site);
        } else {
            let (gone, _) = scene.sites[random.below(scene.sites.len())];
            transaction.delete_sites(&[gone]).unwrap();
            scene.sites.retain(|(point, _)| *point != gone);
        }
    }
}

/// Asserts that the lines and sites of a file are those of a scene, and no others.
async fn compare_lines(scratch: &Scratch, scene: &Scene, seed: u64) {
    let reader = scratch.open().await;
    let mut lines = scene.lines.iter();
    let next = |batch: &mut LineBatch| -> Result<bool, String> {
        let Some(line) = lines.next() else { return Ok(false) };
        let part = LinePart::whole(EdgeSource::new(line.kind, line.number));
        batch.ends = batch_of_line(&line.corners).ends;
        batch.sources = vec![part; batch.ends.len()];
        Ok(true)
    };
    let verified = reader.verify_lines(next).await;
    assert!(verified.is_ok(), "seed {seed}: {verified:?}");
    assert_eq!(reader.metadata().sites, scene.sites.len() as u64);
    for left in [0, 1] {
        let sites = batch_of_sites(&scene.sites[..scene.sites.len().saturating_sub(left)]);
        let mut sites = Some(sites).filter(|sites| left == 0 || sites.len() < scene.sites.len());
        let next = |batch: &mut SiteBatch| -> Result<bool, String> {
            *batch = sites.take().unwrap_or_default();
            Ok(!batch.is_empty())
        };
        let verified = reader.verify_sites(next).await;
        assert_eq!(verified.is_ok(), left == 0 || scene.sites.is_empty(), "{verified:?}");
    }
    if let Some(last) = scene.lines.last() {
        let mut left = scene.lines[..scene.lines.len() - 1].iter();
        let is_there_twice = left.clone().any(|line| line.kind == last.kind);
        let next = |batch: &mut LineBatch| -> Result<bool, String> {
            let Some(line) = left.next() else { return Ok(false) };
            let part = LinePart::whole(EdgeSource::new(line.kind, 0));
            batch.ends = batch_of_line(&line.corners).ends;
            batch.sources = vec![part; batch.ends.len()];
            Ok(true)
        };
        // A line of another kind is missed, wherever it runs.
        let is_point = last.corners.iter().all(|corner| *corner == last.corners[0]);
        assert!(is_there_twice || is_point || reader.verify_lines(next).await.is_err());
    }
}

#[test]
fn random_sequences_with_lines_that_go_give_what_a_build_gives() {
    runtime().block_on(async {
        let (seeds, mut edits) = (seeds(300), 0);
        for &seed in &seeds {
            edits += check_sequence(seed, 3..5).await;
        }
        assert!(3 * edits > 5 * seeds.len() as u64, "{edits}");
    });
}

#[test]
fn lines_come_to_files_without_triangles_and_leave_files_without() {
    runtime().block_on(async {
        // Sites with numbers and sites with texts as their ids, in a file that is built anew.
        check_sequence(500_721, 6..7).await;
        let (seeds, mut edits) = (seeds(120), 0);
        for &seed in &seeds {
            edits += check_sequence(seed, 6..7).await;
        }
        assert!(3 * edits > 5 * seeds.len() as u64, "{edits}");
    });
}
