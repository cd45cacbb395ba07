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

use super::*;

/// Triangles that a wave to one goal goes through before it joins cones.
pub(super) const JOINED_AFTER: u64 = 1 << 14;
/// Triangles that any wave goes through before it keeps order.
pub(super) const ORDERED_AFTER: u64 = 1 << 18;
/// Places to begin with.
const ROOM: usize = 256;

/// Where in the queue the cone lies that came last to wait at a side, for some sides: by root and side, mixed. Another one may have
/// taken its place, so it is only a hint.
#[derive(Debug)]
pub(super) struct Waiting(Vec<u32>);

/// A cone at a side of the tile at hand, that it is to pass.
#[derive(Clone, Copy)]
pub(super) struct Ahead {
    /// What its ways have at least.
    pub(super) length: f64,
    /// The side, of a triangle of the tile.
    pub(super) side: u32,
}

impl Waiting {
    pub(super) fn new() -> Self {
        Self(Vec::new())
    }

    fn place(&mut self, tile: TileId, root: u32, side: u32) -> &mut u32 {
        let mixed = (u64::from(root) << 32 | u64::from(side)).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ u64::from(tile.0);
        let mixed = mixed.wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 32;
        let place = mixed as usize & (self.0.len() - 1);
        &mut self.0[place]
    }

    /// Makes room for so many cones and more. What was known is forgotten then.
    fn fit(&mut self, count: usize) {
        if 2 * count > self.0.len() {
            let room = (8 * count).next_power_of_two().max(ROOM);
            self.0 = vec![u32::MAX; room];
        }
    }
}

impl Wave {
    /// Joins a cone with the one of the same root that waits next to it at the same side, if there is one.
    pub(super) fn join(&mut self, tile: TileId, root: u32, ahead: &mut Ahead, cone: &mut Cone) {
        self.waiting.fit(self.queue.len() + 1);
        let place = *self.waiting.place(tile, root, ahead.side);
        let Some(there) = self.queue.at(place) else { return };
        let is_it = there.kind == Kind::Cone
            && (there.root, there.index, there.tile) == (root, ahead.side, tile)
            && there.other.tile == NOWHERE;
        if !is_it {
            return;
        }
        if there.left == cone.right {
            cone.right = there.right;
        } else if there.right == cone.left {
            cone.left = there.left;
        } else {
            return;
        }
        there.kind = Kind::Nothing;
        ahead.length = ahead.length.min(f64::from_bits(there.seam));
    }

    /// A cone is joined with what waits next to it, and waits in the queue.
    pub(super) fn put_off(&mut self, tile: TileId, root: u32, ahead: Ahead, cone: &Cone) {
        let (mut ahead, mut cone) = (ahead, *cone);
        if self.joins {
            self.join(tile, root, &mut ahead, &mut cone);
        }
        self.wait(tile, root, ahead, &cone);
    }

    /// A cone that is joined waits in the queue.
    pub(super) fn wait(&mut self, tile: TileId, root: u32, ahead: Ahead, cone: &Cone) {
        if ahead.length > self.limit {
            return;
        }
        let nowhere = VertexId {
            tile: NOWHERE,
            index: 0,
        };
        let item = Item {
            kind: Kind::Cone,
            tile,
            index: ahead.side,
            other: nowhere,
            root,
            right: cone.right,
            left: cone.left,
            seam: ahead.length.to_bits(),
        };
        let place = self.queue.push(ahead.length, item);
        if self.joins {
            *self.waiting.place(tile, root, ahead.side) = place;
        }
    }
}
