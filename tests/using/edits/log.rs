//! The promise: a transaction that was acknowledged in the log is in the file after the next
//! checkpoint, or after the next opening, once, whatever was cut off or is beside the file. The file
//! is then what a build gives.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::PointBatch;
use delaunay_tiles::overviews::OverviewOptions;
use delaunay_tiles::store::{Digest, LogError};
use delaunay_tiles::{BuildOptions, Durability, EditError, EditOptions, EditSummary, Editor, OpenOptions, TileReader};

use crate::edits::scene::{Scene, checked, checked_outcome, key, random_scene};
use crate::edits::{digest, grid, grid_in_tiles_of};
use crate::support::cases::seeds;
use crate::support::{Random, Scratch, built, points_of, runtime};

fn options() -> EditOptions {
    EditOptions::default().memory(1 << 20).durability(Durability::Log)
}

async fn opened(path: &Path) -> Editor {
    Editor::open(path, options()).await.unwrap()
}

fn log_of(path: &Path) -> PathBuf {
    path.with_added_extension("log")
}

async fn insert(editor: &Editor, points: &[Point]) -> Result<EditSummary, EditError> {
    let mut transaction = editor.begin().await?;
    transaction.insert(&PointBatch {
        records: (0..points.len() as u64).collect(),
        points: points.to_vec(),
        z: vec![],
    })?;
    transaction.commit().await
}

async fn delete(editor: &Editor, points: &[Point]) -> Result<EditSummary, EditError> {
    let mut transaction = editor.begin().await?;
    transaction.delete(points)?;
    transaction.commit().await
}

/// Copies a file and its log, as a crash would leave them, and opens the copy. Returns its digest.
async fn after_a_crash(scratch: &Scratch) -> Digest {
    let copy = Scratch::new();
    fs::copy(&scratch.path, &copy.path).unwrap();
    if log_of(&scratch.path).exists() {
        fs::copy(log_of(&scratch.path), log_of(&copy.path)).unwrap();
    }
    drop(opened(&copy.path).await);
    assert!(!log_of(&copy.path).exists());
    checked(&copy).await
}

/// Changes a random scene in logged transactions. Returns the number of those that went to the log.
async fn check_sequence(seed: u64, kinds: Range<usize>) -> u64 {
    let mut random = Random(seed);
    let (mut scene, at) = random_scene(&mut random, kinds).await;
    let scratch = scene.build(4 + random.below(60)).await.unwrap();
    let mut logged = 0;
    let mut editor = opened(&scratch.path).await;
    for _ in 0..1 + random.below(12) {
        let former = scene.clone();
        let mut transaction = editor.begin().await.unwrap();
        for _ in 0..1 + random.below(6) {
            scene.change(&mut transaction, &mut random, &at);
        }
        let is_mistaken = random.below(6) == 0;
        if is_mistaken {
            transaction.delete(&[Point::new(1e9, 1e9)]).unwrap();
        }
        let committed = transaction.commit().await;
        match &committed {
            Ok(summary) => logged += u64::from(summary.pending_transactions > 0),
            Err(EditError::NoPoint { .. }) if is_mistaken => scene = former.clone(),
            Err(EditError::LinesCross { .. }) => scene = former.clone(),
            Err(error) => panic!("seed {seed}: {error}"),
        }
        if let Ok(summary) = committed
            && scene.lines.is_empty()
            && scene.sites.is_empty()
        {
            assert_eq!(summary.vertices, scene.points.len() as u64, "seed {seed}");
        }
        let expected = async || checked(&scene.build(30).await.unwrap()).await;
        match random.below(4) {
            0 => {
                let before = checked(&scratch).await;
                if let Some(made) = editor.checkpoint().await.unwrap() {
                    checked_outcome(Ok(made), &scratch, &scene, before, seed).await;
                }
                assert_eq!(checked(&scratch).await, expected().await, "seed {seed}");
            }
            1 => assert_eq!(after_a_crash(&scratch).await, expected().await, "seed {seed}"),
            2 => {
                drop(editor);
                editor = opened(&scratch.path).await;
                assert_eq!(checked(&scratch).await, expected().await, "seed {seed}");
            }
            _ => {}
        }
    }
    logged
}

#[test]
fn logged_transactions_give_what_a_build_gives() {
    runtime().block_on(async {
        let (of_points, of_all, mut logged) = (seeds(240), seeds(80), 0);
        for &seed in &of_points {
            logged += check_sequence(seed, 0..3).await;
        }
        assert!(logged > 3 * of_points.len() as u64, "{logged}");
        for seed in of_all {
            check_sequence(seed, 3..7).await;
        }
    });
}

