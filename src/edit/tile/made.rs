//! Tiles made of the vertices and triangles of others: a part of a tile, or two tiles in one.

use foldhash::{HashMap, HashMapExt, HashSet, HashSetExt};

use crate::edit::tile::EditTile;
use crate::edit::tile::hubs::Hubs;
use crate::edit::vertex::{EditVertex, owner};
use crate::geometry::{HalfEdge, TriangleId, VertexIndex};
use crate::mesh::{Topology, Twin};
use crate::store::{DigestSum, LinePart, TileId, VertexId};

/// The new ids of vertices. All others keep theirs.
pub(crate) type Renamed = HashMap<VertexId, VertexId>;

/// A tile that is made of others. It first gets all its vertices, and then the triangles of each
/// of these tiles.
pub(crate) struct MadeTile<'a> {
    tile: EditTile,
    renamed: &'a Renamed,
    /// The tiles whose triangles it has.
    complete: Vec<TileId>,
    /// All half-edges, by the corners at their ends.
    half_edges: HashMap<[VertexIndex; 2], HalfEdge>,
    /// Those that are on the hull.
    hull: HashSet<[VertexIndex; 2]>,
}

impl<'a> MadeTile<'a> {
    /// Starts a tile. `renamed` has the new ids of the vertices that change theirs.
    pub(crate) fn new(id: TileId, renamed: &'a Renamed) -> Self {
        Self {
            tile: EditTile::empty(id),
            renamed,
            complete: Vec::new(),
            half_edges: HashMap::new(),
            hull: HashSet::new(),
        }
    }

    /// Adds vertices of a tile.
    pub(crate) fn add_vertices(&mut self, from: &EditTile, vertices: impl Iterator<Item = VertexIndex>) {
        let tile = &mut self.tile;
        for vertex in vertices {
            let new = VertexIndex(tile.points.len() as u32);
            tile.points.push(from.points[vertex.index()]);
            tile.z.extend(from.z.get(vertex.index()));
            tile.records.push(from.records[vertex.index()]);
            if !from.is_input_point(vertex) || !tile.input_points.is_empty() {
                tile.set_input_point(new, from.is_input_point(vertex));
            }
            for place in from.sites_at(vertex) {
                let id = from.site_ids.get(place).map_or("", String::as_str);
                tile.add_site(new, from.sites[place].1, id);
            }
        }
    }

    /// Adds the triangles of a tile that have a vertex of the new one, and the sources of its
    /// edges.
    pub(crate) fn add_triangles(&mut self, from: &EditTile) {
        self.tile.leaving.resize(self.tile.points.len(), None.into());
        for triangle in from.triangle_ids().filter(|&triangle| !from.is_removed(triangle)) {
            let half_edges = HalfEdge::of_triangle(triangle);
            let before = half_edges.map(|half_edge| from.origin_vertex(half_edge));
            let corners = before.map(|vertex| self.renamed(vertex));
            if corners.iter().all(|vertex| vertex.id.tile != self.tile.id) {
                continue;
            }
            let is_there = before.iter().any(|vertex| self.complete.contains(&vertex.id.tile));
            let corners = corners.map(|vertex| self.tile.corner_for(vertex));
            if !is_there {
                self.add_triangle(corners, from.bits[triangle.index()]);
            }
            let on_hull = half_edges
                .iter()
                .filter(|&&half_edge| from.twin(half_edge) == Twin::Hull);
            self.hull.extend(on_hull.map(|half_edge| {
                let s = half_edge.corner() as usize;
                [corners[s], corners[(s + 1) % 3]]
            }));
        }
        self.add_sources(from);
        self.complete.push(from.id);
    }

    fn renamed(&self, vertex: EditVertex) -> EditVertex {
        let id = self.renamed.get(&vertex.id).copied().unwrap_or(vertex.id);
        EditVertex { id, ..vertex }
    }

