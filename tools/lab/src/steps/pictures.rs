//! The five pictures.

use std::ops::RangeInclusive;

use delaunay_tiles::geometry::{Point, Rect, in_circle};

use super::ground::WINDOW;
use super::sheet::{Look, Sheet};
use super::stages::{Leaf, Stages};
use super::triangles::{Triangle, TriangleSet};
use super::walk::Walk;
use tiletool::common::thousands;
use tiletool::plot::style::{CONSTRAINT, INK, SITE, WALL};

const CELL: &str = "#c8452f";
const CELL_WIDTH: f64 = 1.8;
const SETTLED: Look = look("#cfe2f1", "#7d9cb5");
const PENDING: Look = Look {
    inside: None,
    edge: "#b3a78f",
    width: 0.8,
};
const CONFIRMED: Look = look("#fdf3d8", "#c2b48d");
const CROSSING: Look = look("#f3b64f", "#a8731a");
const UNCHANGED: Look = look("#fff", "#b4c4d1");
const HOLES: Look = look("#d3d0c7", "#b9b5a9");
const CHANGED: Look = look("#e08fb8", "#a8327a");
const SEARCHED: Look = look("#b7d6ee", "#6f9cc0");
const USED: &str = "#fdf0c4";
/// The number of points in the circle of the example of a refuted triangle.
const FEW: RangeInclusive<usize> = 2..=4;
/// The circle of a settled triangle, and that of a pending one.
const INSIDE: &str = "#0b5c8f";
const REACHES_OUT: &str = "#a8327a";

/// Returns how triangles of a colour look.
const fn look(inside: &'static str, edge: &'static str) -> Look {
    Look {
        inside: Some(inside),
        edge,
        width: 0.7,
    }
}

/// Draws all pictures. Returns their names, and the SVGs.
pub fn draw(stages: &Stages, walk: &Walk) -> Vec<(&'static str, String)> {
    vec![
        ("steps-1-divide.svg", divide(stages)),
        ("steps-2-conquer.svg", conquer(stages)),
        ("steps-3-merge.svg", merge(stages)),
        ("steps-4-constrain.svg", constrain(stages)),
        ("steps-5-query.svg", query(walk)),
    ]
}

fn divide(stages: &Stages) -> String {
    let points: Vec<Point> = stages.leaves.iter().flat_map(|leaf| &leaf.points).copied().collect();
    let caption = format!(
        "{} points in {} cells of a k-d tree: each becomes a tile",
        count(points.len()),
        stages.leaves.len()
    );
    let mut sheet = Sheet::new("1. Divide", &caption);
    sheet.dots("points", INK, 1.5, &points);
    draw_cells(&mut sheet, stages.cells(), CELL_WIDTH);
    for leaf in &stages.leaves {
        sheet.label(leaf.cell, leaf.id, CELL);
    }
    sheet.finish()
}

fn conquer(stages: &Stages) -> String {
    let [settled, pending] = [|leaf: &Leaf| leaf.settled.len(), |leaf: &Leaf| leaf.pending.len()]
        .map(|number| count(stages.leaves.iter().map(number).sum()));
    let caption = format!("Each cell alone: {settled} triangles are final, {pending} are passed up");
    let mut sheet = Sheet::new("2. Conquer", &caption);
    let leaves = &stages.leaves;
    sheet.triangles("final", SETTLED, leaves.iter().flat_map(|leaf| &leaf.settled));
    sheet.triangles("passed up", PENDING, leaves.iter().flat_map(|leaf| &leaf.pending));
    draw_cells(&mut sheet, stages.cells(), CELL_WIDTH);
    if let Some(example) = stages.largest_inside() {
        draw_example(&mut sheet, "a circle within its cell", INSIDE, &example, &[]);
    }
    if let Some((example, others)) = stages.largest_refuted() {
        draw_example(
            &mut sheet,
            "one with points of another cell",
            REACHES_OUT,
            &example,
            &others,
        );
    }
    sheet.finish()
}

fn merge(stages: &Stages) -> String {
    let merged = &stages.merged;
    let caption = format!(
        "The Delaunay triangulation: {} triangles were final before, {} are confirmed, {} cross between cells",
        count(merged.settled.len()),
        count(merged.confirmed.len()),
        count(merged.crossing.len())
    );
    let mut sheet = Sheet::new("3. Merge", &caption);
    sheet.triangles("final before", SETTLED, &merged.settled);
    sheet.triangles("passed up and confirmed", CONFIRMED, &merged.confirmed);
    sheet.triangles("new, with corners in several cells", CROSSING, &merged.crossing);
    draw_cells(&mut sheet, stages.cells(), CELL_WIDTH);
    sheet.finish()
}