#[test]
fn readers_see_logged_transactions_after_the_checkpoint() {
    runtime().block_on(async {
        let scratch = grid().await;
        let before = digest(&scratch).await;
        let editor = opened(&scratch.path).await;
        let new = [Point::new(3.5, 4.5), Point::new(100.0, 1.0)];
        let summary = insert(&editor, &new).await.unwrap();
        assert_eq!(
            (summary.points.inserted, summary.vertices, summary.pending_transactions),
            (2, 902, 1)
        );
        // The second transaction meets what the first one left.
        let summary = insert(&editor, &new).await.unwrap();
        assert_eq!(
            (
                summary.points.duplicates,
                summary.vertices,
                summary.pending_transactions
            ),
            (2, 902, 2)
        );
        assert!(matches!(
            delete(&editor, &[Point::new(0.5, 0.5)]).await,
            Err(EditError::NoPoint { count: 1, .. })
        ));
        let summary = delete(&editor, &[new[0]]).await.unwrap();
        assert_eq!(
            (summary.points.deleted, summary.vertices, summary.pending_transactions),
            (1, 901, 3)
        );
        assert_eq!(digest(&scratch).await, before);
        let made = editor.checkpoint().await.unwrap().unwrap();
        assert_eq!(
            (made.points.inserted, made.vertices, made.pending_transactions),
            (2, 901, 0)
        );
        assert!(editor.checkpoint().await.unwrap().is_none());
        let reader = scratch.open().await;
        assert_eq!(reader.metadata().vertices, 901);
        assert_eq!(reader.metadata().last_transaction, 3);
        assert!(!log_of(&scratch.path).exists());
    });
}

#[test]
fn large_transactions_and_those_with_lines_are_made_in_the_file_after_the_log() {
    runtime().block_on(async {
        let scratch = grid().await;
        let editor = opened(&scratch.path).await;
        insert(&editor, &[Point::new(3.5, 4.5)]).await.unwrap();
        let many = points_of(distributions::Kind::Uniform, 5000, 3);
        let summary = insert(&editor, &many).await.unwrap();
        assert_eq!((summary.vertices, summary.pending_transactions), (5901, 0));
        assert!(!log_of(&scratch.path).exists());
        assert_eq!(scratch.open().await.metadata().last_transaction, 2);
        insert(&editor, &[Point::new(4.5, 4.5)]).await.unwrap();
        let mut transaction = editor.begin().await.unwrap();
        let wall = super::segment((4.5, 4.5), (3.5, 4.5));
        transaction
            .constrain(delaunay_tiles::store::LineKind::Wall, 0, &wall)
            .unwrap();
        let summary = transaction.commit().await.unwrap();
        assert_eq!(
            (summary.added_vertices, summary.vertices, summary.pending_transactions),
            (0, 5902, 0)
        );
        // From now on there is a line.
        let summary = insert(&editor, &[Point::new(5.5, 4.5)]).await.unwrap();
        assert_eq!((summary.vertices, summary.pending_transactions), (5903, 0));
        scratch.open().await.verify(true).await.unwrap();
    });
}

