//! Constraints: segments become edges of a triangulation, which stays Delaunay beside them.
//!
//! In: a canonical triangulation, and segments between its points. Out: the constrained Delaunay triangulation, which is
//! a function of the points and of the segments as sets: the circle test's tie rule leaves one choice only, so neither the
//! order nor the direction of the segments matters.
//!
//! A segment is cut into **pieces** at the vertices that lie on it. Inserting a piece changes exactly the triangles that it
//! crosses (Wu, Lemma 3.3.6); these are taken out, and the [cavity](super::cavity) is triangulated on both sides:
//!
//! ```text
//!        u ───── v                u ───── v
//!      ╱  ╲     ╱ ╲             ╱      ╱   ╲
//!     a    ╲   ╱   b     →     a ═══════════ b
//!      ╲    ╲ ╱   ╱             ╲     │     ╱
//!        ──── l ──                ──── l ──
//! ```
//!
//! As many triangles come out as go in, so they keep their places in the arrays.

mod star;

use super::boundary::Boundary;
use super::cavity::Cavity;
use super::{NONE, Triangulation, next_side, prev_side};
use crate::geometry::{Orientation, Point, orient2d};
pub(crate) use star::Stars;
use star::{Start, begin};

/// In the byte of a triangle, the bits of its sides that are constraints stand at 0 to 2, those that are walls too at
/// [`WALLS`] to 5, and that of a triangle that a piece crosses here.
const CROSSED: u8 = 1 << 6;
/// The place of the first side's wall bit.
pub(crate) const WALLS: u32 = 3;
/// The bits of a side that is a constraint, and of one that is a wall, both in the places of the first side.
const CONSTRAINT: u8 = 1;
const WALL: u8 = CONSTRAINT | 1 << WALLS;

/// A triangulation with constraints.
#[derive(Clone, Debug, Default)]
pub struct Constrained {
    mesh: Triangulation,
    /// For each triangle, the bits of its sides; and [`CROSSED`], while it is being replaced.
    fixed: Vec<u8>,
    /// A side that starts at each point.
    sides: Vec<u32>,
    boundary: Boundary,
    /// Without triangles: for each point of the hull, whether the edge to the next is a constraint, and its place there.
    line: Vec<bool>,
    places: Vec<u32>,
}

/// Two segments cross, away from the points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the segment between points {} and {} crosses the constraint between {} and {}", segment[0], segment[1], edge[0], edge[1])]
pub struct Crossing {
    /// The ends of the segment that was to be inserted.
    pub segment: [u32; 2],
    /// The ends of the constraint edge that it crosses.
    pub edge: [u32; 2],
}

/// Inserts segments. It keeps its memory from one to the next.
///
/// ```
/// use delaunay_tiles::geometry::Point;
/// use delaunay_tiles::mesh::{Constrained, EngineKind, Inserter, Triangulation};
///
/// let points = [[0.0, 0.0], [8.0, 0.0], [4.0, 1.0], [4.0, -1.0]].map(|[x, y]| Point::new(x, y));
/// let mut mesh = Triangulation::default();
/// EngineKind::Native.create().triangulate(&points, &mut mesh);
/// let mut mesh = Constrained::new(mesh, points.len());
/// Inserter::default().insert(&points, &mut mesh, [0, 1])?;
/// assert_eq!(mesh.constraints().count(), 1);
/// assert!(mesh.mesh().triangles.iter().all(|t| t.contains(&0) && t.contains(&1)));
/// # Ok::<(), delaunay_tiles::mesh::Crossing>(())
/// ```
#[derive(Debug, Default)]
pub struct Inserter {
    /// The triangles that a piece crosses.
    crossed: Vec<u32>,
    left: Chain,
    right: Chain,
    cavity: Cavity,
}

/// The boundary of a cavity on one side of a piece.
#[derive(Debug, Default)]
struct Chain {
    vertices: Vec<u32>,
    /// Between each vertex and the next, the side of the crossed triangle there.
    sides: Vec<u32>,
    /// What lies across each of these, and the bits of the side, in the places of a first one.
    across: Vec<(Across, u8)>,
    /// Positions whose edges the chain passes once more.
    open: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
enum Across {
    /// A side of a triangle that stays, or [`NONE`].
    Side(u32),
    /// The chain passes the edge once more, the other way, at this position.
    Chain(u32),
}

/// Where the line from a vertex goes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// Along the edge of this side, to this vertex.
    Edge(u32, u32),
    /// Through triangles, to this vertex on the line.
    Triangles(u32),
    /// Through triangles, or none, to where there are no more.
    Out,
}

