//! The formats of all kinds of exports, and what they show.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use anyhow::anyhow;
use delaunay_tiles::export::{Format, RasterFormat, What};
use delaunay_tiles::terrain::Measure;

/// A format of meshes and features, or of rasters.
#[derive(Clone, Copy, Debug)]
pub enum AnyFormat {
    /// Vertices, triangles and edges.
    Mesh(Format),
    /// Cells.
    Raster(RasterFormat),
    /// Map tiles.
    #[cfg(feature = "pmtiles")]
    Archive,
}

/// The suffix and the name of the format of map tiles.
#[cfg(feature = "pmtiles")]
const ARCHIVE: &str = "pmtiles";

impl AnyFormat {
    /// Returns the format that a file's suffix indicates.
    pub fn from_path(path: &Path) -> anyhow::Result<Self> {
        #[cfg(feature = "pmtiles")]
        if path
            .extension()
            .is_some_and(|suffix| suffix.eq_ignore_ascii_case(ARCHIVE))
        {
            return Ok(Self::Archive);
        }
        match RasterFormat::from_path(path) {
            Some(format) => Ok(Self::Raster(format)),
            None => Format::from_path(path).map(Self::Mesh).map_err(with_rasters),
        }
    }
}

impl fmt::Display for AnyFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Mesh(format) => format.fmt(f),
            Self::Raster(format) => format.fmt(f),
            #[cfg(feature = "pmtiles")]
            Self::Archive => f.write_str(ARCHIVE),
        }
    }
}

impl FromStr for AnyFormat {
    type Err = anyhow::Error;

    fn from_str(name: &str) -> anyhow::Result<Self> {
        #[cfg(feature = "pmtiles")]
        if name == ARCHIVE {
            return Ok(Self::Archive);
        }
        match name.parse() {
            Ok(format) => Ok(Self::Raster(format)),
            Err(_) => name.parse().map(Self::Mesh).map_err(with_rasters),
        }
    }
}

/// Returns the error of an unknown format, with the formats of rasters and of map tiles.
fn with_rasters(error: delaunay_tiles::export::UnknownFormat) -> anyhow::Error {
    match cfg!(feature = "pmtiles") {
        true => anyhow!("{error}; rasters are tif and asc; map tiles are pmtiles"),
        false => anyhow!("{error}; rasters are tif and asc"),
    }
}

/// What an export shows: the elements of a mesh, or a measure of the surface.
#[derive(Clone, Copy, Debug)]
pub enum Shown {
    /// Elements.
    Mesh(What),
    /// A measure.
    Raster(Measure),
}

impl FromStr for Shown {
    type Err = anyhow::Error;

    fn from_str(name: &str) -> anyhow::Result<Self> {
        let measure = name.parse().map(Self::Raster);
        measure.or_else(|_| {
            let what = name.parse().map(Self::Mesh);
            what.map_err(|_| {
                anyhow!("it is triangles, vertices or edges, and for rasters z, slope, aspect or hillshade")
            })
        })
    }
}
