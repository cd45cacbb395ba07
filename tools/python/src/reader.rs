//! The reader of a tile file: opening, metadata, tiles, digest, verification.

use std::path::{Path, PathBuf};

use delaunay_tiles::store::Metadata;
use delaunay_tiles::{OpenOptions, TileReader};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::runtime::ask;

/// A cache of tiles.
#[pyclass(frozen, module = "delaunay_tiles._core")]
pub struct Cache(delaunay_tiles::Cache);

#[pymethods]
impl Cache {
    #[new]
    fn new(capacity: usize) -> Self {
        Self(delaunay_tiles::Cache::new(capacity))
    }

    #[getter]
    fn capacity(&self) -> usize {
        self.0.capacity()
    }

    /// Returns the hits, the misses, and the bytes held.
    fn statistics(&self) -> (u64, u64, usize) {
        let statistics = self.0.statistics();
        (statistics.hits, statistics.misses, statistics.bytes)
    }
}

/// A reader of a tile file. It answers in tuples of arrays.
#[pyclass(frozen, module = "delaunay_tiles._core")]
pub struct Reader(pub TileReader);

/// Opens a file, or an address.
#[pyfunction]
#[pyo3(signature = (name, cache, is_awaited))]
pub fn open<'py>(py: Python<'py>, name: PathBuf, cache: &Cache, is_awaited: bool) -> PyResult<Bound<'py, PyAny>> {
    let cache = cache.0.clone();
    ask(py, is_awaited, async move {
        let options = OpenOptions::default().cache(&cache);
        let reader = match url_of(&name) {
            Some(url) => TileReader::open_url(url, options).await?,
            None => TileReader::open(&name, options).await?,
        };
        Ok(Reader(reader))
    })
}

/// Returns a name that is an address on the network.
pub fn url_of(name: &Path) -> Option<&str> {
    let schemes = ["http://", "https://", "s3://"];
    let is_url = |name: &&str| schemes.iter().any(|scheme| name.starts_with(scheme));
    name.to_str().filter(is_url)
}

#[pymethods]
impl Reader {
    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    #[getter]
    fn generation(&self) -> u64 {
        self.0.generation()
    }

    /// Returns the metadata as keyword arguments of the Python part's class.
    fn metadata<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let Metadata { bounds, digest, .. } = self.0.metadata();
        let m = self.0.metadata();
        let counts = [
            ("tiles", u64::from(m.tiles)),
            ("tile_vertices", u64::from(m.tile_vertices)),
            ("vertices", m.vertices),
            ("triangles", m.triangles),
            ("hull_edges", m.hull_edges),
            ("points", m.points),
            ("duplicates", m.duplicates),
            ("added_vertices", m.ends),
            ("constraint_edges", m.constraint_edges),
            ("regions", m.regions),
            ("hole_regions", m.hole_regions),
            ("hole_triangles", m.hole_triangles),
            ("sites", m.sites),
            ("crossings", m.crossings),
            ("generation", self.0.generation()),
            ("file_bytes", self.0.file_length()),
        ];
        let members = PyDict::new(py);
        for (name, count) in counts {
            members.set_item(name, count)?;
        }
        members.set_item("has_z", m.has_z)?;
        members.set_item("exterior_is_hole", m.exterior_is_hole)?;
        members.set_item("producer", &m.producer)?;
        members.set_item("file_id", self.0.file_id().to_string())?;
        members.set_item("digest", digest.to_string())?;
        let corners = (bounds.min_x, bounds.min_y, bounds.max_x, bounds.max_y);
        members.set_item("bounds", (!bounds.is_empty()).then_some(corners))?;
        Ok(members)
    }

    /// Returns the coordinate reference system as text, or `None`.
    fn crs<'py>(&self, py: Python<'py>, is_awaited: bool) -> PyResult<Bound<'py, PyAny>> {
        let reader = self.0.clone();
        ask(py, is_awaited, async move { Ok(reader.crs().await?) })
    }

    /// Returns the digest, computed from the tiles.
    fn digest<'py>(&self, py: Python<'py>, is_awaited: bool) -> PyResult<Bound<'py, PyAny>> {
        let reader = self.0.clone();
        ask(py, is_awaited, async move {
            Ok(reader.recompute_digest().await?.to_string())
        })
    }

    /// Checks the file. Returns the counts of the Python part's `Verified`.
    fn verify<'py>(&self, py: Python<'py>, deep: bool, is_awaited: bool) -> PyResult<Bound<'py, PyAny>> {
        let reader = self.0.clone();
        ask(py, is_awaited, async move {
            let checked = reader.verify(deep).await?;
            Ok((
                checked.tiles,
                checked.vertices,
                checked.triangles,
                checked.edges,
                checked.constraint_edges,
            ))
        })
    }
}
