//! The walk to the triangle that contains a point: a [walk](crate::mesh::Walk) from tile to tile,
//! which starts at a near vertex of the cell's tile (Mücke, Saias and Zhu, "Fast randomized point
//! location without preprocessing", 1996).

use super::location::{Location, TriangleRef};
use crate::geometry::{HalfEdge, Point, TriangleId, VertexIndex};
use crate::mesh::{Walk, WalkEnd};
use crate::query::request::{Contradiction, QueryError, Tiles, half_edge_towards};
use crate::store::{Tile, TileId, VertexId};

/// The walk starts at the nearest of a sample of the tile's `n` vertices. The sample has about
/// `SAMPLE` times the largest power of two below the cube root of `n` vertices, so that sampling
/// takes about as long as the walk.
const SAMPLE: usize = 2;

/// The end of a walk.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Walked {
    pub(crate) location: Location,
    /// The hull edge by which the walk left, with the hull on its left. `None` if the point is not
    /// outside or there are no triangles.
    pub(crate) exit: Option<[VertexId; 2]>,
}

impl From<Location> for Walked {
    fn from(location: Location) -> Self {
        Self { location, exit: None }
    }
}

/// Where a walk ends in a tile.
#[derive(Clone, Copy, Debug)]
pub(super) enum Spot {
    /// Inside a triangle.
    Triangle(TriangleId),
    /// Inside the edge of a half-edge.
    Edge(HalfEdge),
    /// On a vertex: a corner of the tile.
    Vertex(VertexIndex),
    /// Outside the hull, behind the hull edge between these vertices, which has the hull on its left.
    /// `None` if there are no triangles.
    Outside(Option<[VertexId; 2]>),
}

/// The outcome of a step of the walk, in the numbers of a tile.
pub(super) enum SpotStep {
    /// The walk continues in this tile.
    Need(TileId),
    There(Spot),
}

/// The outcome of a step of the walk.
pub(crate) enum WalkStep {
    /// The walk continues in this tile.
    Need(TileId),
    Done(Walked),
}

/// The start of the walk in a tile.
enum WalkStart {
    /// The walk starts in the triangle of this half-edge.
    From(HalfEdge),
    /// The walk ends at once.
    There(Spot),
}

/// A walk that pauses where it enters another tile.
#[derive(Clone, Debug)]
pub(crate) struct Locate {
    walk: Walk,
    /// The half-edge by which the walk enters the next tile, from the first vertex to the second,
    /// which the next tile owns.
    enter: Option<(VertexId, VertexId)>,
}

impl Locate {
    /// Creates a walk to `target` in a triangulation of `triangles` triangles.
    pub(crate) fn new(target: Point, triangles: u64) -> Self {
        Self {
            walk: Walk::new(target, triangles),
            enter: None,
        }
    }

    /// Continues in a tile. Fails if the tile contradicts itself or others.
    pub(crate) fn step(&mut self, tile: &Tile) -> Result<WalkStep, Contradiction> {
        let spot = match self.step_to_spot(tile)? {
            SpotStep::Need(tile) => return Ok(WalkStep::Need(tile)),
            SpotStep::There(spot) => spot,
        };
        let location = match spot {
            Spot::Triangle(triangle) => Location::InTriangle(TriangleRef::of(tile, triangle)),
            Spot::Edge(half_edge) => Location::OnEdge {
                ends: tile.ends(half_edge),
                triangle: TriangleRef::of(tile, half_edge.triangle()),
            },
            Spot::Vertex(corner) => Location::OnVertex(tile.vertex(corner)),
            Spot::Outside(_) => Location::Outside,
        };
        let exit = match spot {
            Spot::Outside(exit) => exit,
            _ => None,
        };
        Ok(WalkStep::Done(Walked { location, exit }))
    }

    /// Continues in a tile, like [`step`](Self::step).
    pub(super) fn step_to_spot(&mut self, tile: &Tile) -> Result<SpotStep, Contradiction> {
        let start = match self.enter.take() {
            None => match self.start(tile) {
                WalkStart::From(half_edge) => half_edge,
                WalkStart::There(spot) => return Ok(SpotStep::There(spot)),
            },
            Some((from, to)) => {
                if !tile.has_vertex(to.index) {
                    return Err(Contradiction::NoVertex(to.index));
                }
                match half_edge_towards(tile, to.index, from)? {
                    Some(half_edge) => half_edge,
                    None => return Ok(SpotStep::There(Spot::Outside(Some([to, from])))),
                }
            }
        };
        Ok(SpotStep::There(match self.walk.run(tile, start)? {
            WalkEnd::Triangle(triangle) => Spot::Triangle(triangle),
            WalkEnd::Edge(half_edge) => Spot::Edge(half_edge),
            WalkEnd::Vertex(half_edge) => Spot::Vertex(tile.origin(half_edge)),
            WalkEnd::Hull(exit) => Spot::Outside(Some(tile.ends(exit).map(|end| end.id))),
            WalkEnd::Elsewhere(exit) => {
                let [from, to] = tile.ends(exit).map(|end| end.id);
                // The twin runs from `to` to `from`.
                self.enter = Some((to, from));
                return Ok(SpotStep::Need(from.tile));
            }
        }))
    }

    /// Returns a half-edge whose origin is a vertex near the target, or the location of the target
    /// if no half-edge leaves that vertex.
    fn start(&self, tile: &Tile) -> WalkStart {
        let target = self.walk.target();
        let square = |p: Point| {
            let (dx, dy) = (p.x - target.x, p.y - target.y);
            dx * dx + dy * dy
        };
        // The vertices are in Morton order, so the sample is spread evenly. `step_by` comes first:
        // it steps over plain numbers in constant time, and over mapped ones one by one.
        let sample = (0..tile.vertex_count())
            .step_by(apart(tile.vertex_count()))
            .map(VertexIndex);
        let nearest = sample.min_by(|&p, &q| square(tile.point(p)).total_cmp(&square(tile.point(q))));
        if let Some(half_edge) = nearest.and_then(|vertex| tile.leaving(vertex)) {
            return WalkStart::From(half_edge);
        }
        // A tile without triangles has only vertices.
        let here = tile
            .points()
            .zip(tile.vertex_indices())
            .find(|(point, _)| *point == target);
        WalkStart::There(here.map_or(Spot::Outside(None), |(_, vertex)| Spot::Vertex(vertex)))
    }
}

/// Returns the step between sampled vertices in a tile of `count` vertices.
fn apart(count: u32) -> usize {
    let root = 1 << (count.max(1).ilog2() / 3);
    (count as usize / (SAMPLE * root)).max(1)
}

impl Tiles {
    /// Walks to a point.
    pub(crate) async fn walk(&mut self, target: Point) -> Result<Walked, QueryError> {
        let Some(mut id) = self.tile_at(target).await? else {
            return Ok(Location::Outside.into());
        };
        let mut walk = Locate::new(target, self.metadata().triangles);
        loop {
            let tile = self.get(id).await?;
            match self.checked(id, walk.step(&tile))? {
                WalkStep::Need(other) => id = other,
                WalkStep::Done(walked) => return Ok(walked),
            }
        }
    }
}
