//! The area within a walking distance.

use delaunay_tiles::Point;
use delaunay_tiles::geometry::{Orientation, orient2d};
use delaunay_tiles::query::QueryError;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use tiletool::query::answer::{Area, Status};
use tiletool::query::area;

use super::batch::{Options, Rows, points};
use super::ends::Ends;
use crate::columns::{Column, Columns};
use crate::error::Failure;
use crate::reader::Reader;
use crate::runtime::ask;

/// Finds the area within a walking distance of a point. Returns the end, the size, and polygons as
/// points, offsets of rings, and offsets of polygons among the rings.
#[pyfunction]
pub fn reach<'py>(
    py: Python<'py>,
    reader: &Reader,
    at: [f64; 2],
    radius: f64,
    options: Options,
    is_awaited: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let reader = reader.0.clone();
    let options = options.into_query()?;
    ask(py, is_awaited, async move {
        let [x, y] = at;
        let found = area::within(&reader, Point::new(x, y), radius, options).await;
        let (status, area) = found.map_err(|error| match error.downcast::<QueryError>() {
            Ok(error) => Failure::from(error),
            Err(other) => Failure::other(other.to_string()),
        })?;
        Ok::<_, Failure>(columns(status, &area))
    })
}

/// Returns the columns of an answer.
fn columns(status: Status, area: &Area) -> Columns {
    let mut ends = Ends::default();
    ends.push(status);
    let (mut corners, mut rings, mut polygons) = (Vec::new(), vec![0], vec![0]);
    for polygon in &area.polygons {
        for ring in polygon.rings() {
            corners.extend(ring);
            rings.push(corners.len() as i64);
        }
        polygons.push((rings.len() - 1) as i64);
    }
    let mut columns = ends.into_columns();
    columns.extend([
        Column::F64(vec![area.size]),
        Column::points(&corners),
        Column::I64(rings),
        Column::I64(polygons),
    ]);
    Columns(columns)
}

/// Returns whether each point is in the closed area within rings, of which the inner ones are holes.
#[pyfunction]
pub fn in_polygons<'py>(
    py: Python<'py>,
    corners: Rows<'py>,
    rings: PyReadonlyArray1<'py, i64>,
    xy: Rows<'py>,
) -> PyResult<Bound<'py, PyArray1<bool>>> {
    let (corners, rings, at) = (points(&corners)?, rings.as_slice()?.to_vec(), points(&xy)?);
    let found = py.detach(move || {
        let edges = Edges::new(&corners, &rings);
        at.iter().map(|&point| edges.contain(point)).collect::<Vec<bool>>()
    });
    Ok(found.into_pyarray(py))
}

/// The edges of rings, in stripes of equal height.
struct Edges {
    low: f64,
    /// Stripes per unit of y.
    scale: f64,
    stripes: Vec<Vec<[Point; 2]>>,
}

impl Edges {
    fn new(corners: &[Point], rings: &[i64]) -> Self {
        let mut edges = Vec::with_capacity(corners.len());
        for ring in rings.windows(2) {
            let ring = corners.get(ring[0] as usize..ring[1] as usize).unwrap_or_default();
            edges.extend(ring.iter().copied().zip(ring.iter().copied().cycle().skip(1)));
        }
        let [low, high] = [f64::min, f64::max].map(|of| corners.iter().map(|p| p.y).reduce(of).unwrap_or(0.0));
        // On average, an edge is in no more than four stripes.
        let heights: f64 = edges.iter().map(|(a, b)| (b.y - a.y).abs()).sum();
        let most = edges.len().max(1);
        let count = ((3.0 * most as f64 * (high - low) / heights) as usize).clamp(1, most);
        let scale = count as f64 / (high - low);
        let scale = if scale.is_finite() { scale } else { 0.0 };
        let mut this = Self {
            low,
            scale,
            stripes: vec![Vec::new(); count],
        };
        for (a, b) in edges {
            let (first, last) = (this.stripe(a.y.min(b.y)), this.stripe(a.y.max(b.y)));
            for stripe in &mut this.stripes[first..=last] {
                stripe.push([a, b]);
            }
        }
        this
    }

    fn stripe(&self, y: f64) -> usize {
        (((y - self.low) * self.scale) as usize).min(self.stripes.len() - 1)
    }

    /// Counts the edges that a ray to the right crosses.
    fn contain(&self, point: Point) -> bool {
        let mut is_inside = false;
        for &[a, b] in &self.stripes[self.stripe(point.y)] {
            let (down, up) = if a.y <= b.y { (a, b) } else { (b, a) };
            if point.y < down.y || point.y > up.y {
                continue;
            }
            match orient2d(down, up, point) {
                // On the line of the edge, at its height; a level edge has an extent in x.
                Orientation::Collinear if a.x.min(b.x) <= point.x && point.x <= a.x.max(b.x) => return true,
                Orientation::CounterClockwise if point.y < up.y => is_inside = !is_inside,
                _ => {}
            }
        }
        is_inside
    }
}
