//! How cones are joined with those that wait next to them, and wait.

use super::cone::Cone;
use super::task::Task;
use super::waiting::Ahead;
use super::wave::Wave;
use crate::store::TileId;

impl Wave {
    /// Joins a cone with the one of the same root that waits next to it at the same side, if there is one.
    pub(super) fn join(&mut self, tile: TileId, root: u32, ahead: &mut Ahead, cone: &mut Cone) {
        self.waiting.fit(self.queue.len() + 1);
        let place = *self.waiting.place(tile, root, ahead.side);
        let Some(there) = self.queue.at(place) else { return };
        let Task::Cone {
            tile: of_tile,
            side,
            root: of_root,
            right,
            left,
            length,
        } = *there
        else {
            return;
        };
        if (of_root, side, of_tile) != (root, ahead.side, tile) {
            return;
        }
        if left == cone.right {
            cone.right = right;
        } else if right == cone.left {
            cone.left = left;
        } else {
            return;
        }
        *there = Task::Nothing;
        ahead.length = ahead.length.min(length);
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
        let task = Task::Cone {
            tile,
            side: ahead.side,
            root,
            right: cone.right,
            left: cone.left,
            length: ahead.length,
        };
        let place = self.queue.push(ahead.length, Some(tile), task);
        if self.joins {
            *self.waiting.place(tile, root, ahead.side) = place;
        }
    }
}
