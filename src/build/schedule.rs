//! Who does what next: conquers the leaves in order and merges as soon as children are done.
//!
//! Threads take tasks from one board. A merge that can be done comes before the next leaf, so the tree is worked depth
//! first and few seams wait. The fan-out adapts: seams go up unmerged as long as all those of a node together fit in one
//! merge; so as many levels are merged at once as possible, and two nodes at least.

use parking_lot::{Condvar, Mutex};

use super::node::Seam;
use crate::store::{KdNode, KdTree, TileId};

/// A piece of work.
#[derive(Debug)]
pub(super) enum Task {
    /// Conquer a leaf.
    Leaf {
        /// Its node in the tree.
        node: u32,
        /// Its tile.
        tile: TileId,
    },
    /// Merge the seams of the nodes below one.
    Merge {
        /// The node.
        node: u32,
        /// The seams, in leaf order.
        seams: Vec<Seam>,
    },
}

/// The board that threads take their tasks from.
pub(super) struct Board {
    state: Mutex<State>,
    changed: Condvar,
    /// The node of each tile.
    leaves: Vec<u32>,
    links: Vec<Link>,
    merge_vertices: usize,
}

/// The place of a node below its parent.
#[derive(Clone, Copy)]
struct Link {
    parent: u32,
    is_right: bool,
    children: [u32; 2],
}

const ROOT: u32 = 0;

#[derive(Default)]
struct State {
    next_leaf: usize,
    merges: Vec<Task>,
    /// For each inner node, the seams that its children have handed up.
    arrived: Vec<[Option<Vec<Seam>>; 2]>,
    running: usize,
    stopped: bool,
}

impl Board {
    pub(super) fn new(tree: &KdTree, merge_vertices: usize) -> Self {
        let nodes = tree.nodes();
        let mut links = vec![
            Link {
                parent: ROOT,
                is_right: false,
                children: [0; 2],
            };
            nodes.len()
        ];
        let mut leaves = Vec::new();
        for (number, node) in (0u32..).zip(nodes) {
            match *node {
                KdNode::X { right, .. } | KdNode::Y { right, .. } => {
                    let children = [number + 1, right];
                    links[number as usize].children = children;
                    for (child, is_right) in children.into_iter().zip([false, true]) {
                        links[child as usize].parent = number;
                        links[child as usize].is_right = is_right;
                    }
                }
                KdNode::Leaf(_) => leaves.push(number),
            }
        }
        Self {
            state: Mutex::new(State {
                arrived: nodes.iter().map(|_| [None, None]).collect(),
                ..State::default()
            }),
            changed: Condvar::new(),
            leaves,
            links,
            merge_vertices,
        }
    }

    /// The next task; waits for one if others may still make some. None: there will be no more.
    pub(super) fn take(&self) -> Option<Task> {
        let mut state = self.state.lock();
        loop {
            if state.stopped {
                return None;
            }
            if let Some(merge) = state.merges.pop() {
                state.running += 1;
                return Some(merge);
            }
            if let Some(&node) = self.leaves.get(state.next_leaf) {
                let tile = TileId(state.next_leaf as u32);
                state.next_leaf += 1;
                state.running += 1;
                return Some(Task::Leaf { node, tile });
            }
            if state.running == 0 {
                return None;
            }
            self.changed.wait(&mut state);
        }
    }

    /// A task is done; its node has this seam.
    pub(super) fn done(&self, node: u32, seam: Seam) {
        let mut state = self.state.lock();
        state.running -= 1;
        self.hand_up(&mut state, node, vec![seam]);
        self.changed.notify_all();
    }

    /// Ends all: nobody gets another task.
    pub(super) fn stop(&self) {
        self.state.lock().stopped = true;
        self.changed.notify_all();
    }

    fn hand_up(&self, state: &mut State, mut node: u32, mut seams: Vec<Seam>) {
        let total = |seams: &[Seam]| seams.iter().map(|seam| seam.vertices.len()).sum::<usize>();
        while node != ROOT {
            let Link { parent, is_right, .. } = self.links[node as usize];
            let arrived = &mut state.arrived[parent as usize];
            arrived[usize::from(is_right)] = Some(seams);
            let [Some(left), Some(right)] = arrived else { return };
            let fits = total(left) + total(right) <= self.merge_vertices;
            if !fits && (left.len() > 1 || right.len() > 1) {
                // Shrink the sides first; they come back as one seam each.
                for (side, child) in arrived.iter_mut().zip(self.links[parent as usize].children) {
                    if side.as_ref().is_some_and(|seams| seams.len() > 1) {
                        let seams = side.take().unwrap_or_default();
                        state.merges.push(Task::Merge { node: child, seams });
                    }
                }
                return;
            }
            let mut both = left.split_off(0);
            both.append(right);
            *arrived = [None, None];
            if parent == ROOT || !fits {
                state.merges.push(Task::Merge {
                    node: parent,
                    seams: both,
                });
                return;
            }
            (node, seams) = (parent, both);
        }
    }
}
