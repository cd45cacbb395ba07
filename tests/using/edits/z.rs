//! The promise: a vertex has the z of the first that holds it, a point before the ends of lines, these
//! before sites; what goes leaves its z to what holds the vertex, and to nothing that comes later.

use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::{MissingZ, SegmentBatch, SiteBatch, SiteId};
use delaunay_tiles::store::{Digest, LineKind};
use delaunay_tiles::{BuildOptions, Builder, EditError};

use crate::edits::scene::{Scene, batch_of_line, batch_of_sites, checked, key};
use crate::edits::{ENOUGH, edited};
use crate::support::{Scratch, runtime};

/// A grid of 10 by 10 points, on a slope.
fn hill() -> Scene {
    let mut scene = Scene {
        has_z: true,
        ..Scene::default()
    };
    for place in 0..100 {
        let point = at(f64::from(place % 10), f64::from(place / 10));
        scene.points.insert(key(point), (point, point.x));
    }
    scene
}

fn at(x: f64, y: f64) -> Point {
    Point::new(x, y)
}

async fn z_at<const N: usize>(scratch: &Scratch, points: [Point; N]) -> [f64; N] {
    let reader = scratch.open().await;
    let mut all = [f64::NAN; N];
    for (z, point) in all.iter_mut().zip(points) {
        let found = reader.surface_z(point.x, point.y, Default::default()).await;
        *z = found.unwrap().unwrap();
    }
    all
}

/// A line of two corners with z.
fn line(corners: [Point; 2], z: [f64; 2]) -> SegmentBatch {
    SegmentBatch {
        z: vec![z],
        ..batch_of_line(&corners)
    }
}

fn site(point: Point, z: f64) -> SiteBatch {
    SiteBatch {
        z: vec![z],
        ..batch_of_sites(&[(point, SiteId::Number(1))])
    }
}

async fn built(scene: &Scene, lines: &[SegmentBatch], sites: &[SiteBatch]) -> Scratch {
    let scratch = Scratch::new();
    let mut builder = Builder::new(&scratch.path, BuildOptions::default().tile_vertices(25)).unwrap();
    for (line, number) in lines.iter().zip(0..) {
        builder.push_lines(LineKind::Wall, number, line).unwrap();
    }
    for site in sites {
        builder.push_sites(site).unwrap();
    }
    builder
        .push(&scene.batch(scene.points.values().copied()))
        .await
        .unwrap();
    builder.finish().await.unwrap();
    scratch
}

#[test]
fn a_line_that_takes_the_place_of_another_brings_its_z() {
    runtime().block_on(async {
        let scratch = hill().build(8).await.unwrap();
        let [start, end, point] = [(0.5, 0.5), (3.5, 2.5), (4.0, 2.0)].map(|(x, y)| Point::new(x, y));
        let line = |z: f64| SegmentBatch {
            z: vec![[z, z]; 2],
            ..batch_of_line(&[start, end, point])
        };
        let other = batch_of_line(&[end, Point::new(3.25, 2.75)]);
        edited(&scratch, ENOUGH, |transaction| {
            transaction.constrain(LineKind::Wall, 0, &line(40.0)).unwrap()
        })
        .await
        .unwrap();
        // A point keeps its own z.
        assert_eq!(z_at(&scratch, [start, end, point]).await, [40.0, 40.0, 4.0]);
        edited(&scratch, ENOUGH, |transaction| {
            transaction.unconstrain(LineKind::Wall, 0, &line(40.0)).unwrap();
            transaction.constrain(LineKind::Wall, 0, &line(70.0)).unwrap();
            transaction.constrain(LineKind::BreakLine, 1, &other).unwrap();
        })
        .await
        .unwrap();
        assert_eq!(z_at(&scratch, [start, end, point]).await, [70.0, 70.0, 4.0]);
        // Now another line holds one of the ends, with the z that it has.
        edited(&scratch, ENOUGH, |transaction| {
            transaction.unconstrain(LineKind::Wall, 0, &line(0.0)).unwrap();
            transaction.constrain(LineKind::Wall, 0, &line(90.0)).unwrap();
        })
        .await
        .unwrap();
        assert_eq!(z_at(&scratch, [start, end, point]).await, [90.0, 70.0, 4.0]);
        scratch.open().await.verify(true).await.unwrap();
    });
}

