//! The promise: after lines were removed, and sites changed, the file is the one that a build of the
//! others gives, whatever the tiles, and whether the lines were given by geometry or by number; a mistake
//! changes nothing. `line_sequences` has random ones.

use std::fs;

use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::{SegmentBatch, SiteId};
use delaunay_tiles::store::LineKind;
use delaunay_tiles::{BuildOptions, Builder, Crossings, EditError, EditOptions, Editor};

use crate::edits::scene::{Line, Scene, batch_of_line, batch_of_sites, checked, key};
use crate::edits::{ENOUGH, edited};
use crate::support::{Scratch, runtime};

fn points(places: &[(f64, f64)]) -> Vec<Point> {
    places.iter().map(|&(x, y)| Point::new(x, y)).collect()
}

/// Builds a lattice of 10 by 10 points with a bent break line (0), a wall (1), and an obstacle with a
/// hole (2). Their ends are no points, but for the break line's.
async fn town() -> (Scene, Scratch) {
    let mut scene = Scene::default();
    for place in 0..100 {
        let point = Point::new(f64::from(place % 10), f64::from(place / 10));
        scene.points.insert(key(point), (point, 0.0));
    }
    let ring = |low: f64, high: f64| [(low, low), (high, low), (high, high), (low, high), (low, low)];
    let mut hole = points(&ring(5.2, 7.8));
    hole.reverse();
    for (number, (kind, corners)) in [
        (LineKind::BreakLine, points(&[(0.0, 9.0), (4.0, 9.0), (4.0, 5.0)])),
        (LineKind::Wall, points(&[(0.5, 0.5), (3.5, 2.5)])),
        (LineKind::Obstacle, points(&ring(4.5, 8.5))),
    ]
    .into_iter()
    .enumerate()
    {
        let number = number as u64;
        scene.lines.push(Line { kind, corners, number });
    }
    let scratch = Scratch::new();
    let mut builder = Builder::new(&scratch.path, BuildOptions::default().tile_vertices(8)).unwrap();
    for line in &scene.lines {
        let mut batch = batch_of_line(&line.corners);
        if line.kind == LineKind::Obstacle {
            batch.ends.extend(batch_of_line(&hole).ends);
            batch.lines.resize(batch.ends.len(), 0);
        }
        builder.push_lines(line.kind, line.number, &batch).unwrap();
    }
    builder
        .push(&scene.batch(scene.points.values().copied()))
        .await
        .unwrap();
    builder.finish().await.unwrap();
    (scene, scratch)
}

