//! Which triangle contains a point: a [walk](crate::mesh::Walk) from a near vertex of the cell's tile (Mücke, Saias and Zhu, "Fast
//! randomized point location without preprocessing", 1996), from tile to tile.

use super::location::{Location, TriangleRef};
use crate::geometry::{HalfEdge, Point, VertexIndex};
use crate::mesh::{Walk, WalkEnd};
use crate::query::request::{Contradiction, QueryError, Tiles, side_towards};
use crate::store::{Tile, TileId, VertexId};

/// So many times the power of two below the cube root of their number of the vertices of a tile are looked at for where to start: the walk
/// takes about as long as that then.
const SAMPLE: usize = 2;

/// Where a walk ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Walked {
    pub(crate) location: Location,
    /// Outside: the edge by which it left the hull, which lies on its left; none if there are no triangles.
    pub(crate) exit: Option<[VertexId; 2]>,
}

impl From<Location> for Walked {
    fn from(location: Location) -> Self {
        Self { location, exit: None }
    }
}

/// What the walk needs to go on.
pub(crate) enum Step {
    /// The tile of this vertex.
    Need(TileId),
    Done(Walked),
}

/// Where the walk starts.
enum Start {
    /// In the triangle of this side.
    From(HalfEdge),
    /// Nowhere: it is at its end.
    There(Location),
}

/// A walk that is interrupted where it enters another tile.
pub(crate) struct Locate {
    walk: Walk,
    /// Where to enter the next tile: through the side from the first vertex to the second, which the next tile owns.
    enter: Option<(VertexId, VertexId)>,
}

impl Locate {
    /// A walk to a point, in a triangulation of so many triangles.
    pub(crate) fn new(target: Point, triangles: u64) -> Self {
        Self {
            walk: Walk::new(target, triangles),
            enter: None,
        }
    }

    /// Goes on in a tile; an error says how the tile contradicts itself or others.
    pub(crate) fn step(&mut self, tile: &Tile) -> Result<Step, Contradiction> {
        let start = match self.enter.take() {
            None => match self.start(tile) {
                Start::From(side) => side,
                Start::There(location) => return Ok(Step::Done(location.into())),
            },
            Some((from, to)) => {
                if !tile.has_vertex(to.index) {
                    return Err(Contradiction::NoVertex(to.index));
                }
                match side_towards(tile, to.index, from)? {
                    Some(side) => side,
                    None => return Ok(outside([to, from])),
                }
            }
        };
        let location = match self.walk.run(tile, start)? {
            WalkEnd::Triangle(triangle) => Location::InTriangle(TriangleRef::of(tile, triangle)),
            WalkEnd::Edge(side) => Location::OnEdge {
                ends: tile.ends(side),
                triangle: TriangleRef::of(tile, side.triangle()),
            },
            WalkEnd::Vertex(side) => Location::OnVertex(tile.vertex(tile.origin(side))),
            WalkEnd::Hull(exit) => return Ok(outside(tile.ends(exit).map(|end| end.id))),
            WalkEnd::Elsewhere(exit) => {
                let [from, to] = tile.ends(exit).map(|end| end.id);
                // Across, the side runs from `to` to `from`.
                self.enter = Some((to, from));
                return Ok(Step::Need(from.tile));
            }
        };
        Ok(Step::Done(location.into()))
    }

    /// A side that leaves a vertex near the target, or where the target lies if nothing leaves it.
    fn start(&self, tile: &Tile) -> Start {
        let target = self.walk.target();
        let square = |p: Point| {
            let (dx, dy) = (p.x - target.x, p.y - target.y);
            dx * dx + dy * dy
        };
        // The nearest of a few; their vertices are in Morton order, so these are spread evenly.
        let sample = (0..tile.vertex_count())
            .step_by(apart(tile.vertex_count()))
            .map(VertexIndex);
        let nearest = sample.min_by(|&p, &q| square(tile.point(p)).total_cmp(&square(tile.point(q))));
        if let Some(side) = nearest.and_then(|vertex| tile.leaving(vertex)) {
            return Start::From(side);
        }
        // Without triangles there is nothing but vertices.
        let here = tile
            .points()
            .zip(tile.vertex_indices())
            .find(|(point, _)| *point == target);
        Start::There(here.map_or(Location::Outside, |(_, vertex)| Location::OnVertex(tile.vertex(vertex))))
    }
}

/// How far apart the vertices lie that are looked at, of so many.
fn apart(count: u32) -> usize {
    let root = 1 << (count.max(1).ilog2() / 3);
    (count as usize / (SAMPLE * root)).max(1)
}

fn outside(exit: [VertexId; 2]) -> Step {
    Step::Done(Walked {
        location: Location::Outside,
        exit: Some(exit),
    })
}

impl Tiles {
    /// Walks to a point.
    pub(crate) async fn walk(&mut self, target: Point) -> Result<Walked, QueryError> {
        let directory = self.directory();
        let Some(mut id) = directory.tree.tile_at(target) else {
            return Ok(Location::Outside.into());
        };
        let mut walk = Locate::new(target, directory.metadata.triangles);
        loop {
            let tile = self.get(id).await?;
            match self.checked(id, walk.step(&tile))? {
                Step::Need(other) => id = other,
                Step::Done(walked) => return Ok(walked),
            }
        }
    }
}
