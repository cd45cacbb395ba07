//! The promise: after each edit of points, the file is the one that a build of the changed points
//! with the same lines and sites gives, whatever the tiles, the order and the place of the changes;
//! a mistake changes nothing.

use std::fs;
use std::ops::Range;

use delaunay_tiles::geometry::{Orientation, Point, orient2d};
use delaunay_tiles::input::{MissingZ, PointBatch, SiteId};
use delaunay_tiles::store::LineKind;
use delaunay_tiles::{BuildOptions, EditError, EditOptions, Editor, PointCounts, Transaction};
use distributions::Kind;

use crate::edits::scene::{Line, Scene, checked, checked_outcome, key, random_scene};
use crate::edits::{ENOUGH, batch, edit, edited, segment};
use crate::support::cases::seeds;
use crate::support::{Random, Scratch, built, points_of, runtime};

/// So little memory that tiles must leave the cache and come back.
const LITTLE: u64 = 256 << 10;

/// Edits a random scene a few times. Returns the number of edits that were made.
async fn check_sequence(seed: u64, kinds: Range<usize>) -> u64 {
    let mut random = Random(seed);
    let (mut scene, at) = random_scene(&mut random, kinds).await;
    let scratch = scene.build(4 + random.below(60)).await.unwrap();
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
        transaction.prefer_build(random.below(5) == 0);
        for _ in 0..1 + random.below(30) {
            scene.change(&mut transaction, &mut random, &at);
        }
        match checked_outcome(transaction.commit().await, &scratch, &scene, before, seed).await {
            Some(_) => edits += 1,
            None => scene = former,
        }
    }
    edits
}

#[test]
fn random_sequences_of_edits_give_what_a_build_gives() {
    runtime().block_on(async {
        let (seeds, mut edits) = (seeds(400), 0);
        for &seed in &seeds {
            edits += check_sequence(seed, 0..5).await;
        }
        assert!(edits > 2 * seeds.len() as u64, "{edits}");
    });
}

#[test]
fn points_come_to_files_without_triangles_and_leave_files_without() {
    runtime().block_on(async {
        let (seeds, mut edits) = (seeds(120), 0);
        for &seed in &seeds {
            edits += check_sequence(seed, 5..6).await;
        }
        assert!(edits > 2 * seeds.len() as u64, "{edits}");
    });
}

/// Builds points with z in tiles of at most 50.
async fn hills() -> (Vec<Point>, Scratch) {
    let points = points_of(distributions::Kind::Uniform, 2000, 5);
    let mut scene = Scene {
        has_z: true,
        ..Scene::default()
    };
    scene.points.extend(points.iter().map(|&p| (key(p), (p, p.x))));
    (points, scene.build(50).await.unwrap())
}

fn with_z(points: &[Point], z: f64) -> PointBatch {
    PointBatch {
        records: (0..points.len() as u64).collect(),
        points: points.to_vec(),
        z: vec![z; points.len()],
    }
}

#[test]
fn calls_act_in_their_order_and_are_counted() {
    runtime().block_on(async {
        let (points, scratch) = hills().await;
        let [far, farther] = [1e3, 1e6].map(|x| Point::new(x, -x));
        let summary = edited(&scratch, ENOUGH, |transaction| {
            transaction.insert(&with_z(&[far, points[0], far], 7.0)).unwrap();
            transaction
                .move_points(&[[far, farther], [points[1], far], [points[2], points[3]]])
                .unwrap();
            transaction.delete(&[points[4]]).unwrap();
            transaction.insert(&with_z(&[points[4]], 9.0)).unwrap();
            transaction.set_z(&with_z(&[farther], 8.0)).unwrap();
        });
        let summary = summary.await.unwrap();
        let counts = PointCounts {
            inserted: 2,
            duplicates: 3,
            deleted: 1,
            moved: 3,
            z_set: 1,
            ..PointCounts::default()
        };
        assert_eq!((summary.points, summary.vertices), (counts, 2000));
        let reader = scratch.open().await;
        reader.verify(true).await.unwrap();
        let z_at = async |p: Point| reader.surface_z(p.x, p.y, Default::default()).await.unwrap();
        // A point takes its z along, and one that comes again has the z that it comes with.
        let expected = [farther, far, points[3], points[4], points[0]];
        for (point, z) in expected
            .into_iter()
            .zip([8.0, points[1].x, points[3].x, 9.0, points[0].x])
        {
            assert_eq!(z_at(point).await, Some(z), "{point:?}");
        }
        assert_eq!(reader.metadata().bounds.max_x, 1e6);
    });
}