#[test]
fn a_line_that_is_not_there_is_an_error_unless_it_is_to_be_skipped() {
    runtime().block_on(async {
        let (scene, scratch) = town().await;
        let before = fs::read(&scratch.path).unwrap();
        let missing: [(LineKind, &[(f64, f64)]); 6] = [
            // Nowhere; a part of a segment; a segment and its continuation; across a bend; another
            // kind; from a vertex of no line.
            (LineKind::Wall, &[(0.25, 0.5), (3.5, 2.5)]),
            (LineKind::BreakLine, &[(0.0, 9.0), (3.0, 9.0)]),
            (LineKind::BreakLine, &[(0.0, 9.0), (5.0, 9.0)]),
            (LineKind::BreakLine, &[(0.0, 9.0), (4.0, 5.0)]),
            (LineKind::BreakLine, &[(0.5, 0.5), (3.5, 2.5)]),
            (LineKind::BreakLine, &[(1.0, 1.0), (2.0, 1.0)]),
        ];
        for (kind, places) in missing {
            let batch = batch_of_line(&points(places));
            let error = edited(&scratch, ENOUGH, |transaction| {
                transaction.unconstrain(kind, 0, &batch).unwrap()
            })
            .await;
            assert!(
                matches!(error, Err(EditError::NoLine { ends, count: 1 }) if [ends] == batch.ends[..]),
                "{error:?}"
            );
        }
        let error = edited(&scratch, ENOUGH, |transaction| transaction.remove_lines(&[1, 3, 4])).await;
        assert!(
            matches!(error, Err(EditError::NoLineNumber { line: 3, count: 2 })),
            "{error:?}"
        );
        for wrong in [f64::NAN, 1e300] {
            let batch = batch_of_line(&[Point::new(0.0, 0.0), Point::new(wrong, 1.0)]);
            let mut transaction = Editor::open(&scratch.path, EditOptions::default().memory(16 << 20))
                .await
                .unwrap()
                .begin()
                .await
                .unwrap();
            for call in [
                transaction.constrain(LineKind::Wall, 0, &batch),
                transaction.unconstrain(LineKind::Wall, 0, &batch),
            ] {
                assert!(matches!(call, Err(EditError::InvalidPoint(_))), "{call:?}");
            }
        }
        // A ring alone is no whole obstacle.
        let ring = batch_of_line(&scene.lines[2].corners);
        let error = edited(&scratch, ENOUGH, |transaction| {
            transaction.unconstrain(LineKind::Obstacle, 0, &ring).unwrap()
        })
        .await;
        assert!(
            matches!(error, Err(EditError::PartOfObstacle { line: 2, .. })),
            "{error:?}"
        );
        let records = SegmentBatch {
            records: vec![[0, 1]],
            lines: vec![0],
            ..SegmentBatch::default()
        };
        let mut transaction = Editor::open(&scratch.path, EditOptions::default().memory(16 << 20))
            .await
            .unwrap()
            .begin()
            .await
            .unwrap();
        let error = transaction.unconstrain(LineKind::Wall, 0, &records);
        assert!(matches!(error, Err(EditError::Records)), "{error:?}");
        drop(transaction);
        assert_eq!(fs::read(&scratch.path).unwrap(), before);

        let summary = edited(&scratch, ENOUGH, |transaction| {
            transaction.skip_missing(true);
            for (kind, places) in missing {
                transaction
                    .unconstrain(kind, 0, &batch_of_line(&points(places)))
                    .unwrap();
            }
            transaction.remove_lines(&[2, 9]);
        });
        let lines = summary.await.unwrap().lines;
        assert_eq!((lines.removed_segments, lines.removed_lines, lines.skipped), (0, 1, 7));
        // The corners of both rings were vertices of nothing else.
        assert_eq!(lines.removed_vertices, 8);
        let reader = scratch.open().await;
        assert_eq!(reader.metadata().hole_regions, 0);
        reader.verify(true).await.unwrap();
    });
}

#[test]
fn vertices_go_with_the_lines_unless_something_else_holds_them() {
    runtime().block_on(async {
        let (mut scene, scratch) = town().await;
        let [bend, wall] = [0, 1].map(|place| batch_of_line(&scene.lines[place].corners));
        let end = Point::new(0.5, 0.5);
        let summary = edited(&scratch, ENOUGH, |transaction| {
            transaction.unconstrain(LineKind::BreakLine, 0, &bend).unwrap();
            transaction.unconstrain(LineKind::Wall, 1, &wall).unwrap();
            // A point comes where the wall began.
            transaction.insert(&scene.batch([(end, 0.0)].into_iter())).unwrap();
            transaction.remove_lines(&[2]);
        });
        let summary = summary.await.unwrap();
        assert_eq!((summary.lines.removed_segments, summary.lines.removed_vertices), (3, 9));
        assert_eq!(
            (summary.vertices, summary.constraint_edges, summary.regions),
            (101, 0, 1)
        );
        scene.points.insert(key(end), (end, 0.0));
        scene.lines.clear();
        assert_eq!(checked(&scratch).await, checked(&scene.build(30).await.unwrap()).await);
    });
}

