//! Memory of a tile that Python reads without a copy.
#![allow(unsafe_code, reason = "the buffer protocol is an interface of C")]

use std::ffi::{c_int, c_void};

use bytes::Bytes;
use pyo3::exceptions::PyBufferError;
use pyo3::ffi;
use pyo3::prelude::*;

/// Bytes of a tile, for the buffer protocol. They live as long as anything refers to this object, whatever
/// happens to the reader and its cache.
#[pyclass(frozen, module = "delaunay_tiles._core")]
pub struct View(pub Bytes);

#[pymethods]
impl View {
    /// # Safety
    /// The interpreter calls this with a buffer that it owns.
    unsafe fn __getbuffer__(slf: Bound<'_, Self>, view: *mut ffi::Py_buffer, flags: c_int) -> PyResult<()> {
        if view.is_null() {
            return Err(PyBufferError::new_err("there is no buffer to fill"));
        }
        let bytes = &slf.get().0;
        let length = ffi::Py_ssize_t::try_from(bytes.len())?;
        // SAFETY: `view` is valid by the contract of this method. The bytes do not move and are not
        // changed while `slf` lives, to which the buffer gets a reference; it is marked as read-only,
        // so the pointer is not written through.
        let filled = unsafe {
            let start = bytes.as_ptr().cast_mut().cast::<c_void>();
            ffi::PyBuffer_FillInfo(view, slf.as_ptr(), start, length, 1, flags)
        };
        match filled {
            0 => Ok(()),
            _ => Err(PyErr::fetch(slf.py())),
        }
    }
}
