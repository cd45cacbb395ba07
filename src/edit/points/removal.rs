//! Removal of a vertex: the triangles around it are replaced by those of its link.
//!
//! ```text
//!   inside               on the hull               on a line
//!     d ─── c               d ─── c                    c ─── b
//!    ╱ ╲   ╱ ╲             ╱ ╲   ╱ ╲                  ╱ ╲   ╱ ╲
//!   e ── v ── b           e ── v ── b            d ══════ v ══════ a
//!    ╲ ╱   ╲ ╱                                       ╲ ╱   ╲ ╱
//!     f ─── a                                         e ─── f
//! ```
//!
//! Inside, the link is closed: the polygon is triangulated anew. On the hull, the link is open, and
//! the new hull runs along it where it is convex; between lie polygons, each below an edge of the
//! new hull. A vertex that a line passes, from a to d, parts its star in two, and the edge between a
//! and d becomes the constraint.

use crate::edit::chain::Chain;
use crate::edit::contradiction::Contradiction;
use crate::edit::error::EditError;
use crate::edit::exchange::exchange;
use crate::edit::patch::{OldTriangle, Patch, PatchTwin};
use crate::edit::tiles::Tiles;
use crate::edit::vertex::{EditVertex, owner};
use crate::geometry::{HalfEdge, Orientation, Point, TriangleId, orient2d};
use crate::mesh::{Cavity, StarEnd, Topology, WALLS};
use crate::store::{LinePart, VertexId};

/// A remover of vertices, which reuses its buffers.
#[derive(Default)]
pub(crate) struct VertexRemover {
    /// Whether any edge of the file may be a constraint.
    has_lines: bool,
    cavity: Cavity,
    patch: Patch,
    chain: Chain,
    /// The vertices around the one to remove, counter-clockwise.
    link: Vec<u32>,
    /// The half-edge of the old triangle from each vertex of the link to the next.
    sides: Vec<HalfEdge>,
    /// Whether the last vertex of the link is followed by the first.
    is_closed: bool,
    spokes: Vec<Spoke>,
}

/// An edge that becomes a constraint: its ends, and the lines along it, as seen from the first.
type NewLine = ([EditVertex; 2], Vec<LinePart>);

/// A constraint edge at the vertex to remove.
struct Spoke {
    /// The place of its other end in the link.
    place: usize,
    end: EditVertex,
    bits: u8,
    /// Its sources, as seen from the vertex to remove, in order.
    sources: Vec<LinePart>,
}

impl VertexRemover {
    pub(crate) fn new(has_lines: bool) -> Self {
        Self {
            has_lines,
            ..Self::default()
        }
    }

    /// Removes a vertex from all triangles, unless a site or the end of a segment holds it. Returns
    /// whether it is removed.
    pub(crate) fn remove(&mut self, tiles: &mut Tiles, id: VertexId) -> Result<bool, EditError> {
        let tile = tiles.get(id.tile)?;
        let vertex = tile.vertex(id.index);
        let (has_site, has_triangles) = (tile.has_site(id.index), tile.leaving(id.index).is_some());
        drop(tile);
        if has_site {
            return Ok(false);
        }
        if !has_triangles {
            // All vertices left lie on one line.
            return if self.has_lines {
                Err(EditError::NothingLeft)
            } else {
                Ok(true)
            };
        }
        self.gather(tiles, vertex)?;
        self.find_sources(tiles, vertex)?;
        if self.is_held(tiles) {
            return Ok(false);
        }
        let new_line = self.new_line(tiles, vertex)?;
        if !self.fill(vertex.point) {
            return Err(tiles.damaged(id.tile, Contradiction::UnfitCavity));
        }
        if new_line.is_some() {
            for Spoke { end, .. } in &self.spokes {
                let ends = [vertex, *end];
                let taken = tiles.change(owner(ends))?.take_sources(ends.map(|end| end.id));
                taken.ok_or_else(|| tiles.damaged(id.tile, Contradiction::NoSource))?;
            }
        }
        exchange(&mut self.patch, tiles)?;
        tiles.change(id.tile)?.set_lone(id.index);
        if let Some((ends, sources)) = new_line {
            let given = tiles
                .change(owner(ends))?
                .give_sources(ends.map(|end| end.id), &sources);
            given.ok_or_else(|| tiles.damaged(id.tile, Contradiction::NoSource))?;
        }
        Ok(true)
    }

