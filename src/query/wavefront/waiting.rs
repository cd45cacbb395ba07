//! Cones that wait at the sides of a tile, and become one where two of the same root lie next to each other.
//!
//! Each vertex that a cone meets parts it in two. Where nothing is in the way, the two come to a side behind the vertex again, one next to the other,
//! and together they show there what each of them does: whoever does not join them goes through a triangle once for each vertex
//! that was passed on the way, and not once or twice.
//!
//! ```text
//!        ────┬────     side
//!         ╲  │  ╱      both cones wait here: that between the rays through R and v, and that between those through v and L
//!          ╲ │ ╱
//!        L  ╲v╱  R     the straight ways from the root through v belong to both, so nothing is left out between them
//!            r
//! ```
//!
//! A wave that hurries to one goal may come there in a narrow bundle, so it joins none before it has gone through many triangles. And after
//! far more, every wave does what is nearest in its tile first: whoever is ahead of that waits for nobody, and is not joined.

use crate::geometry::HalfEdge;
use crate::store::TileId;

/// Triangles that a wave to one goal goes through before it joins cones.
pub(crate) const JOINED_AFTER: u64 = 1 << 14;
/// Triangles that any wave goes through before it keeps order.
pub(crate) const ORDERED_AFTER: u64 = 1 << 18;
/// Places to begin with.
const ROOM: usize = 256;

/// Where in the queue the cone lies that came last to wait at a side, for some sides: by root and side, mixed. Another one may have
/// taken its place, so it is only a hint.
#[derive(Debug)]
pub(crate) struct Waiting(Vec<u32>);

/// A cone at a side of the tile at hand, that it is to pass.
#[derive(Clone, Copy)]
pub(crate) struct Ahead {
    /// What its ways have at least.
    pub(crate) length: f64,
    /// The side, of a triangle of the tile.
    pub(crate) side: HalfEdge,
}

impl Waiting {
    pub(crate) fn new() -> Self {
        Self(Vec::new())
    }

    pub(super) fn place(&mut self, tile: TileId, root: u32, side: HalfEdge) -> &mut u32 {
        let mixed = (u64::from(root) << 32 | u64::from(side.0)).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ u64::from(tile.0);
        let mixed = mixed.wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 32;
        let place = mixed as usize & (self.0.len() - 1);
        &mut self.0[place]
    }

    /// Makes room for so many cones and more. What was known is forgotten then.
    pub(super) fn fit(&mut self, count: usize) {
        if 2 * count > self.0.len() {
            let room = (8 * count).next_power_of_two().max(ROOM);
            self.0 = vec![u32::MAX; room];
        }
    }
}
