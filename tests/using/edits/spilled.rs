//! The promise: changes of points that do not fit into memory go to disk, and give the same file, the same
//! counts and the same errors as those that do.

use std::f64::consts::TAU;
use std::fs;

use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::{PointBatch, SiteBatch, SiteId};
use delaunay_tiles::store::{Digest, LineKind};
use delaunay_tiles::{BuildOptions, EditError, EditSummary, Transaction};
use distributions::Kind;

use crate::edits::scene::{batch_of_line, checked, checked_outcome, random_scene, source};
use crate::edits::{ENOUGH, batch, edited};
use crate::support::cases::seeds;
use crate::support::{Random, Scratch, built, points_of, runtime};

/// Half of it holds some thousand changes.
const LITTLE: u64 = 512 << 10;

fn copy(scratch: &Scratch) -> Scratch {
    let copy = Scratch::new();
    fs::copy(&scratch.path, &copy.path).unwrap();
    copy
}

/// Returns what a file has in force, and its length.
async fn state(scratch: &Scratch) -> (Digest, u64, u64) {
    let generation = scratch.open().await.generation();
    (
        checked(scratch).await,
        generation,
        fs::metadata(&scratch.path).unwrap().len(),
    )
}

/// Edits a random scene a few times, with memory for 12 to 50 changes.
async fn check_sequence(seed: u64) -> u64 {
    let mut random = Random(seed);
    let (mut scene, at) = random_scene(&mut random, 0..5).await;
    let scratch = scene.build(4 + random.below(60)).await.unwrap();
    let mut edits = 0;
    for _ in 0..1 + random.below(3) {
        let before = checked(&scratch).await;
        let former = scene.clone();
        let memory = 2000 + random.below(6000) as u64;
        let done = edited(&scratch, memory, |transaction| {
            for _ in 0..20 + random.below(80) {
                scene.change(transaction, &mut random, &at);
            }
        });
        let done = done.await;
        if let Err(EditError::Memory(_)) = done {
            // Without triangles, a file must be built anew, for which there is no memory.
            assert_eq!(checked(&scratch).await, before, "seed {seed}");
            break;
        }
        match checked_outcome(done, &scratch, &scene, before, seed).await {
            Some(_) => edits += 1,
            None => scene = former,
        }
    }
    edits
}

#[test]
fn random_sequences_of_changes_on_disk_give_what_a_build_gives() {
    runtime().block_on(async {
        let (seeds, mut edits) = (seeds(240), 0);
        for &seed in &seeds {
            edits += check_sequence(seed).await;
        }
        assert!(edits > seeds.len() as u64, "{edits}");
        // An edge at two vertices that went kept its sources, and the edit failed.
        check_sequence(700_137).await;
        // The file is built anew, and for the edit that inserts its long lines there is no memory.
        check_sequence(2_001_222).await;
    });
}

/// Once the limits on walks came from the size of the file alone, and an edit like this one failed.
#[test]
fn many_points_come_to_a_small_file() {
    runtime().block_on(async {
        let triangle = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(x, y)| Point::new(x, y));
        // Along the hull, the walk from one to the next is long.
        let on_a_circle = (0..4000).map(|place| {
            let (sin, cos) = (f64::from(place) * TAU / 4000.0).sin_cos();
            Point::new(40.0 * cos, 40.0 * sin)
        });
        let new: Vec<Point> = on_a_circle.collect();
        let scratch = built(&triangle, BuildOptions::default()).await.0;
        let whole = [&triangle[..], &new].concat();
        edited(&scratch, LITTLE, |transaction| {
            transaction.insert(&batch(&new)).unwrap()
        })
        .await
        .unwrap();
        let expected = built(&whole, BuildOptions::default()).await.0;
        assert_eq!(checked(&scratch).await, checked(&expected).await);
    });
}

/// Makes the same changes with little memory and with enough, in files that are alike. Returns what the
/// first edit said.
async fn compare(scratch: &Scratch, change: impl Fn(&mut Transaction)) -> EditSummary {
    let other = copy(scratch);
    let in_memory = edited(&other, ENOUGH, |transaction| change(transaction)).await.unwrap();
    let on_disk = edited(scratch, LITTLE, |transaction| change(transaction))
        .await
        .unwrap();
    assert_eq!(checked(scratch).await, checked(&other).await);
    let said = [in_memory, on_disk].map(|said| {
        let holes = [said.hole_regions, said.hole_triangles];
        let new = [said.segments, said.added_vertices, said.constraint_edges];
        (
            said.points,
            said.lines,
            said.sites,
            said.vertices,
            said.triangles,
            new,
            holes,
        )
    });
    assert_eq!(said[0], said[1]);
    let [one, two] = [scratch.open().await, other.open().await];
    let told = [&one, &two].map(|reader| {
        let metadata = reader.metadata();
        (metadata.ends, metadata.next_record, metadata.last_transaction)
    });
    assert_eq!(told[0], told[1]);
    // What was spilled has no name, and is gone.
    assert_eq!(fs::read_dir(scratch.path.parent().unwrap()).unwrap().count(), 1);
    on_disk
}

#[test]
fn all_points_may_be_replaced_by_many_others() {
    runtime().block_on(async {
        let points = points_of(Kind::Uniform, 22_000, 3);
        let (first, second) = points.split_at(9000);
        let scratch = built(first, BuildOptions::default().tile_vertices(500)).await.0;
        let summary = compare(&scratch, |transaction| {
            transaction.delete(first).unwrap();
            transaction.insert(&batch(second)).unwrap();
            // Some of those that went come again, and some that came go.
            transaction.insert(&batch(&first[..1000])).unwrap();
            transaction.delete(&second[..2000]).unwrap();
            let moves: Vec<[Point; 2]> = (2000..6000).map(|i| [second[i], first[i]]).collect();
            transaction.move_points(&moves).unwrap();
        });
        let summary = summary.await;
        assert_eq!((summary.points.deleted, summary.points.moved), (11_000, 4000));
        assert_eq!(summary.vertices, 12_000);
    });
}

