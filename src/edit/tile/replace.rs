//! Takes triangles out of a tile, and puts others in their place.

use std::iter;

use crate::edit::contradiction::Contradiction;
use crate::edit::patch::{Beside, New, Patch, Seat, Seats, Share};
use crate::edit::tile::{EditTile, GONE, REMOVED, make_room};
use crate::geometry::{HalfEdge, TriangleId, VertexIndex};
use crate::mesh::{Topology, Twin};
use crate::store::{Vertex, VertexId};

/// A new triangle whose first side runs between two vertices of other tiles: what lies across must be looked for elsewhere.
pub(crate) type Unlinked = [VertexId; 3];

impl EditTile {
    /// Takes the old triangles of its share of a patch out, which it must have, and puts the new ones in their place. Returns those that
    /// have a side, their first, across which another triangle of the tile may lie that only other tiles can tell.
    ///
    /// ```text
    ///      u ─── v            u ─── v        edges around stay, and what lies across them;
    ///    ╱  ╲   ╱  ╲    →   ╱    ╱    ╲      what is outside the tile on one side is so marked
    ///   a ──── w ── b      a ════════ b
    /// ```
    pub(crate) fn replace(
        &mut self,
        patch: &Patch,
        share: &Share,
        at: &mut Seats,
    ) -> Result<Vec<Unlinked>, Contradiction> {
        let Share { old, new, .. } = share;
        self.take_out(patch, old, at)?;
        self.put_in(patch, new, at);
        let unlinked = self.join(patch, new, at);
        // What lay across old triangles of the tile may lie across new ones that have no vertex here.
        for (follower, twin) in followed(patch, old, at) {
            if at.of_new(follower).is_none() {
                self.set_twin(twin, Twin::Elsewhere);
            }
        }
        self.make_hubs(at, new);
        Ok(unlinked)
    }

    /// Takes old triangles out, and notes where they were and what lay across.
    fn take_out(&mut self, patch: &Patch, old: &[TriangleId], at: &mut Seats) -> Result<(), Contradiction> {
        for &number in old {
            let triangle = &patch.old[number.index()];
            let corners = patch.ids(triangle.corners);
            let (tile, found) = triangle.found;
            let found = (tile == self.id && self.is_at(found, corners)).then_some(found);
            let first = found
                .or_else(|| self.side_of(corners))
                .ok_or(Contradiction::MissingTriangle)?;
            self.bits[first.triangle().index()] |= REMOVED;
            let twins = [first, first.next(), first.prev()].map(|side| self.twin(side));
            at.old[number.index()] = Some(Seat { first, twins });
        }
        if followed(patch, old, at).any(|(_, twin)| self.bits[twin.triangle().index()] & REMOVED != 0) {
            return Err(Contradiction::UnfitStrip);
        }
        for seat in old.iter().rev().filter_map(|&number| at.old[number.index()].as_ref()) {
            let place = seat.first.triangle();
            self.free.push(place);
            let corners = std::mem::replace(&mut self.triangles[place.index()], GONE);
            self.hubs.remove(corners);
        }
        Ok(())
    }

    /// Puts new triangles in, and notes where they are.
    fn put_in(&mut self, patch: &Patch, new: &[TriangleId], at: &mut Seats) {
        let more = new.len().saturating_sub(self.free.len());
        make_room(&mut self.triangles, more);
        make_room(&mut self.twins, more);
        make_room(&mut self.bits, more);
        for &number in new {
            let New { corners, bits, .. } = patch.new[number.index()];
            let corners = corners.map(|corner| self.corner_for(patch.vertices[corner as usize]));
            let place = self.free.pop().unwrap_or(TriangleId(self.triangles.len() as u32));
            if place.index() == self.triangles.len() {
                self.triangles.push(corners);
                self.twins.push([Twin::Hull.into(); 3]);
                self.bits.push(bits);
            } else {
                self.triangles[place.index()] = corners;
                self.bits[place.index()] = bits;
            }
            at.new[number.index()] = Some(place);
            self.hubs.add(corners, place);
            for (side, corner) in iter::zip(HalfEdge::of_triangle(place), corners) {
                if let Some(leaving) = self.leaving.get_mut(corner.index()) {
                    *leaving = side.into();
                }
            }
        }
    }

