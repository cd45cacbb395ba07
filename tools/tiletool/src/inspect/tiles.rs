//! A table with one row per tile.

use delaunay_tiles::store::{Directory, TileEntry};
use serde::Serialize;

use crate::common::thousands;
use crate::numbers::{Bounds, Coordinates, Table};

/// The directory's entry of a tile. Its field names are stable keys of `--json`.
#[derive(Serialize)]
pub struct TileRow {
    pub id: u32,
    pub vertices: u32,
    pub core_triangles: u32,
    pub border_triangles: u32,
    pub owned_triangles: u32,
    pub generation: u32,
    pub core_offset: u64,
    pub core_bytes: u32,
    pub core_raw_bytes: u32,
    pub core_codec: &'static str,
    pub core_crc32c: String,
    pub border_offset: u64,
    pub border_bytes: u32,
    pub border_raw_bytes: u32,
    pub border_codec: &'static str,
    pub border_crc32c: String,
    pub bounds: Option<Bounds>,
}

impl TileRow {
    /// Creates the row of a tile.
    pub fn new(id: u32, entry: &TileEntry) -> Self {
        Self {
            id,
            vertices: entry.vertices,
            core_triangles: entry.core_triangles,
            border_triangles: entry.border_triangles,
            owned_triangles: entry.owned_triangles,
            generation: entry.generation,
            core_offset: entry.core.offset,
            core_bytes: entry.core.length,
            core_raw_bytes: entry.core.decoded,
            core_codec: entry.core.codec.name(),
            core_crc32c: format!("{:08x}", entry.core.crc),
            border_offset: entry.border.offset,
            border_bytes: entry.border.length,
            border_raw_bytes: entry.border.decoded,
            border_codec: entry.border.codec.name(),
            border_crc32c: format!("{:08x}", entry.border.crc),
            bounds: Bounds::new(entry.bounds),
        }
    }

    /// Returns the rows of all tiles.
    pub fn all(directory: &Directory) -> impl Iterator<Item = Self> {
        used(directory).map(|(id, entry)| Self::new(id, entry))
    }
}

/// Returns the tiles by their numbers.
fn used(directory: &Directory) -> impl Iterator<Item = (u32, &TileEntry)> {
    (0..).zip(&directory.tiles).filter(|(_, entry)| !entry.is_unused())
}

/// Returns whether some tile is not stored as it is.
fn is_compressed(directory: &Directory) -> bool {
    used(directory).any(|(_, t)| t.decoded_bytes() != t.stored_bytes())
}

/// Returns the table of all tiles for people.
pub fn table(directory: &Directory, coordinates: Coordinates) -> String {
    let is_compressed = is_compressed(directory);
    let mut columns = vec![
        "tile",
        "vertices",
        "core",
        "border",
        "owned",
        "core bytes",
        "border bytes",
    ];
    if is_compressed {
        columns.push("raw bytes");
    }
    columns.extend(["offset", "min x", "min y", "max x", "max y"]);
    let mut table = Table::new(&columns);
    for (id, t) in used(directory) {
        let raw_bytes = is_compressed.then(|| t.decoded_bytes());
        let counts = [
            id.into(),
            t.vertices.into(),
            t.core_triangles.into(),
            t.border_triangles.into(),
            t.owned_triangles.into(),
            t.core.length.into(),
            t.border.length.into(),
        ];
        let counts = counts.into_iter().chain(raw_bytes).chain([t.core.offset]);
        let bounds = [t.bounds.min_x, t.bounds.min_y, t.bounds.max_x, t.bounds.max_y];
        let bounds = bounds.map(|value| {
            if t.bounds.is_empty() {
                "-".to_owned()
            } else {
                coordinates.show(value)
            }
        });
        table.row(counts.map(thousands).chain(bounds));
    }
    table.show(0)
}
