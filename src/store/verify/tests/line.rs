//! Files of collinear points that are wrong in one respect each.

use crate::geometry::{Point, VertexIndex};
use crate::store::format::edge_source::{EdgeSource, LineKind};
use crate::store::format::ids::{TileId, VertexId};
use crate::store::verify::tests::model::{Model, pair};

fn at(step: usize) -> Point {
    Point::new(step as f64, 7.0 - 3.0 * step as f64)
}

/// Forty points, with edges between all but the last: a break line in the other direction, and a
/// wall along a part of it.
fn model(tile_vertices: usize) -> Model {
    let points: Vec<Point> = (0..40).map(at).collect();
    let lines = [
        ([at(38), at(0)], EdgeSource::new(LineKind::BreakLine, 0).into()),
        ([at(10), at(30)], EdgeSource::new(LineKind::Wall, 1).into()),
    ];
    Model::with_lines(&points, &lines, &[], tile_vertices)
}

fn vertex(model: &Model, step: usize) -> VertexId {
    let tiles = (0..).map(TileId).zip(&model.tiles);
    let mut found = tiles.filter_map(|(tile, its)| {
        let index = VertexIndex(its.points.iter().position(|&p| p == at(step))? as u32);
        Some(VertexId { tile, index })
    });
    found.next().unwrap()
}

/// Replaces the edge from vertex `step` to the next one by an edge to `to`.
fn bend(model: &mut Model, step: usize, to: VertexId) {
    let [from, next] = [step, step + 1].map(|step| vertex(model, step));
    let sources = &mut model.tiles[from.tile.0 as usize].sources;
    let its = sources.remove(&pair(from, next)).unwrap();
    sources.insert(pair(from, to), its);
}

#[track_caller]
fn found(model: &Model, words: &str) {
    let complaint = model.verify().expect_err("something is wrong").to_string();
    assert!(complaint.contains(words), "{complaint}");
}

#[test]
fn edges_that_skip_the_next_vertex_on_the_line_are_found() {
    for tile_vertices in [8, 1000] {
        let right = model(tile_vertices);
        right.verify().unwrap();
        assert_eq!(right.directory.metadata.constraint_edges, 38);
        assert_eq!(right.tiles.iter().map(|tile| tile.sources.len()).sum::<usize>(), 38);
        let last_of_tile = |&step: &usize| vertex(&right, step).tile != vertex(&right, step + 1).tile;
        for step in (0..38).filter(|step| !last_of_tile(step)) {
            let mut wrong = right.clone();
            let to = vertex(&wrong, (step + 2) % 40);
            bend(&mut wrong, step, to);
            found(&wrong, "does not lead to the next vertex on the line");
        }
        let ends: Vec<usize> = (0..38).filter(last_of_tile).collect();
        assert_eq!(ends.is_empty(), tile_vertices > 40);
        for step in ends {
            let mut wrong = right.clone();
            let to = vertex(&wrong, step + 2);
            bend(&mut wrong, step, to);
            found(
                &wrong,
                "its last edge leads to a vertex that is not the next one on the line",
            );
            // The right vertex, at a wrong position.
            let mut wrong = right.clone();
            let next = vertex(&wrong, step + 1);
            let tile = vertex(&wrong, step).tile.0 as usize;
            wrong.tiles[tile]
                .beliefs
                .insert(next, Point::new(39.5, 7.0 - 3.0 * 39.5));
            found(
                &wrong,
                "its last edge leads to a vertex that is not the next one on the line",
            );
            // The right vertex, with a wrong z.
            let mut wrong = right.clone();
            wrong.tiles[tile].z_beliefs.insert(next, -1.5);
            let says = format!("it says that vertex {next} has z -1.5, but the tile that owns it says");
            found(&wrong, &says);
        }
    }
}

#[test]
fn edges_without_sources_are_found() {
    let mut wrong = model(8);
    let edge = pair(vertex(&wrong, 20), vertex(&wrong, 21));
    for tile in &mut wrong.tiles {
        if let Some(sources) = tile.sources.get_mut(&edge) {
            sources.clear();
        }
    }
    found(&wrong, "without a source");
}
