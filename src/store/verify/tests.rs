//! Tests that the verifier finds faults. The files are valid ones that were changed consistently,
//! with right checksums.

mod components;
mod line;
mod lines;
mod model;
mod polygons;
mod regions;
mod renumbered;
mod tables;
mod town;

use crate::geometry::{Point, VertexIndex};
use crate::store::format::ids::{TileId, VertexId};
use crate::store::verify::error::VerifyError;
use model::{Model, ModelTile, Named, pair};

fn grid() -> Vec<Point> {
    (0..100)
        .map(|i| Point::new(f64::from(i % 10), f64::from(i / 10)))
        .collect()
}

fn scattered() -> Vec<Point> {
    let mut seed = 7u64;
    let mut random = || {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (seed >> 40) as f64 / 1e6
    };
    (0..200).map(|_| Point::new(random(), random())).collect()
}

fn models() -> Vec<Model> {
    [(grid(), 16), (scattered(), 16), (scattered(), 1000), (grid(), 1000)]
        .map(|(p, n)| Model::of(&p, n))
        .into()
}

/// Asserts that verification fails with a fault in a tile. Returns the tile, the triangle and the
/// reason.
#[track_caller]
fn found(model: &Model) -> (TileId, Option<u32>, String) {
    match model.verify() {
        Err(VerifyError::Tile { tile, triangle, reason }) => (tile, triangle.map(|triangle| triangle.0), reason),
        other => panic!("{other:?}"),
    }
}

#[test]
fn unchanged_models_are_valid() {
    for model in models() {
        model.verify().unwrap();
    }
}

#[test]
fn a_flipped_edge_is_found() {
    let mut ties = 0;
    for model in models() {
        let whole: Vec<Named> = model.tiles.iter().flat_map(|t| t.core.clone()).collect();
        for (old, new) in model.flips(|_| true).into_iter().step_by(7) {
            let core = old.iter().all(|t| whole.contains(t));
            let mut wrong = model.clone();
            old.iter().for_each(|&t| wrong.remove(t));
            new.iter().for_each(|&t| wrong.add(t, core));
            let (_, triangle, reason) = found(&wrong);
            assert!(triangle.is_some() && reason.contains("circle"), "{reason}");
            ties += usize::from(core);
        }
    }
    assert!(ties > 20, "{ties}");
}

/// A flipped edge is valid if it is a constraint and all tiles say so.
#[test]
fn a_tile_that_does_not_know_a_constraint_is_found() {
    let mut partly = 0;
    for model in models() {
        let whole: Vec<Named> = model.tiles.iter().flat_map(|t| t.core.clone()).collect();
        for (old, new) in model.flips(|_| true).into_iter().step_by(11) {
            let core = old.iter().all(|t| whole.contains(t));
            let edge = pair(new[0][0], new[0][2]);
            let mut right = model.clone();
            old.iter().for_each(|&t| right.remove(t));
            new.iter().for_each(|&t| right.add(t, core));
            right
                .tiles
                .iter_mut()
                .for_each(|tile| _ = tile.constraints.insert(edge));
            right.verify().unwrap();
            let knows = |tile: &ModelTile| {
                let triangles = tile.core.iter().chain(&tile.border);
                triangles.filter(|t| edge.iter().all(|v| t.contains(v))).count() > 0
            };
            for tile in (0..right.tiles.len()).filter(|&tile| knows(&right.tiles[tile])) {
                let mut wrong = right.clone();
                wrong.tiles[tile].constraints.clear();
                found(&wrong);
                partly += usize::from(!core);
            }
        }
    }
    assert!(partly > 100, "{partly}");
}

#[test]
fn a_moved_vertex_of_a_grid_is_found() {
    for model in models() {
        for step in [1e-9, 0.3] {
            let mut faults = 0;
            for (tile, index) in (0..model.tiles.len()).flat_map(|t| [(t, 3), (t, 7)]) {
                let mut wrong = model.clone();
                wrong.tiles[tile].points[index].x += step;
                faults += usize::from(wrong.verify().is_err());
            }
            // Scattered points may move a little and stay valid. The points of a grid may not,
            // because of the tie rule.
            let tie = model
                .point(VertexId {
                    tile: TileId(0),
                    index: VertexIndex(0),
                })
                .x
                .fract()
                == 0.0;
            assert!(
                !tie || faults == 2 * model.tiles.len(),
                "{faults} of {}",
                2 * model.tiles.len()
            );
        }
    }
}

#[test]
fn a_border_that_lacks_a_triangle_is_found() {
    for model in &models()[..2] {
        for tile in 0..model.tiles.len() {
            for index in (0..model.tiles[tile].border.len()).step_by(5) {
                let mut wrong = model.clone();
                wrong.tiles[tile].border.remove(index);
                found(&wrong);
            }
        }
    }
}