#[test]
fn a_site_takes_its_z_from_the_surface_unless_it_has_its_own_and_outside_it_needs_one() {
    runtime().block_on(async {
        let scratch = hill().build(20).await.unwrap();
        let [new, far, nowhere] = [at(3.25, 7.5), at(50.0, -20.0), at(3.0, 3.5)];
        let error = edited(&scratch, ENOUGH, |transaction| {
            transaction.insert_sites(&site(far, f64::NAN)).unwrap()
        });
        let error = error.await;
        assert!(
            matches!(error, Err(EditError::PointWithoutZ { point, count: 1 }) if point == far),
            "{error:?}"
        );
        edited(&scratch, ENOUGH, |transaction| {
            transaction.insert_sites(&site(new, f64::NAN)).unwrap();
            transaction.insert_sites(&site(far, 4.0)).unwrap();
        })
        .await
        .unwrap();
        edited(&scratch, ENOUGH, |transaction| {
            transaction.missing_z(MissingZ::Zero);
            transaction.insert_sites(&site(nowhere, f64::NAN)).unwrap();
        })
        .await
        .unwrap();
        assert_eq!(z_at(&scratch, [new, far, nowhere]).await, [3.25, 4.0, 0.0]);
        scratch.open().await.verify(true).await.unwrap();
    });
}

/// Once a line at the place of a point that the same transaction deleted got the z of the point,
/// unless the file was built anew.
#[test]
fn what_takes_the_place_of_a_point_brings_its_z() {
    runtime().block_on(async {
        let [of_line, of_site, held, stays] = [at(4.0, 2.0), at(8.0, 8.0), at(2.0, 6.0), at(7.0, 3.0)];
        let old = line([held, at(2.5, 7.5)], [2.0, 40.0]);
        let new = [
            line([of_line, stays], [50.0, 60.0]),
            line([at(1.5, 4.5), held], [80.0, 90.0]),
        ];
        let new_site = site(of_site, 70.0);
        // They need more memory than there is in one of the cases.
        let others: Vec<Point> = (0..1800)
            .map(|place| at(20.0 + f64::from(place % 50), f64::from(place / 50)))
            .collect();
        let mut scene = hill();
        let before = built(&scene, std::slice::from_ref(&old), &[]).await;
        let others = scene.batch(others.iter().map(|&point| (point, 1.0)));
        let gone = [of_line, of_site, held];
        for point in gone {
            scene.points.remove(&key(point));
        }
        for &point in &others.points {
            scene.points.insert(key(point), (point, 1.0));
        }
        let [first, second] = new.clone();
        let whole = built(&scene, &[old, first, second], std::slice::from_ref(&new_site)).await;
        let expected: Digest = checked(&whole).await;
        for (memory, prefer_build) in [(ENOUGH, false), (ENOUGH, true), (80_000, false)] {
            let scratch = Scratch::new();
            std::fs::copy(&before.path, &scratch.path).unwrap();
            edited(&scratch, memory, |transaction| {
                transaction.prefer_build(prefer_build);
                transaction.delete(&gone).unwrap();
                transaction.insert(&others).unwrap();
                for (line, number) in new.iter().zip(1..) {
                    transaction.constrain(LineKind::Wall, number, line).unwrap();
                }
                transaction.insert_sites(&new_site).unwrap();
            })
            .await
            .unwrap();
            let z = z_at(&scratch, [of_line, of_site, held, stays]).await;
            assert_eq!(z, [50.0, 70.0, 2.0, 7.0], "{memory}");
            assert_eq!(checked(&scratch).await, expected, "{memory}");
        }
    });
}

#[test]
fn a_site_that_takes_the_place_of_another_brings_its_z() {
    runtime().block_on(async {
        let place = at(3.25, 7.5);
        let scratch = built(&hill(), &[], &[site(place, 33.0)]).await;
        edited(&scratch, ENOUGH, |transaction| {
            // The first of both holds the vertex; a point holds its own.
            for (place, z) in [(place, 44.0), (at(1.0, 1.0), 55.0)] {
                transaction.insert_sites(&site(place, z)).unwrap();
            }
        })
        .await
        .unwrap();
        assert_eq!(z_at(&scratch, [place, at(1.0, 1.0)]).await, [33.0, 1.0]);
        edited(&scratch, ENOUGH, |transaction| {
            transaction.delete_sites(&[place]).unwrap();
            transaction.insert_sites(&site(place, 80.0)).unwrap();
            transaction.insert_sites(&site(place, 90.0)).unwrap();
        })
        .await
        .unwrap();
        assert_eq!(z_at(&scratch, [place]).await, [80.0]);
        let expected = built(
            &hill(),
            &[],
            &[site(place, 80.0), site(place, 90.0), site(at(1.0, 1.0), 55.0)],
        )
        .await;
        assert_eq!(checked(&scratch).await, checked(&expected).await);
    });
}
