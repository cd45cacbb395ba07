//! What a tile says of its vertices besides their points, and the removal of vertices.

use std::collections::BTreeSet;

use crate::edit::tile::hubs::Hubs;
use crate::edit::tile::{EditTile, GONE};
use crate::geometry::{PackedHalfEdge, VertexIndex};
use crate::mesh::Topology;
use crate::store::{LinePart, TileId, VertexId};

/// A vertex that took the place of a removed one.
#[derive(Debug, PartialEq)]
pub(crate) struct MovedVertex {
    pub(crate) from: VertexId,
    pub(crate) to: VertexId,
    /// The other tiles that have it as a corner.
    pub(crate) tiles: BTreeSet<TileId>,
}

/// The new index of a vertex that was removed.
const REMOVED: u32 = u32::MAX;

impl EditTile {
    /// Returns whether a point of the input lies at a vertex.
    pub(crate) fn is_input_point(&self, vertex: VertexIndex) -> bool {
        self.input_points.get(vertex.index()).copied().unwrap_or(true)
    }

    /// Sets whether a point of the input lies at a vertex.
    pub(crate) fn set_input_point(&mut self, vertex: VertexIndex, is_input_point: bool) {
        self.input_points.resize(self.points.len(), true);
        self.input_points[vertex.index()] = is_input_point;
    }

    pub(crate) fn record(&self, vertex: VertexIndex) -> u64 {
        self.records[vertex.index()]
    }

    pub(crate) fn set_record(&mut self, vertex: VertexIndex, record: u64) {
        self.records[vertex.index()] = record;
    }

    /// Sets the z of a vertex, the tile's own or a corner of another tile, in a file with z.
    pub(crate) fn set_z(&mut self, id: VertexId, z: f64) {
        if id.tile == self.id {
            self.z[id.index.index()] = z;
        } else if let Some(corner) = self.foreign_corners.get(&id) {
            self.foreign[corner.index() - self.points.len()].z = z;
        }
    }

    /// Returns the other tiles that have a vertex of this tile as a corner.
    pub(crate) fn tiles_at(&self, vertex: VertexIndex) -> BTreeSet<TileId> {
        let corners = self.around(vertex).flat_map(|half_edge| {
            let corners = [self.destination(half_edge), self.apex(half_edge)];
            corners.map(|corner| self.vertex(corner).id.tile)
        });
        corners.filter(|&tile| tile != self.id).collect()
    }

    /// Removes vertices that no triangle has. The last vertices take their places. Returns these.
    pub(crate) fn remove_vertices(&mut self, removed: &[VertexIndex]) -> Vec<MovedVertex> {
        let own = self.points.len() as u32;
        let left = own - removed.len() as u32;
        let mut new_index: Vec<u32> = (0..own).collect();
        removed.iter().for_each(|vertex| new_index[vertex.index()] = REMOVED);
        let mut holes: Vec<u32> = removed.iter().map(|vertex| vertex.0).filter(|&v| v < left).collect();
        holes.sort_unstable();
        let last = (left..own)
            .rev()
            .filter(|&vertex| new_index[vertex as usize] != REMOVED);
        let pairs: Vec<[u32; 2]> = last.zip(holes).map(|(from, to)| [from, to]).collect();
        let moved = pairs.iter().map(|pair| {
            let [from, to] = pair.map(|index| VertexId {
                tile: self.id,
                index: VertexIndex(index),
            });
            let tiles = self.tiles_at(from.index);
            MovedVertex { from, to, tiles }
        });
        let moved: Vec<MovedVertex> = moved.collect();
        for [from, to] in pairs {
            new_index[from as usize] = to;
            self.take_place(from as usize, to as usize);
        }
        self.cut_off(left as usize);
        self.renumber(&new_index, left);
        moved
    }

    /// Copies what the tile says of a vertex to another place.
    fn take_place(&mut self, from: usize, to: usize) {
        self.points[to] = self.points[from];
        self.records[to] = self.records[from];
        self.leaving[to] = self.leaving[from];
        if !self.z.is_empty() {
            self.z[to] = self.z[from];
        }
        if !self.input_points.is_empty() {
            self.input_points[to] = self.input_points[from];
        }
    }

    /// Forgets all vertices from a place on.
    fn cut_off(&mut self, left: usize) {
        self.points.truncate(left);
        self.records.truncate(left);
        self.leaving.truncate(left);
        self.z.truncate(left);
        self.input_points.truncate(left);
    }

    /// Renumbers corners: `new_index` has the new number of each of the tile's own, of which `left`
    /// are left.
    fn renumber(&mut self, new_index: &[u32], left: u32) {
        let own = new_index.len() as u32;
        let renumbered = |corner: VertexIndex| match new_index.get(corner.index()) {
            Some(&index) => VertexIndex(index),
            None => VertexIndex(corner.0 - own + left),
        };
        let triangles = self.triangles.iter_mut().filter(|corners| **corners != GONE);
        triangles.flatten().for_each(|corner| *corner = renumbered(*corner));
        let foreign = self.foreign_corners.values_mut();
        foreign.for_each(|corner| *corner = renumbered(*corner));
        // Edges at vertices that go are gone. Others may have taken their sources over.
        let is_left = |ends: [VertexIndex; 2]| ends.iter().all(|&end| renumbered(end).0 != REMOVED);
        let sources = std::mem::take(&mut self.sources);
        self.sources = sources
            .into_iter()
            .filter(|&(ends, _)| is_left(ends))
            .map(|(ends, mut sources)| {
                let [from, to] = ends.map(renumbered);
                if from < to {
                    return ([from, to], sources);
                }
                // They are seen from the smaller corner.
                sources.iter_mut().for_each(|part| *part = part.reversed());
                sources.sort_unstable();
                ([to, from], sources)
            })
            .collect();
        self.source_count = self.sources.values().map(Vec::len).sum();
        let ids = if self.site_ids.is_empty() {
            vec![String::new(); self.sites.len()]
        } else {
            std::mem::take(&mut self.site_ids)
        };
        let sites = self.sites.iter().zip(ids);
        let mut sites: Vec<((u32, u64), String)> = sites
            .map(|(&(vertex, number), id)| ((new_index[vertex as usize], number), id))
            .collect();
        sites.sort_unstable();
        let has_ids = sites.iter().any(|(_, id)| !id.is_empty());
        (self.sites, self.site_ids) = sites.into_iter().unzip();
        if !has_ids {
            self.site_ids.clear();
        }
        self.hubs = Hubs::of(left as usize, &self.triangles);
    }

    /// Gives a corner that another tile owns the new id of its vertex.
    pub(crate) fn rename(&mut self, from: VertexId, to: VertexId) {
        if let Some(corner) = self.foreign_corners.remove(&from) {
            self.foreign[corner.index() - self.points.len()].id = to;
            self.foreign_corners.insert(to, corner);
        }
    }

    /// Returns the sources of an edge of the tile, as seen from its first end.
    pub(crate) fn sources_along(&self, ends: [VertexId; 2]) -> Option<Vec<LinePart>> {
        let [from, to] = ends.map(|id| self.corner(id));
        let [from, to] = [from?, to?];
        let sources = self.sources.get(&[from.min(to), from.max(to)])?;
        let seen = |part: &LinePart| if from < to { *part } else { part.reversed() };
        Some(sources.iter().map(seen).collect())
    }

    /// Makes a vertex have no triangle.
    pub(crate) fn set_lone(&mut self, vertex: VertexIndex) {
        self.leaving[vertex.index()] = PackedHalfEdge::NONE;
    }
}
