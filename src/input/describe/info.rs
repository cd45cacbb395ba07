//! What a file holds, as [`describe`](crate::input::describe) finds it.

use crate::geometry::{Point, Rect};
use crate::input::about::{Field, LasInfo};
use std::path::PathBuf;

/// What a file holds. Counts and bounds come from the records that were read, not from a header.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct FileInfo {
    /// The file, with the layer if the path named one.
    pub path: PathBuf,
    /// The format: the name of a [`Format`](crate::input::Format), or `u32` or `u64` for pairs of
    /// record numbers.
    pub format: String,
    /// The variety of the format, if it has any: `LAS`, `LAZ` or `COPC`; the encoding of PLY;
    /// `GeoParquet`.
    pub variety: Option<String>,
    /// The size in bytes; `None` if the file is a pipe.
    pub bytes: Option<u64>,
    /// Whether the file is compressed with gzip.
    pub is_gzip: bool,
    /// The contents: one element, or for GeoPackage one for each layer.
    pub contents: Vec<Contents>,
    /// The header of a LAS file.
    pub las: Option<LasInfo>,
    /// Notes of the readers, for instance which columns were not read.
    pub notes: Vec<String>,
}

/// The contents of a file or layer.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Contents {
    /// The name of the layer of a GeoPackage.
    pub layer: Option<String>,
    /// The type of geometry that the layer of a GeoPackage declares.
    pub declared_type: Option<String>,
    /// The numbers of records of each kind.
    pub counts: ItemCounts,
    /// The fields of the records or features.
    pub fields: Vec<Field>,
    /// The bounds of the valid positions; empty if there are none.
    pub bounds: Rect,
    /// The lowest and the highest z of the valid positions; `None` if none has z.
    pub z: Option<[f64; 2]>,
    /// The text of the coordinate reference system, if the file names one; see
    /// [`Crs`](crate::crs::Crs).
    pub crs: Option<String>,
}

/// The numbers of records of each kind in a file or layer. A kind that the format does not have is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct ItemCounts {
    /// The features of vector data, and geometries outside of any feature.
    pub features: u64,
    /// The features without any geometry.
    pub without_geometry: u64,
    /// The valid records of a file of points, without withheld ones; or the Point geometries.
    pub points: u64,
    /// The `MultiPoint` geometries.
    pub multi_points: u64,
    /// The `LineString` geometries.
    pub lines: u64,
    /// The `MultiLineString` geometries.
    pub multi_lines: u64,
    /// The Polygon geometries.
    pub polygons: u64,
    /// The `MultiPolygon` geometries.
    pub multi_polygons: u64,
    /// The valid positions: of vector data, the vertices of all geometries; otherwise as `points`.
    pub positions: u64,
    /// The valid positions that have z.
    pub positions_with_z: u64,
    /// The valid positions of Point and `MultiPoint` geometries, which can be sites.
    pub sites: u64,
    /// The triangles of `.ele`, or the faces and lines of PLY and OBJ.
    pub faces: u64,
    /// The edges of these, without repetition.
    pub edges: u64,
    /// The segments of `.poly`, or pairs of record numbers.
    pub segments: u64,
    /// The hole points of `.poly`.
    pub holes: u64,
    /// The points of LAS that are marked as withheld.
    pub withheld: u64,
    /// The invalid records or positions.
    pub invalid: u64,
}

impl Contents {
    pub(super) fn new() -> Self {
        Self {
            layer: None,
            declared_type: None,
            counts: ItemCounts::default(),
            fields: Vec::new(),
            bounds: Rect::EMPTY,
            z: None,
            crs: None,
        }
    }

    /// Adds a valid position to the counts and the bounds. NaN stands for a missing z.
    pub(super) fn add_position(&mut self, point: Point, z: f64) {
        self.counts.positions += 1;
        self.bounds = self.bounds.including(point);
        if !z.is_nan() {
            self.counts.positions_with_z += 1;
            let [low, high] = self.z.unwrap_or([z, z]);
            self.z = Some([low.min(z), high.max(z)]);
        }
    }
}