#[test]
fn lines_that_were_split_stay() {
    runtime().block_on(async {
        let scratch = Scratch::new();
        let options = BuildOptions::default().crossings(Crossings::Split);
        let mut builder = Builder::new(&scratch.path, options).unwrap();
        let cross = [[(0.0, 0.0), (2.0, 2.0)], [(0.0, 2.0), (2.0, 0.0)]];
        for (ends, number) in cross.iter().zip(0..) {
            builder
                .push_lines(LineKind::Wall, number, &batch_of_line(&points(ends)))
                .unwrap();
        }
        builder.finish().await.unwrap();
        let error = edited(&scratch, ENOUGH, |transaction| transaction.remove_lines(&[0])).await;
        assert!(matches!(error, Err(EditError::SplitLines)), "{error:?}");
    });
}

#[test]
fn sites_come_and_go_with_their_vertices() {
    runtime().block_on(async {
        let (scene, scratch) = town().await;
        let before = checked(&scratch).await;
        let [known, new, far, nowhere] =
            [(3.0, 3.0), (3.25, 7.5), (50.0, -20.0), (3.0, 3.5)].map(|(x, y)| Point::new(x, y));
        let text = |text: &str| SiteId::Text(text.to_owned());
        let sites = [
            (known, text("a")),
            (known, text("b")),
            (new, SiteId::Number(7)),
            (far, text("c")),
            (new, text("d")),
        ];
        let summary = edited(&scratch, ENOUGH, |transaction| {
            transaction.insert_sites(&batch_of_sites(&sites)).unwrap()
        });
        let summary = summary.await.unwrap();
        assert_eq!((summary.sites.inserted, summary.added_vertices), (5, 2));
        let metadata = scratch.open().await.metadata().clone();
        assert_eq!(
            (metadata.sites, metadata.next_site, metadata.bounds.max_x),
            (5, 5, 50.0)
        );
        let error = edited(&scratch, ENOUGH, |transaction| {
            transaction.delete_sites(&[far, nowhere, far]).unwrap()
        })
        .await;
        assert!(
            matches!(error, Err(EditError::NoSite { point, count: 2 }) if point == nowhere),
            "{error:?}"
        );
        let mut transaction = Editor::open(&scratch.path, EditOptions::default().memory(1 << 20))
            .await
            .unwrap()
            .begin()
            .await
            .unwrap();
        let mut wrong = batch_of_sites(&sites);
        wrong.ids.pop();
        let error = transaction.insert_sites(&wrong);
        assert!(
            matches!(error, Err(EditError::SiteBatch { sites: 5, ids: 4, z: 0 })),
            "{error:?}"
        );
        let error = transaction.insert_sites(&batch_of_sites(&[(far, text(&"x".repeat(300_000)))]));
        assert!(matches!(error, Err(EditError::Memory(_))), "{error:?}");
        drop(transaction);
        let summary = edited(&scratch, ENOUGH, |transaction| {
            transaction.skip_missing(true);
            transaction.delete_sites(&[known, new, far, nowhere]).unwrap();
            // A point holds the vertex from now on.
            transaction.insert(&scene.batch([(far, 0.0)].into_iter())).unwrap();
        });
        let sites = summary.await.unwrap().sites;
        assert_eq!((sites.deleted, sites.skipped), (5, 1));
        assert_ne!(checked(&scratch).await, before);
        edited(&scratch, ENOUGH, |transaction| transaction.delete(&[far]).unwrap())
            .await
            .unwrap();
        assert_eq!(checked(&scratch).await, before);
    });
}