impl Constrained {
    /// Takes a triangulation of so many points, none of whose edges is a constraint.
    #[must_use]
    pub fn new(mesh: Triangulation, points: usize) -> Self {
        let fixed = vec![0; mesh.triangles.len()];
        Self::with_constraints(mesh, fixed, points)
    }

    /// Takes triangles of so many points, which may be parts of a triangulation, and the bits of each one's sides.
    pub(crate) fn with_constraints(mesh: Triangulation, fixed: Vec<u8>, points: usize) -> Self {
        let mut this = Self {
            fixed,
            sides: vec![NONE; points],
            ..Self::default()
        };
        if mesh.triangles.is_empty() {
            this.line = vec![false; mesh.hull.len()];
            this.places = vec![NONE; points];
            for (&point, place) in mesh.hull.iter().zip(0..) {
                this.places[point as usize] = place;
            }
        } else {
            for (&point, side) in mesh.triangles.as_flattened().iter().zip(0..) {
                this.sides[point as usize] = side;
            }
            let sides = 0..3 * mesh.triangles.len() as u32;
            let edges = sides.filter(|&side| mesh.twin(side) == NONE);
            let edges = edges.map(|side| (mesh.origin(side), mesh.origin(next_side(side)), side));
            this.boundary = Boundary::new(edges.collect(), points);
        }
        this.mesh = mesh;
        this
    }

    /// The triangles and their adjacency. Their corners and their places may differ from those without constraints; the hull
    /// does not.
    #[must_use]
    pub fn mesh(&self) -> &Triangulation {
        &self.mesh
    }

    /// Whether a side is on a constraint.
    #[must_use]
    pub fn is_constraint(&self, side: u32) -> bool {
        self.fixed[(side / 3) as usize] >> (side % 3) & 1 == 1
    }

    /// All constraint edges, once each.
    pub fn constraints(&self) -> impl Iterator<Item = [u32; 2]> {
        let mesh = &self.mesh;
        let sides = (0..3 * mesh.triangles.len() as u32).filter(|&side| self.is_constraint(side));
        let once = sides.filter(|&side| mesh.twin(side) == NONE || side < mesh.twin(side));
        let edges = once.map(|side| [mesh.origin(side), mesh.origin(next_side(side))]);
        let pairs = mesh.hull.windows(2).zip(&self.line);
        edges.chain(pairs.filter(|(_, fixed)| **fixed).map(|(pair, _)| [pair[0], pair[1]]))
    }

    /// The bits of a triangle's sides: from 0 on those that are constraints, from [`WALLS`] on those that are walls.
    pub(crate) fn side_bits(&self, triangle: u32) -> u8 {
        self.fixed[triangle as usize]
    }

    /// The triangles, and the bits of each one's sides.
    pub(crate) fn into_parts(self) -> (Triangulation, Vec<u8>) {
        (self.mesh, self.fixed)
    }

    /// Makes the edge of a side a constraint, or even a wall.
    pub(crate) fn fix(&mut self, side: u32, is_wall: bool) {
        let bits = if is_wall { WALL } else { CONSTRAINT };
        for side in [side, self.mesh.twin(side)] {
            if side != NONE {
                self.fixed[(side / 3) as usize] |= bits << (side % 3);
            }
        }
    }

    /// A boundary edge belongs to this side now.
    fn move_boundary(&mut self, side: u32) {
        let [from, to] = [side, next_side(side)].map(|side| self.mesh.origin(side));
        self.boundary.set_side(from, to, side);
    }

    fn set_neighbour(&mut self, side: u32, twin: u32) {
        self.mesh.neighbours[(side / 3) as usize][(side % 3) as usize] = twin;
    }
}

impl Inserter {
    /// Makes a segment between two points a chain of constraint edges. If they are the same, nothing happens.
    ///
    /// `points` are those of the triangulation.
    ///
    /// # Errors
    /// If it crosses a constraint. Some of its pieces may be constraints then.
    pub fn insert(&mut self, points: &[Point], mesh: &mut Constrained, segment: [u32; 2]) -> Result<(), Crossing> {
        if mesh.mesh.triangles.is_empty() {
            let [a, b] = segment.map(|point| mesh.places[point as usize] as usize);
            mesh.line[a.min(b)..a.max(b)].fill(true);
            return Ok(());
        }
        let mut ends = segment;
        while ends[0] != ends[1] {
            let (which, step) = self
                .step_between(points, mesh, ends)
                .map_err(|edge| Crossing { segment, edge })?;
            ends[which] = match step {
                Step::Edge(side, vertex) => {
                    mesh.fix(side, false);
                    vertex
                }
                Step::Triangles(vertex) => {
                    self.replace(points, mesh, false);
                    vertex
                }
                Step::Out => unreachable!("a triangulation has no gaps between its points"),
            };
        }
        Ok(())
    }

