//! How windows wait in the queue, and how adjacent windows are joined.

use super::state::Wavefront;
use super::task::Task;
use super::waiting::{Ahead, WaitingKey};
use super::window::Window;
use crate::store::TileId;

impl Wavefront {
    /// Joins a window with the waiting window of the same root that is next to it at the same
    /// half-edge, if there is one.
    pub(super) fn join(&mut self, tile: TileId, root: u32, ahead: &mut Ahead, window: &mut Window) {
        self.waiting.fit(self.queue.len() + 1);
        let key = WaitingKey::new(tile, root, ahead.half_edge);
        let Some(slot) = self.waiting.hint(key) else { return };
        let Some(there) = self.queue.at(slot) else { return };
        let Task::Window {
            tile: of_tile,
            half_edge,
            root: of_root,
            right,
            left,
            length,
        } = *there
        else {
            return;
        };
        if (of_root, half_edge, of_tile) != (root, ahead.half_edge, tile) {
            return;
        }
        if left == window.right {
            window.right = right;
        } else if right == window.left {
            window.left = left;
        } else {
            return;
        }
        *there = Task::Nothing;
        ahead.length = ahead.length.min(length);
    }

    /// Joins a window with an adjacent waiting one, and puts it in the queue.
    pub(super) fn defer(&mut self, tile: TileId, root: u32, ahead: Ahead, window: &Window) {
        let (mut ahead, mut window) = (ahead, *window);
        if self.joins && ahead.is_cut {
            self.join(tile, root, &mut ahead, &mut window);
        }
        self.wait(tile, root, ahead, &window);
    }

    /// Puts a window, which was joined already, in the queue.
    pub(super) fn wait(&mut self, tile: TileId, root: u32, ahead: Ahead, window: &Window) {
        if ahead.length > self.limit {
            return;
        }
        let task = Task::Window {
            tile,
            half_edge: ahead.half_edge,
            root,
            right: window.right,
            left: window.left,
            length: ahead.length,
        };
        let slot = self.queue.push(ahead.length, Some(tile), task);
        if self.joins && ahead.is_cut {
            self.waiting.note(WaitingKey::new(tile, root, ahead.half_edge), slot);
        }
    }
}
