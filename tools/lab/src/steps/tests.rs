//! What the pictures say is so.

use std::path::Path;

use delaunay_tiles::geometry::{Point, Rect, in_circle, segments_cross};

use super::ground::{Ground, POINTS};
use super::stages::{Merged, Stages};
use super::triangles::{Triangle, TriangleSet};
use super::walk::Walk;
use crate::work::block_on;

const COASTS: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../tests/data/indonesia/indonesia_ne10m.geojson"
);

fn ground() -> Ground {
    Ground::read(Path::new(COASTS)).unwrap()
}

fn stages(ground: &Ground) -> Stages {
    let scratch = tempfile::tempdir().unwrap();
    block_on(Stages::build(ground, scratch.path())).unwrap()
}

/// Returns whether a line crosses an edge of a triangle.
fn crosses(&[from, to]: &[Point; 2], triangle: &Triangle) -> bool {
    let &[a, b, c] = triangle;
    Rect::around([from, to]).intersects(Rect::around(*triangle))
        && [[a, b], [b, c], [c, a]]
            .iter()
            .any(|&[a, b]| segments_cross(from, to, a, b))
}

#[test]
fn a_triangle_that_is_final_in_its_cell_is_in_the_merged_triangulation() {
    let stages = stages(&ground());
    assert!(stages.leaves.len() >= 8);
    let settled: Vec<Triangle> = stages.leaves.iter().flat_map(|leaf| leaf.settled.clone()).collect();
    assert!(settled.len() > POINTS / 2);
    assert!(settled.iter().all(|triangle| stages.delaunay.has(triangle)));
    assert_eq!(settled.len(), stages.merged.settled.len());
    // No point of any cell is in such a circle.
    let points: Vec<Point> = stages.leaves.iter().flat_map(|leaf| leaf.points.clone()).collect();
    assert_eq!(points.len(), POINTS);
    for &[a, b, c] in &settled {
        let is_corner = |point: Point| [a, b, c].contains(&point);
        assert!(
            !points
                .iter()
                .any(|&point| !is_corner(point) && in_circle(a, b, c, point))
        );
    }
}

#[test]
fn a_merge_keeps_or_refutes_what_is_passed_up_and_adds_triangles_between_cells_only() {
    let stages = stages(&ground());
    let Merged {
        settled,
        confirmed,
        crossing,
    } = &stages.merged;
    let groups = settled.iter().chain(confirmed).chain(crossing);
    assert_eq!(
        groups.collect::<TriangleSet>().len(),
        settled.len() + confirmed.len() + crossing.len()
    );
    let pending: TriangleSet = stages.leaves.iter().flat_map(|leaf| &leaf.pending).collect();
    assert!(confirmed.iter().all(|triangle| pending.has(triangle)));
    assert!(confirmed.len() < pending.len(), "nothing is refuted");
    let cells = |triangle: &Triangle| {
        let seen = stages
            .leaves
            .iter()
            .filter(|leaf| triangle.iter().any(|corner| leaf.points.contains(corner)));
        seen.count()
    };
    assert!(crossing.iter().all(|triangle| cells(triangle) > 1));
    assert!(settled.iter().chain(confirmed).all(|triangle| cells(triangle) == 1));
}

#[test]
fn the_triangles_that_change_are_those_that_a_constraint_crosses() {
    let ground = ground();
    let stages = stages(&ground);
    let constrained = &stages.constrained;
    let after: TriangleSet = constrained.triangles.iter().collect();
    let Merged {
        settled,
        confirmed,
        crossing,
    } = &stages.merged;
    let lines = || constrained.walls.iter().chain(&constrained.breaks);
    let mut gone = 0;
    for triangle in settled.iter().chain(confirmed).chain(crossing) {
        let is_crossed = lines().any(|line| crosses(line, triangle));
        assert_eq!(is_crossed, !after.has(triangle));
        gone += usize::from(is_crossed);
    }
    // No vertex is added, so there are as many triangles as before.
    assert_eq!(gone, stages.changed().len());
    assert!(gone > 50);
    assert_eq!(constrained.triangles.len(), stages.delaunay.len());
    assert!(!constrained.holes.is_empty() && !constrained.walls.is_empty());
    // Each break line passes through several cells.
    for ends in &ground.lines {
        let around = |corner: &Point| stages.leaves.iter().position(|leaf| leaf.points.contains(corner));
        assert_ne!(around(&ends[0]), around(&ends[1]));
    }
}

#[test]
fn smaller_tiles_have_the_same_triangles_and_a_path_uses_a_part_of_them() {
    let ground = ground();
    let scratch = tempfile::tempdir().unwrap();
    let walk = block_on(Walk::take(&ground, scratch.path())).unwrap();
    let constrained = stages(&ground).constrained;
    let in_large: TriangleSet = constrained.triangles.iter().collect();
    assert_eq!(walk.ground.triangles.len(), in_large.len());
    assert!(walk.ground.triangles.iter().all(|triangle| in_large.has(triangle)));
    assert!(2 * walk.used.len() < walk.ground.cells.len());
    assert!(walk.path.len() > 2);
    // Every searched triangle has a corner in a tile that was used, since a tile has all of them.
    let cells = walk.ground.cells.iter().filter(|(id, _)| walk.used.contains(id));
    let cells: Vec<Rect> = cells.map(|&(_, cell)| cell).collect();
    for corners in &walk.searched {
        assert!(in_large.has(corners));
        assert!(
            cells
                .iter()
                .any(|cell| corners.iter().any(|&corner| cell.contains(corner)))
        );
    }
}
