//! The surface at many points, as [overviews](crate::overviews) ask for it.

use std::convert::Infallible;
use std::sync::Arc;

use foldhash::{HashMap, HashMapExt};

use super::batch::{At, BulkOptions, Outcome, Question, ask};
use super::sorted_walk::{half_edge_at, walk_from};
use super::walk::{Locate, Spot, SpotStep};
use crate::geometry::{HalfEdge, Point, Rect};
use crate::query::request::Contradiction;
use crate::store::{PassReader, ReadError, Tile, TileId, TileReader, spawn};
use crate::terrain::{Facet, Place, facet};

/// The surface at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum OnSurface {
    /// The point is a vertex with this z, which is NaN in files without z.
    Vertex(f64),
    /// The point lies elsewhere on the surface.
    Between {
        /// NaN in files without z.
        z: f64,
        /// About twice the area of the triangle, the same whatever the tiles.
        area: f64,
    },
    /// The point is outside.
    Outside,
}

/// The part of a surface around a tile of a finer one: the tiles of it that are there.
pub(crate) struct SurfacePart {
    reader: PassReader,
    tiles: HashMap<TileId, Arc<Tile>>,
}

/// The triangle in which a walk ended.
struct Near<'a> {
    tile: &'a Tile,
    half_edge: HalfEdge,
    /// The triangle, if the point was inside it.
    facet: Option<Facet>,
}

impl TileReader {
    /// Returns the surface at points, in their order. Nothing is left out of it. The file has triangles.
    ///
    /// # Errors
    /// If a tile cannot be read or is damaged.
    async fn on_surface(&self, points: Vec<Point>) -> Result<Vec<OnSurface>, ReadError> {
        let options = BulkOptions::default().threads(1);
        ask(self, points.into(), options, Where, OnSurface::Outside).await
    }
}

impl SurfacePart {
    /// Reads the part of a surface within bounds.
    ///
    /// # Errors
    /// If a tile cannot be read or is damaged.
    pub(crate) async fn within(reader: &PassReader, bounds: Rect) -> Result<Self, ReadError> {
        let mut tiles = HashMap::new();
        for id in reader.tiles_where(|tile| tile.intersects(bounds)).await? {
            tiles.insert(id, reader.tile(id).await?);
        }
        Ok(Self {
            reader: reader.clone(),
            tiles,
        })
    }

    /// Returns the surface at points, in their order, each of which should be near the one before it.
    /// What other tiles are needed for is found last. Must be awaited within a tokio runtime.
    ///
    /// # Errors
    /// If a tile cannot be read or is damaged.
    pub(crate) async fn at(self, points: Arc<[Point]>) -> Result<Vec<OnSurface>, ReadError> {
        let reader = self.reader.clone();
        let all = Arc::clone(&points);
        let (mut found, open) = spawn(move || self.find(&all)).await??;
        if !open.is_empty() {
            let rest = open.iter().map(|&place| points[place]).collect();
            for (place, at) in open.into_iter().zip(reader.on_surface(rest).await?) {
                found[place] = at;
            }
        }
        Ok(found)
    }

    /// Returns the surface at points, and which of them need other tiles.
    fn find(&self, points: &[Point]) -> Result<(Vec<OnSurface>, Vec<usize>), ReadError> {
        let (mut found, mut open) = (Vec::with_capacity(points.len()), Vec::new());
        let mut near = None;
        for (place, &point) in points.iter().enumerate() {
            found.push(match self.find_one(point, &mut near)? {
                Some(at) => at,
                None => {
                    open.push(place);
                    OnSurface::Outside
                }
            });
        }
        Ok((found, open))
    }

