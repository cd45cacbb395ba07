//! The nearest vertices and sites by Euclidean distance.

use delaunay_tiles::query::Near;
use pyo3::prelude::*;
use tiletool::query::answer::Status;

use super::batch::{Options, Rows, in_order, points};
use super::ends::{Ends, first};
use super::names::Names;
use super::ways::pair;
use crate::columns::{Column, Columns};
use crate::reader::Reader;
use crate::runtime::ask;

/// Finds up to `most` vertices or sites for each point, nearest first. Returns the ends, offsets,
/// distances, points, vertices, numbers of sites (-1 for vertices), and ids.
#[pyfunction]
pub fn nearest<'py>(
    py: Python<'py>,
    reader: &Reader,
    xy: Rows<'py>,
    most: usize,
    of_sites: bool,
    options: Options,
    is_awaited: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let (reader, at) = (reader.0.clone(), points(&xy)?);
    let options = options.into_query()?;
    ask(py, is_awaited, async move {
        let answers = in_order(at.into_iter(), move |at| {
            let (reader, options) = (reader.clone(), options.clone());
            async move {
                match of_sites {
                    true => first(reader.sites_by_euclidean_distance(at, options), most).await,
                    false => first(reader.vertices_by_euclidean_distance(at, options), most).await,
                }
            }
        });
        Ok(columns(answers.await?))
    })
}

/// Returns the columns of answers.
fn columns(answers: Vec<(Status, Vec<Near>)>) -> Columns {
    let (mut ends, mut names) = (Ends::default(), Names::default());
    let (mut offsets, mut distances, mut places) = (vec![0], Vec::new(), Vec::new());
    let (mut vertices, mut numbers) = (Vec::new(), Vec::new());
    for (status, found) in answers {
        ends.push(status);
        for near in found {
            distances.push(near.distance);
            places.push(near.vertex.point);
            vertices.extend(pair(&near.vertex));
            numbers.push(near.site.map_or(-1, |number| number as i64));
            if let Some(number) = near.site {
                names.push(number, near.id);
            }
        }
        offsets.push(distances.len() as i64);
    }
    let mut columns = ends.into_columns();
    columns.extend([
        Column::I64(offsets),
        Column::F64(distances),
        Column::points(&places),
        Column::I64Rows(vertices, 2),
        Column::I64(numbers),
    ]);
    columns.extend(names.into_columns());
    Columns(columns)
}