    /// The first step from one of two vertices to the other, and which it starts from: whichever has fewer edges, since
    /// thousands of segments may share one end. Or the constraint in its way.
    pub(crate) fn step_between(
        &mut self,
        points: &[Point],
        mesh: &Constrained,
        ends: [u32; 2],
    ) -> Result<(usize, Step), [u32; 2]> {
        let Some((which, start)) = begin(points, mesh, ends) else {
            self.crossed.clear();
            return Ok((0, Step::Out));
        };
        let to = points[ends[1 - which] as usize];
        Ok((which, self.follow(points, mesh, start, to)?))
    }

    /// The first step from a vertex towards another place. Or the constraint in its way. `stars` are of this mesh as it is.
    pub(crate) fn step(
        &mut self,
        points: &[Point],
        mesh: &Constrained,
        stars: &mut Stars,
        from: u32,
        to: Point,
    ) -> Result<Step, [u32; 2]> {
        match stars.start(points, mesh, from, to) {
            Some(start) => self.follow(points, mesh, start, to),
            None => {
                self.crossed.clear();
                Ok(Step::Out)
            }
        }
    }

    /// The first step of a line that comes in by a boundary edge. None: it does not. Or the constraint in its way.
    pub(crate) fn enter(
        &mut self,
        points: &[Point],
        mesh: &Constrained,
        line: [Point; 2],
    ) -> Result<Option<Step>, [u32; 2]> {
        let Some((from, to, side)) = mesh.boundary.entry(points, line) else {
            return Ok(None);
        };
        if mesh.is_constraint(side) {
            return Err([from, to]);
        }
        self.crossed.clear();
        // Nobody asks for these after a line that comes in; they must not grow with each.
        self.left.clear();
        self.right.clear();
        self.walk(points, mesh, side, line).map(Some)
    }

    /// The triangles that the last step crossed.
    pub(crate) fn crossed(&self) -> &[u32] {
        &self.crossed
    }

    /// Follows a line from the origin of a side.
    fn follow(&mut self, points: &[Point], mesh: &Constrained, start: Start, to: Point) -> Result<Step, [u32; 2]> {
        let side = match start {
            Start::Edge(side, vertex) => return Ok(Step::Edge(side, vertex)),
            Start::Triangle(side) => side,
        };
        let topology = &mesh.mesh;
        let from = topology.origin(side);
        let gate = next_side(side);
        self.crossed.clear();
        self.crossed.push(side / 3);
        self.right.begin(from, topology.origin(gate), side);
        self.left.begin(from, topology.origin(next_side(gate)), prev_side(side));
        match pass(mesh, gate)? {
            NONE => Ok(Step::Out),
            entered => self.walk(points, mesh, entered, [points[from as usize], to]),
        }
    }

    /// Walks along a line from the side by which it enters a triangle, and collects what is crossed up to the next vertex on
    /// the line.
    fn walk(
        &mut self,
        points: &[Point],
        mesh: &Constrained,
        mut entered: u32,
        [a, b]: [Point; 2],
    ) -> Result<Step, [u32; 2]> {
        loop {
            let apex = mesh.mesh.origin(prev_side(entered));
            self.crossed.push(entered / 3);
            let (left, right) = (prev_side(entered), next_side(entered));
            let gate = match orient2d(a, b, points[apex as usize]) {
                Orientation::CounterClockwise => {
                    self.left.push(apex, left);
                    right
                }
                Orientation::Clockwise => {
                    self.right.push(apex, right);
                    left
                }
                Orientation::Collinear => {
                    self.left.push(apex, left);
                    self.right.push(apex, right);
                    return Ok(Step::Triangles(apex));
                }
            };
            entered = pass(mesh, gate)?;
            if entered == NONE {
                return Ok(Step::Out);
            }
        }
    }

