//! Exports and maps.

use std::ffi::OsString;
use std::path::PathBuf;

use pyo3::prelude::*;
use tiletool::export::{WrongArgument, export_open};
use tiletool::plot::{PlotFile, draw};

use crate::error::{Failure, Outcome};
use crate::reader::Reader;
use crate::runtime::{ask, in_place};
use crate::surface::SurfaceArguments;

#[pymethods]
impl Reader {
    /// Exports as `tiletool export` does with these arguments. Returns the summary as JSON.
    fn export<'py>(
        &self,
        py: Python<'py>,
        arguments: Vec<OsString>,
        surface: SurfaceArguments,
        is_awaited: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let reader = self.0.clone();
        let clip = surface.clip()?;
        let export = async move || {
            let exported = export_open(&reader, clip, arguments).await;
            exported.map_err(|error| match error.downcast_ref::<WrongArgument>() {
                Some(wrong) => Failure::argument(wrong.to_string()),
                None => Failure::of_tool(error),
            })
        };
        ask(py, is_awaited, in_place(export))
    }

    /// Draws a map, as the tool does, into a file whose suffix is `.svg` or `.png`.
    fn plot<'py>(&self, py: Python<'py>, path: PathBuf, is_awaited: bool) -> PyResult<Bound<'py, PyAny>> {
        let reader = self.0.clone();
        ask(py, is_awaited, in_place(async move || plot(&reader, path).await))
    }
}

async fn plot(reader: &delaunay_tiles::TileReader, path: PathBuf) -> Outcome<()> {
    let file = PlotFile::new(path).map_err(|error| Failure::value(error.to_string()))?;
    draw(reader, &file).await.map_err(Failure::of_tool)?;
    Ok(())
}
