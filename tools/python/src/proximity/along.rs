//! The nearest sites along a line.

use delaunay_tiles::Point;
use delaunay_tiles::query::AlongInterval;
use pyo3::prelude::*;
use tiletool::query::answer::Status;

use super::batch::Options;
use super::ends::{Ends, first};
use super::names::Names;
use crate::columns::{Column, Columns};
use crate::reader::Reader;
use crate::runtime::ask;

/// Finds the intervals of a line with the same nearest sites. Returns the end, positions, points and
/// freedom of the intervals, and offsets, numbers, points, distances and ids of their sites.
#[pyfunction]
pub fn along<'py>(
    py: Python<'py>,
    reader: &Reader,
    line: [f64; 4],
    k: usize,
    options: Options,
    is_awaited: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let reader = reader.0.clone();
    let options = options.into_query()?;
    let [from, to] = [Point::new(line[0], line[1]), Point::new(line[2], line[3])];
    ask(py, is_awaited, async move {
        let intervals = reader.nearest_along(from, to, k, options);
        let (status, intervals) = first(intervals, usize::MAX).await?;
        Ok(columns(status, intervals))
    })
}

/// Returns the columns of an answer.
fn columns(status: Status, intervals: Vec<AlongInterval>) -> Columns {
    let (mut ends, mut names) = (Ends::default(), Names::default());
    ends.push(status);
    let (mut positions, mut corners, mut free) = (Vec::new(), Vec::new(), Vec::new());
    let (mut offsets, mut numbers, mut places, mut distances) = (vec![0], Vec::new(), Vec::new(), Vec::new());
    for interval in intervals {
        positions.extend([interval.from_t, interval.to_t]);
        corners.extend([interval.from.x, interval.from.y, interval.to.x, interval.to.y]);
        free.push(interval.sites.is_some());
        for site in interval.sites.into_iter().flatten() {
            numbers.push(site.number as i64);
            places.push(site.vertex.point);
            distances.extend(site.distances);
            names.push(site.number, site.id);
        }
        offsets.push(numbers.len() as i64);
    }
    let mut columns = ends.into_columns();
    columns.extend([
        Column::F64Rows(positions, 2),
        Column::F64Rows(corners, 4),
        Column::Bool(free),
        Column::I64(offsets),
        Column::I64(numbers),
        Column::points(&places),
        Column::F64Rows(distances, 2),
    ]);
    columns.extend(names.into_columns());
    Columns(columns)
}
