//! The triangulation as a surface: heights, rasters, contours, profiles, volumes.

use std::sync::Arc;

use delaunay_tiles::export::{ContourOutput, Format, export_contours};
use delaunay_tiles::input::{SegmentBatch, SegmentSource};
use delaunay_tiles::query::BulkOptions;
use delaunay_tiles::terrain::{Clip, ContourOptions, Grid, Levels, Light, Measure, RasterOptions, Surface};
use delaunay_tiles::{Point, ReadError};
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use serde::Deserialize;

use crate::columns::{Column, Columns};
use crate::elements::{Bounds, points, rect};
use crate::error::{Failure, Outcome};
use crate::reader::Reader;
use crate::runtime::ask;

/// The triangles that count, and the polygons in which they do.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct SurfaceArguments {
    holes: bool,
    max_edge: Option<f64>,
    from_hull: bool,
    /// Polygons as well-known binary.
    clip: Option<Vec<Vec<u8>>>,
}

impl SurfaceArguments {
    fn surface(&self) -> Surface {
        let surface = Surface::default().holes(self.holes);
        surface.max_edge(self.max_edge).from_hull(self.from_hull)
    }

    /// Returns the polygons.
    pub fn clip(self) -> Outcome<Option<Arc<Clip>>> {
        let Some(polygons) = self.clip else { return Ok(None) };
        let mut source = SegmentSource::from_wkb("clip", polygons.into_iter(), true)?;
        let (mut batch, mut edges) = (SegmentBatch::default(), Vec::new());
        while source.next_batch(&mut batch)? {
            edges.extend_from_slice(&batch.ends);
            if edges.len() > Clip::MAX_EDGES {
                return Err(Failure::value(format!(
                    "the polygons of clip can have {} edges; simplify them",
                    Clip::MAX_EDGES
                )));
            }
        }
        Ok(Some(Arc::new(Clip::new(edges))))
    }
}

/// Returns what a raster shows.
fn measure(name: &str, azimuth: f64, altitude: f64) -> Outcome<Measure> {
    match name {
        "z" => Ok(Measure::Z),
        "slope" => Ok(Measure::Slope),
        "aspect" => Ok(Measure::Aspect),
        "hillshade" => Ok(Measure::Hillshade(Light { azimuth, altitude })),
        _ => Err(Failure::value(format!(
            "what must be 'z', 'slope', 'aspect' or 'hillshade', not '{name}'"
        ))),
    }
}

/// The keyword arguments of a raster.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct RasterArguments {
    resolution: f64,
    bounds: Option<Bounds>,
    align: Option<(f64, f64)>,
    what: String,
    z_factor: f64,
    azimuth: f64,
    altitude: f64,
}

