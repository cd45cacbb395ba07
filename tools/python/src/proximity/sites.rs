//! The nearest sites, and those within a distance.

use delaunay_tiles::query::SiteFound;
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use tiletool::query::answer::Status;

use super::batch::{Options, Rows, in_order, points};
use super::ends::{Distances, Ends, first};
use super::names::Names;
use super::ways::Ways;
use crate::columns::{Column, Columns};
use crate::error::Failure;
use crate::reader::Reader;
use crate::runtime::ask;

/// Finds up to `most` sites within a walking distance of each point, nearest first. Returns the
/// ends, offsets, numbers, distances, points, ids, and paths if the options request them.
#[pyfunction]
pub fn sites<'py>(
    py: Python<'py>,
    reader: &Reader,
    xy: Rows<'py>,
    radii: PyReadonlyArray1<'py, f64>,
    most: usize,
    options: Options,
    is_awaited: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let (reader, at) = (reader.0.clone(), points(&xy)?);
    let radii = radii.as_slice()?.to_vec();
    let wants_paths = options.wants_paths();
    let options = options.into_query()?;
    ask(py, is_awaited, async move {
        let questions = at.into_iter().zip(radii);
        let answers = in_order(questions, move |(at, radius)| {
            first(reader.sites_within(at, radius, options.clone()), most)
        });
        let answers = answers.await?;
        Ok::<_, Failure>(columns(answers, wants_paths))
    })
}

/// Returns the columns of answers.
fn columns(answers: Vec<(Status, Vec<SiteFound>)>, wants_paths: bool) -> Columns {
    let (mut ends, mut names, mut ways, mut distances) =
        (Ends::default(), Names::default(), Ways::default(), Distances::default());
    let (mut offsets, mut numbers, mut places) = (vec![0], Vec::new(), Vec::new());
    for (status, sites) in answers {
        ends.push(status);
        for site in sites {
            numbers.push(site.number as i64);
            distances.push(site.distance);
            places.push(site.vertex.point);
            if wants_paths {
                ways.push(site.path.as_ref());
            }
            names.push(site.number, site.id);
        }
        offsets.push(numbers.len() as i64);
    }
    let mut columns = ends.into_columns();
    columns.extend([Column::I64(offsets), Column::I64(numbers)]);
    columns.extend(distances.into_columns());
    columns.push(Column::points(&places));
    columns.extend(names.into_columns());
    if wants_paths {
        columns.extend(ways.into_columns());
    }
    Columns(columns)
}
