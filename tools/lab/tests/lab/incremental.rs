//! The second candidate gives the same triangles as the library's kernel; otherwise its times would
//! mean nothing.

use delaunay_tiles::geometry::Point;
use delaunay_tiles::mesh::{Engine, EngineKind, Topology, Triangulation};
use distributions::Kind;
use lab::kernels::Input;
use lab::kernels::incremental::{Incremental, Order};

fn sorted_triangles(mesh: &Triangulation) -> Vec<[u32; 3]> {
    let smallest_first = |mut t: [u32; 3]| {
        let smallest = (0..3).min_by_key(|&i| t[i]).unwrap_or(0);
        t.rotate_left(smallest);
        t
    };
    let mut triangles: Vec<_> = mesh.triangles.iter().map(|&t| smallest_first(t)).collect();
    triangles.sort_unstable();
    triangles
}

/// Returns the hull, from its smallest index on.
fn hull(mesh: &Triangulation) -> Vec<u32> {
    let mut hull = mesh.hull.clone();
    let smallest = (0..hull.len()).min_by_key(|&i| hull[i]).unwrap_or(0);
    if !mesh.triangles.is_empty() {
        hull.rotate_left(smallest);
    }
    hull
}

fn check(engines: &mut [Box<dyn Engine>; 3], points: &[Point], what: &str) {
    let [expected, hilbert, brio] = engines.each_mut().map(|engine| {
        let mut mesh = Triangulation::default();
        engine.triangulate(points, &mut mesh);
        mesh
    });
    for mesh in [hilbert, brio] {
        assert_eq!(sorted_triangles(&mesh), sorted_triangles(&expected), "{what}");
        assert_eq!(hull(&mesh), hull(&expected), "{what}");
        for side in mesh.half_edges() {
            if let Some(twin) = mesh.twin(side).half_edge() {
                assert_eq!(mesh.twin(twin).half_edge(), Some(side), "{what}");
                assert_eq!(mesh.origin(twin), mesh.destination(side), "{what}");
            }
        }
    }
}

fn engines() -> [Box<dyn Engine>; 3] {
    [
        EngineKind::Native.create(),
        Box::new(Incremental::new(Order::Hilbert)),
        Box::new(Incremental::new(Order::Brio)),
    ]
}

#[test]
fn engines_give_the_same_triangles_on_all_distributions() {
    let mut engines = engines();
    for kind in Kind::ALL {
        for n in (0..40).chain([100, 333, 1000, 2000]) {
            check(&mut engines, &Input::new(kind, n).points, &format!("{kind} {n}"));
        }
    }
}

#[test]
fn engines_give_the_same_triangles_on_grids() {
    let mut engines = engines();
    for (columns, rows) in [(1, 1), (1, 50), (50, 1), (2, 50), (50, 2), (37, 41)] {
        let points = |turned: i32| -> Vec<_> {
            (0..columns * rows)
                .map(|i| (i % columns, i / columns))
                .map(|(x, y)| Point::new((x + turned * y).into(), (y - turned * x).into()))
                .collect()
        };
        check(&mut engines, &points(0), "upright");
        check(&mut engines, &points(1), "turned");
    }
}

/// Every subset of a 5 by 5 grid is a number of 25 bits; some of them are tested, in some order.
#[test]
fn engines_give_the_same_triangles_on_subsets_of_a_small_grid() {
    let mut engines = engines();
    let mut state = 1u64;
    let mut random = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        state >> 33
    };
    for _ in 0..20_000 {
        let subset = random();
        let mut points: Vec<_> = (0..25)
            .filter(|i| subset >> i & 1 == 1)
            .map(|i| Point::new(f64::from(i % 5), f64::from(i / 5)))
            .collect();
        for i in (1..points.len()).rev() {
            points.swap(i, random() as usize % (i + 1));
        }
        check(&mut engines, &points, &format!("{points:?}"));
    }
}
