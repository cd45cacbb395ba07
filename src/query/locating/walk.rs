//! Which triangle contains a point: a walk from a near vertex of the cell's tile (Mücke, Saias and Zhu, "Fast randomized point location
//! without preprocessing", 1996).
//!
//! The walk crosses any side that has the point strictly on its other side (Devillers, Pion and Teillaud, "Walking in a
//! triangulation", 2002), in random order: on a Delaunay triangulation it cannot go in circles, and on others it does not for ever.

use super::location::{Location, TriangleRef};
use crate::geometry::{HalfEdge, Orientation, Point, orient2d};
use crate::query::request::{Contradiction, QueryError, Tiles, side_towards};
use crate::store::{Across, Tile, TileId, VertexId};

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
    target: Point,
    /// Where to enter the next tile: through the side from the first vertex to the second, which the next tile owns.
    enter: Option<(VertexId, VertexId)>,
    /// Triangles that may still be entered, before the walk must be going in circles.
    steps: u64,
}

impl Locate {
    /// A walk to a point, in a triangulation of so many triangles.
    pub(crate) fn new(target: Point, triangles: u64) -> Self {
        Self {
            target,
            enter: None,
            steps: 4 * triangles.saturating_add(4),
        }
    }

    /// Goes on in a tile; an error says how the tile contradicts itself or others.
    pub(crate) fn step(&mut self, tile: &Tile) -> Result<Step, Contradiction> {
        let mut side = match self.enter.take() {
            None => match self.start(tile) {
                Start::From(side) => side,
                Start::There(location) => return Ok(Step::Done(location.into())),
            },
            Some((from, to)) => {
                if to.index >= tile.vertex_count() {
                    return Err(Contradiction::NoVertex(to.index));
                }
                match side_towards(tile, to.index, from)? {
                    Some(side) => side,
                    None => return Ok(outside([to, from])),
                }
            }
        };
        loop {
            self.steps = self.steps.checked_sub(1).ok_or(Contradiction::EndlessWalk)?;
            // Off Delaunay's triangulation, where constraints are, the walk might go in circles if it always turned the same way.
            let turns_left = self.steps.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 63 == 1;
            let [one, other] = if turns_left {
                [side.prev(), side.next()]
            } else {
                [side.next(), side.prev()]
            };
            let sides = [one, other, side];
            let turn = |s: HalfEdge| {
                let [from, to] = [s, s.next()].map(|s| tile.corner(tile.origin(s.0)));
                orient2d(from, to, self.target)
            };
            let Some(exit) = sides.into_iter().find(|&s| turn(s) == Orientation::Clockwise) else {
                return Ok(Step::Done(inside(tile, sides, sides.map(turn)).into()));
            };
            side = match tile.across(exit.0) {
                Across::Side(side) => HalfEdge(side),
                Across::Hull => return Ok(outside(tile.ends(exit.0).map(|end| end.id))),
                Across::Elsewhere => {
                    let [from, to] = [exit, exit.next()].map(|s| tile.vertex(tile.origin(s.0)).id);
                    // Across, the side runs from `to` to `from`.
                    self.enter = Some((to, from));
                    return Ok(Step::Need(from.tile));
                }
            };
        }
    }

    /// A side that leaves a vertex near the target, or where the target lies if nothing leaves it.
    fn start(&self, tile: &Tile) -> Start {
        let square = |p: Point| {
            let (dx, dy) = (p.x - self.target.x, p.y - self.target.y);
            dx * dx + dy * dy
        };
        // The nearest of a few; their vertices are in Morton order, so these are spread evenly.
        let sample = (0..tile.vertex_count()).step_by(apart(tile.vertex_count()));
        let nearest = sample.min_by(|&p, &q| square(tile.point(p)).total_cmp(&square(tile.point(q))));
        if let Some(side) = nearest.and_then(|vertex| tile.side_leaving(vertex).map(HalfEdge)) {
            return Start::From(side);
        }
        // Without triangles there is nothing but vertices.
        let here = tile.points().zip(0..).find(|(point, _)| *point == self.target);
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

/// Where the target lies in a triangle that it is not outside of.
fn inside(tile: &Tile, sides: [HalfEdge; 3], turns: [Orientation; 3]) -> Location {
    let triangle = TriangleRef::of(tile, sides[0].triangle());
    let on: Vec<HalfEdge> = sides
        .into_iter()
        .zip(turns)
        .filter(|(_, turn)| *turn == Orientation::Collinear)
        .map(|(side, _)| side)
        .collect();
    let origin = |side: HalfEdge| tile.vertex(tile.origin(side.0));
    match on[..] {
        [] => Location::InTriangle(triangle),
        [side] => Location::OnEdge {
            ends: [origin(side), origin(side.next())],
            triangle,
        },
        // On two sides: at the corner between them.
        [a, b, ..] => Location::OnVertex(origin(if a.next() == b { b } else { a })),
    }
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
