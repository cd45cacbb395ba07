//! The nearest vertices and sites by Euclidean distance.

use delaunay_tiles::query::{Near, QueryOptions};
use delaunay_tiles::{Point, TileReader};
use pyo3::prelude::*;
use tiletool::query::answer::Status;

use super::batch::{Options, Rows, in_order, points};
use super::ends::{Ends, first};
use super::names::Names;
use super::ways::pair;
use crate::columns::{Column, Columns};
use crate::error::Outcome;
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
        let (mut ends, mut names) = (Ends::default(), Names::default());
        let (mut offsets, mut distances, mut places) = (vec![0], Vec::new(), Vec::new());
        let (mut vertices, mut numbers) = (Vec::new(), Vec::new());
        let question = move |at| nearest_to(reader.clone(), at, most, of_sites, options.clone());
        in_order(
            at.into_iter(),
            |&at| at,
            question,
            |(status, found)| {
                ends.push(status);
                for near in found {
                    distances.push(near.distance);
                    places.extend([near.vertex.point.x, near.vertex.point.y]);
                    vertices.extend(pair(&near.vertex));
                    numbers.push(near.site.map_or(-1, |number| number as i64));
                    if let Some(number) = near.site {
                        names.push(number, near.id);
                    }
                }
                offsets.push(distances.len() as i64);
            },
        )
        .await?;
        let mut columns = ends.into_columns();
        columns.extend([
            Column::I64(offsets),
            Column::F64(distances),
            Column::F64Rows(places, 2),
            Column::I64Rows(vertices, 2),
            Column::I64(numbers),
        ]);
        columns.extend(names.into_columns());
        Ok(Columns(columns))
    })
}

/// Returns the nearest vertices or sites of one point.
async fn nearest_to(
    reader: TileReader,
    at: Point,
    most: usize,
    of_sites: bool,
    options: QueryOptions,
) -> Outcome<(Status, Vec<Near>)> {
    match of_sites {
        true => first(reader.sites_by_euclidean_distance(at, options), most).await,
        false => first(reader.vertices_by_euclidean_distance(at, options), most).await,
    }
}
