//! Parts of tiles. A part is formatted at once, so that no text exceeds a mebibyte, however large
//! the tile is.

use std::ops::Range;
use std::sync::Arc;

use super::error::Contradiction;
use super::numbering::Numbering;
use super::what::CutBy;
use crate::geometry::{TriangleId, VertexIndex};
use crate::store::{ReadError, TileEdge, TileInPass};
use crate::terrain::TileSurface;

/// The number of vertices, triangles or edges in a part.
const PART: u32 = 2048;

/// The limit on the bytes of a formatted part: no vertex and no triangle takes more than 512 bytes
/// in any format.
pub(super) const CHUNK_BYTES: u64 = 512 * PART as u64;

/// Some of the vertices, triangles or edges of a tile.
pub(super) struct TilePart {
    pub(super) tile: Arc<TileInPass>,
    /// The surface in the tile, if this is a part of its triangles.
    surface: Option<Arc<TileSurface>>,
    /// The indices of the elements in the tile.
    pub(super) range: Range<u32>,
    /// The number of elements to be written.
    pub(super) written: u32,
    /// The number of elements written before these, over all tiles.
    pub(super) written_before: u64,
    /// Whether this is the last part of its tile.
    pub(super) is_last: bool,
}

impl TilePart {
    /// Calls `take` with each triangle that is written, its corners and the numbers of the corners.
    pub(super) fn for_each_triangle(
        &self,
        numbering: &Numbering,
        mut take: impl FnMut(TriangleId, [VertexIndex; 3], [u64; 3]) -> Result<(), Contradiction>,
    ) -> Result<(), Contradiction> {
        let tile = &self.tile;
        let start = numbering.start(tile);
        for triangle in self.triangles(numbering) {
            let corners = tile.corners(triangle);
            let mut numbers = corners.map(|corner| start + u64::from(corner.0));
            for (corner, number) in corners.into_iter().zip(&mut numbers) {
                if !tile.has_vertex(corner) {
                    *number = numbering.number(tile.vertex(corner).id)?;
                }
            }
            take(triangle, corners, numbers)?;
        }
        Ok(())
    }

    /// Returns the triangles that are written.
    fn triangles<'a>(&'a self, numbering: &'a Numbering) -> impl Iterator<Item = TriangleId> + 'a {
        let surface = self.surface.as_deref().into_iter();
        surface.flat_map(move |surface| {
            let triangles = self.range.clone().map(TriangleId);
            triangles.filter(move |&triangle| numbering.is_written(&self.tile, surface, triangle))
        })
    }

    /// Returns the vertices, with their numbers over the whole file.
    pub(super) fn vertices(&self, numbering: &Numbering) -> impl Iterator<Item = (VertexIndex, u64)> + use<> {
        let start = numbering.start(&self.tile);
        let vertices = self.range.clone();
        vertices.map(move |vertex| (VertexIndex(vertex), start + u64::from(vertex)))
    }

    /// Returns the vertices that are written as features, with their numbers.
    pub(super) fn points<'a>(&'a self, numbering: &'a Numbering) -> impl Iterator<Item = (VertexIndex, u64)> + 'a {
        let vertices = self.vertices(numbering);
        vertices.filter(|&(vertex, _)| numbering.writes_point(&self.tile, vertex))
    }

    /// Returns the constraint edges that are written.
    pub(super) fn edges<'a>(&'a self, numbering: &'a Numbering) -> impl Iterator<Item = TileEdge> + 'a {
        let edges = self.tile.owned_constraints().skip(self.range.start as usize);
        edges
            .take(self.range.len())
            .filter(|&edge| numbering.writes_edge(&self.tile, edge))
    }
}

impl Numbering {
    /// Cuts a tile into parts, at least one. Fails if the tile and the directory disagree on whether
    /// there is a z, or, if it is cut by triangles, on the number of triangles that it owns.
    pub(super) fn cut(&self, tile: &Arc<TileInPass>, cut: CutBy) -> Result<Vec<TilePart>, ReadError> {
        if tile.has_z() != self.reader().metadata().has_z {
            return Err(self.damaged(tile.id(), Contradiction::HasZ));
        }
        let count = match cut {
            CutBy::Vertices | CutBy::Points => tile.vertex_count(),
            CutBy::Triangles => tile.triangle_count(),
            CutBy::Edges => tile.owned_constraints().count() as u32,
        };
        let owned = match cut {
            CutBy::Triangles => self.check_owned(tile)?,
            // In a file without triangles, no tile may have any either.
            CutBy::Points if self.reader().metadata().triangles == 0 => self.check_owned(tile)?,
            _ => 0,
        };
        let all_in_part = owned == tile.triangle_count() && self.writes_all(CutBy::Triangles);
        let surface = (cut == CutBy::Triangles).then(|| Arc::new(self.surface().in_tile(tile)));
        let mut parts = Vec::new();
        for start in (0..count.max(1)).step_by(PART as usize) {
            let range = start..count.min(start.saturating_add(PART));
            let mut part = TilePart {
                tile: Arc::clone(tile),
                surface: surface.clone(),
                is_last: range.end == count,
                written: range.end - range.start,
                range,
                written_before: 0,
            };
            part.written = match cut {
                CutBy::Vertices => part.written,
                CutBy::Triangles if all_in_part => part.written,
                CutBy::Triangles => part.triangles(self).count() as u32,
                CutBy::Points if self.writes_all(cut) => part.written,
                CutBy::Points => part.points(self).count() as u32,
                CutBy::Edges => part.edges(self).count() as u32,
            };
            parts.push(part);
        }
        Ok(parts)
    }

    /// Returns the number of triangles that a tile owns. Fails if the directory says another number.
    fn check_owned(&self, tile: &TileInPass) -> Result<u32, ReadError> {
        let owned = tile.core_triangle_count() + tile.border_triangle_ids().filter(|&t| tile.owns(t)).count() as u32;
        let expected = self.reader().directory().tiles[tile.id().0 as usize].owned_triangles;
        if owned == expected {
            return Ok(owned);
        }
        let reason = format!("it owns {owned} triangles, but the directory says {expected}");
        Err(self.reader().damaged(tile.id(), reason))
    }
}
