//! Flips of edges until the constrained Delaunay property holds again.
//!
//! ```text
//!       c               c
//!     ╱   ╲           ╱ │ ╲
//!    a ─── b    →    a  │  b     d lies in the circle of a, b and c.
//!     ╲   ╱           ╲ │ ╱
//!       d               d
//! ```

use crate::edit::error::EditError;
use crate::edit::exchange::exchange;
use crate::edit::patch::{NewTriangle, OldTriangle, Patch, PatchTwin};
use crate::edit::tiles::Tiles;
use crate::geometry::{HalfEdge, TriangleId, in_circle};
use crate::mesh::WALLS;
use crate::store::VertexId;

/// Flips of edges, which reuse their buffers.
#[derive(Default)]
pub(super) struct Flips {
    /// The edges to examine.
    open: Vec<[VertexId; 2]>,
    patch: Patch,
}

/// The triangles of a flip: in both, the second triangle's first half-edge follows.
const FIRST: TriangleId = TriangleId(0);
const SECOND: TriangleId = TriangleId(1);

impl Flips {
    /// Flips edges until the property holds, given the only edge that may violate it.
    pub(super) fn spread_from(&mut self, tiles: &mut Tiles, edge: [VertexId; 2]) -> Result<(), EditError> {
        self.open.push(edge);
        while let Some(edge) = self.open.pop() {
            self.examine(tiles, edge)?;
        }
        Ok(())
    }

    /// Flips an edge if it violates the property.
    fn examine(&mut self, tiles: &mut Tiles, [a, b]: [VertexId; 2]) -> Result<(), EditError> {
        let tile = tiles.get(a.tile)?;
        // On the hull, the edge has one triangle only.
        let [Some(here), Some(there)] = [[a, b], [b, a]].map(|[from, to]| tile.half_edge_between(from, to)) else {
            return Ok(());
        };
        let [(above, bits_above), (below, bits_below)] = [here, there].map(|half_edge| tile.triangle(half_edge));
        let [pa, pb, pc, pd] = [above[0], above[1], above[2], below[2]].map(|corner| corner.point);
        // An edge that violates the property is a diagonal of a convex quadrilateral.
        if bits_above & 1 == 1 || !in_circle(pa, pb, pc, pd) {
            return Ok(());
        }
        self.patch.clear();
        let [a, b, c, d] = [above[0], above[1], above[2], below[2]].map(|corner| self.patch.number(corner).0);
        self.patch.old.extend([
            OldTriangle::new([a, b, c], bits_above, (tile.id, here)),
            OldTriangle::new([b, a, d], bits_below, (tile.id, there)),
        ]);
        drop(tile);
        let [[_, bc, ca], [_, ad, db]] = [FIRST, SECOND].map(HalfEdge::of_triangle);
        let [[_, dc, _], [_, _, cd]] = [FIRST, SECOND].map(HalfEdge::of_triangle);
        let bits = |old: HalfEdge| {
            let of_triangle = [bits_above, bits_below][old.triangle().index()];
            of_triangle >> old.corner() & (1 | 1 << WALLS)
        };
        self.patch.new.extend([
            NewTriangle {
                corners: [a, d, c],
                bits: bits(ad) | bits(ca) << 2,
                twins: [PatchTwin::Old(ad), PatchTwin::New(cd), PatchTwin::Old(ca)],
            },
            NewTriangle {
                corners: [d, b, c],
                bits: bits(db) | bits(bc) << 1,
                twins: [PatchTwin::Old(db), PatchTwin::Old(bc), PatchTwin::New(dc)],
            },
        ]);
        exchange(&mut self.patch, tiles)?;
        let around = [[a, d], [d, b], [b, c], [c, a]];
        let id = |number: u32| self.patch.vertices[number as usize].id;
        self.open.extend(around.map(|ends| ends.map(id)));
        Ok(())
    }
}