#[test]
fn a_border_with_a_wrong_foreign_vertex_is_found() {
    for model in &models()[..2] {
        for tile in 0..model.tiles.len() {
            let id = TileId(tile as u32);
            let foreign = model.tiles[tile].border.iter().flatten().filter(|v| v.tile != id);
            for &v in foreign.step_by(11) {
                let mut wrong = model.clone();
                let p = model.point(v);
                // The smallest possible step.
                let moved = Point::new(p.x, if p.y == 0.0 { 1e-40 } else { p.y.next_up() });
                wrong.tiles[tile].beliefs.insert(v, moved);
                found(&wrong);
                // Another id for the vertex, in this tile only.
                let mut wrong = model.clone();
                let other = VertexId {
                    index: VertexIndex(v.index.0 + 1000),
                    ..v
                };
                wrong.tiles[tile].beliefs.insert(other, p);
                for w in wrong.tiles[tile]
                    .border
                    .as_flattened_mut()
                    .iter_mut()
                    .filter(|w| **w == v)
                {
                    *w = other;
                }
                found(&wrong);
            }
        }
    }
}

#[test]
fn a_repeated_vertex_an_isolated_vertex_and_a_wrong_z_are_found() {
    for model in models() {
        let mut twice = model.clone();
        let p = twice.tiles[0].points[0];
        twice.tiles[0].points.push(p);
        twice.tiles[0].z.push(0.0);
        assert!(found(&twice).2.contains("has the same coordinates as another"));
        let mut apart = model.clone();
        let mut q = model.tiles[0].points[0];
        q.x -= 1e-7;
        apart.tiles[0].points.push(q);
        apart.tiles[0].z.push(0.0);
        assert!(found(&apart).2.contains("is missing or does not start there"));
        for z in [f64::NAN, f64::INFINITY] {
            let mut infinite = model.clone();
            infinite.tiles[0].z[2] = z;
            let error = infinite.verify().unwrap_err().to_string();
            assert!(error.contains("vertex 2 has no finite z"), "{error}");
        }
        let mut flat = model.clone();
        flat.tiles.last_mut().unwrap().z.clear();
        found(&flat);
    }
}

#[test]
fn a_border_with_another_z_of_a_foreign_vertex_is_found() {
    let mut tried = 0;
    for model in &models()[..2] {
        for tile in 0..model.tiles.len() {
            let id = TileId(tile as u32);
            let foreign = model.tiles[tile].border.iter().flatten().filter(|v| v.tile != id);
            for &v in foreign.step_by(7) {
                let right = model.tiles[v.tile.0 as usize].z[v.index.index()];
                // The smallest possible step.
                let z = right.next_up();
                let mut wrong = model.clone();
                wrong.tiles[tile].z_beliefs.insert(v, z);
                let (at, triangle, reason) = found(&wrong);
                let says = format!("it says that vertex {v} has z {z:?}, but the tile that owns it says {right:?}");
                assert_eq!((at, triangle.is_some(), reason), (id, true, says));
                tried += 1;
            }
        }
    }
    assert!(tried > 50, "{tried}");
    // Equal numbers with different bits.
    let mut wrong = models()[0].clone();
    let v = *wrong.tiles[0].border.iter().flatten().find(|v| v.tile.0 > 0).unwrap();
    wrong.tiles[v.tile.0 as usize].z[v.index.index()] = 0.0;
    wrong.verify().unwrap();
    wrong.tiles[0].z_beliefs.insert(v, -0.0);
    assert!(
        found(&wrong)
            .2
            .contains("has z -0.0, but the tile that owns it says 0.0")
    );
}

#[test]
fn missing_reversed_and_doubled_triangles_are_found() {
    for model in models() {
        let all = model.triangles();
        for &t in all.iter().step_by(3) {
            let mut wrong = model.clone();
            wrong.remove(t);
            // A removed corner triangle leaves its vertex without triangles; otherwise the hull is
            // not convex.
            assert!(wrong.verify().is_err(), "without {t:?}");
            let mut turned = model.clone();
            let core = turned.tiles.iter().any(|tile| tile.core.contains(&t));
            turned.remove(t);
            turned.add([t[0], t[2], t[1]], core);
            assert!(turned.verify().is_err(), "with {t:?} turned round");
        }
        let mut doubled = model.clone();
        let t = all[all.len() / 2];
        doubled.add(t, false);
        assert!(doubled.verify().is_err());
        let mut none = model.clone();
        all.iter().for_each(|&t| none.remove(t));
        assert!(found(&none).2.contains("not collinear"));
    }
}
