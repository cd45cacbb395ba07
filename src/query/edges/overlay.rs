//! Points inserted into the triangulation for one query; the file does not change.
//!
//! The input is a triangulation on disk, and points that are not its vertices. The output is how
//! the constrained Delaunay triangulation with these points differs from it near them: which edges
//! are removed, and which edges connect the points to the vertices round them. The tie rule makes
//! that triangulation unique, so it is the one that a build with the points would produce.
//!
//! A point removes the triangles whose circumcircle contains it and which it reaches without
//! crossing a constraint (Bowyer 1981, Watson 1981). They are its *cavity*. The point is connected
//! to all vertices round the cavity:
//!
//! ```text
//!       d ───── c            d ───── c
//!       │╲      │            │╲     ╱│    The triangles a b d and b c d are removed, and with them
//!       │  ╲ p  │      →     │  ╲p╱  │    the edge b d. The triangles round p are its *star*. What
//!       │    ╲  │            │  ╱ ╲  │    is beyond the edges of the cavity does not change.
//!       a ───── b            a ───── b
//! ```
//!
//! A point on an edge is in the triangles on both sides of the edge. If the edge is a constraint,
//! each side is a separate cavity, and if the edge blocks, the point has two sectors. Outside the
//! hull, each hull edge that the point sees has a triangle with infinity, which is removed like the
//! others. So the point is connected to the vertices of the hull that it sees, and, where no
//! constraint is in between, to some inside the hull.
//!
//! The sectors of the file's vertices do not change: a new edge at a vertex is in a wedge of a
//! removed triangle.

use std::collections::BTreeMap;

use foldhash::{HashMap, HashSet};

use super::cavity::Cavity;
use super::corner::{Corner, EdgeKind, Face, FaceEdge, GraphVertex, Within, sorted};
use crate::geometry::{Orientation, Point, in_circle, orient2d};
use crate::query::free_space::{FreeSpace, Position, QueryPoint};
use crate::query::request::{Contradiction, QueryError, Tiles};
use crate::store::VertexId;

/// An edge that is not in the file, from a vertex in one of its sectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Link {
    pub(super) within: Within,
    pub(super) to: Corner,
}

/// The triangulation round the inserted points.
#[derive(Clone, Debug, Default)]
pub(crate) struct Overlay {
    /// The points, by number, with the number of sectors of each.
    points: Vec<(Point, u32)>,
    /// The triangles of their stars, by number, and the number of the triangle at each directed
    /// edge.
    stars: BTreeMap<u32, Face>,
    by_edge: HashMap<[GraphVertex; 2], u32>,
    next_star: u32,
    /// The removed triangles of the file.
    gone: HashSet<[GraphVertex; 3]>,
    /// The removed edges of the file.
    gone_edges: HashSet<[GraphVertex; 2]>,
    /// Hull edges that are walls with points on them, seen from outside.
    outer: Vec<FaceEdge>,
    /// New edges of the hull, by their starts and by their ends. The inside of the hull is on their
    /// left.
    hull: [BTreeMap<GraphVertex, FaceEdge>; 2],
}

/// The space on the left of a directed edge.
enum Left {
    Face(Face),
    Outside,
    /// A hole, or the outside if it is not free.
    Nothing,
}

/// The position of a point in the current triangulation.
enum InsertPosition {
    In(Face),
    On([GraphVertex; 2]),
    /// Outside the hull, in sight of this hull edge.
    Outside(FaceEdge),
}

impl Overlay {
    /// Inserts a free point, unless it is a vertex or was inserted before. Returns its vertex.
    ///
    /// # Errors
    /// If a tile cannot be read, or tiles contradict each other.
    pub(crate) async fn insert_point(
        &mut self,
        tiles: &mut Tiles,
        query_point: &QueryPoint,
    ) -> Result<GraphVertex, QueryError> {
        if let Some(vertex) = query_point.vertex() {
            return Ok(vertex.into());
        }
        let same = self.points.iter().position(|&(point, _)| point == query_point.point);
        let number = same.unwrap_or(self.points.len()) as u32;
        let vertex = GraphVertex::inserted(number);
        if same.is_none() {
            let position = self.position(tiles, query_point).await?;
            self.insert(tiles, query_point.point, vertex, position).await?;
        }
        Ok(vertex)
    }

    /// Returns an inserted point, with its number of sectors.
    pub(super) fn point(&self, vertex: GraphVertex) -> Option<(Point, u32)> {
        vertex
            .number()
            .and_then(|number| self.points.get(number as usize).copied())
    }

    /// Returns whether an edge of the file was removed.
    pub(super) fn is_gone(&self, edge: [GraphVertex; 2]) -> bool {
        !self.gone_edges.is_empty() && self.gone_edges.contains(&sorted(edge))
    }

