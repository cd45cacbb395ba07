//! Points put into the triangulation for one query; the file stays as it is.
//!
//! In: a triangulation on disk, and points that are none of its vertices. Out: how the constrained Delaunay triangulation with
//! these points differs from it near them: which edges are gone, and which join the points to the vertices round them. The tie rule
//! makes that triangulation unique, so it is the one that a build with the points would have come to.
//!
//! A point removes the triangles whose circle holds it and which it reaches without crossing a constraint (Bowyer 1981, Watson 1981),
//! its *cavity*, and is joined to all vertices round that:
//!
//! ```text
//!       d ───── c            d ───── c
//!       │╲      │            │╲     ╱│        the triangles a b d and b c d are gone, and with them the edge b d; those
//!       │  ╲ p  │      →     │  ╲p╱  │        round p are its *star*. On each side of the cavity, what was beyond stays
//!       │    ╲  │            │  ╱ ╲  │
//!       a ───── b            a ───── b
//! ```
//!
//! A point on an edge lies in the triangles on both sides of it; if the edge is a constraint, each side is a cavity by itself, and if it
//! blocks, the point has two sectors. Outside the hull, each hull edge that the point sees has a triangle with infinity, which goes as
//! others do: the point is joined to the vertices that it sees of the hull, and where no constraint is in between to
//! some within.
//!
//! Sectors of the file's vertices stay what they were: what is new at a vertex lies in a wedge of a triangle that is gone.

use std::collections::BTreeMap;

use foldhash::{HashMap, HashSet};

use super::corner::{Bar, Corner, End, Face, Rim, Within, sorted};
use crate::geometry::{Orientation, Point, in_circle, orient2d};
use crate::query::free_space::{Ground, Place, Spot};
use crate::query::request::{Contradiction, QueryError, Tiles};
use crate::store::VertexId;

/// An edge that is not in the file, from a vertex in a sector of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Link {
    pub(super) within: Within,
    pub(super) to: Corner,
}

/// The triangulation round the points that were put in.
#[derive(Clone, Debug, Default)]
pub(crate) struct Overlay {
    /// The points, by number, and how many sectors each has.
    points: Vec<(Point, u32)>,
    /// The triangles of their stars, and which of them has which side.
    stars: BTreeMap<u32, Face>,
    by_side: HashMap<[End; 2], u32>,
    next_star: u32,
    /// Triangles of the file that are gone.
    gone: HashSet<[End; 3]>,
    /// Edges of the file that are gone.
    gone_edges: HashSet<[End; 2]>,
    /// Hull edges that are walls with points on them, seen from outside.
    outer: Vec<Rim>,
    /// New edges of the hull, which has its inside on their left, by their starts and by their ends.
    hull: [BTreeMap<End, Rim>; 2],
}

/// What lies on the left of an edge.
enum Left {
    Face(Face),
    Outside,
    /// A hole, or what lies round a hull that one may not leave.
    Nothing,
}

/// Where a point lies among what is there now.
enum Seat {
    In(Face),
    On([End; 2]),
    /// It sees this edge of the hull from outside.
    Outside(Rim),
}

/// A part of a cavity: the sides of its triangles.
#[derive(Default)]
struct Cavity {
    sides: HashMap<[End; 2], Rim>,
    /// In the order in which they came, so that all is always done in the same order.
    order: Vec<[End; 2]>,
    open: Vec<Rim>,
    faces: Vec<Face>,
}

impl Cavity {
    fn take(&mut self, face: Face) {
        self.faces.push(face);
        face.rims().into_iter().for_each(|rim| self.take_side(rim));
    }

    fn take_side(&mut self, rim: Rim) {
        if self.sides.insert(rim.ends(), rim).is_none() {
            self.order.push(rim.ends());
            self.open.push(rim);
        }
    }

    fn has_beyond(&self, [from, to]: [End; 2]) -> bool {
        self.sides.contains_key(&[to, from])
    }
}

impl Overlay {
    /// Puts in a free place, unless it is a vertex or was put in before. Returns the vertex that it is now.
    ///
    /// # Errors
    /// If a tile cannot be read, or tiles contradict each other.
    pub(crate) async fn put_in(&mut self, tiles: &mut Tiles, place: &Place) -> Result<End, QueryError> {
        if let Some(vertex) = place.vertex() {
            return Ok(vertex.into());
        }
        let same = self.points.iter().position(|&(point, _)| point == place.point);
        let number = same.unwrap_or(self.points.len()) as u32;
        let vertex = End::put_in(number);
        if same.is_none() {
            let seat = self.seat(tiles, place).await?;
            self.insert(tiles, place.point, vertex, seat).await?;
        }
        Ok(vertex)
    }