#[test]
fn a_mistake_changes_nothing_unless_it_is_to_be_skipped() {
    runtime().block_on(async {
        let (points, scratch) = hills().await;
        let flat = built(&points, BuildOptions::default()).await.0;
        let nowhere = Point::new(0.5, 77.0);
        let before = fs::read(&scratch.path).unwrap();
        let error = edited(&scratch, ENOUGH, |transaction| {
            transaction.delete(&[points[0], nowhere, nowhere]).unwrap()
        })
        .await;
        assert!(
            matches!(error, Err(EditError::NoPoint { point, count: 2 }) if point == nowhere),
            "{error:?}"
        );
        // A point that is deleted twice is not there the second time.
        let error = edited(&scratch, ENOUGH, |transaction| {
            transaction.delete(&[points[0], points[0]]).unwrap()
        })
        .await;
        assert!(matches!(error, Err(EditError::NoPoint { count: 1, .. })), "{error:?}");
        let mut without_z = with_z(&[nowhere], 0.0);
        without_z.z.clear();
        let error = edited(&scratch, ENOUGH, |transaction| transaction.insert(&without_z).unwrap()).await;
        assert!(
            matches!(error, Err(EditError::PointWithoutZ { point, count: 1 }) if point == nowhere),
            "{error:?}"
        );
        let error = edited(&flat, ENOUGH, |transaction| {
            transaction.insert(&with_z(&[nowhere], 1.0)).unwrap()
        })
        .await;
        assert!(matches!(error, Err(EditError::HasNoZ)), "{error:?}");
        for wrong in [f64::NAN, f64::INFINITY, 1e300, 1e-300].map(|x| Point::new(0.0, x)) {
            let error = edited(&scratch, ENOUGH, |transaction| {
                let calls = [
                    transaction.insert(&with_z(&[wrong], 1.0)),
                    transaction.delete(&[wrong]),
                    transaction.move_points(&[[points[0], wrong]]),
                    transaction.set_z(&with_z(&[wrong], 1.0)),
                ];
                for call in calls {
                    assert!(matches!(call, Err(EditError::InvalidPoint(_))), "{call:?}");
                }
            });
            // Calls with an error have no effect.
            assert_eq!(error.await.unwrap().points, PointCounts::default());
        }
        let infinite = with_z(&[nowhere], f64::INFINITY);
        let error = Editor::open(&scratch.path, EditOptions::default().memory(1 << 20))
            .await
            .unwrap()
            .begin()
            .await
            .unwrap()
            .insert(&infinite);
        assert!(matches!(error, Err(EditError::InvalidZ { .. })), "{error:?}");
        assert_eq!(fs::read(&scratch.path).unwrap(), before);

        let summary = edited(&scratch, ENOUGH, |transaction| {
            transaction.skip_missing(true);
            transaction.missing_z(MissingZ::Zero);
            transaction.delete(&[points[0], nowhere]).unwrap();
            transaction.insert(&without_z).unwrap();
        });
        let PointCounts {
            deleted,
            inserted,
            skipped,
            ..
        } = summary.await.unwrap().points;
        assert_eq!([deleted, inserted, skipped], [1; 3]);
        scratch.open().await.verify(true).await.unwrap();
    });
}

#[test]
fn a_dry_run_tells_what_would_be_and_changes_nothing() {
    runtime().block_on(async {
        let (points, scratch) = hills().await;
        let before = fs::read(&scratch.path).unwrap();
        let change = |transaction: &mut Transaction| transaction.delete(&points[..1000]).unwrap();
        let dry = edited(&scratch, ENOUGH, |transaction| {
            transaction.dry_run(true);
            change(transaction);
        });
        let dry = dry.await.unwrap();
        assert!(fs::read(&scratch.path).unwrap() == before);
        let wet = edited(&scratch, ENOUGH, change).await.unwrap();
        assert_eq!(
            (dry.points, dry.vertices, dry.triangles, dry.tiles_written),
            (wet.points, 1000, wet.triangles, wet.tiles_written)
        );
    });
}

