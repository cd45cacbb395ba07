//! Distances without paths: between all points of two lists, and along edges.

use delaunay_tiles::query::{DistanceOutcome, Mode, QueryOptions};
use delaunay_tiles::{Distance, Point, TileReader};
use futures::TryStreamExt;
use pyo3::prelude::*;
use tiletool::query::answer::Status;

use super::batch::{Options, Rows, in_order, points, space};
use super::ends::{Distances, code, missing, status};
use super::paths::ended;
use crate::columns::{Column, Columns};
use crate::error::Outcome;
use crate::reader::Reader;
use crate::runtime::ask;

/// Cells of distances, with codes of how each question ended.
struct Cells {
    codes: Vec<u8>,
    distances: Distances,
}

impl Cells {
    /// Returns no cells, with space for `count`.
    ///
    /// # Errors
    /// Fails if there is not enough memory.
    fn with_space(count: usize) -> Outcome<Self> {
        Ok(Self {
            codes: space(count)?,
            distances: Distances::with_space(count)?,
        })
    }

    fn push(&mut self, (status, distance): (Status, Option<Distance>)) {
        self.codes.push(code(status));
        self.distances.push(distance.unwrap_or_else(|| missing(status)));
    }

    /// Returns the codes and the distances.
    fn into_columns(self) -> Columns {
        let mut columns = vec![Column::U8(self.codes)];
        columns.extend(self.distances.into_columns());
        Columns(columns)
    }
}

/// Finds the walking distance between each point of one list and each of another. Returns codes
/// and distances: row by row, or column by column if the mode is exact and the second list is the
/// shorter one.
#[pyfunction]
pub fn matrix<'py>(
    py: Python<'py>,
    reader: &Reader,
    starts: Rows<'py>,
    ends: Rows<'py>,
    options: Options,
    is_awaited: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let (reader, from, to) = (reader.0.clone(), points(&starts)?, points(&ends)?);
    let is_exact = options.mode()? == Mode::Exact;
    let options = options.into_query()?;
    ask(py, is_awaited, async move {
        let cells = match is_exact {
            true => by_wavefronts(reader, from, to, options).await?,
            false => by_pairs(reader, from, to, options).await?,
        };
        Ok(cells.into_columns())
    })
}

/// Returns the cells of exact distances. One search serves a row or a column.
async fn by_wavefronts(reader: TileReader, from: Vec<Point>, to: Vec<Point>, options: QueryOptions) -> Outcome<Cells> {
    let mut cells = Cells::with_space(from.len().saturating_mul(to.len()))?;
    let mut pairs = reader.distance_matrix(from, to, options);
    while let Some(pair) = pairs.try_next().await? {
        cells.push(match pair.outcome {
            DistanceOutcome::Found(distance) => (Status::Ok, Some(distance)),
            DistanceOutcome::Unreachable => (Status::Unreachable, None),
            DistanceOutcome::InsideObstacle { point, nearest_free } => (Status::Inside(point, nearest_free), None),
            DistanceOutcome::OutOfBudget { lower_bound } => (Status::Budget(lower_bound), None),
        });
    }
    Ok(cells)
}

/// Returns the cells of distances with bounds, for which each pair is a search.
async fn by_pairs(reader: TileReader, from: Vec<Point>, to: Vec<Point>, options: QueryOptions) -> Outcome<Cells> {
    let (width, count) = (to.len(), from.len().saturating_mul(to.len()));
    let mut cells = Cells::with_space(count)?;
    let pairs = (0..count).map(move |cell| (from[cell / width], to[cell % width]));
    let question = move |(from, to)| {
        let (reader, options) = (reader.clone(), options.clone());
        async move {
            let (status, path) = ended(reader.shortest_path(from, to, options).await)?;
            Ok((status, path.map(|path| path.distance)))
        }
    };
    in_order(pairs, |pair| pair.0, question, |answer| cells.push(answer)).await?;
    Ok(cells)
}

/// Finds the distance along edges for each pair of points. Returns codes and distances.
#[pyfunction]
pub fn edge_distances<'py>(
    py: Python<'py>,
    reader: &Reader,
    starts: Rows<'py>,
    ends: Rows<'py>,
    options: Options,
    is_awaited: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let (reader, from, to) = (reader.0.clone(), points(&starts)?, points(&ends)?);
    let options = options.into_query()?;
    ask(py, is_awaited, async move {
        let mut cells = Cells::with_space(from.len())?;
        let question = move |(from, to)| {
            let (reader, options) = (reader.clone(), options.clone());
            async move {
                match reader.cdt_distance(from, to, options).await {
                    Ok(Some(path)) => Ok((Status::Ok, Some(path.distance))),
                    Ok(None) => Ok((Status::Unreachable, None)),
                    Err(error) => Ok((status(error)?, None)),
                }
            }
        };
        in_order(
            from.into_iter().zip(to),
            |pair| pair.0,
            question,
            |answer| cells.push(answer),
        )
        .await?;
        Ok(cells.into_columns())
    })
}