    /// Collects the triangles at a vertex, its link and the constraints between.
    fn gather(&mut self, tiles: &Tiles, vertex: EditVertex) -> Result<(), EditError> {
        self.patch.clear();
        self.link.clear();
        self.sides.clear();
        self.spokes.clear();
        let id = vertex.id;
        let tile = tiles.get(id.tile)?;
        let unfit = || tiles.damaged(id.tile, Contradiction::UnfitCavity);
        let first = tile.leaving(id.index).ok_or_else(unfit)?;
        let (start, _) = tile.rewind(first);
        let mut star = tile.star(start);
        let mut last = None;
        for half_edge in star.by_ref() {
            let (corners, bits) = tile.triangle(half_edge);
            let numbers = corners.map(|corner| self.patch.number(corner).0);
            let triangle = TriangleId(self.patch.old.len() as u32);
            self.note_spoke(corners[1], bits);
            self.link.push(numbers[1]);
            self.sides.push(HalfEdge::new(triangle, 1));
            self.patch
                .old
                .push(OldTriangle::new(numbers, bits, (tile.id, half_edge)));
            last = Some((numbers[2], corners[2], bits >> 2));
        }
        self.is_closed = match star.end() {
            Some(StarEnd::Closed) => true,
            Some(StarEnd::Hull(_)) => false,
            _ => return Err(unfit()),
        };
        if let Some((number, corner, bits)) = last.filter(|_| !self.is_closed) {
            self.note_spoke(corner, bits);
            self.link.push(number);
        }
        Ok(())
    }

    /// Notes an edge to the next vertex of the link, if it is a constraint. `bits` are those of its
    /// half-edge.
    fn note_spoke(&mut self, end: EditVertex, bits: u8) {
        let bits = bits & (1 | 1 << WALLS);
        if bits & 1 == 1 {
            self.spokes.push(Spoke {
                place: self.link.len(),
                end,
                bits,
                sources: Vec::new(),
            });
        }
    }

    fn find_sources(&mut self, tiles: &Tiles, vertex: EditVertex) -> Result<(), EditError> {
        for spoke in &mut self.spokes {
            let ends = [vertex, spoke.end];
            let tile = tiles.get(owner(ends))?;
            let sources = tile.sources_along(ends.map(|end| end.id));
            spoke.sources = sources.ok_or_else(|| tiles.damaged(tile.id, Contradiction::NoSource))?;
            spoke.sources.sort_unstable();
        }
        Ok(())
    }

    /// Returns whether a line holds the vertex: a segment ends there. Where lines were split at
    /// crossings and at borders of cells, these points are theirs as well, and not told apart.
    fn is_held(&self, tiles: &Tiles) -> bool {
        let is_split = tiles.directory().has_split_lines();
        let mut sources = self.spokes.iter().flat_map(|spoke| &spoke.sources);
        (is_split && !self.spokes.is_empty()) || sources.any(|part| part.begins())
    }

    /// Returns the edge that takes the place of two constraints on one line at the vertex, with the
    /// lines along it; `None` if no lines pass the vertex.
    fn new_line(&self, tiles: &Tiles, vertex: EditVertex) -> Result<Option<NewLine>, EditError> {
        let [one, other] = match &self.spokes[..] {
            [] => return Ok(None),
            [one, other] => [one, other],
            [one, others @ ..] => {
                let lines = others.iter().chain([one]).map(|spoke| spoke.sources[0].source());
                let first = one.sources[0].source();
                let second = lines
                    .clone()
                    .find(|line| line.number() != first.number())
                    .unwrap_or(first);
                return Err(EditError::LinesCross {
                    point: vertex.point,
                    lines: [first, second],
                });
            }
        };
        let pairs = one.sources.iter().map(|part| part.reversed());
        let mut towards: Vec<LinePart> = pairs.collect();
        towards.sort_unstable();
        let is_one_line = orient2d(one.end.point, vertex.point, other.end.point) == Orientation::Collinear
            && towards
                .iter()
                .map(|part| part.source())
                .eq(other.sources.iter().map(|part| part.source()));
        if !is_one_line {
            return Err(tiles.damaged(vertex.id.tile, Contradiction::NoSource));
        }
        let joined = towards
            .iter()
            .zip(&other.sources)
            .map(|(from, to)| LinePart::of(from.source(), from.begins(), to.ends()));
        Ok(Some(([one.end, other.end], joined.collect())))
    }

