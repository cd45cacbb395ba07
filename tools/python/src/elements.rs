//! Tiles as arrays, and where points lie.

use std::sync::Arc;

use delaunay_tiles::geometry::{HalfEdge, VertexIndex};
use delaunay_tiles::query::{BulkOptions, Place, triangle_meets};
use delaunay_tiles::store::{Tile as StoredTile, TileId};
use delaunay_tiles::{Point, Rect};
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

use crate::columns::{Column, Columns};
use crate::reader::Reader;
use crate::runtime::ask;
use crate::views::View;

/// A box, as Python has it: min_x, min_y, max_x, max_y.
pub type Bounds = (f64, f64, f64, f64);

/// Returns the rectangle of a box, or the whole plane.
pub fn rect(bounds: Option<Bounds>) -> Rect {
    bounds.map_or(Rect::PLANE, |(min_x, min_y, max_x, max_y)| {
        Rect::new(min_x, min_y, max_x, max_y)
    })
}

/// Returns the rows of an array as points.
pub fn points(rows: &PyReadonlyArray2<'_, f64>) -> Vec<Point> {
    let rows = rows.as_array();
    rows.outer_iter().map(|row| Point::new(row[0], row[1])).collect()
}

/// A tile in memory.
#[pyclass(frozen, module = "delaunay_tiles._core")]
pub struct Tile(Arc<StoredTile>);

#[pymethods]
impl Reader {
    /// Returns the numbers of the tiles whose boxes meet a box.
    fn tile_ids<'py>(&self, py: Python<'py>, bounds: Option<Bounds>, is_awaited: bool) -> PyResult<Bound<'py, PyAny>> {
        let reader = self.0.clone();
        ask(py, is_awaited, async move {
            let (directory, rect) = (reader.directory().await?, rect(bounds));
            let met = directory
                .tile_ids()
                .filter(|id| directory.tiles[id.0 as usize].bounds.intersects(rect));
            Ok(met.map(|id| id.0).collect::<Vec<u32>>())
        })
    }

    /// Returns a tile.
    fn tile<'py>(&self, py: Python<'py>, number: u32, is_awaited: bool) -> PyResult<Bound<'py, PyAny>> {
        let reader = self.0.clone();
        ask(
            py,
            is_awaited,
            async move { Ok(Tile(reader.tile(TileId(number)).await?)) },
        )
    }

    /// Returns, for each point: the kind of its place (0 outside, 1 in a triangle, 2 on an edge, 3 on a
    /// vertex), the tile, the triangle in the tile, and the edge's first corner or the vertex in the tile.
    fn locate<'py>(
        &self,
        py: Python<'py>,
        xy: PyReadonlyArray2<'py, f64>,
        is_awaited: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (reader, points) = (self.0.clone(), points(&xy));
        ask(py, is_awaited, async move {
            let places = reader.locate_many(points, BulkOptions::default()).await?;
            Ok(columns_of(&places))
        })
    }
}

/// Returns places as columns.
fn columns_of(places: &[Place]) -> Columns {
    let kind = |place: &Place| match place {
        Place::Outside => 0,
        Place::InTriangle { .. } => 1,
        Place::OnEdge { .. } => 2,
        Place::OnVertex { .. } => 3,
    };
    let corner = |place: &Place| match *place {
        Place::Outside | Place::InTriangle { .. } => -1,
        Place::OnEdge { corner, .. } => i64::from(corner),
        Place::OnVertex { vertex, .. } => i64::from(vertex.index.0),
    };
    Columns(vec![
        Column::U8(places.iter().map(kind).collect()),
        Column::I64(
            places
                .iter()
                .map(|place| place.tile().map_or(-1, |tile| tile.0.into()))
                .collect(),
        ),
        Column::I64(
            places
                .iter()
                .map(|place| place.triangle().map_or(-1, |id| id.0.into()))
                .collect(),
        ),
        Column::I64(places.iter().map(corner).collect()),
    ])
}

#[pymethods]
impl Tile {
    #[getter]
    fn id(&self) -> u32 {
        self.0.id().0
    }

    /// Returns x and y of the vertices, in the memory of the tile.
    fn coordinates(&self) -> View {
        View(self.0.coordinate_bytes())
    }

    /// Returns z of the vertices, in the memory of the tile.
    fn z(&self) -> Option<View> {
        self.0.z_bytes().map(View)
    }

    /// Returns the record of each vertex.
    fn records(&self) -> Columns {
        let records = self.0.vertex_indices().map(|vertex| self.0.record(vertex) as i64);
        Columns(vec![Column::I64(records.collect())])
    }

    /// Returns the triangles that the tile owns: their numbers in the tile, their corners, their regions,
    /// whether they are holes, whether the edge from each corner is a constraint; and the points of the
    /// corners that other tiles own, with their tiles, their numbers there, and their z.
    fn triangles(&self, py: Python<'_>) -> Columns {
        py.detach(|| triangles(&self.0))
    }

    /// Returns whether each triangle that the tile owns intersects a box.
    fn meets(&self, bounds: Bounds) -> Columns {
        let rect = rect(Some(bounds));
        let triangles = self
            .0
            .owned_triangles()
            .map(|triangle| self.0.triangle_points(triangle));
        Columns(vec![Column::Bool(
            triangles.map(|triangle| triangle_meets(triangle, rect)).collect(),
        )])
    }

    /// Returns the sites: their vertices, their numbers, and their ids.
    fn sites(&self) -> Columns {
        let sites: Vec<_> = self.0.sites().collect();
        Columns(vec![
            Column::I64(sites.iter().map(|site| site.vertex.0.into()).collect()),
            Column::I64(sites.iter().map(|site| site.number as i64).collect()),
            Column::Texts(sites.iter().map(|site| site.id.map(str::to_owned)).collect()),
        ])
    }
}

fn triangles(tile: &StoredTile) -> Columns {
    let owned: Vec<_> = tile.owned_triangles().collect();
    let corners: Vec<VertexIndex> = owned.iter().flat_map(|&triangle| tile.corners(triangle)).collect();
    let vertices = tile.vertex_count();
    let last = corners
        .iter()
        .map(|corner| corner.0 + 1)
        .max()
        .unwrap_or(0)
        .max(vertices);
    let others: Vec<_> = (vertices..last)
        .map(|corner| tile.vertex(VertexIndex(corner)))
        .collect();
    let other_points: Vec<Point> = others.iter().map(|vertex| vertex.point).collect();
    let other_z = (vertices..last).map(|corner| tile.z(VertexIndex(corner)).unwrap_or(f64::NAN));
    let is_fixed = owned.iter().flat_map(|&triangle| HalfEdge::of_triangle(triangle));
    Columns(vec![
        Column::I64(owned.iter().map(|triangle| triangle.0.into()).collect()),
        Column::I64Rows(corners.iter().map(|corner| corner.0.into()).collect(), 3),
        Column::I64(owned.iter().map(|&triangle| tile.region(triangle) as i64).collect()),
        Column::Bool(owned.iter().map(|&triangle| tile.is_hole(triangle)).collect()),
        Column::BoolRows(is_fixed.map(|edge| tile.is_constraint(edge)).collect(), 3),
        Column::points(&other_points),
        Column::I64(others.iter().map(|vertex| vertex.id.tile.0.into()).collect()),
        Column::I64(others.iter().map(|vertex| vertex.id.index.0.into()).collect()),
        Column::F64(other_z.collect()),
    ])
}