    /// Returns the surface at a point, close to where the walk before ended. Returns `None` if that
    /// needs a tile that is not there.
    fn find_one<'a>(&'a self, point: Point, near: &mut Option<Near<'a>>) -> Result<Option<OnSurface>, ReadError> {
        // Most points lie in the triangle of the point before.
        if let Some(Near { facet: Some(facet), .. }) = near
            && facet.place(point) == Some(Place::Inside)
        {
            return Ok(Some(OnSurface::inside(facet, point)));
        }
        let Some((tile, spot)) = self.walk(point, near)? else {
            return Ok(None);
        };
        let Spot::Triangle(triangle) = spot else {
            return Ok(Some(OnSurface::at(tile, point, spot)));
        };
        let facet = facet(tile, triangle);
        if let Some(near) = near {
            near.facet = facet;
        }
        Ok(Some(
            facet.map_or(OnSurface::BETWEEN, |facet| OnSurface::inside(&facet, point)),
        ))
    }

    /// Walks to a point, from where the walk before ended. Returns `None` if it needs a tile that is not
    /// there.
    fn walk<'a>(&'a self, point: Point, near: &mut Option<Near<'a>>) -> Result<Option<(&'a Tile, Spot)>, ReadError> {
        let triangles = self.reader.metadata().triangles;
        if let Some(near) = near {
            let (tile, mut half_edge) = (near.tile, near.half_edge);
            let spot = walk_from(tile, triangles, point, &mut half_edge);
            if let Some(spot) = spot.map_err(|error| self.reader.damaged(tile.id(), error.to_string()))? {
                *near = Near::new(tile, half_edge);
                return Ok(Some((tile, spot)));
            }
        }
        let mut walk = Locate::new(point, triangles);
        let mut id = self.reader.directory().tree.tile_at(point);
        while let Some(tile) = id.and_then(|id| self.tiles.get(&id)) {
            let step = walk.step_to_spot(tile);
            match step.map_err(|error| self.reader.damaged(tile.id(), error.to_string()))? {
                SpotStep::Need(other) => id = Some(other),
                SpotStep::There(spot) => {
                    if let Some(half_edge) = half_edge_at(tile, spot) {
                        *near = Some(Near::new(tile, half_edge));
                    }
                    return Ok(Some((tile, spot)));
                }
            }
        }
        Ok(None)
    }
}

impl<'a> Near<'a> {
    fn new(tile: &'a Tile, half_edge: HalfEdge) -> Self {
        Self {
            tile,
            half_edge,
            facet: None,
        }
    }
}

impl OnSurface {
    /// Where there is no z.
    const BETWEEN: Self = Self::Between {
        z: f64::NAN,
        area: f64::NAN,
    };

    /// Returns the surface at a point inside a triangle.
    fn inside(facet: &Facet, point: Point) -> Self {
        Self::Between {
            z: facet.z_inside(point),
            area: facet.doubled_area(),
        }
    }

    /// Returns the surface at a point whose walk ended at a spot of a tile.
    fn at(tile: &Tile, point: Point, spot: Spot) -> Self {
        match spot {
            Spot::Outside(_) => Self::Outside,
            Spot::Vertex(corner) => Self::Vertex(tile.z(corner).unwrap_or(f64::NAN)),
            Spot::Triangle(triangle) => {
                facet(tile, triangle).map_or(Self::BETWEEN, |facet| Self::inside(&facet, point))
            }
            Spot::Edge(half_edge) => {
                // Which of the two triangles the walk comes to depends on where it starts.
                let [a, b] = tile.ends(half_edge).map(|end| end.point);
                let (dx, dy) = (b.x - a.x, b.y - a.y);
                let facet = facet(tile, half_edge.triangle());
                let z = facet.and_then(|facet| Some(facet.z_at(point, facet.place(point)?)));
                Self::Between {
                    z: z.unwrap_or(f64::NAN),
                    area: dx * dx + dy * dy,
                }
            }
        }
    }
}

/// The question what the surface is.
struct Where;

impl Question for Where {
    type Answer = OnSurface;
    type Errand = Infallible;
    type InTile = ();

    fn in_tile(&self, _: &Tile) {}

    fn answer(&self, at: &At<'_, ()>, spot: Spot, _: TileId) -> Result<Outcome<Self>, Contradiction> {
        Ok(Outcome::Answer(OnSurface::at(at.tile, at.point, spot)))
    }

    fn finish(&self, _: &At<'_, ()>, errand: Infallible) -> Result<OnSurface, Contradiction> {
        match errand {}
    }
}