    /// Triangulates both sides of the piece of the last step, which went through triangles to a vertex, in place of the
    /// triangles that it crosses.
    pub(crate) fn replace(&mut self, points: &[Point], mesh: &mut Constrained, is_wall: bool) {
        for &triangle in &self.crossed {
            mesh.fixed[triangle as usize] |= CROSSED;
        }
        // Both chains have their polygon on the left.
        self.right.reverse();
        self.left.resolve(mesh);
        self.right.resolve(mesh);
        let (left, right) = self.crossed.split_at(self.left.vertices.len() - 2);
        let sides = [(&self.left, left), (&self.right, right)].map(|(chain, places)| {
            let chain_points = chain.vertices.iter().map(|&vertex| points[vertex as usize]);
            let is_polygon = self.cavity.triangulate(chain_points);
            assert!(is_polygon, "what a piece crosses is a polygon on each side");
            fill(mesh, chain, places, &self.cavity)
        });
        mesh.set_neighbour(sides[0], sides[1]);
        mesh.set_neighbour(sides[1], sides[0]);
        mesh.fix(sides[0], is_wall);
    }
}

impl Chain {
    fn clear(&mut self) {
        self.vertices.clear();
        self.sides.clear();
    }

    fn begin(&mut self, from: u32, to: u32, side: u32) {
        self.clear();
        self.vertices.push(from);
        self.push(to, side);
    }

    fn push(&mut self, vertex: u32, side: u32) {
        self.vertices.push(vertex);
        self.sides.push(side);
    }

    fn reverse(&mut self) {
        self.vertices.reverse();
        self.sides.reverse();
    }

    /// Finds out what lies across, while the crossed triangles are still there.
    ///
    /// An edge between two crossed triangles that is not crossed itself is passed twice: a constraint that dangles into the
    /// cavity, or an edge from which triangles hang that the piece does not cross. Such edges lie within each other as
    /// brackets do.
    fn resolve(&mut self, mesh: &Constrained) {
        self.across.clear();
        self.open.clear();
        for (position, &side) in (0..).zip(&self.sides) {
            let twin = mesh.mesh.twin(side);
            let is_passed_twice = twin != NONE && mesh.fixed[(twin / 3) as usize] & CROSSED != 0;
            let across = match self.open.last() {
                _ if !is_passed_twice => Across::Side(twin),
                Some(&other) if self.sides[other as usize] == twin => {
                    self.open.pop();
                    self.across[other as usize].0 = Across::Chain(position);
                    Across::Chain(other)
                }
                _ => {
                    self.open.push(position);
                    // Until it comes again.
                    Across::Chain(position)
                }
            };
            let bits = mesh.fixed[(side / 3) as usize] >> (side % 3) & WALL;
            self.across.push((across, bits));
        }
        debug_assert!(self.open.is_empty());
    }
}

/// Puts the triangles of a cavity in these places. Returns the side on the piece.
fn fill(mesh: &mut Constrained, chain: &Chain, places: &[u32], cavity: &Cavity) -> u32 {
    let global = |side: u32| 3 * places[(side / 3) as usize] + side % 3;
    for ((&place, corners), first) in places.iter().zip(&cavity.triangles).zip((0..).step_by(3)) {
        let corners = corners.map(|position| chain.vertices[position as usize]);
        mesh.mesh.triangles[place as usize] = corners;
        mesh.mesh.neighbours[place as usize] = [0, 1, 2].map(|side| cavity.twin(first + side).map_or(NONE, global));
        mesh.fixed[place as usize] = 0;
        for (side, vertex) in (3 * place..).zip(corners) {
            mesh.sides[vertex as usize] = side;
        }
    }
    let mut sides = cavity.sides.iter().map(|&side| global(side));
    for (&(across, bits), side) in chain.across.iter().zip(sides.by_ref()) {
        match across {
            Across::Side(other) => {
                mesh.set_neighbour(side, other);
                if other == NONE {
                    mesh.move_boundary(side);
                } else {
                    mesh.set_neighbour(other, side);
                }
            }
            Across::Chain(position) => mesh.set_neighbour(side, global(cavity.sides[position as usize])),
        }
        mesh.fixed[(side / 3) as usize] |= bits << (side % 3);
    }
    sides.next().expect("one side more than edges of the chain")
}

/// The side behind a gate, unless that is a constraint.
fn pass(mesh: &Constrained, gate: u32) -> Result<u32, [u32; 2]> {
    if mesh.is_constraint(gate) {
        return Err([gate, next_side(gate)].map(|side| mesh.mesh.origin(side)));
    }
    Ok(mesh.mesh.twin(gate))
}

#[cfg(test)]
mod tests;