    /// A point that was put in, and how many sectors it has.
    pub(super) fn point(&self, vertex: End) -> Option<(Point, u32)> {
        vertex
            .number()
            .and_then(|number| self.points.get(number as usize).copied())
    }

    /// Whether an edge of the file is gone.
    pub(super) fn is_gone(&self, edge: [End; 2]) -> bool {
        !self.gone_edges.is_empty() && self.gone_edges.contains(&sorted(edge))
    }

    /// All edges that are not in the file, from both ends; some come more than once.
    pub(super) fn links(&self) -> HashMap<End, Vec<Link>> {
        let mut links: HashMap<End, Vec<Link>> = HashMap::default();
        let sides = self
            .stars
            .values()
            .flat_map(Face::rims)
            .chain(self.outer.iter().copied());
        for rim in sides.filter(|rim| rim.from.vertex.is_put_in() || rim.to.vertex.is_put_in()) {
            for (a, b) in [(rim.from, rim.to), (rim.to, rim.from)] {
                let link = Link {
                    within: a.within,
                    to: b,
                };
                links.entry(a.vertex).or_default().push(link);
            }
        }
        links
    }

    /// What lies on the left of an edge.
    async fn left_of(&self, tiles: &mut Tiles, [from, to]: [End; 2]) -> Result<Left, QueryError> {
        if let Some(star) = self.by_side.get(&[from, to]).and_then(|star| self.stars.get(star)) {
            return Ok(Left::Face(*star));
        }
        let (Some(start), Some(end)) = (from.vertex(), to.vertex()) else {
            let is_hull = self.hull[0].get(&to).is_some_and(|rim| rim.to.vertex == from);
            return Ok(if is_hull { Left::Outside } else { Left::Nothing });
        };
        Ok(match tiles.side_between(start, end).await? {
            Some((tile, side)) if tile.is_hole(side.triangle()) => Left::Nothing,
            Some((tile, side)) => Left::Face(Face::of(&tile, side.triangle())),
            None if tiles.outside_is_free() => Left::Outside,
            None => Left::Nothing,
        })
    }

    /// The edge of the hull that leaves a vertex, or the one that comes in; the outside is what the corners are within.
    async fn along_hull(&self, tiles: &mut Tiles, vertex: End, forward: bool) -> Result<Rim, QueryError> {
        if let Some(rim) = self.hull[usize::from(!forward)].get(&vertex) {
            return Ok(*rim);
        }
        let vertex = file_vertex(vertex)?;
        let tile = tiles.get(vertex.tile).await?;
        let side = Ground::of(tiles, &tile).along_hull(vertex.index, forward);
        let side = tiles.checked(vertex.tile, side)?;
        let [from, to] = tile.ends(side).map(|end| Corner {
            vertex: end.id.into(),
            point: end.point,
            within: Within::Outside,
        });
        let bar = Bar::of(&tile, side);
        Ok(Rim { from, to, bar })
    }

    async fn seat(&self, tiles: &mut Tiles, place: &Place) -> Result<Seat, QueryError> {
        match place.spot {
            Spot::Triangle(triangle) => {
                let tile = tiles.get(triangle.tile).await?;
                let face = Face::of(&tile, triangle.triangle);
                if !self.gone.contains(&face.key()) {
                    return Ok(Seat::In(face));
                }
            }
            Spot::Edge { ends } => {
                let ends = ordered(ends.map(|end| (end.point, end.id.into())));
                if !self.is_gone(ends) {
                    return Ok(Seat::On(ends));
                }
            }
            Spot::Outside([from, to]) => {
                if let Some(seat) = self.seat_in_stars(place.point) {
                    return Ok(seat);
                }
                let [from, to] = [from, to].map(End::from);
                if !self.is_gone([from, to]) && !self.by_side.contains_key(&[to, from]) {
                    return Ok(Seat::Outside(self.along_hull(tiles, from, true).await?));
                }
                // What hides that edge is seen itself.
                let seen = self.hull[0].values().find(|rim| is_seen(rim, place.point));
                if let Some(rim) = seen {
                    return Ok(Seat::Outside(*rim));
                }
            }
            Spot::Vertex(_) => {}
        }
        if let Some(seat) = self.seat_in_stars(place.point) {
            return Ok(seat);
        }
        let tile = tiles.last().await?;
        Err(tiles.damaged(tile.id(), Contradiction::NothingAt(place.point)))
    }

