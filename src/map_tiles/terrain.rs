//! Terrain for Cesium: meshes in the format quantized-mesh.

use std::sync::Arc;

use futures::future::FutureExt;

use crate::geometry::{Point, Rect};
use crate::map_tiles::budget::Budget;
use crate::map_tiles::coord::{GridKind, TerrainCoord};
use crate::map_tiles::drawn::{DrawError, DrawLimits, Drawn, NoGrid};
use crate::map_tiles::grid::around;
use crate::map_tiles::projection::Projection;
use crate::map_tiles::quantized::{MeshVertex, STEPS, encode, places};
use crate::map_tiles::source::{FILE, MapSource};
use crate::store::{Tile, spawn};

/// The typical length of edges up to which a level is fine enough, as a share of the side of a
/// tile.
const EDGE: f64 = 1.0 / 32.0;
/// The number of typical edges along the side of a tile at the deepest zoom.
const FINEST: f64 = 16.0;
/// The deepest zoom that viewers should ask for.
const DEEPEST: u8 = 23;
/// A file is not seen in a tile if it is smaller than this share of its side.
const TINY: f64 = 1.0 / 64.0;
const WORLD: Rect = Rect::new(-180.0, -90.0, 180.0, 90.0);

/// How a file is on Earth.
#[derive(Clone)]
struct Earth {
    projection: Arc<Projection>,
    /// A rectangle around all vertices, in degrees.
    bounds: Rect,
    /// The length of a degree in units of the file, at its centre.
    degree: f64,
}

/// What describes the terrain of a file, as for `layer.json`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TerrainFacts {
    /// A rectangle around all vertices, in degrees of longitude and latitude.
    pub bounds: Rect,
    /// The deepest zoom that viewers should ask for.
    pub max_zoom: u8,
    /// The tiles of each zoom, from 0 up to `max_zoom`.
    pub available: Vec<TerrainRange>,
}

/// The tiles of a zoom, in columns from the west and rows from the south, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct TerrainRange {
    /// The first column.
    pub start_x: u32,
    /// The first row.
    pub start_y: u32,
    /// The last column.
    pub end_x: u32,
    /// The last row.
    pub end_y: u32,
}

impl TerrainFacts {
    /// The reference system of tiles, as `layer.json` names it.
    pub const PROJECTION: &'static str = "EPSG:4326";
    /// The format of tiles, as `layer.json` names it.
    pub const FORMAT: &'static str = "quantized-mesh-1.0";
    /// The media type of tiles.
    pub const MEDIA_TYPE: &'static str = "application/vnd.quantized-mesh";
    /// The ending of names of tiles, without the dot.
    pub const ENDING: &'static str = "terrain";
}

impl MapSource {
    /// Returns what describes the terrain.
    ///
    /// # Errors
    /// If the file has no z, or is not known to be on Earth.
    pub fn terrain_facts(&self) -> Result<TerrainFacts, NoGrid> {
        let earth = self.earth()?;
        let degree = earth.degree;
        let edge = self.spacing_of(FILE);
        let fine = |z: &u8| 180.0 / f64::from(1u32 << z) * degree <= FINEST * edge;
        let max_zoom = (0..DEEPEST).find(fine).unwrap_or(DEEPEST);
        let range = |z: u8| {
            let side = 180.0 / f64::from(1u32 << z);
            let number = |degrees: f64, most: u32| ((degrees / side) as u32).min(most);
            let (columns, rows) = ((2 << z) - 1, (1 << z) - 1);
            let bounds = if z == 0 { WORLD } else { earth.bounds };
            TerrainRange {
                start_x: number(bounds.min_x + 180.0, columns),
                start_y: number(bounds.min_y + 90.0, rows),
                end_x: number(bounds.max_x + 180.0, columns),
                end_y: number(bounds.max_y + 90.0, rows),
            }
        };
        Ok(TerrainFacts {
            bounds: earth.bounds,
            max_zoom,
            available: (0..=max_zoom).map(range).collect(),
        })
    }