    fn add_triangle(&mut self, corners: [VertexIndex; 3], bits: u8) {
        let triangle = TriangleId(self.tile.triangles.len() as u32);
        self.tile.triangles.push(corners);
        self.tile.bits.push(bits);
        self.tile.count_in(triangle);
        for (s, half_edge) in HalfEdge::of_triangle(triangle).into_iter().enumerate() {
            self.half_edges.insert([corners[s], corners[(s + 1) % 3]], half_edge);
            if let Some(leaving) = self.tile.leaving.get_mut(corners[s].index()) {
                *leaving = half_edge.into();
            }
        }
    }

    /// Adds the sources of the edges of a tile that belong to the new one.
    fn add_sources(&mut self, from: &EditTile) {
        for (ends, parts) in &from.sources {
            let ends = ends.map(|corner| self.renamed(from.vertex(corner)));
            if owner(ends) == self.tile.id {
                let parts: &[LinePart] = parts;
                let given = self.tile.give_sources(ends.map(|end| end.id), parts);
                debug_assert!(given.is_some(), "the tile has the triangles at its edges");
            }
        }
    }

    /// Links the triangles and returns the tile.
    pub(crate) fn finish(self) -> EditTile {
        let Self {
            mut tile,
            half_edges,
            hull,
            ..
        } = self;
        tile.twins = vec![[Twin::Elsewhere.into(); 3]; tile.triangles.len()];
        for (&[from, to], &half_edge) in &half_edges {
            let twin = match half_edges.get(&[to, from]) {
                Some(&twin) => Twin::HalfEdge(twin),
                // Between vertices of other tiles, these alone know that it is on the hull.
                None if hull.contains(&[from, to]) && from.min(to).index() < tile.points.len() => Twin::Hull,
                None => Twin::Elsewhere,
            };
            tile.twins.as_flattened_mut()[half_edge.index()] = twin.into();
        }
        tile.hubs = Hubs::of(tile.points.len(), &tile.triangles);
        tile
    }
}

impl EditTile {
    /// Creates a tile without vertices.
    pub(crate) fn empty(id: TileId) -> Self {
        Self {
            id,
            points: Vec::new(),
            z: Vec::new(),
            records: Vec::new(),
            input_points: Vec::new(),
            sites: Vec::new(),
            site_ids: Vec::new(),
            foreign: Vec::new(),
            foreign_corners: HashMap::new(),
            triangles: Vec::new(),
            twins: Vec::new(),
            bits: Vec::new(),
            owned: Some(DigestSum::default()),
            free: Vec::new(),
            leaving: Vec::new(),
            hubs: Hubs::default(),
            sources: HashMap::new(),
            source_count: 0,
        }
    }

    /// Returns the other tiles that have a triangle of this tile.
    pub(crate) fn neighbours(&self) -> HashSet<TileId> {
        self.foreign_in_use()
            .map(|corner| self.vertex(corner).id.tile)
            .collect()
    }

    /// Gives corners that other tiles own the new ids of their vertices.
    pub(crate) fn rename_all(&mut self, renamed: &Renamed) {
        let in_use: Vec<VertexIndex> = self.foreign_in_use().collect();
        // Vertices that are no corners any more may have the ids of others now.
        self.foreign_corners.clear();
        for corner in in_use {
            let vertex = &mut self.foreign[corner.index() - self.points.len()];
            vertex.id = renamed.get(&vertex.id).copied().unwrap_or(vertex.id);
            self.foreign_corners.insert(vertex.id, corner);
        }
    }

    /// Returns the vertices of other tiles that are corners, each once.
    fn foreign_in_use(&self) -> impl Iterator<Item = VertexIndex> + use<> {
        let own = self.points.len();
        let mut is_used = vec![false; self.foreign.len()];
        for corner in self.triangles.as_flattened() {
            // The corners of removed triangles are beyond all.
            if let Some(index) = corner.index().checked_sub(own)
                && let Some(is_used) = is_used.get_mut(index)
            {
                *is_used = true;
            }
        }
        let corners = is_used.into_iter().zip((own as u32..).map(VertexIndex));
        corners.filter_map(|(is_used, corner)| is_used.then_some(corner))
    }
}