    /// Returns all edges that are not in the file, from both ends. Some edges occur more than once.
    pub(super) fn links(&self) -> HashMap<GraphVertex, Vec<Link>> {
        let mut links: HashMap<GraphVertex, Vec<Link>> = HashMap::default();
        let half_edges = self
            .stars
            .values()
            .flat_map(Face::edges)
            .chain(self.outer.iter().copied());
        for face_edge in
            half_edges.filter(|face_edge| face_edge.from.vertex.is_inserted() || face_edge.to.vertex.is_inserted())
        {
            for (a, b) in [(face_edge.from, face_edge.to), (face_edge.to, face_edge.from)] {
                let link = Link {
                    within: a.within,
                    to: b,
                };
                links.entry(a.vertex).or_default().push(link);
            }
        }
        links
    }

    /// Returns the space on the left of a directed edge.
    async fn left_of(&self, tiles: &mut Tiles, [from, to]: [GraphVertex; 2]) -> Result<Left, QueryError> {
        if let Some(star) = self.by_edge.get(&[from, to]).and_then(|star| self.stars.get(star)) {
            return Ok(Left::Face(*star));
        }
        let (Some(start), Some(end)) = (from.vertex(), to.vertex()) else {
            let is_hull = self.hull[0]
                .get(&to)
                .is_some_and(|face_edge| face_edge.to.vertex == from);
            return Ok(if is_hull { Left::Outside } else { Left::Nothing });
        };
        Ok(match tiles.half_edge_between(start, end).await? {
            Some((tile, edge_unused)) if tile.is_hole(edge_unused.triangle()) => Left::Nothing,
            Some((tile, edge_unused)) => Left::Face(Face::of(&tile, edge_unused.triangle())),
            None if tiles.outside_is_free() => Left::Outside,
            None => Left::Nothing,
        })
    }

    /// Returns the hull edge that leaves a vertex (`forward`), or the one that arrives there. Its
    /// corners are in the outside.
    async fn along_hull(&self, tiles: &mut Tiles, vertex: GraphVertex, forward: bool) -> Result<FaceEdge, QueryError> {
        if let Some(face_edge) = self.hull[usize::from(!forward)].get(&vertex) {
            return Ok(*face_edge);
        }
        let vertex = file_vertex(vertex)?;
        let tile = tiles.get(vertex.tile).await?;
        let edge_unused = FreeSpace::of(tiles, &tile).along_hull(vertex.index, forward);
        let edge_unused = tiles.checked(vertex.tile, edge_unused)?;
        let [from, to] = tile.ends(edge_unused).map(|end| Corner {
            vertex: end.id.into(),
            point: end.point,
            within: Within::Outside,
        });
        let kind = EdgeKind::of(&tile, edge_unused);
        Ok(FaceEdge { from, to, kind })
    }

    async fn position(&self, tiles: &mut Tiles, query_point: &QueryPoint) -> Result<InsertPosition, QueryError> {
        match query_point.position {
            Position::Triangle(triangle) => {
                let tile = tiles.get(triangle.tile).await?;
                let face = Face::of(&tile, triangle.triangle);
                if !self.gone.contains(&face.key()) {
                    return Ok(InsertPosition::In(face));
                }
            }
            Position::Edge { ends } => {
                let ends = ordered(ends.map(|end| (end.point, end.id.into())));
                if !self.is_gone(ends) {
                    return Ok(InsertPosition::On(ends));
                }
            }
            Position::Outside([from, to]) => {
                if let Some(position) = self.position_in_stars(query_point.point) {
                    return Ok(position);
                }
                let [from, to] = [from, to].map(GraphVertex::from);
                if !self.is_gone([from, to]) && !self.by_edge.contains_key(&[to, from]) {
                    return Ok(InsertPosition::Outside(self.along_hull(tiles, from, true).await?));
                }
                // If that edge is hidden, the point sees the edge that hides it.
                let seen = self.hull[0]
                    .values()
                    .find(|face_edge| is_seen(face_edge, query_point.point));
                if let Some(face_edge) = seen {
                    return Ok(InsertPosition::Outside(*face_edge));
                }
            }
            Position::Vertex(_) => {}
        }
        if let Some(position) = self.position_in_stars(query_point.point) {
            return Ok(position);
        }
        let tile = tiles.last().await?;
        Err(tiles.damaged(tile.id(), Contradiction::NothingAt(query_point.point)))
    }

