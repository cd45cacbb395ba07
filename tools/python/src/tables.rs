//! Triangles, vertices and edges as Arrow streams: a record batch for each tile.

use std::sync::Arc;

use arrow_array::{
    ArrayRef, BooleanArray, Float64Array, RecordBatch, RecordBatchReader, StringArray, UInt32Array, UInt64Array,
};
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef};
use delaunay_tiles::geometry::VertexIndex;
use delaunay_tiles::query::triangle_meets;
use delaunay_tiles::store::{Tile, TileId};
use delaunay_tiles::{ReadError, Rect, TileReader};
use pyo3::prelude::*;
use pyo3_arrow::PyRecordBatchReader;
use tokio::runtime::Runtime;
use tokio::task::JoinHandle;

use crate::elements::{Bounds, rect};
use crate::error::{Failure, Outcome};
use crate::reader::Reader;
use crate::runtime::runtime;

#[pymethods]
impl Reader {
    /// Returns triangles, vertices or edges that meet a box, as a stream that can be read once.
    fn arrow(&self, py: Python<'_>, kind: &str, bounds: Option<Bounds>) -> PyResult<PyRecordBatchReader> {
        let runtime = runtime()?;
        let kind = Kind::named(kind)?;
        let rect = rect(bounds);
        let reader = self.0.clone();
        let tiles = py.detach(|| runtime.block_on(tiles(&reader, rect)))?;
        Ok(PyRecordBatchReader::new(Box::new(Rows {
            schema: kind.schema(reader.metadata().has_z),
            kind,
            rect,
            reader,
            tiles,
            next: None,
            runtime,
        })))
    }
}

/// Returns the tiles whose boxes meet a rectangle, the last one first.
async fn tiles(reader: &TileReader, rect: Rect) -> Outcome<Vec<TileId>> {
    let directory = reader.directory().await?;
    let mut met: Vec<TileId> = directory.tile_ids().collect();
    met.retain(|id| directory.tiles[id.0 as usize].bounds.intersects(rect));
    met.reverse();
    Ok(met)
}

#[derive(Clone, Copy)]
enum Kind {
    Triangles,
    Vertices,
    Edges,
}

impl Kind {
    fn named(name: &str) -> Outcome<Self> {
        match name {
            "triangles" => Ok(Self::Triangles),
            "vertices" => Ok(Self::Vertices),
            "edges" => Ok(Self::Edges),
            _ => Err(Failure::value(format!(
                "kind must be 'triangles', 'vertices' or 'edges', not '{name}'"
            ))),
        }
    }

    fn schema(self, has_z: bool) -> SchemaRef {
        let (before, corners, after) = match self {
            Self::Triangles => {
                let after = [("region", DataType::UInt64), ("hole", DataType::Boolean)];
                (&["tile", "triangle"][..], 3, after)
            }
            Self::Vertices => {
                let after = [("record", DataType::UInt64), ("input", DataType::Boolean)];
                (&["tile", "vertex"][..], 1, after)
            }
            Self::Edges => (&["tile"][..], 2, [("kind", DataType::Utf8), ("line", DataType::UInt64)]),
        };
        let axes: &[&str] = if has_z { &["x", "y", "z"] } else { &["x", "y"] };
        let mut fields: Vec<Field> = before
            .iter()
            .map(|name| Field::new(*name, DataType::UInt32, false))
            .collect();
        for corner in 0..corners {
            let name = |axis: &str| match corners {
                1 => axis.to_owned(),
                _ => format!("{axis}{corner}"),
            };
            fields.extend(axes.iter().map(|axis| Field::new(name(axis), DataType::Float64, false)));
        }
        fields.extend(after.map(|(name, kind)| Field::new(name, kind, false)));
        Arc::new(Schema::new(fields))
    }
}

/// The rows of the tiles that remain, in order. The next tile is read while one is converted.
struct Rows {
    schema: SchemaRef,
    kind: Kind,
    rect: Rect,
    reader: TileReader,
    tiles: Vec<TileId>,
    next: Option<JoinHandle<Result<Arc<Tile>, ReadError>>>,
    runtime: &'static Runtime,
}

impl Rows {
    fn load(&mut self) -> Option<JoinHandle<Result<Arc<Tile>, ReadError>>> {
        let id = self.tiles.pop()?;
        let reader = self.reader.clone();
        Some(self.runtime.spawn(async move { reader.tile(id).await }))
    }

    fn batch(&self, tile: &Tile) -> Result<RecordBatch, ArrowError> {
        let columns = match self.kind {
            Kind::Triangles => triangle_columns(tile, self.rect),
            Kind::Vertices => vertex_columns(tile, self.rect),
            Kind::Edges => edge_columns(tile, self.rect),
        };
        RecordBatch::try_new(Arc::clone(&self.schema), columns)
    }
}