    /// Draws a terrain tile in the format quantized-mesh-1.0, without compression. Must be awaited
    /// within a tokio runtime.
    ///
    /// A tile has vertices of its level, which are triangulated by longitude and latitude, and
    /// samples of the surface at fixed places of its sides. Heights are steps of 1/32767 of one
    /// range for the whole file. So tiles of a zoom have the same vertices where they meet. Where
    /// there is no surface, the terrain has the lowest height of that range. Holes count as ground.
    /// Heights are the file's z, in metres, without any change of the vertical datum.
    ///
    /// Both tiles of zoom 0 exist, as Cesium expects; the others are empty where the file has
    /// nothing.
    ///
    /// # Errors
    /// As [`draw`](Self::draw).
    pub fn terrain(
        &self,
        at: TerrainCoord,
        limits: DrawLimits,
    ) -> impl Future<Output = Result<Drawn, DrawError>> + Send {
        async move {
            let earth = self.earth()?;
            if at.z() > 0 && !at.bounds().intersects(earth.bounds) {
                return Ok(Drawn::NOTHING);
            }
            limits.check()?;
            let mut budget = Budget::new(limits);
            let level = self.level_for(at.side() * earth.degree * EDGE);
            let tiles = match budget.try_claim(self.level(level), earth.rect_of(at)).await? {
                Ok(tiles) => tiles,
                // Nothing of the file would be seen.
                Err(_) if earth.is_tiny(at) => Vec::new(),
                Err(needed) => {
                    return Err(DrawError::OutOfBudget {
                        needed,
                        allowed: limits.max_tiles,
                    });
                }
            };
            let is_blank = tiles.is_empty();
            let mut vertices = Vec::new();
            let of = {
                let earth = earth.clone();
                move |tile: &Tile| earth.vertices_in(tile, at)
            };
            self.of_tiles(level, tiles, limits, of, |mut part| vertices.append(&mut part))
                .await?;
            let (vertices, places) = spawn(move || places(vertices)).await?;
            let heights = match is_blank {
                true => vec![f64::NAN; places.len()],
                false => {
                    let points = spawn({
                        let places = places.clone();
                        move || earth.points(at, &places)
                    });
                    self.heights_at(level, points.await?).await?
                }
            };
            limits.check()?;
            let unit = self.units().z;
            let range = self.heights().map_or([0.0; 2], |range| range.all.map(|z| z * unit));
            let sampled = places
                .into_iter()
                .zip(heights)
                .map(|(place, z)| MeshVertex { place, z });
            let mut all: Vec<MeshVertex> = vertices.into_iter().chain(sampled).collect();
            all.iter_mut().for_each(|vertex| vertex.z *= unit);
            let bytes = spawn(move || encode(at, all, range)).await?;
            Ok(Drawn {
                bytes,
                tiles: budget.used(),
            })
        }
        .boxed()
    }

    /// Returns how the file is on Earth.
    fn earth(&self) -> Result<Earth, NoGrid> {
        let grid = self.grid(GridKind::WebMercatorQuad)?;
        let known = self.heights().and(grid.projection()).zip(grid.lon_lat_bounds());
        let (projection, bounds) = known.ok_or(NoGrid::NoHeights)?;
        Ok(Earth {
            projection: Arc::clone(projection),
            bounds,
            degree: grid.degree(),
        })
    }
}

impl Earth {
    /// Returns a rectangle of the file that contains all of its points in a tile.
    fn rect_of(&self, at: TerrainCoord) -> Rect {
        let (tile, bounds) = (at.bounds(), self.bounds);
        let cut = Rect::new(
            tile.min_x.max(bounds.min_x),
            tile.min_y.max(bounds.min_y),
            tile.max_x.min(bounds.max_x),
            tile.max_y.min(bounds.max_y),
        );
        match cut.is_empty() {
            true => Rect::EMPTY,
            false => around(cut, |p| self.projection.of_lon_lat([p.x, p.y]).map(|p| [p.x, p.y])),
        }
    }

    /// Returns whether the file is too small to be seen in a tile.
    fn is_tiny(&self, at: TerrainCoord) -> bool {
        let (width, height) = self.bounds.size();
        width.max(height) < TINY * at.side()
    }

    /// Returns the vertices of a tile of the file inside a terrain tile.
    fn vertices_in(&self, tile: &Tile, at: TerrainCoord) -> Vec<MeshVertex> {
        let place = |degrees: f64, number: u32| {
            let share = degrees / at.side() - f64::from(number);
            let step = (share * f64::from(STEPS)).round();
            (step > 0.0 && step < f64::from(STEPS)).then_some(step as u16)
        };
        let rect = self.rect_of(at);
        let near = tile
            .vertex_indices()
            .filter(|&vertex| rect.contains(tile.point(vertex)));
        let vertices = near.filter_map(|vertex| {
            let [lon, lat] = self.projection.to_lon_lat(tile.point(vertex))?;
            Some(MeshVertex {
                place: [place(lon + 180.0, at.x())?, place(lat + 90.0, at.y())?],
                z: tile.z(vertex)?,
            })
        });
        vertices.collect()
    }

    /// Returns the points of the file at places of a tile.
    fn points(&self, at: TerrainCoord, places: &[[u16; 2]]) -> Arc<[Point]> {
        // A place on a side has the same number in both tiles.
        let degrees = |step: u16, number: u32, start: f64| {
            let steps = f64::from(number) * f64::from(STEPS) + f64::from(step);
            steps * at.side() / f64::from(STEPS) - start
        };
        let point = |&[u, v]: &[u16; 2]| {
            let lon_lat = [degrees(u, at.x(), 180.0), degrees(v, at.y(), 90.0)];
            self.projection
                .of_lon_lat(lon_lat)
                .unwrap_or(Point::new(f64::NAN, f64::NAN))
        };
        places.iter().map(point).collect()
    }
}