    /// Puts new triangles side by side with each other and with those that stay. Returns those that other tiles must help to.
    fn join(&mut self, patch: &Patch, new: &[TriangleId], at: &Seats) -> Vec<Unlinked> {
        let own = self.points.len() as u32;
        let mut unlinked = Vec::new();
        for &number in new {
            let sides = at.new[number.index()].into_iter().flat_map(HalfEdge::of_triangle);
            for (side, &beside) in sides.zip(&patch.new[number.index()].across) {
                let twin = match beside {
                    Beside::New(twin) => at.of_new(twin).map_or(Twin::Elsewhere, Twin::HalfEdge),
                    Beside::Old(old) => at.beside_old(old).unwrap_or_else(|| {
                        unlinked.push(self.triangle(side).0.map(|vertex| vertex.id));
                        Twin::Elsewhere
                    }),
                    Beside::Hull if self.origin(side).min(self.destination(side)).0 < own => Twin::Hull,
                    Beside::Hull => Twin::Elsewhere,
                };
                self.set_twin(side, twin);
                if let Twin::HalfEdge(twin) = twin {
                    self.set_twin(twin, Twin::HalfEdge(side));
                }
            }
        }
        unlinked
    }

    /// Makes those corners of new triangles hubs that have become so.
    fn make_hubs(&mut self, at: &Seats, new: &[TriangleId]) {
        for place in new.iter().filter_map(|&number| at.new[number.index()]) {
            for corner in self.triangles[place.index()] {
                if !self.hubs.is_new(corner) {
                    continue;
                }
                self.hubs.make(corner);
                let places: Vec<TriangleId> = self.around(corner).map(HalfEdge::triangle).collect();
                for place in places {
                    self.hubs.enter(self.triangles[place.index()], place);
                }
            }
        }
    }

    /// Whether a triangle with these corners has its first side there.
    fn is_at(&self, side: HalfEdge, corners: [VertexId; 3]) -> bool {
        let triangle = self.triangles.get(side.triangle().index());
        let Some(triangle) = triangle.filter(|&&triangle| triangle != GONE) else {
            return false;
        };
        let own = self.points.len();
        corners.iter().zip([side, side.next(), side.prev()]).all(|(&id, at)| {
            let corner = triangle[at.corner() as usize];
            match corner.index().checked_sub(own) {
                None => id.index == corner && id.tile == self.id,
                Some(place) => self.foreign[place].id == id,
            }
        })
    }

    /// Puts two triangles of the tile side by side: one by its first side, and the one across that has this apex.
    pub(crate) fn link(&mut self, corners: Unlinked, apex: VertexId) -> Result<(), Contradiction> {
        let [from, to, _] = corners;
        let [Some(side), Some(other)] = [corners, [to, from, apex]].map(|corners| self.side_of(corners)) else {
            return Err(Contradiction::MissingTriangle);
        };
        self.set_twin(side, Twin::HalfEdge(other));
        self.set_twin(other, Twin::HalfEdge(side));
        Ok(())
    }

    fn set_twin(&mut self, side: HalfEdge, twin: Twin) {
        self.twins.as_flattened_mut()[side.index()] = twin.into();
    }

    /// The corner that a vertex is here, and is to be if it is none yet.
    fn corner_for(&mut self, vertex: Vertex) -> VertexIndex {
        if let Some(corner) = self.corner(vertex.id) {
            return corner;
        }
        let corner = VertexIndex((self.points.len() + self.foreign.len()) as u32);
        make_room(&mut self.foreign, 1);
        self.foreign.push(vertex);
        self.foreign_places.insert(vertex.id, corner);
        corner
    }
}

/// The half-edges of the tile across the boundary of a patch, each with the new half-edge of the patch that follows the old one there.
fn followed(patch: &Patch, old: &[TriangleId], at: &Seats) -> impl Iterator<Item = (HalfEdge, HalfEdge)> {
    let sides = old.iter().flat_map(|&number| {
        let followers = patch.old[number.index()].follower;
        let twins = at.old[number.index()].iter().flat_map(|seat| seat.twins);
        twins.zip(followers)
    });
    sides.filter_map(|(twin, follower)| Some((follower?, twin.half_edge()?)))
}
