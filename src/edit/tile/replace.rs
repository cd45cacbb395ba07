//! Replacement of triangles of a tile by others.

use std::iter;

use crate::edit::contradiction::Contradiction;
use crate::edit::patch::{NewTriangle, OldPosition, Patch, PatchTwin, TilePositions, TileShare};
use crate::edit::tile::room::make_room;
use crate::edit::tile::{EditTile, GONE, REMOVED};
use crate::edit::vertex::EditVertex;
use crate::geometry::{HalfEdge, PackedHalfEdge, TriangleId, VertexIndex};
use crate::mesh::{Topology, Twin};
use crate::store::VertexId;

/// A new triangle whose first half-edge runs between two vertices of other tiles. Its twin
/// must be looked up in another tile.
pub(crate) type Unlinked = [VertexId; 3];

impl EditTile {
    /// Removes the old triangles of the tile's share of a patch, which it must have, and adds the
    /// new ones. Returns the triangles whose first half-edge may have a twin in the tile that only
    /// other tiles know.
    ///
    /// ```text
    ///      u ─── v            u ─── v        Edges around stay, with their twins. A twin
    ///    ╱  ╲   ╱  ╲    →   ╱    ╱    ╲      outside the tile is marked as such.
    ///   a ──── w ── b      a ════════ b
    /// ```
    pub(crate) fn replace(
        &mut self,
        patch: &Patch,
        share: &TileShare,
        positions: &mut TilePositions,
    ) -> Result<Vec<Unlinked>, Contradiction> {
        let TileShare { old, new, .. } = share;
        self.find_staying(patch, new, positions);
        self.take_out(patch, old, positions)?;
        self.put_in(patch, new, positions);
        let unlinked = self.join(patch, new, positions);
        // The twin of a half-edge at the boundary may now be in a triangle without a vertex in this
        // tile.
        for (replacement, twin) in replaced_at_boundary(patch, old, positions) {
            if positions.half_edge_of_new(replacement).is_none() {
                self.set_twin(twin, Twin::Elsewhere);
            }
        }
        self.bare(patch, positions);
        self.make_hubs(positions, new);
        Ok(unlinked)
    }

    /// Records the half-edges of triangles that stay, at edges that were on the hull.
    fn find_staying(&self, patch: &Patch, new: &[TriangleId], positions: &mut TilePositions) {
        for &number in new {
            let NewTriangle { corners, twins, .. } = &patch.new[number.index()];
            for (s, half_edge) in HalfEdge::of_triangle(number).into_iter().enumerate() {
                if twins[s] != PatchTwin::Stays {
                    continue;
                }
                let ends = [corners[(s + 1) % 3], corners[s]].map(|end| patch.vertices[end as usize].id);
                if ends.iter().any(|end| end.tile == self.id)
                    && let Some(staying) = self.half_edge_between(ends[0], ends[1])
                {
                    positions.staying.push((half_edge, staying));
                }
            }
        }
    }

    /// Makes edges hull edges from which the triangles on one side are removed. A vertex that had a
    /// removed triangle as its way into its star gets another one there, or none.
    fn bare(&mut self, patch: &Patch, positions: &TilePositions) {
        if patch.bared.is_empty() {
            return;
        }
        for &old in &patch.bared {
            let Some(twin) = positions.twin_of_old(old).and_then(Twin::half_edge) else {
                continue;
            };
            self.set_twin(twin, self.outside_of(twin));
            for half_edge in [twin, twin.next()] {
                let corner = self.origin(half_edge);
                if corner.index() < self.leaving.len() && !self.leaves(corner) {
                    self.leaving[corner.index()] = half_edge.into();
                }
            }
        }
        let of_old = |&number: &u32| patch.vertices[number as usize].id;
        for id in patch.old.iter().flat_map(|old| &old.corners).map(of_old) {
            if id.tile == self.id && !self.leaves(id.index) {
                self.leaving[id.index.index()] = PackedHalfEdge::NONE;
            }
        }
    }

