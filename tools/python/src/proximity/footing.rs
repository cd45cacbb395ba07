//! Whether points are free.

use delaunay_tiles::query::Footing;
use pyo3::prelude::*;
use tiletool::query::answer::Status;

use super::batch::{Options, Rows, in_order, points};
use super::ends::{Ends, status};
use crate::columns::Columns;
use crate::reader::Reader;
use crate::runtime::ask;

/// Finds whether each point is free. Returns the ends.
#[pyfunction]
pub fn footing<'py>(
    py: Python<'py>,
    reader: &Reader,
    xy: Rows<'py>,
    options: Options,
    is_awaited: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let (reader, at) = (reader.0.clone(), points(&xy)?);
    let options = options.into_query()?;
    ask(py, is_awaited, async move {
        let question = move |at| {
            let (reader, options) = (reader.clone(), options.clone());
            async move {
                match reader.footing(at, options).await {
                    Ok(Footing::Free) => Ok(Status::Ok),
                    Ok(Footing::InsideObstacle { nearest_free }) => Ok(Status::Inside(at, nearest_free)),
                    Err(error) => status(error),
                }
            }
        };
        let mut ends = Ends::default();
        in_order(at.into_iter(), |&at| at, question, |end| ends.push(end)).await?;
        Ok(Columns(ends.into_columns()))
    })
}
