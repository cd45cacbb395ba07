//! How cones are joined with those that wait next to them, and wait.

use super::cone::Cone;
use super::queue::{Item, Kind, NOWHERE};
use super::waiting::Ahead;
use super::wave::Wave;
use crate::store::{TileId, VertexId};

impl Wave {
    /// Joins a cone with the one of the same root that waits next to it at the same side, if there is one.
    pub(crate) fn join(&mut self, tile: TileId, root: u32, ahead: &mut Ahead, cone: &mut Cone) {
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
    pub(crate) fn put_off(&mut self, tile: TileId, root: u32, ahead: Ahead, cone: &Cone) {
        let (mut ahead, mut cone) = (ahead, *cone);
        if self.joins {
            self.join(tile, root, &mut ahead, &mut cone);
        }
        self.wait(tile, root, ahead, &cone);
    }

    /// A cone that is joined waits in the queue.
    pub(crate) fn wait(&mut self, tile: TileId, root: u32, ahead: Ahead, cone: &Cone) {
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