fn constrain(stages: &Stages) -> String {
    let (constrained, changed) = (&stages.constrained, stages.changed());
    let drawn_later: TriangleSet = constrained.holes.iter().chain(&changed).collect();
    let others = constrained
        .triangles
        .iter()
        .filter(|triangle| !drawn_later.has(triangle));
    let caption = format!(
        "Coast lines as obstacles, and two break lines: {} of {} triangles change",
        count(changed.len()),
        count(constrained.triangles.len())
    );
    let mut sheet = Sheet::new("4. Constrain", &caption);
    sheet.triangles("", UNCHANGED, others);
    sheet.triangles("holes", HOLES, &constrained.holes);
    sheet.triangles("changed", CHANGED, &changed);
    draw_cells(&mut sheet, constrained.cells.iter().map(|(_, cell)| cell), CELL_WIDTH);
    sheet.lines("coasts", WALL, 2.0, &constrained.walls);
    sheet.lines("break lines", CONSTRAINT, 2.6, &constrained.breaks);
    sheet.finish()
}

fn query(walk: &Walk) -> String {
    let caption = format!(
        "The same triangulation in {} smaller tiles: a shortest path uses {} of them, and searches {} triangles",
        walk.ground.cells.len(),
        walk.used.len(),
        count(walk.searched.len())
    );
    let mut sheet = Sheet::new("5. Query", &caption);
    let (cells, is_used) = (&walk.ground.cells, |id| walk.used.binary_search(id).is_ok());
    let used = cells.iter().filter(|(id, _)| is_used(id));
    sheet.cells("tiles that are read", USED, None, used.map(|(_, cell)| cell));
    sheet.triangles("searched", SEARCHED, &walk.searched);
    sheet.triangles("holes", HOLES, &walk.ground.holes);
    draw_cells(&mut sheet, cells.iter().map(|(_, cell)| cell), 0.9);
    sheet.lines("", WALL, 1.2, &walk.ground.walls);
    sheet.polyline("shortest path", SITE, 3.4, &walk.path);
    let ends = [walk.path.first(), walk.path.last()].into_iter().flatten().copied();
    sheet.dots("", SITE, 6.0, &ends.collect::<Vec<_>>());
    sheet.finish()
}

fn draw_cells<'a>(sheet: &mut Sheet, cells: impl Iterator<Item = &'a Rect>, width: f64) {
    sheet.cells("cells", CELL, Some(width), cells);
}

/// Draws a triangle, its circumcircle, and the points of other cells in it.
fn draw_example(sheet: &mut Sheet, name: &'static str, colour: &'static str, example: &Example, others: &[Point]) {
    let [a, b, c] = example.corners;
    sheet.circle(name, colour, example.centre, a);
    sheet.polyline("", colour, 2.2, &[a, b, c, a]);
    sheet.dots("", colour, 3.6, others);
}

/// A triangle and the centre of its circumcircle.
#[derive(Clone, Copy)]
pub struct Example {
    pub corners: Triangle,
    pub centre: Point,
    square_of_radius: f64,
}

impl Example {
    /// Returns the triangle, unless its circumcircle leaves the window. The centre is rounded.
    fn within_window(&[a, b, c]: &Triangle) -> Option<Self> {
        let (ux, uy, vx, vy) = (b.x - a.x, b.y - a.y, c.x - a.x, c.y - a.y);
        let (uu, vv, twice) = (ux * ux + uy * uy, vx * vx + vy * vy, 2.0 * (ux * vy - uy * vx));
        let (dx, dy) = ((vy * uu - uy * vv) / twice, (ux * vv - vx * uu) / twice);
        let (centre, square_of_radius) = (Point::new(a.x + dx, a.y + dy), dx * dx + dy * dy);
        let radius = square_of_radius.sqrt();
        let disc = Rect::new(
            centre.x - radius,
            centre.y - radius,
            centre.x + radius,
            centre.y + radius,
        );
        let is_inside = disc.union(WINDOW) == WINDOW;
        is_inside.then_some(Self {
            corners: [a, b, c],
            centre,
            square_of_radius,
        })
    }
}

impl Stages {
    /// Returns the settled triangle with the largest circumcircle.
    fn largest_inside(&self) -> Option<Example> {
        let settled = self.leaves.iter().flat_map(|leaf| &leaf.settled);
        largest(settled)
    }

    /// Returns the triangle with the largest circumcircle of those that few points refute, and the
    /// points in that circle, which are of other cells.
    fn largest_refuted(&self) -> Option<(Example, Vec<Point>)> {
        let pending = self.leaves.iter().flat_map(|leaf| &leaf.pending);
        let example = largest(pending.filter(|corners| FEW.contains(&self.inside(corners).count())))?;
        let inside = self.inside(&example.corners).collect();
        Some((example, inside))
    }

    /// Returns the points in the circumcircle of a triangle.
    fn inside(&self, &[a, b, c]: &Triangle) -> impl Iterator<Item = Point> {
        let points = self.leaves.iter().flat_map(|leaf| &leaf.points).copied();
        points.filter(move |&point| ![a, b, c].contains(&point) && in_circle(a, b, c, point))
    }

    fn cells(&self) -> impl Iterator<Item = &Rect> {
        self.leaves.iter().map(|leaf| &leaf.cell)
    }
}

/// Returns the triangle with the largest circumcircle.
fn largest<'a>(triangles: impl Iterator<Item = &'a Triangle>) -> Option<Example> {
    let examples = triangles.filter_map(Example::within_window);
    examples.max_by(|one, other| one.square_of_radius.total_cmp(&other.square_of_radius))
}

fn count(number: usize) -> String {
    thousands(number as u64)
}
