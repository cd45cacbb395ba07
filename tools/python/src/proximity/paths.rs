//! Shortest paths.

use delaunay_tiles::query::{Path, PathOutcome, QueryError};
use pyo3::prelude::*;
use tiletool::query::answer::Status;

use super::batch::{Options, Rows, in_order, points};
use super::ends::{Distances, Ends, missing, status};
use super::ways::Ways;
use crate::columns::Columns;
use crate::error::Outcome;
use crate::reader::Reader;
use crate::runtime::ask;

/// Finds a shortest path for each pair of points. Returns the ends, the distances and the paths.
#[pyfunction]
pub fn paths<'py>(
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
        let (mut ends, mut distances, mut ways) = (Ends::default(), Distances::default(), Ways::default());
        let question = move |(from, to)| {
            let (reader, options) = (reader.clone(), options.clone());
            async move { ended(reader.shortest_path(from, to, options).await) }
        };
        in_order(
            from.into_iter().zip(to),
            |pair| pair.0,
            question,
            |(status, path)| {
                ends.push(status);
                distances.push(path.as_ref().map_or_else(|| missing(status), |path| path.distance));
                ways.push(path.as_ref());
            },
        )
        .await?;
        let mut columns = ends.into_columns();
        columns.extend(distances.into_columns());
        columns.extend(ways.into_columns());
        Ok(Columns(columns))
    })
}

/// Returns how a question for a path ended, and the path.
///
/// # Errors
/// Returns errors that are no answers.
pub fn ended(outcome: Result<PathOutcome, QueryError>) -> Outcome<(Status, Option<Path>)> {
    Ok(match outcome {
        Ok(PathOutcome::Found(path)) => (Status::Ok, Some(path)),
        Ok(PathOutcome::Unreachable) => (Status::Unreachable, None),
        Ok(PathOutcome::InsideObstacle { point, nearest_free }) => (Status::Inside(point, nearest_free), None),
        Err(error) => (status(error)?, None),
    })
}
