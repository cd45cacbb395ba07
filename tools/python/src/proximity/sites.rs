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
use crate::reader::Reader;
use crate::runtime::ask;

/// Finds the `most` nearest sites of each point, nearest first. Returns the ends, offsets, numbers,
/// distances, points, ids, and paths if the options request them.
#[pyfunction]
pub fn nearest_sites<'py>(
    py: Python<'py>,
    reader: &Reader,
    xy: Rows<'py>,
    most: usize,
    options: Options,
    is_awaited: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let (reader, at) = (reader.0.clone(), points(&xy)?);
    let mut found = Found::new(options.wants_paths());
    let options = options.into_query()?.first(most);
    ask(py, is_awaited, async move {
        let question = move |at| first(reader.nearest_sites(at, options.clone()), most);
        in_order(at.into_iter(), |&at| at, question, |answer| found.push(answer)).await?;
        Ok(found.into_columns())
    })
}

/// Finds the sites within a walking distance of each point, nearest first. Returns the same columns
/// as [`nearest_sites`].
#[pyfunction]
pub fn sites_within<'py>(
    py: Python<'py>,
    reader: &Reader,
    xy: Rows<'py>,
    radii: PyReadonlyArray1<'py, f64>,
    options: Options,
    is_awaited: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let (reader, at) = (reader.0.clone(), points(&xy)?);
    let radii = radii.as_slice()?.to_vec();
    let mut found = Found::new(options.wants_paths());
    let options = options.into_query()?;
    ask(py, is_awaited, async move {
        let question = move |(at, radius)| first(reader.sites_within(at, radius, options.clone()), usize::MAX);
        let questions = at.into_iter().zip(radii);
        in_order(questions, |question| question.0, question, |answer| found.push(answer)).await?;
        Ok(found.into_columns())
    })
}

/// The columns of answers.
struct Found {
    ends: Ends,
    offsets: Vec<i64>,
    numbers: Vec<i64>,
    distances: Distances,
    places: Vec<f64>,
    names: Names,
    ways: Option<Ways>,
}

impl Found {
    fn new(wants_paths: bool) -> Self {
        Self {
            ends: Ends::default(),
            offsets: vec![0],
            numbers: Vec::new(),
            distances: Distances::default(),
            places: Vec::new(),
            names: Names::default(),
            ways: wants_paths.then(Ways::default),
        }
    }

    fn push(&mut self, (status, sites): (Status, Vec<SiteFound>)) {
        self.ends.push(status);
        for site in sites {
            self.numbers.push(site.number as i64);
            self.distances.push(site.distance);
            self.places.extend([site.vertex.point.x, site.vertex.point.y]);
            if let Some(ways) = &mut self.ways {
                ways.push(site.path.as_ref());
            }
            self.names.push(site.number, site.id);
        }
        self.offsets.push(self.numbers.len() as i64);
    }

    fn into_columns(self) -> Columns {
        let mut columns = self.ends.into_columns();
        columns.extend([Column::I64(self.offsets), Column::I64(self.numbers)]);
        columns.extend(self.distances.into_columns());
        columns.push(Column::F64Rows(self.places, 2));
        columns.extend(self.names.into_columns());
        columns.extend(self.ways.into_iter().flat_map(Ways::into_columns));
        Columns(columns)
    }
}
