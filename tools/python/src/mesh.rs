//! Triangulations in memory.

use std::collections::VecDeque;

use delaunay_tiles::Point;
use delaunay_tiles::geometry::HalfEdge;
use delaunay_tiles::mesh::{Constrained, EngineKind, Inserter, Mesh, Topology, Triangulation, Walk, WalkEnd};
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

use crate::columns::{Column, Columns};
use crate::elements::points;
use crate::error::{Failure, Outcome};

/// The most points of a triangulation in memory.
const MOST: usize = (1 << 29) - 1;

/// Triangulates points in memory, with segments between them, and without what can be reached from the hole
/// points. Returns, for each point, the one that stands for it; the corners of the triangles; the triangle
/// opposite to each corner, or -1; and whether the edge opposite to each corner is a constraint.
#[pyfunction]
pub fn triangulate(
    py: Python<'_>,
    xy: PyReadonlyArray2<'_, f64>,
    segments: PyReadonlyArray2<'_, i64>,
    holes: PyReadonlyArray2<'_, f64>,
) -> PyResult<Columns> {
    let (points, holes) = (points(&xy), points(&holes));
    let segments: Vec<[i64; 2]> = segments.as_array().outer_iter().map(|row| [row[0], row[1]]).collect();
    let columns = py.detach(|| InMemory::new(points)?.constrained(&segments, &holes));
    Ok(columns?)
}

/// The distinct points of a triangulation.
struct InMemory {
    /// The place in `distinct` of each point.
    places: Vec<u32>,
    distinct: Vec<Point>,
    /// The first point at each place.
    firsts: Vec<i64>,
}

impl InMemory {
    fn new(points: Vec<Point>) -> Outcome<Self> {
        if points.len() > MOST {
            return Err(Failure::value(format!(
                "there are {} points; in memory there can be {MOST}",
                points.len()
            )));
        }
        let points: Vec<Point> = points.into_iter().map(Point::normalized).collect();
        if let Some(row) = points.iter().position(|point| !point.is_valid()) {
            let Point { x, y } = points[row];
            return Err(Failure::value(format!(
                "xy[{row}] is ({x}, {y}): coordinates must be 0 or of a magnitude from {:e} to {:e}",
                Point::MIN_MAGNITUDE,
                Point::MAX_MAGNITUDE
            )));
        }
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        order.sort_unstable_by(|&a, &b| points[a as usize].lex_cmp(points[b as usize]).then(a.cmp(&b)));
        let mut first_at: Vec<u32> = (0..points.len() as u32).collect();
        for pair in order.windows(2) {
            let [before, this] = [pair[0] as usize, pair[1] as usize];
            if points[before] == points[this] {
                first_at[this] = first_at[before];
            }
        }
        let mut this = Self {
            places: vec![0; points.len()],
            distinct: Vec::new(),
            firsts: Vec::new(),
        };
        for (point, &first) in first_at.iter().enumerate() {
            if first as usize == point {
                this.places[point] = this.distinct.len() as u32;
                this.distinct.push(points[point]);
                this.firsts.push(point as i64);
            } else {
                this.places[point] = this.places[first as usize];
            }
        }
        Ok(this)
    }

    fn constrained(&self, segments: &[[i64; 2]], holes: &[Point]) -> Outcome<Columns> {
        let mut triangles = Triangulation::default();
        EngineKind::default()
            .create()
            .triangulate(&self.distinct, &mut triangles);
        let mut mesh = Constrained::new(triangles, self.distinct.len());
        let mut inserter = Inserter::default();
        for (row, ends) in segments.iter().enumerate() {
            let place = |end: i64| usize::try_from(end).ok().and_then(|end| self.places.get(end).copied());
            let [Some(from), Some(to)] = ends.map(place) else {
                return Err(Failure::value(format!(
                    "segments[{row}] is ({}, {}), and there are {} points, numbered from 0",
                    ends[0],
                    ends[1],
                    self.places.len()
                )));
            };
            inserter
                .insert(&self.distinct, &mut mesh, [from, to])
                .map_err(|crossing| {
                    let [a, b] = crossing.edge.map(|end| self.firsts[end as usize]);
                    Failure::build(format!(
                        "segments[{row}] from point {} to {} crosses the segment between points {a} and {b}; add a \
                     point where they cross",
                        ends[0], ends[1]
                    ))
                })?;
        }
        Ok(self.columns(&mesh, &self.outside(&mesh, holes)))
    }

    /// Returns whether each triangle can be reached from a hole point without crossing a constraint.
    fn outside(&self, mesh: &Constrained, holes: &[Point]) -> Vec<bool> {
        let triangulation = mesh.mesh();
        let mut is_hole = vec![false; triangulation.triangles.len()];
        let mut queue = VecDeque::new();
        for &hole in holes.iter().filter(|_| !triangulation.triangles.is_empty()) {
            let embedded = Mesh {
                triangulation,
                points: &self.distinct,
            };
            let mut walk = Walk::new(hole.normalized(), triangulation.triangles.len() as u64);
            match walk.run(&embedded, HalfEdge(0)) {
                Ok(WalkEnd::Triangle(triangle)) => queue.push_back(triangle),
                Ok(WalkEnd::Edge(edge)) => {
                    queue.push_back(edge.triangle());
                    queue.extend(triangulation.twin(edge).half_edge().map(HalfEdge::triangle));
                }
                Ok(WalkEnd::Vertex(edge)) => queue.extend(triangulation.star(edge).map(HalfEdge::triangle)),
                Ok(WalkEnd::Hull(_) | WalkEnd::Elsewhere(_)) | Err(_) => {}
            }
            while let Some(triangle) = queue.pop_front() {
                if std::mem::replace(&mut is_hole[triangle.index()], true) {
                    continue;
                }
                let open = HalfEdge::of_triangle(triangle)
                    .into_iter()
                    .filter(|&edge| !mesh.is_constraint(edge));
                queue.extend(
                    open.filter_map(|edge| triangulation.twin(edge).half_edge())
                        .map(HalfEdge::triangle),
                );
            }
        }
        is_hole
    }

    fn columns(&self, mesh: &Constrained, is_hole: &[bool]) -> Columns {
        let triangulation = mesh.mesh();
        let mut numbers = vec![-1; is_hole.len()];
        let kept: Vec<usize> = (0..is_hole.len()).filter(|&triangle| !is_hole[triangle]).collect();
        for (&triangle, number) in kept.iter().zip(0..) {
            numbers[triangle] = number;
        }
        let (mut corners, mut neighbours, mut fixed) = (Vec::new(), Vec::new(), Vec::new());
        for &triangle in &kept {
            for corner in 0..3 {
                corners.push(self.firsts[triangulation.triangles[triangle][corner] as usize]);
                // The edge opposite to corner 0 runs from corner 1 to corner 2.
                let edge = HalfEdge((3 * triangle + (corner + 1) % 3) as u32);
                let twin = triangulation.twin(edge).half_edge();
                neighbours.push(twin.map_or(-1, |twin| numbers[twin.triangle().index()]));
                fixed.push(mesh.is_constraint(edge));
            }
        }
        let stands = self.places.iter().map(|&place| self.firsts[place as usize]);
        Columns(vec![
            Column::I64(stands.collect()),
            Column::I64Rows(corners, 3),
            Column::I64Rows(neighbours, 3),
            Column::BoolRows(fixed, 3),
        ])
    }
}
