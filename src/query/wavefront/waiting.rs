//! Windows that wait at the half-edges of a tile. Two adjacent windows of the same root are joined.
//!
//! Each vertex inside a window splits the window in two. Where nothing is in the way, both parts
//! reach the same edge behind the vertex, one next to the other, and together they see there what
//! each of them sees. Without joining, a triangle would be passed once for each vertex that was
//! passed on the way, not once or twice.
//!
//! ```text
//!        ────┬────     edge
//!         ╲  │  ╱      Both windows wait here: the one between the rays through R and v, and
//!          ╲ │ ╱       the one between the rays through v and L. The straight paths from the
//!        L  ╲v╱  R     root through v belong to both, so there is no gap between them.
//!            r
//! ```
//!
//! A wavefront to one goal may reach it in a narrow bundle of windows, so it joins none until it
//! has passed many triangles. After far more triangles, every wavefront processes the nearest task
//! of a tile first: a window that is ahead of that does not wait, and is not joined.

use crate::collections::prefetch::prefetch;
use crate::geometry::HalfEdge;
use crate::store::TileId;

/// The number of triangles that a wavefront to one goal passes before it joins windows.
pub(crate) const JOINED_AFTER: u64 = 1 << 14;
/// The number of triangles that any wavefront passes before it keeps the order within a tile.
pub(crate) const ORDERED_AFTER: u64 = 1 << 18;
/// The initial number of slots.
const ROOM: usize = 256;

/// The queue slots of windows that wait at half-edges, by a hash of root and half-edge, each with
/// the other half of the hash. Other windows overwrite entries, and windows that no longer wait
/// leave theirs behind, so an entry is only a hint. The other half of the hash excludes nearly all
/// false hints before a window is looked up in vain.
#[derive(Debug)]
pub(crate) struct Waiting(Vec<Hint>);

#[derive(Clone, Copy, Debug)]
struct Hint {
    check: u32,
    slot: u32,
}

/// The continuation of a window through a half-edge of the current tile.
#[derive(Clone, Copy)]
pub(crate) struct Ahead {
    /// The lower bound of the lengths of its paths.
    pub(crate) length: f64,
    /// The half-edge by which the window enters the next triangle of the tile.
    pub(crate) half_edge: HalfEdge,
    /// Whether a ray of the window passes between the ends of the half-edge. Otherwise no other
    /// window is next to it there.
    pub(crate) is_cut: bool,
}

impl Waiting {
    pub(crate) fn new() -> Self {
        Self(Vec::new())
    }

    /// Says that the hint for a half-edge will soon be used.
    #[inline]
    pub(super) fn expect(&self, key: WaitingKey) {
        prefetch(&self.0, key.index as usize & self.0.len().wrapping_sub(1));
    }

    /// Returns the hint for a half-edge, if there is one.
    #[inline]
    pub(super) fn hint(&self, key: WaitingKey) -> Option<u32> {
        let hint = self.0[key.index as usize & (self.0.len() - 1)];
        (hint.check == key.check).then_some(hint.slot)
    }

    /// Notes in which slot a window waits.
    #[inline]
    pub(super) fn note(&mut self, key: WaitingKey, slot: u32) {
        let index = key.index as usize & (self.0.len() - 1);
        self.0[index] = Hint { check: key.check, slot };
    }

    /// Makes room for `count` windows and more. Growing forgets all entries.
    pub(super) fn fit(&mut self, count: usize) {
        if 2 * count > self.0.len() {
            let room = (4 * count).next_power_of_two().max(ROOM);
            let none = Hint {
                check: 0,
                slot: u32::MAX,
            };
            self.0 = vec![none; room];
        }
    }
}

/// A hash of a root and a half-edge.
#[derive(Clone, Copy)]
pub(super) struct WaitingKey {
    index: u32,
    check: u32,
}

impl WaitingKey {
    #[inline]
    pub(super) fn new(tile: TileId, root: u32, half_edge: HalfEdge) -> Self {
        let mixed =
            (u64::from(root) << 32 | u64::from(half_edge.0)).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ u64::from(tile.0);
        let mixed = mixed.wrapping_mul(0xbf58_476d_1ce4_e5b9);
        Self {
            index: (mixed >> 32) as u32,
            check: mixed as u32,
        }
    }
}