impl Iterator for Rows {
    type Item = Result<RecordBatch, ArrowError>;

    fn next(&mut self) -> Option<Self::Item> {
        let load = self.next.take().or_else(|| self.load())?;
        let loaded = self.runtime.block_on(load);
        self.next = self.load();
        let tile = match loaded {
            Ok(Ok(tile)) => tile,
            Ok(Err(error)) => return Some(Err(ArrowError::ExternalError(Box::new(error)))),
            Err(error) => return Some(Err(ArrowError::ExternalError(Box::new(error)))),
        };
        Some(self.batch(&tile))
    }
}

impl RecordBatchReader for Rows {
    fn schema(&self) -> SchemaRef {
        Arc::clone(&self.schema)
    }
}

impl Drop for Rows {
    fn drop(&mut self) {
        if let Some(load) = &self.next {
            load.abort();
        }
    }
}

/// Returns the x, y and z of rows with the same number of corners each, as a column for each.
fn coordinate_columns(tile: &Tile, corners: &[Vec<VertexIndex>]) -> Vec<ArrayRef> {
    let has_z = tile.z_bytes().is_some();
    let mut columns = Vec::new();
    for of_rows in corners {
        let points = || of_rows.iter().map(|&corner| tile.point(corner));
        columns.push(array(points().map(|point| point.x)));
        columns.push(array(points().map(|point| point.y)));
        if has_z {
            columns.push(array(of_rows.iter().map(|&corner| tile.z(corner).unwrap_or(f64::NAN))));
        }
    }
    columns
}

fn array(values: impl Iterator<Item = f64>) -> ArrayRef {
    Arc::new(Float64Array::from_iter_values(values))
}

fn same(value: u32, count: usize) -> ArrayRef {
    Arc::new(UInt32Array::from_value(value, count))
}

fn triangle_columns(tile: &Tile, rect: Rect) -> Vec<ArrayRef> {
    let mut met: Vec<_> = tile.owned_triangles().collect();
    met.retain(|&triangle| triangle_meets(tile.triangle_points(triangle), rect));
    let corners = |corner: usize| met.iter().map(|&triangle| tile.corners(triangle)[corner]).collect();
    let mut columns = vec![same(tile.id().0, met.len())];
    columns.push(Arc::new(UInt32Array::from_iter_values(
        met.iter().map(|triangle| triangle.0),
    )));
    columns.extend(coordinate_columns(tile, &[corners(0), corners(1), corners(2)]));
    let regions = met.iter().map(|&triangle| tile.region(triangle));
    columns.push(Arc::new(UInt64Array::from_iter_values(regions)));
    let holes: Vec<bool> = met.iter().map(|&triangle| tile.is_hole(triangle)).collect();
    columns.push(Arc::new(BooleanArray::from(holes)));
    columns
}

fn vertex_columns(tile: &Tile, rect: Rect) -> Vec<ArrayRef> {
    let mut met: Vec<_> = tile.vertex_indices().collect();
    met.retain(|&vertex| rect.contains(tile.point(vertex)));
    let mut columns = vec![same(tile.id().0, met.len())];
    columns.push(Arc::new(UInt32Array::from_iter_values(
        met.iter().map(|vertex| vertex.0),
    )));
    columns.extend(coordinate_columns(tile, std::slice::from_ref(&met)));
    let records = met.iter().map(|&vertex| tile.record(vertex));
    columns.push(Arc::new(UInt64Array::from_iter_values(records)));
    let inputs: Vec<bool> = met.iter().map(|&vertex| tile.is_input_point(vertex)).collect();
    columns.push(Arc::new(BooleanArray::from(inputs)));
    columns
}

/// Returns a row for each line along each constraint edge whose box meets the rectangle.
fn edge_columns(tile: &Tile, rect: Rect) -> Vec<ArrayRef> {
    let mut ends = [Vec::new(), Vec::new()];
    let (mut kinds, mut lines) = (Vec::new(), Vec::new());
    for edge in tile.owned_constraints() {
        let points = tile.ends(edge).map(|vertex| vertex.point);
        if !Rect::around(points).intersects(rect) {
            continue;
        }
        for source in tile.edge_sources(edge) {
            for (column, end) in ends.iter_mut().zip(tile.corners_of_edge(edge)) {
                column.push(end);
            }
            kinds.push(source.kind().to_string());
            lines.push(source.number());
        }
    }
    let mut columns = vec![same(tile.id().0, lines.len())];
    columns.extend(coordinate_columns(tile, &ends));
    columns.push(Arc::new(StringArray::from(kinds)));
    columns.push(Arc::new(UInt64Array::from(lines)));
    columns
}
