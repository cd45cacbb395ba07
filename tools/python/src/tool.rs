//! The command `tiletool`.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the tool with these arguments, the first of which is its name. Returns its exit code.
#[pyfunction]
pub fn tiletool(py: Python<'_>, args: Vec<OsString>) -> u8 {
    py.detach(|| ::tiletool::tiletool(args))
}