    /// Where a point lies in the stars of others.
    fn seat_in_stars(&self, point: Point) -> Option<Seat> {
        for face in self.stars.values() {
            let turns = face.rims().map(|rim| orient2d(rim.from.point, rim.to.point, point));
            if turns.contains(&Orientation::Clockwise) {
                continue;
            }
            let on = turns.iter().position(|&turn| turn == Orientation::Collinear);
            return Some(on.map_or(Seat::In(*face), |side| Seat::On(in_order(&face.rims()[side]))));
        }
        let is_on = |rim: &&Rim| {
            let [from, to] = [rim.from.point, rim.to.point];
            orient2d(from, to, point) == Orientation::Collinear && from.lex_cmp(point) == point.lex_cmp(to)
        };
        self.outer.iter().find(is_on).map(|rim| Seat::On(in_order(rim)))
    }

    async fn insert(&mut self, tiles: &mut Tiles, point: Point, vertex: End, seat: Seat) -> Result<(), QueryError> {
        let here = |sector| Corner {
            vertex,
            point,
            within: Within::Sector(sector),
        };
        let mut sectors = 1;
        match seat {
            Seat::In(face) => {
                let cavity = self.cavity(tiles, point, vec![face], Vec::new()).await?;
                self.replace(&cavity, here(0), None);
            }
            Seat::Outside(seen) => {
                let seen = self.seen(tiles, point, seen).await?;
                let cavity = self.cavity(tiles, point, Vec::new(), seen.clone()).await?;
                self.replace(&cavity, here(0), None);
                if let (Some(first), Some(last)) = (seen.first(), seen.last()) {
                    self.set_hull(first.from, here(0), last.to, Bar::Open);
                }
            }
            Seat::On(edge) => sectors = self.split(tiles, edge, here).await?,
        }
        self.points.push((point, sectors));
        Ok(())
    }

    /// Puts a point in on an edge. Returns how many sectors it has.
    async fn split(
        &mut self,
        tiles: &mut Tiles,
        edge: [End; 2],
        here: impl Fn(u32) -> Corner,
    ) -> Result<u32, QueryError> {
        let [a, b] = edge;
        let point = here(0).point;
        let lefts = [self.left_of(tiles, [a, b]).await?, self.left_of(tiles, [b, a]).await?];
        let bar = |(left, edge): (&Left, [End; 2])| match left {
            Left::Face(face) => face.rims().iter().find(|rim| rim.ends() == edge).map(|rim| rim.bar),
            Left::Outside | Left::Nothing => None,
        };
        let bar = lefts.iter().zip([[a, b], [b, a]]).find_map(bar).unwrap_or(Bar::Wall);
        self.outer.retain(|rim| sorted(rim.ends()) != sorted(edge));
        let mut sectors = 0;
        let mut together = Vec::new();
        let mut outside = None;
        for (left, ends) in lefts.into_iter().zip([[a, b], [b, a]]) {
            let sector = if bar == Bar::Wall { sectors } else { 0 };
            match left {
                Left::Nothing => continue,
                Left::Outside => outside = Some((ends, sector)),
                Left::Face(face) if bar == Bar::Open => together.push(face),
                Left::Face(face) => {
                    let cavity = self.cavity(tiles, point, vec![face], Vec::new()).await?;
                    self.replace(&cavity, here(sector), Some((edge, bar)));
                }
            }
            sectors = sector + 1;
        }
        if !together.is_empty() {
            let cavity = self.cavity(tiles, point, together, Vec::new()).await?;
            self.replace(&cavity, here(0), Some((edge, bar)));
        }
        if let Some(([to, from], sector)) = outside {
            let rim = self.along_hull(tiles, from, true).await?;
            if rim.to.vertex != to {
                let [from, to] = [file_vertex(from)?, file_vertex(to)?];
                return Err(tiles.damaged(from.tile, Contradiction::NoHullEdge(from, to)));
            }
            self.set_hull(rim.from, here(sector), rim.to, bar);
            if bar == Bar::Wall {
                let here = here(sector);
                self.outer
                    .extend([(rim.from, here), (here, rim.to)].map(|(from, to)| Rim { from, to, bar }));
            }
        }
        if edge.iter().all(|end| !end.is_put_in()) {
            self.gone_edges.insert(sorted(edge));
        }
        Ok(sectors.max(1))
    }

