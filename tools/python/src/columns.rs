//! Answers as tuples of numpy arrays.

use delaunay_tiles::Point;
use numpy::{Element, PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};

/// One member of an answer.
pub enum Column {
    F64(Vec<f64>),
    I64(Vec<i64>),
    U8(Vec<u8>),
    Bool(Vec<bool>),
    /// Rows of this length.
    F64Rows(Vec<f64>, usize),
    I64Rows(Vec<i64>, usize),
    BoolRows(Vec<bool>, usize),
    /// A list of texts, and `None` where there is none.
    Texts(Vec<Option<String>>),
}

/// An answer: its members, in an order on which both parts of the package agree.
pub struct Columns(pub Vec<Column>);

impl Column {
    /// Returns points as rows of two.
    pub fn points(points: &[Point]) -> Self {
        Self::F64Rows(points.iter().flat_map(|p| [p.x, p.y]).collect(), 2)
    }

    fn into_python(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        Ok(match self {
            Self::F64(values) => PyArray1::from_vec(py, values).into_any(),
            Self::I64(values) => PyArray1::from_vec(py, values).into_any(),
            Self::U8(values) => PyArray1::from_vec(py, values).into_any(),
            Self::Bool(values) => PyArray1::from_vec(py, values).into_any(),
            Self::F64Rows(values, width) => rows(py, values, width)?,
            Self::I64Rows(values, width) => rows(py, values, width)?,
            Self::BoolRows(values, width) => rows(py, values, width)?,
            Self::Texts(texts) => PyList::new(py, texts)?.into_any(),
        })
    }
}

/// Returns a matrix with rows of `width` values.
fn rows<T: Element>(py: Python<'_>, values: Vec<T>, width: usize) -> PyResult<Bound<'_, PyAny>> {
    let count = values.len().checked_div(width).unwrap_or(0);
    Ok(PyArray1::from_vec(py, values).reshape([count, width])?.into_any())
}

impl<'py> IntoPyObject<'py> for Columns {
    type Target = PyTuple;
    type Output = Bound<'py, PyTuple>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Self::Output> {
        let members: PyResult<Vec<_>> = self.0.into_iter().map(|column| column.into_python(py)).collect();
        PyTuple::new(py, members?)
    }
}