    /// Returns the position of a point in the stars of other points.
    fn position_in_stars(&self, point: Point) -> Option<InsertPosition> {
        for face in self.stars.values() {
            let turns = face
                .edges()
                .map(|face_edge| orient2d(face_edge.from.point, face_edge.to.point, point));
            if turns.contains(&Orientation::Clockwise) {
                continue;
            }
            let on = turns.iter().position(|&rank| rank == Orientation::Collinear);
            return Some(on.map_or(InsertPosition::In(*face), |edge_unused| {
                InsertPosition::On(in_order(&face.edges()[edge_unused]))
            }));
        }
        let is_on = |face_edge: &&FaceEdge| {
            let [from, to] = [face_edge.from.point, face_edge.to.point];
            orient2d(from, to, point) == Orientation::Collinear && from.lex_cmp(point) == point.lex_cmp(to)
        };
        self.outer
            .iter()
            .find(is_on)
            .map(|face_edge| InsertPosition::On(in_order(face_edge)))
    }

    async fn insert(
        &mut self,
        tiles: &mut Tiles,
        point: Point,
        vertex: GraphVertex,
        position: InsertPosition,
    ) -> Result<(), QueryError> {
        let here = |sector| Corner {
            vertex,
            point,
            within: Within::Sector(sector),
        };
        let mut sectors = 1;
        match position {
            InsertPosition::In(face) => {
                let cavity = self.cavity(tiles, point, vec![face], Vec::new()).await?;
                self.replace(&cavity, here(0), None);
            }
            InsertPosition::Outside(seen) => {
                let seen = self.seen(tiles, point, seen).await?;
                let cavity = self.cavity(tiles, point, Vec::new(), seen.clone()).await?;
                self.replace(&cavity, here(0), None);
                if let (Some(first), Some(last)) = (seen.first(), seen.last()) {
                    self.set_hull(first.from, here(0), last.to, EdgeKind::Open);
                }
            }
            InsertPosition::On(edge) => sectors = self.split(tiles, edge, here).await?,
        }
        self.points.push((point, sectors));
        Ok(())
    }

    /// Inserts a point on an edge. Returns its number of sectors.
    async fn split(
        &mut self,
        tiles: &mut Tiles,
        edge: [GraphVertex; 2],
        here: impl Fn(u32) -> Corner,
    ) -> Result<u32, QueryError> {
        let [a, b] = edge;
        let point = here(0).point;
        let lefts = [self.left_of(tiles, [a, b]).await?, self.left_of(tiles, [b, a]).await?];
        let kind = |(left, edge): (&Left, [GraphVertex; 2])| match left {
            Left::Face(face) => face
                .edges()
                .iter()
                .find(|face_edge| face_edge.ends() == edge)
                .map(|face_edge| face_edge.kind),
            Left::Outside | Left::Nothing => None,
        };
        let kind = lefts
            .iter()
            .zip([[a, b], [b, a]])
            .find_map(kind)
            .unwrap_or(EdgeKind::Wall);
        self.outer.retain(|face_edge| sorted(face_edge.ends()) != sorted(edge));
        let mut sectors = 0;
        let mut together = Vec::new();
        let mut outside = None;
        for (left, ends) in lefts.into_iter().zip([[a, b], [b, a]]) {
            let sector = if kind == EdgeKind::Wall { sectors } else { 0 };
            match left {
                Left::Nothing => continue,
                Left::Outside => outside = Some((ends, sector)),
                Left::Face(face) if kind == EdgeKind::Open => together.push(face),
                Left::Face(face) => {
                    let cavity = self.cavity(tiles, point, vec![face], Vec::new()).await?;
                    self.replace(&cavity, here(sector), Some((edge, kind)));
                }
            }
            sectors = sector + 1;
        }
        if !together.is_empty() {
            let cavity = self.cavity(tiles, point, together, Vec::new()).await?;
            self.replace(&cavity, here(0), Some((edge, kind)));
        }
        if let Some(([to, from], sector)) = outside {
            let face_edge = self.along_hull(tiles, from, true).await?;
            if face_edge.to.vertex != to {
                let [from, to] = [file_vertex(from)?, file_vertex(to)?];
                return Err(tiles.damaged(from.tile, Contradiction::NoHullEdge(from, to)));
            }
            self.set_hull(face_edge.from, here(sector), face_edge.to, kind);
            if kind == EdgeKind::Wall {
                let here = here(sector);
                self.outer.extend(
                    [(face_edge.from, here), (here, face_edge.to)].map(|(from, to)| FaceEdge { from, to, kind }),
                );
            }
        }
        if edge.iter().all(|end| !end.is_inserted()) {
            self.gone_edges.insert(sorted(edge));
        }
        Ok(sectors.max(1))
    }

    fn set_hull(&mut self, from: Corner, here: Corner, to: Corner, kind: EdgeKind) {
        for (from, to) in [(from, here), (here, to)] {
            let face_edge = FaceEdge { from, to, kind };
            self.hull[0].insert(from.vertex, face_edge);
            self.hull[1].insert(to.vertex, face_edge);
        }
    }