#[test]
fn lines_take_their_z_from_the_surface_with_what_is_in_the_log() {
    runtime().block_on(async {
        let mut digests = Vec::new();
        for durability in [Durability::Log, Durability::File] {
            let mut scene = Scene {
                has_z: true,
                ..Scene::default()
            };
            let corners = [(0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (0.0, 9.0)].map(|(x, y)| Point::new(x, y));
            scene.points.extend(corners.map(|p| (key(p), (p, 0.0))));
            let scratch = scene.build(50).await.unwrap();
            let editor = Editor::open(&scratch.path, options().durability(durability))
                .await
                .unwrap();
            let mut transaction = editor.begin().await.unwrap();
            let top = [(Point::new(4.5, 4.5), 100.0)];
            transaction.insert(&scene.batch(top.into_iter())).unwrap();
            let logged = transaction.commit().await.unwrap().pending_transactions;
            assert_eq!(logged > 0, durability == Durability::Log);
            let mut transaction = editor.begin().await.unwrap();
            let line = super::segment((4.5, 4.0), (3.0, 3.5));
            transaction
                .constrain(delaunay_tiles::store::LineKind::BreakLine, 0, &line)
                .unwrap();
            transaction.commit().await.unwrap();
            digests.push(checked(&scratch).await);
        }
        assert_eq!(digests[0], digests[1]);
    });
}

/// Logs three transactions. Returns the digests after none to all of them.
async fn three_logged(scratch: &Scratch) -> [Digest; 4] {
    let mut digests = [digest(scratch).await; 4];
    let reference = Scratch::new();
    fs::copy(&scratch.path, &reference.path).unwrap();
    let editor = opened(&scratch.path).await;
    let in_file = Editor::open(&reference.path, EditOptions::default().memory(1 << 20))
        .await
        .unwrap();
    for (number, x) in [3.25, 4.25, 5.25].into_iter().enumerate() {
        let points = [Point::new(x, 7.5), Point::new(x, 60.0)];
        insert(&editor, &points[..1 + number % 2]).await.unwrap();
        insert(&in_file, &points[..1 + number % 2]).await.unwrap();
        digests[number + 1] = digest(&reference).await;
    }
    digests
}

#[test]
fn a_log_that_was_cut_off_has_the_transactions_before() {
    runtime().block_on(async {
        let scratch = grid().await;
        let digests = three_logged(&scratch).await;
        let log = fs::read(log_of(&scratch.path)).unwrap();
        let file = fs::read(&scratch.path).unwrap();
        let mut found = Vec::new();
        for length in (48..=log.len()).rev() {
            fs::write(&scratch.path, &file).unwrap();
            fs::write(log_of(&scratch.path), &log[..length]).unwrap();
            drop(opened(&scratch.path).await);
            found.push(digest(&scratch).await);
        }
        found.dedup();
        let expected: Vec<Digest> = digests.into_iter().rev().collect();
        assert_eq!(found, expected);
        for length in 0..48 {
            fs::write(&scratch.path, &file).unwrap();
            fs::write(log_of(&scratch.path), &log[..length]).unwrap();
            let error = Editor::open(&scratch.path, options()).await.err().unwrap();
            assert!(
                matches!(error, EditError::Log(LogError::Damaged { .. })),
                "{length}: {error}"
            );
        }
    });
}

#[test]
fn a_damaged_log_is_refused_or_ends_where_the_damage_is() {
    runtime().block_on(async {
        let scratch = grid().await;
        let digests = three_logged(&scratch).await;
        let log = fs::read(log_of(&scratch.path)).unwrap();
        let file = fs::read(&scratch.path).unwrap();
        let mut refused = 0;
        for at in 0..log.len() {
            let mut damaged = log.clone();
            damaged[at] ^= 1 << (at % 8);
            fs::write(&scratch.path, &file).unwrap();
            fs::write(log_of(&scratch.path), damaged).unwrap();
            match Editor::open(&scratch.path, options()).await {
                Ok(_) => assert!(digests[..3].contains(&digest(&scratch).await), "byte {at}"),
                Err(EditError::Log(_)) => {
                    refused += 1;
                    assert_eq!(fs::read(&scratch.path).unwrap(), file, "byte {at}");
                }
                Err(error) => panic!("byte {at}: {error}"),
            }
        }
        // The head, and transactions before others.
        assert!(refused > 44, "{refused}");
    });
}

#[test]
fn transactions_are_never_made_twice() {
    runtime().block_on(async {
        // A few changes are made in the file; many, in all tiles, build it anew.
        for (points, gone) in [(900, 1), (100_000, 4000)] {
            let points = points_of(distributions::Kind::Uniform, points, 7);
            let (scratch, _) = built(&points, BuildOptions::default()).await;
            let editor = Editor::open(&scratch.path, options().memory(64 << 20)).await.unwrap();
            let id = scratch.open().await.file_id();
            let points = points[..gone].to_vec();
            delete(&editor, &points).await.unwrap();
            let log = fs::read(log_of(&scratch.path)).unwrap();
            editor.checkpoint().await.unwrap().unwrap();
            drop(editor);
            let expected = digest(&scratch).await;
            let file = fs::read(&scratch.path).unwrap();
            // As if the process had ended before the log was removed.
            fs::write(log_of(&scratch.path), &log).unwrap();
            let editor = Editor::open(&scratch.path, options().memory(64 << 20)).await.unwrap();
            assert_eq!(fs::read(&scratch.path).unwrap(), file);
            assert!(!log_of(&scratch.path).exists());
            assert_eq!(scratch.open().await.file_id() != id, gone > 1);
            insert(&editor, &points).await.unwrap();
            editor.checkpoint().await.unwrap().unwrap();
            assert_ne!(digest(&scratch).await, expected);
            scratch.open().await.verify(true).await.unwrap();
        }
    });
}

#[test]
fn the_log_of_another_file_is_refused_and_a_build_removes_it() {
    runtime().block_on(async {
        let scratch = grid().await;
        insert(&opened(&scratch.path).await, &[Point::new(0.5, 0.5)])
            .await
            .unwrap();
        let log = fs::read(log_of(&scratch.path)).unwrap();
        let other = grid_in_tiles_of(50).await;
        fs::write(log_of(&other.path), &log).unwrap();
        let error = Editor::open(&other.path, options()).await.err().unwrap();
        assert!(matches!(error, EditError::Log(LogError::OfAnother { .. })), "{error}");
        let points = points_of(distributions::Kind::Uniform, 100, 3);
        let options = BuildOptions::default().force(true);
        crate::support::build_batches(&other.path, &crate::support::batches(&points, &[]), options)
            .await
            .unwrap();
        assert!(!log_of(&other.path).exists());
        drop(opened(&other.path).await);
    });
}

#[test]
fn overviews_that_are_made_meanwhile_leave_the_log_as_it_is() {
    runtime().block_on(async {
        let (scratch, _) = built(
            &points_of(distributions::Kind::Uniform, 3000, 5),
            BuildOptions::default(),
        )
        .await;
        insert(&opened(&scratch.path).await, &[Point::new(5.0, 5.0)])
            .await
            .unwrap();
        delaunay_tiles::overviews::make(&scratch.path, OverviewOptions::default())
            .await
            .unwrap();
        drop(opened(&scratch.path).await);
        let reader = TileReader::open(&scratch.path, OpenOptions::default()).await.unwrap();
        assert_eq!(reader.metadata().vertices, 3001);
    });
}