    /// Adds the new triangles to the patch. Returns false if the link is none.
    fn fill(&mut self, centre: Point) -> bool {
        let last = self.link.len() - 1;
        match (&self.spokes[..], self.is_closed) {
            ([], true) => {
                self.chain_from(last, self.link.len());
                self.chain.half_edges.push(self.sides[last]);
                let vertices = self.chain.vertices.iter();
                let points = vertices.map(|&vertex| self.patch.vertices[vertex as usize].point);
                let is_filled = self.cavity.triangulate_star(centre, points);
                if is_filled {
                    self.chain.fill(&mut self.patch, &self.cavity, false);
                }
                is_filled
            }
            ([], false) => self.fill_below_hull(),
            (&[Spoke { place: a, bits, .. }, Spoke { place: b, .. }], true) => {
                let around = self.link.len();
                let sides = [(b, b - a + 1), (a, around - (b - a) + 1)];
                let bases = sides.map(|(from, count)| self.fill_polygon(from, count));
                let [Some(one), Some(other)] = bases else { return false };
                for [base, twin] in [[one, other], [other, one]] {
                    self.patch.new[base.triangle().index()].set(base, PatchTwin::New(twin), bits);
                }
                true
            }
            (&[Spoke { place: 0, bits, .. }, Spoke { place, .. }], false) if place == last => {
                let Some(base) = self.fill_polygon(last, self.link.len()) else {
                    return false;
                };
                self.patch.new[base.triangle().index()].set(base, PatchTwin::Hull, bits);
                true
            }
            _ => false,
        }
    }

    /// Fills the polygons between the link and the new hull, which runs along convex vertices of the
    /// link. The other edges of the link become edges of the hull.
    fn fill_below_hull(&mut self) -> bool {
        let mut hull: Vec<usize> = Vec::new();
        let point = |this: &Self, place: usize| this.patch.vertices[this.link[place] as usize].point;
        for place in (0..self.link.len()).rev() {
            while let [.., before, top] = hull[..]
                && orient2d(point(self, before), point(self, top), point(self, place)) == Orientation::Clockwise
            {
                hull.pop();
            }
            hull.push(place);
        }
        for pair in hull.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            if from - to == 1 {
                self.patch.bared.push(self.sides[to]);
            } else if self.fill_polygon(from, from - to + 1).is_none() {
                return false;
            }
        }
        true
    }

    /// Fills the polygon between `count` vertices of the link, clockwise from a place on, and the
    /// edge between the first and the last of them. Returns the half-edge on that edge.
    fn fill_polygon(&mut self, from: usize, count: usize) -> Option<HalfEdge> {
        if count < 3 {
            return None;
        }
        self.chain_from(from, count);
        let vertices = self.chain.vertices.iter();
        let points = vertices.map(|&vertex| self.patch.vertices[vertex as usize].point);
        let is_filled = self.cavity.triangulate(points);
        is_filled.then(|| self.chain.fill(&mut self.patch, &self.cavity, false))
    }

    /// Makes the chain `count` vertices of the link, clockwise from a place on.
    fn chain_from(&mut self, from: usize, count: usize) {
        self.chain.clear();
        let around = self.link.len();
        for step in 0..count {
            let place = (from + around - step) % around;
            self.chain.vertices.push(self.link[place]);
            if step + 1 < count {
                self.chain.half_edges.push(self.sides[(place + around - 1) % around]);
            }
        }
    }
}