    fn set_hull(&mut self, from: Corner, here: Corner, to: Corner, bar: Bar) {
        for (from, to) in [(from, here), (here, to)] {
            let rim = Rim { from, to, bar };
            self.hull[0].insert(from.vertex, rim);
            self.hull[1].insert(to.vertex, rim);
        }
    }

    /// All edges of the hull that a point outside sees, in order, from one of them on.
    async fn seen(&self, tiles: &mut Tiles, point: Point, first: Rim) -> Result<Vec<Rim>, QueryError> {
        let most = tiles.hull_edges().saturating_add(4);
        let mut seen = vec![first];
        // Tiles that contradict each other might lead round and round.
        let mut met = HashSet::from_iter([first.ends()]);
        for forward in [false, true] {
            let mut rim = first;
            for _ in 0..most {
                let vertex = if forward { rim.to } else { rim.from }.vertex;
                rim = self.along_hull(tiles, vertex, forward).await?;
                if !is_seen(&rim, point) || !met.insert(rim.ends()) {
                    break;
                }
                seen.push(rim);
            }
            if !forward {
                seen.reverse();
            }
        }
        Ok(seen)
    }

    /// The triangles whose circle holds a point and which it reaches from these without crossing a constraint, or from outside over
    /// edges of the hull.
    async fn cavity(
        &self,
        tiles: &mut Tiles,
        point: Point,
        faces: Vec<Face>,
        seen: Vec<Rim>,
    ) -> Result<Cavity, QueryError> {
        let mut cavity = Cavity::default();
        faces.into_iter().for_each(|face| cavity.take(face));
        for Rim { from, to, bar } in seen {
            // The outside is on the left of the edge backwards.
            cavity.take_side(Rim {
                from: to,
                to: from,
                bar,
            });
        }
        while let Some(rim) = cavity.open.pop() {
            let [from, to] = rim.ends();
            if rim.bar != Bar::Open || cavity.has_beyond([from, to]) {
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

    /// Puts the star of a point in the place of a cavity; the point may lie on an edge.
    fn replace(&mut self, cavity: &Cavity, here: Corner, on: Option<([End; 2], Bar)>) {
        for face in &cavity.faces {
            if face.corners.iter().any(|corner| corner.vertex.is_put_in()) {
                for rim in face.rims() {
                    if let Some(star) = self.by_side.remove(&rim.ends()) {
                        self.stars.remove(&star);
                    }
                }
            } else {
                self.gone.insert(face.key());
            }
        }
        let bar_to = |vertex: End| match on {
            Some((edge, bar)) if edge.contains(&vertex) => bar,
            _ => Bar::Open,
        };
        for ends in &cavity.order {
            let rim = cavity.sides[ends];
            if on.is_some_and(|(edge, _)| sorted(*ends) == sorted(edge)) {
                continue;
            }
            if cavity.has_beyond(*ends) {
                if !rim.from.vertex.is_put_in() && !rim.to.vertex.is_put_in() {
                    self.gone_edges.insert(sorted(*ends));
                }
                continue;
            }
            let star = Face {
                corners: [here, rim.from, rim.to],
                bars: [bar_to(rim.from.vertex), rim.bar, bar_to(rim.to.vertex)],
            };
            for side in star.rims() {
                self.by_side.insert(side.ends(), self.next_star);
            }
            self.stars.insert(self.next_star, star);
            self.next_star += 1;
        }
    }
}

/// The ends of an edge in the order of their coordinates, so that the sides of a point on it have the same numbers in every file.
fn ordered([a, b]: [(Point, End); 2]) -> [End; 2] {
    if a.0.lex_cmp(b.0).is_lt() {
        [a.1, b.1]
    } else {
        [b.1, a.1]
    }
}

fn in_order(rim: &Rim) -> [End; 2] {
    ordered([rim.from, rim.to].map(|end| (end.point, end.vertex)))
}

/// A vertex, which must be the file's.
fn file_vertex(end: End) -> Result<VertexId, QueryError> {
    end.vertex().ok_or_else(|| QueryError::Uncertified {
        reason: "a point that was put in is not where it was".to_owned(),
    })
}

/// Whether a point sees an edge of the hull from outside.
fn is_seen(rim: &Rim, point: Point) -> bool {
    orient2d(rim.from.point, rim.to.point, point) == Orientation::Clockwise
}