/// Once a segment was taken off an edge along which another segment of the same line runs, too. The
/// file has the ends of both there, as if one segment were the edge.
#[test]
fn a_segment_that_its_own_line_runs_over_is_not_removed_alone() {
    runtime().block_on(async {
        for is_point in [false, true] {
            let mut scene = Scene::default();
            for point in points(&[(0.0, 0.0), (2.0, 0.0), (1.0, 3.0)]) {
                scene.points.insert(key(point), (point, 0.0));
            }
            let middle = Point::new(1.0, 0.0);
            if is_point {
                scene.points.insert(key(middle), (middle, 0.0));
            }
            let plain = checked(&scene.build(20).await.unwrap()).await;
            let corners = points(&[(0.0, 0.0), (2.0, 0.0), (1.0, 0.0)]);
            scene.lines.push(Line {
                kind: LineKind::Wall,
                corners: corners.clone(),
                number: 0,
            });
            let scratch = scene.build(20).await.unwrap();
            for alone in [[corners[1], corners[2]], [corners[2], corners[1]]] {
                let batch = batch_of_line(&alone);
                let error = edited(&scratch, ENOUGH, |transaction| {
                    transaction.unconstrain(LineKind::Wall, 0, &batch).unwrap()
                })
                .await;
                assert!(matches!(error, Err(EditError::NoLine { count: 1, .. })), "{error:?}");
            }
            edited(&scratch, ENOUGH, |transaction| transaction.remove_lines(&[0]))
                .await
                .unwrap();
            assert_eq!(checked(&scratch).await, plain);
        }
    });
}

/// Once the edges that a new point splits were not counted, so an edit believed that no constraint
/// was left.
#[test]
fn constraints_may_be_left_on_one_line() {
    runtime().block_on(async {
        let mut scene = Scene::default();
        for point in points(&[(0.0, 0.0), (2.0, 0.0), (3.0, 0.0), (1.0, 5.0)]) {
            scene.points.insert(key(point), (point, 0.0));
        }
        for (number, ends) in [[(0.0, 0.0), (2.0, 0.0)], [(2.0, 0.0), (3.0, 0.0)]].iter().enumerate() {
            scene.lines.push(Line {
                kind: LineKind::Wall,
                corners: points(ends),
                number: number as u64,
            });
        }
        let scratch = scene.build(20).await.unwrap();
        let [new, gone] = [Point::new(1.0, 0.0), Point::new(1.0, 5.0)];
        let summary = edited(&scratch, ENOUGH, |transaction| {
            transaction.insert(&scene.batch([(new, 0.0)].into_iter())).unwrap();
            transaction.remove_lines(&[0]);
            transaction.delete(&[gone]).unwrap();
        });
        let summary = summary.await.unwrap();
        assert_eq!((summary.points.inserted, summary.points.deleted), (1, 1));
        assert_eq!((summary.lines.removed_lines, summary.constraint_edges), (1, 1));
        scene.points.insert(key(new), (new, 0.0));
        scene.points.remove(&key(gone));
        scene.lines.remove(0);
        assert_eq!(checked(&scratch).await, checked(&scene.build(20).await.unwrap()).await);
    });
}

#[test]
fn a_site_that_goes_in_the_same_edit_leaves_nothing() {
    runtime().block_on(async {
        let (_, scratch) = town().await;
        let before = checked(&scratch).await;
        let [new, far] = [(3.25, 7.5), (50.0, -20.0)].map(|(x, y)| Point::new(x, y));
        let site = |point: Point, number: u64| batch_of_sites(&[(point, SiteId::Number(number))]);
        let summary = edited(&scratch, ENOUGH, |transaction| {
            transaction.insert_sites(&site(far, 1)).unwrap();
            transaction.insert_sites(&site(far, 2)).unwrap();
            transaction.delete_sites(&[far]).unwrap();
            transaction.insert_sites(&site(new, 3)).unwrap();
            transaction.delete_sites(&[new]).unwrap();
            transaction.insert_sites(&site(new, 4)).unwrap();
        });
        let summary = summary.await.unwrap();
        assert_eq!(
            (summary.sites.inserted, summary.sites.deleted, summary.added_vertices),
            (4, 3, 1)
        );
        let reader = scratch.open().await;
        assert_eq!(reader.metadata().sites, 1);
        reader.verify(true).await.unwrap();
        edited(&scratch, ENOUGH, |transaction| {
            transaction.delete_sites(&[new]).unwrap()
        })
        .await
        .unwrap();
        assert_eq!(checked(&scratch).await, before);
    });
}