#[test]
fn tiles_keep_their_size_whatever_the_parts() {
    runtime().block_on(async {
        let points = points_of(Kind::Uniform, 40_000, 6);
        let scratch = built(&points[..500], BuildOptions::default().tile_vertices(100))
            .await
            .0;
        compare(&scratch, |transaction| {
            transaction.insert(&batch(&points[500..])).unwrap()
        })
        .await;
        let reader = scratch.open().await;
        let directory = reader.directory().await.unwrap();
        let largest = directory.tiles.iter().map(|tile| tile.vertices).max();
        assert!(largest <= Some(150), "{largest:?}");
    });
}

#[test]
fn points_come_to_an_empty_file() {
    runtime().block_on(async {
        let scratch = built(&[], BuildOptions::default().tile_vertices(200)).await.0;
        let points = points_of(Kind::Kuzmin, 10_000, 4);
        let summary = compare(&scratch, |transaction| transaction.insert(&batch(&points)).unwrap()).await;
        assert!(summary.points.inserted > 9000);
    });
}

#[test]
fn lines_and_sites_come_with_them_and_hold_vertices() {
    runtime().block_on(async {
        let at = |x: f64, y: f64| Point::new(x, y);
        let grid: Vec<Point> = (0..10_000)
            .map(|i| at(f64::from(i % 100), f64::from(i / 100)))
            .collect();
        let scratch = built(&grid, BuildOptions::default().tile_vertices(700)).await.0;
        let wall = [at(10.0, 10.0), at(60.0, 10.0), at(60.0, 40.0)];
        let crossing = [at(30.0, 5.0), at(30.0, 15.0)];
        let site = |point| SiteBatch {
            points: vec![point],
            ids: vec![SiteId::Number(7)],
            z: Vec::new(),
        };
        edited(&scratch, ENOUGH, |transaction| {
            for (line, corners) in [(0, &wall[..]), (1, &crossing[..])] {
                transaction
                    .constrain(LineKind::Wall, line, &batch_of_line(corners))
                    .unwrap();
                transaction.add_sources(vec![source(LineKind::Wall, line)]);
            }
            transaction.insert_sites(&site(at(5.0, 5.0))).unwrap();
        })
        .await
        .unwrap();
        let kept = at(30.0, 10.0);
        let most: Vec<Point> = grid.iter().copied().filter(|p| p.y < 80.0 && *p != kept).collect();
        // Where lines cross, a point must stay, as long as they do.
        let before = state(&scratch).await;
        let error = edited(&scratch, LITTLE, |transaction| {
            transaction.delete(&most).unwrap();
            transaction.delete(&[kept]).unwrap();
        });
        let error = error.await;
        assert!(matches!(error, Err(EditError::LinesCross { .. })), "{error:?}");
        assert_eq!(state(&scratch).await, before);
        let summary = compare(&scratch, |transaction| {
            transaction.delete(&[kept]).unwrap();
            transaction.delete(&most).unwrap();
            transaction
                .unconstrain(LineKind::Wall, 0, &batch_of_line(&crossing))
                .unwrap();
            transaction
                .constrain(LineKind::BreakLine, 0, &batch_of_line(&[at(2.0, 50.5), at(90.0, 50.5)]))
                .unwrap();
            transaction.add_sources(vec![source(LineKind::BreakLine, 0)]);
            transaction.insert_sites(&site(at(50.0, 50.5))).unwrap();
        });
        let summary = summary.await;
        // The wall's three corners, the new line's ends, and two sites.
        assert_eq!(summary.vertices, 2000 + 7);
        assert_eq!(summary.lines.removed_segments, 1);
    });
}

#[test]
fn a_mistake_among_many_changes_is_named_and_changes_nothing() {
    runtime().block_on(async {
        let points = points_of(Kind::Uniform, 12_000, 5);
        let scratch = built(&points[..6000], BuildOptions::default().tile_vertices(500))
            .await
            .0;
        let before = state(&scratch).await;
        let change = |transaction: &mut Transaction| {
            transaction.insert(&batch(&points[..5000])).unwrap();
            transaction.delete(&points[5000..8000]).unwrap();
            transaction.insert(&batch(&points[8000..])).unwrap();
        };
        for memory in [LITTLE, ENOUGH] {
            let error = edited(&scratch, memory, change).await;
            assert!(
                matches!(error, Err(EditError::NoPoint { point, count: 2000 }) if point == points[6000]),
                "{error:?}"
            );
            let with_z = PointBatch {
                z: vec![1.0; 5000],
                ..batch(&points[..5000])
            };
            let error = edited(&scratch, memory, |transaction| {
                transaction.insert(&with_z).unwrap();
                change(transaction);
            });
            let error = error.await;
            assert!(matches!(error, Err(EditError::HasNoZ)), "{error:?}");
        }
        assert_eq!(state(&scratch).await, before);
        let summary = compare(&scratch, |transaction| {
            transaction.skip_missing(true);
            change(transaction);
        });
        let points = summary.await.points;
        assert_eq!([points.duplicates, points.deleted, points.skipped], [5000, 1000, 2000]);
    });
}