    /// Returns the twin of a half-edge on the hull. Between vertices of other tiles, these alone know
    /// that it is on the hull.
    fn outside_of(&self, half_edge: HalfEdge) -> Twin {
        match self.origin(half_edge).min(self.destination(half_edge)).index() < self.points.len() {
            true => Twin::Hull,
            false => Twin::Elsewhere,
        }
    }

    /// Returns whether the half-edge that is said to leave a vertex does.
    fn leaves(&self, vertex: VertexIndex) -> bool {
        let half_edge = self.leaving[vertex.index()].get();
        half_edge.is_some_and(|half_edge| self.origin(half_edge) == vertex)
    }

    /// Removes old triangles, and records their positions and twins.
    fn take_out(
        &mut self,
        patch: &Patch,
        old: &[TriangleId],
        positions: &mut TilePositions,
    ) -> Result<(), Contradiction> {
        for &number in old {
            let triangle = &patch.old[number.index()];
            let corners = patch.ids(triangle.corners);
            let (tile, found) = triangle.found;
            let found = (tile == self.id && self.is_at(found, corners)).then_some(found);
            let first = found
                .or_else(|| self.half_edge_of(corners))
                .ok_or(Contradiction::MissingTriangle)?;
            self.bits[first.triangle().index()] |= REMOVED;
            let twins = [first, first.next(), first.prev()].map(|half_edge| self.twin(half_edge));
            positions.old[number.index()] = Some(OldPosition { first, twins });
        }
        if replaced_at_boundary(patch, old, positions)
            .any(|(_, twin)| self.bits[twin.triangle().index()] & REMOVED != 0)
        {
            return Err(Contradiction::UnfitStrip);
        }
        for position in old
            .iter()
            .rev()
            .filter_map(|&number| positions.old[number.index()].as_ref())
        {
            let triangle = position.first.triangle();
            self.free.push(triangle);
            self.count_out(triangle);
            let corners = std::mem::replace(&mut self.triangles[triangle.index()], GONE);
            self.hubs.remove(corners);
        }
        Ok(())
    }

    /// Adds new triangles, and records their positions.
    fn put_in(&mut self, patch: &Patch, new: &[TriangleId], positions: &mut TilePositions) {
        let more = new.len().saturating_sub(self.free.len());
        make_room(&mut self.triangles, more);
        make_room(&mut self.twins, more);
        make_room(&mut self.bits, more);
        for &number in new {
            let NewTriangle { corners, bits, .. } = patch.new[number.index()];
            let corners = corners.map(|corner| self.corner_for(patch.vertices[corner as usize]));
            let triangle = self.free.pop().unwrap_or(TriangleId(self.triangles.len() as u32));
            if triangle.index() == self.triangles.len() {
                self.triangles.push(corners);
                self.twins.push([Twin::Hull.into(); 3]);
                self.bits.push(bits);
            } else {
                self.triangles[triangle.index()] = corners;
                self.bits[triangle.index()] = bits;
            }
            self.count_in(triangle);
            positions.new[number.index()] = Some(triangle);
            self.hubs.add(corners, triangle);
            for (half_edge, corner) in iter::zip(HalfEdge::of_triangle(triangle), corners) {
                if let Some(leaving) = self.leaving.get_mut(corner.index()) {
                    *leaving = half_edge.into();
                }
            }
        }
    }

    /// Links new triangles with each other and with those that stay. Returns the triangles for
    /// which another tile is needed.
    fn join(&mut self, patch: &Patch, new: &[TriangleId], positions: &TilePositions) -> Vec<Unlinked> {
        let mut unlinked = Vec::new();
        for &number in new {
            let half_edges = positions.new[number.index()]
                .into_iter()
                .flat_map(HalfEdge::of_triangle);
            for (half_edge, &patch_twin) in half_edges.zip(&patch.new[number.index()].twins) {
                let twin = match patch_twin {
                    PatchTwin::New(twin) => positions.half_edge_of_new(twin).map_or(Twin::Elsewhere, Twin::HalfEdge),
                    PatchTwin::Old(old) => positions.twin_of_old(old).unwrap_or_else(|| {
                        unlinked.push(self.triangle(half_edge).0.map(|vertex| vertex.id));
                        Twin::Elsewhere
                    }),
                    PatchTwin::Stays => match positions.staying_at(HalfEdge::new(number, half_edge.corner())) {
                        Some(staying) => Twin::HalfEdge(staying),
                        None => {
                            unlinked.push(self.triangle(half_edge).0.map(|vertex| vertex.id));
                            Twin::Elsewhere
                        }
                    },
                    PatchTwin::Hull => self.outside_of(half_edge),
                };
                self.set_twin(half_edge, twin);
                if let Twin::HalfEdge(twin) = twin {
                    self.set_twin(twin, Twin::HalfEdge(half_edge));
                }
            }
        }
        unlinked
    }

