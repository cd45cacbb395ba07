//! Distances without paths: between all points of two lists, and along edges.

use delaunay_tiles::query::{DistanceOutcome, Mode, QueryOptions};
use delaunay_tiles::{Point, TileReader};
use futures::TryStreamExt;
use pyo3::prelude::*;
use tiletool::query::answer::Status;

use super::batch::{Options, Rows, filled, in_order, points};
use super::ends::{Distances, code, missing, status};
use super::paths::ended;
use crate::columns::{Column, Columns};
use crate::error::Outcome;
use crate::reader::Reader;
use crate::runtime::ask;

/// Finds the walking distance between each point of one list and each of another. Returns codes
/// and distances, row by row.
#[pyfunction]
pub fn matrix<'py>(
    py: Python<'py>,
    reader: &Reader,
    from: Rows<'py>,
    to: Rows<'py>,
    options: Options,
    is_awaited: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let (reader, from, to) = (reader.0.clone(), points(&from)?, points(&to)?);
    let is_exact = options.mode()? == Mode::Exact;
    let options = options.into_query()?;
    ask(py, is_awaited, async move {
        match is_exact {
            true => by_wavefronts(reader, from, to, options).await,
            false => by_pairs(reader, from, to, options).await,
        }
    })
}

/// Returns the cells of exact distances. One search serves a row or a column.
async fn by_wavefronts(
    reader: TileReader,
    from: Vec<Point>,
    to: Vec<Point>,
    options: QueryOptions,
) -> Outcome<Columns> {
    let (width, count) = (to.len(), from.len().saturating_mul(to.len()));
    let (mut codes, mut distances) = (filled(0, count)?, Distances::infinite(count)?);
    let mut pairs = reader.distance_matrix(from, to, options);
    while let Some(pair) = pairs.try_next().await? {
        let (status, distance) = match pair.outcome {
            DistanceOutcome::Found(distance) => (Status::Ok, Some(distance)),
            DistanceOutcome::Unreachable => (Status::Unreachable, None),
            DistanceOutcome::InsideObstacle { point, nearest_free } => (Status::Inside(point, nearest_free), None),
            DistanceOutcome::OutOfBudget { lower_bound } => (Status::Budget(lower_bound), None),
        };
        let cell = pair.from_index * width + pair.to_index;
        codes[cell] = code(status);
        distances.set(cell, distance.unwrap_or_else(|| missing(status)));
    }
    Ok(columns(codes, distances))
}

/// Returns the cells of distances with bounds, for which each pair is a search.
async fn by_pairs(reader: TileReader, from: Vec<Point>, to: Vec<Point>, options: QueryOptions) -> Outcome<Columns> {
    let (width, count) = (to.len(), from.len().saturating_mul(to.len()));
    let (mut codes, mut distances) = (filled(0, count)?, Distances::infinite(count)?);
    let pairs = (0..count).map(move |cell| (from[cell / width], to[cell % width]));
    let answers = in_order(pairs, move |(from, to)| {
        let (reader, options) = (reader.clone(), options.clone());
        async move {
            let (status, path) = ended(reader.shortest_path(from, to, options).await)?;
            Ok((code(status), path.map_or_else(|| missing(status), |path| path.distance)))
        }
    });
    for (cell, (code, distance)) in answers.await?.into_iter().enumerate() {
        codes[cell] = code;
        distances.set(cell, distance);
    }
    Ok(columns(codes, distances))
}

/// Finds the distance along edges for each pair of points. Returns codes and distances.
#[pyfunction]
pub fn edge_distances<'py>(
    py: Python<'py>,
    reader: &Reader,
    from: Rows<'py>,
    to: Rows<'py>,
    options: Options,
    is_awaited: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let (reader, from, to) = (reader.0.clone(), points(&from)?, points(&to)?);
    let options = options.into_query()?;
    ask(py, is_awaited, async move {
        let answers = in_order(from.into_iter().zip(to), move |(from, to)| {
            let (reader, options) = (reader.clone(), options.clone());
            async move {
                let (status, distance) = match reader.cdt_distance(from, to, options).await {
                    Ok(Some(path)) => (Status::Ok, Some(path.distance)),
                    Ok(None) => (Status::Unreachable, None),
                    Err(error) => (status(error)?, None),
                };
                Ok((code(status), distance.unwrap_or_else(|| missing(status))))
            }
        });
        let (mut codes, mut distances) = (Vec::new(), Distances::default());
        for (code, distance) in answers.await? {
            codes.push(code);
            distances.push(distance);
        }
        Ok(columns(codes, distances))
    })
}

fn columns(codes: Vec<u8>, distances: Distances) -> Columns {
    let mut columns = vec![Column::U8(codes)];
    columns.extend(distances.into_columns());
    Columns(columns)
}