#[pymethods]
impl Reader {
    /// Returns the height at each point, NaN where there is none.
    fn interpolate<'py>(
        &self,
        py: Python<'py>,
        xy: PyReadonlyArray2<'py, f64>,
        surface: SurfaceArguments,
        is_awaited: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (reader, points, surface) = (self.0.clone(), points(&xy), surface.surface());
        ask(py, is_awaited, async move {
            let heights = reader.surface_z_many(points, surface, BulkOptions::default()).await?;
            Ok(Columns(vec![Column::F64(heights)]))
        })
    }

    /// Returns the values of a grid row by row from the north, the number of columns, and the corners of
    /// the grid.
    fn raster<'py>(
        &self,
        py: Python<'py>,
        arguments: RasterArguments,
        surface: SurfaceArguments,
        is_awaited: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let reader = self.0.clone();
        let what = measure(&arguments.what, arguments.azimuth, arguments.altitude)?;
        let bounds = match arguments.bounds {
            Some(_) => rect(arguments.bounds),
            None => reader.metadata().bounds,
        };
        let grid = match (arguments.align, arguments.bounds) {
            (None, Some(_)) => Grid::starting_at(bounds, arguments.resolution),
            (align, _) => {
                let (x, y) = align.unwrap_or_default();
                Grid::covering(bounds, arguments.resolution, Point::new(x, y))
            }
        };
        let grid = grid.map_err(|error| Failure::value(error.to_string()))?;
        let of_surface = surface.surface();
        let options = RasterOptions::new(grid).measure(what).z_factor(arguments.z_factor);
        let options = options.surface(of_surface).clip(surface.clip()?);
        ask(py, is_awaited, async move {
            let (columns, rows) = (grid.columns(), grid.rows());
            let needed = grid.cells().saturating_mul(16);
            if needed > delaunay_tiles::default_memory().saturating_mul(4) {
                return Err(ReadError::Memory {
                    file: reader.name().into(),
                    needed,
                    allowed: delaunay_tiles::default_memory().saturating_mul(4),
                }
                .into());
            }
            let values = reader.raster(&options, 0..columns, 0..rows).await?;
            let corners = grid.bounds();
            let corners = vec![corners.min_x, corners.min_y, corners.max_x, corners.max_y];
            Ok(Columns(vec![
                Column::F64Rows(values, columns as usize),
                Column::F64(corners),
            ]))
        })
    }

    /// Returns the contours: the height of each, whether it is closed, where its points end, and all points.
    fn contours<'py>(
        &self,
        py: Python<'py>,
        step: f64,
        base: f64,
        surface: SurfaceArguments,
        is_awaited: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let reader = self.0.clone();
        let levels = Levels::new(step, base).map_err(|error| Failure::value(error.to_string()))?;
        let of_surface = surface.surface();
        let options = ContourOptions::new(levels).surface(of_surface).clip(surface.clip()?);
        ask(py, is_awaited, async move {
            let how = ContourOutput::new(Format::GeoJson);
            let written = export_contours(&reader, options, &how, Vec::new(), |_, _| {}).await?;
            let lines: Lines = serde_json::from_slice(&written.output)
                .map_err(|error| Failure::other(format!("internal error: contours cannot be read: {error}")))?;
            Ok(lines.columns())
        })
    }

    /// Returns the length of a line, and the parts of it on the surface: where each ends, and the distance,
    /// the position and the height of all points.
    fn profile<'py>(
        &self,
        py: Python<'py>,
        line: PyReadonlyArray2<'py, f64>,
        surface: SurfaceArguments,
        is_awaited: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (reader, line, surface) = (self.0.clone(), points(&line), surface.surface());
        ask(py, is_awaited, async move {
            let profile = reader.profile(&line, surface).await?;
            let mut offsets = vec![0];
            let all = profile.parts.iter().flat_map(|part| part.points.iter().copied());
            let all: Vec<_> = all.collect();
            for part in &profile.parts {
                offsets.push(offsets[offsets.len() - 1] + part.points.len() as i64);
            }
            let positions: Vec<Point> = all.iter().map(|point| point.point).collect();
            Ok(Columns(vec![
                Column::F64(vec![profile.length]),
                Column::I64(offsets),
                Column::F64(all.iter().map(|point| point.distance).collect()),
                Column::points(&positions),
                Column::F64(all.iter().map(|point| point.z).collect()),
            ]))
        })
    }

    /// Returns the volumes above and below a level, and the areas: all, above, below.
    fn volume<'py>(
        &self,
        py: Python<'py>,
        level: f64,
        surface: SurfaceArguments,
        is_awaited: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let reader = self.0.clone();
        let of_surface = surface.surface();
        let clip = surface.clip()?;
        ask(py, is_awaited, async move {
            let found = reader.volume(level, of_surface, clip).await?;
            Ok((found.cut, found.fill, found.area, found.area_above, found.area_below))
        })
    }
}

/// The contours as the library writes them.
#[derive(Deserialize)]
struct Lines {
    features: Vec<Line>,
}

#[derive(Deserialize)]
struct Line {
    properties: Properties,
    geometry: Geometry,
}

#[derive(Deserialize)]
struct Properties {
    z: f64,
    closed: bool,
}

#[derive(Deserialize)]
struct Geometry {
    coordinates: Vec<[f64; 3]>,
}

impl Lines {
    fn columns(self) -> Columns {
        let mut offsets = vec![0];
        let mut points = Vec::new();
        for line in &self.features {
            points.extend(line.geometry.coordinates.iter().flat_map(|&[x, y, _]| [x, y]));
            offsets.push(points.len() as i64 / 2);
        }
        Columns(vec![
            Column::F64(self.features.iter().map(|line| line.properties.z).collect()),
            Column::Bool(self.features.iter().map(|line| line.properties.closed).collect()),
            Column::I64(offsets),
            Column::F64Rows(points, 2),
        ])
    }
}