    /// Makes corners of new triangles hubs if they have enough triangles now.
    fn make_hubs(&mut self, positions: &TilePositions, new: &[TriangleId]) {
        for triangle in new.iter().filter_map(|&number| positions.new[number.index()]) {
            for corner in self.triangles[triangle.index()] {
                if !self.hubs.is_new(corner) {
                    continue;
                }
                self.hubs.make(corner);
                let triangles: Vec<TriangleId> = self.around(corner).map(HalfEdge::triangle).collect();
                for triangle in triangles {
                    self.hubs.enter(self.triangles[triangle.index()], triangle);
                }
            }
        }
    }

    /// Returns whether a triangle with these corners has `half_edge` as its first half-edge.
    fn is_at(&self, half_edge: HalfEdge, corners: [VertexId; 3]) -> bool {
        let triangle = self.triangles.get(half_edge.triangle().index());
        let Some(triangle) = triangle.filter(|&&triangle| triangle != GONE) else {
            return false;
        };
        let own = self.points.len();
        corners
            .iter()
            .zip([half_edge, half_edge.next(), half_edge.prev()])
            .all(|(&id, half_edge)| {
                let corner = triangle[half_edge.corner() as usize];
                match corner.index().checked_sub(own) {
                    None => id.index == corner && id.tile == self.id,
                    Some(index) => self.foreign[index].id == id,
                }
            })
    }

    /// Links two triangles of the tile: one by its first half-edge, and the one at the same edge
    /// that has this apex.
    pub(crate) fn link(&mut self, corners: Unlinked, apex: VertexId) -> Result<(), Contradiction> {
        let [from, to, _] = corners;
        let [Some(half_edge), Some(other)] = [corners, [to, from, apex]].map(|corners| self.half_edge_of(corners))
        else {
            return Err(Contradiction::MissingTriangle);
        };
        self.set_twin(half_edge, Twin::HalfEdge(other));
        self.set_twin(other, Twin::HalfEdge(half_edge));
        Ok(())
    }

    fn set_twin(&mut self, half_edge: HalfEdge, twin: Twin) {
        self.twins.as_flattened_mut()[half_edge.index()] = twin.into();
    }

    /// Returns the corner of a vertex. Adds it if the tile does not have it yet.
    pub(super) fn corner_for(&mut self, vertex: EditVertex) -> VertexIndex {
        if let Some(corner) = self.corner(vertex.id) {
            // Where the id is that of no corner at the moment, its vertex may have got another z
            // meanwhile, or another one may have got its number.
            if let Some(index) = corner.index().checked_sub(self.points.len()) {
                self.foreign[index] = vertex;
            }
            return corner;
        }
        let corner = VertexIndex((self.points.len() + self.foreign.len()) as u32);
        make_room(&mut self.foreign, 1);
        self.foreign.push(vertex);
        self.foreign_corners.insert(vertex.id, corner);
        corner
    }
}

/// Returns the half-edges of the tile that are twins at the boundary of a patch, each with the new
/// half-edge of the patch that replaces the old one there.
fn replaced_at_boundary(
    patch: &Patch,
    old: &[TriangleId],
    positions: &TilePositions,
) -> impl Iterator<Item = (HalfEdge, HalfEdge)> {
    let half_edges = old.iter().flat_map(|&number| {
        let replacements = patch.old[number.index()].replacement;
        let twins = positions.old[number.index()].iter().flat_map(|position| position.twins);
        twins.zip(replacements)
    });
    half_edges.filter_map(|(twin, replacement)| Some((replacement?, twin.half_edge()?)))
}