    /// Returns all hull edges that a point outside sees, in order; `first` is one of them.
    async fn seen(&self, tiles: &mut Tiles, point: Point, first: FaceEdge) -> Result<Vec<FaceEdge>, QueryError> {
        let most = tiles.hull_edges().saturating_add(4);
        let mut seen = vec![first];
        // Guards against an endless loop if tiles contradict each other.
        let mut met = HashSet::from_iter([first.ends()]);
        for forward in [false, true] {
            let mut face_edge = first;
            for _ in 0..most {
                let vertex = if forward { face_edge.to } else { face_edge.from }.vertex;
                face_edge = self.along_hull(tiles, vertex, forward).await?;
                if !is_seen(&face_edge, point) || !met.insert(face_edge.ends()) {
                    break;
                }
                seen.push(face_edge);
            }
            if !forward {
                seen.reverse();
            }
        }
        Ok(seen)
    }

    /// Returns the triangles whose circumcircle contains a point and which the point reaches
    /// without crossing a constraint, from `faces` or from outside through the hull edges `seen`.
    async fn cavity(
        &self,
        tiles: &mut Tiles,
        point: Point,
        faces: Vec<Face>,
        seen: Vec<FaceEdge>,
    ) -> Result<Cavity, QueryError> {
        let mut cavity = Cavity::default();
        faces.into_iter().for_each(|face| cavity.take(face));
        for FaceEdge { from, to, kind } in seen {
            // The outside is on the left of the reversed edge.
            cavity.take_edge(FaceEdge {
                from: to,
                to: from,
                kind,
            });
        }
        while let Some(face_edge) = cavity.open.pop() {
            let [from, to] = face_edge.ends();
            if face_edge.kind != EdgeKind::Open || cavity.has_twin([from, to]) {
                continue;
            }
            if cavity.faces.len() % 256 == 255 {
                tokio::task::yield_now().await;
                tiles.check_time()?;
            }
            if let Left::Face(face) = self.left_of(tiles, [to, from]).await? {
                let [a, b, c] = face.points();
                if in_circle(a, b, c, point) {
                    cavity.take(face);
                }
            }
        }
        Ok(cavity)
    }

    /// Replaces a cavity by the star of a point. `on` is the edge that the point is on, if any, and
    /// its kind.
    fn replace(&mut self, cavity: &Cavity, here: Corner, on: Option<([GraphVertex; 2], EdgeKind)>) {
        for face in &cavity.faces {
            if face.corners.iter().any(|corner| corner.vertex.is_inserted()) {
                for face_edge in face.edges() {
                    if let Some(star) = self.by_edge.remove(&face_edge.ends()) {
                        self.stars.remove(&star);
                    }
                }
            } else {
                self.gone.insert(face.key());
            }
        }
        let kind_to = |vertex: GraphVertex| match on {
            Some((edge, kind)) if edge.contains(&vertex) => kind,
            _ => EdgeKind::Open,
        };
        for ends in &cavity.order {
            let face_edge = cavity.half_edges[ends];
            if on.is_some_and(|(edge, _)| sorted(*ends) == sorted(edge)) {
                continue;
            }
            if cavity.has_twin(*ends) {
                if !face_edge.from.vertex.is_inserted() && !face_edge.to.vertex.is_inserted() {
                    self.gone_edges.insert(sorted(*ends));
                }
                continue;
            }
            let star = Face {
                corners: [here, face_edge.from, face_edge.to],
                kinds: [
                    kind_to(face_edge.from.vertex),
                    face_edge.kind,
                    kind_to(face_edge.to.vertex),
                ],
            };
            for edge_unused in star.edges() {
                self.by_edge.insert(edge_unused.ends(), self.next_star);
            }
            self.stars.insert(self.next_star, star);
            self.next_star += 1;
        }
    }
}

/// Returns the ends of an edge in the order of their coordinates, so that the sectors of a point on
/// it have the same numbers in every file.
fn ordered([a, b]: [(Point, GraphVertex); 2]) -> [GraphVertex; 2] {
    if a.0.lex_cmp(b.0).is_lt() {
        [a.1, b.1]
    } else {
        [b.1, a.1]
    }
}

fn in_order(face_edge: &FaceEdge) -> [GraphVertex; 2] {
    ordered([face_edge.from, face_edge.to].map(|end| (end.point, end.vertex)))
}

/// Returns a vertex of the file, or an error for an inserted point.
fn file_vertex(end: GraphVertex) -> Result<VertexId, QueryError> {
    end.vertex().ok_or_else(|| QueryError::Uncertified {
        reason: "an inserted point is used as a vertex of the file".to_owned(),
    })
}

/// Returns whether a point sees a hull edge from outside.
fn is_seen(face_edge: &FaceEdge, point: Point) -> bool {
    orient2d(face_edge.from.point, face_edge.to.point, point) == Orientation::Clockwise
}