#[test]
fn the_last_points_may_go_and_tiles_with_them() {
    runtime().block_on(async {
        let (points, scratch) = hills().await;
        let reader = scratch.open().await;
        // Half of the tiles are emptied.
        let left: Vec<Point> = points.iter().copied().filter(|p| p.x < 0.5).collect();
        let gone: Vec<Point> = points.iter().copied().filter(|p| p.x >= 0.5).collect();
        // So little memory that emptied tiles leave the cache.
        let mut transaction = Editor::open(&scratch.path, EditOptions::default().memory(LITTLE))
            .await
            .unwrap()
            .begin()
            .await
            .unwrap();
        transaction.delete(&gone).unwrap();
        transaction.commit().await.unwrap();
        let after = scratch.open().await;
        assert_eq!(after.verify(true).await.unwrap().vertices, left.len() as u64);
        assert!(after.metadata().tiles < reader.metadata().tiles * 2 / 3);
        // New points go into the cells that the others left to their neighbours.
        edited(&scratch, ENOUGH, |transaction| {
            transaction.insert(&with_z(&gone, 1.0)).unwrap()
        })
        .await
        .unwrap();
        scratch.open().await.verify(true).await.unwrap();
        edited(&scratch, ENOUGH, |transaction| {
            transaction.delete(&points[3..]).unwrap()
        })
        .await
        .unwrap();
        assert_eq!(scratch.open().await.verify(true).await.unwrap().triangles, 1);
        edited(&scratch, ENOUGH, |transaction| {
            transaction.delete(&points[..1]).unwrap()
        })
        .await
        .unwrap();
        assert_eq!(scratch.open().await.verify(true).await.unwrap().vertices, 2);
        // The reader from before sees all points.
        assert_eq!(reader.recompute_digest().await.unwrap().vertices.count, 2000);
    });
}

#[test]
fn a_vertex_goes_when_nothing_holds_it_any_more() {
    runtime().block_on(async {
        let at = |x: f64, y: f64| Point::new(x, y);
        let mut scene = Scene::default();
        for i in 0..100 {
            let point = at(f64::from(i % 10), f64::from(i / 10));
            scene.points.insert(key(point), (point, 0.0));
        }
        // Along a row of points, a wall that begins and ends at points, and a site at another one.
        scene.lines.push(Line {
            kind: LineKind::Wall,
            corners: vec![at(1.0, 4.0), at(8.0, 4.0)],
            number: 0,
        });
        scene.sites.push((at(5.0, 7.0), SiteId::Number(3)));
        let scratch = scene.build(8).await.unwrap();
        assert_eq!(scratch.open().await.metadata().constraint_edges, 7);
        let [passed, end, site] = [at(4.0, 4.0), at(8.0, 4.0), at(5.0, 7.0)];
        edited(&scratch, ENOUGH, |transaction| {
            transaction.delete(&[passed, end, site]).unwrap()
        })
        .await
        .unwrap();
        let metadata = scratch.open().await.metadata().clone();
        assert_eq!(
            (metadata.vertices, metadata.ends, metadata.constraint_edges),
            (99, 2, 6)
        );
        for point in [passed, end, site] {
            scene.points.remove(&key(point));
        }
        assert_eq!(checked(&scratch).await, checked(&scene.build(30).await.unwrap()).await);
        // They are no points any more, but may be again.
        let error = edited(&scratch, ENOUGH, |transaction| transaction.delete(&[end]).unwrap()).await;
        assert!(matches!(error, Err(EditError::NoPoint { .. })), "{error:?}");
        let again = PointBatch {
            points: vec![end],
            records: vec![0],
            z: Vec::new(),
        };
        edited(&scratch, ENOUGH, |transaction| transaction.insert(&again).unwrap())
            .await
            .unwrap();
        assert_eq!(scratch.open().await.metadata().ends, 1);
        checked(&scratch).await;
        assert_eq!(orient2d(passed, end, at(1.0, 4.0)), Orientation::Collinear);
    });
}

#[test]
fn without_lines_only_the_tiles_that_change_are_read() {
    runtime().block_on(async {
        let points = points_of(Kind::Uniform, 20_000, 4);
        let scratch = built(&points, BuildOptions::default().tile_vertices(500)).await.0;
        let directory = scratch.open().await.directory().await.unwrap();
        let ids: Vec<_> = directory.tile_ids().step_by(5).collect();
        let mut all = points;
        for id in ids {
            let bounds = directory.entry(id).unwrap().bounds;
            let middle = [bounds.min_x + bounds.max_x, bounds.min_y + bounds.max_y].map(|sum| sum / 2.0);
            let middle = Point::new(middle[0], middle[1]);
            let summary = edited(&scratch, ENOUGH, |transaction| {
                transaction.insert(&batch(&[middle])).unwrap()
            });
            let summary = summary.await.unwrap();
            assert_eq!((summary.tile_reads, summary.tiles_written), (1, 1), "{id:?}");
            all.push(middle);
        }
        let reader = scratch.open().await;
        assert_eq!(
            (reader.metadata().regions, reader.metadata().vertices),
            (0, all.len() as u64)
        );
        let whole = built(&all, BuildOptions::default()).await.0;
        assert_eq!(checked(&scratch).await, checked(&whole).await);
        // With a line, the regions of all tiles are found.
        edit(&scratch, ENOUGH, &[segment((0.1, 0.1), (0.9, 0.8))])
            .await
            .unwrap();
        assert_eq!(scratch.open().await.metadata().regions, 1);
        checked(&scratch).await;
    });
}
