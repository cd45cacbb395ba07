//! The schedule: divides blocks as they arrive, conquers their leaves in order, and merges seams as
//! soon as the children are done.
//!
//! Threads take tasks from one board. A merge that is ready comes first, so the tree is processed
//! depth-first and few seams wait; then a block to divide, so that there are always leaves; then
//! the next leaf. The fan-out adapts: seams go up unmerged as long as all seams of a node fit in
//! one merge. So a merge covers as many levels as possible, and at least two nodes. Only blocks
//! always end in one seam, which the journal keeps.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use parking_lot::{Condvar, Mutex};
use tokio::sync::OwnedSemaphorePermit;

use crate::constraints::segment::Segment;
use crate::geometry::Rect;
use crate::pipeline::ingest::point_store::PointStore;
use crate::pipeline::records::{Draped, Seam};
use crate::store::divide::Division;
use crate::store::{KdNode, KdTree, TileId};

/// A block in memory.
#[derive(Debug)]
pub(crate) struct BlockPoints {
    pub(crate) number: u32,
    pub(crate) store: PointStore,
    /// The segments that meet its cell, and, once it is divided, the indices of those that meet
    /// each leaf.
    pub(crate) segments: Vec<Segment>,
    pub(crate) of_leaves: Vec<Vec<u32>>,
    /// Its vertices that took their z from the surface.
    pub(crate) draped: Draped,
    /// The memory that the block takes, which is released for another block on drop.
    pub(crate) _permit: Option<OwnedSemaphorePermit>,
}

/// A unit of work.
#[derive(Debug)]
pub(crate) enum Task {
    /// Divide a block.
    Divide {
        /// The block.
        block: BlockPoints,
        /// Number of idle threads, which the task may use.
        threads: usize,
    },
    /// Conquer a leaf.
    Leaf {
        /// Its node in the tree.
        node: u32,
        /// Its tile.
        tile: TileId,
        /// Its block, and the range of its points there.
        block: Arc<BlockPoints>,
        points: Range<usize>,
    },
    /// Merge the seams below a node.
    Merge {
        /// The node.
        node: u32,
        /// The seams, in leaf order.
        seams: Vec<Seam>,
    },
}

/// The board that threads take their tasks from.
pub(crate) struct Board {
    state: Mutex<BoardState>,
    changed: Condvar,
    merge_vertices: usize,
    threads: usize,
    /// The nodes of the blocks in the tree.
    block_nodes: Vec<u32>,
}

/// A node of the tree, with its parent and children.
#[derive(Clone, Copy)]
struct BoardNode {
    parent: u32,
    is_right: bool,
    children: [u32; 2],
    cell: Rect,
    /// The block that the node belongs to; `None` above the blocks.
    block: Option<u32>,
}

/// The memory load of seams.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SeamLoad {
    /// Bytes of the seams that wait or are being merged.
    pub(crate) bytes: u64,
    /// Most seam vertices of a waiting merge.
    pub(crate) next_vertices: u64,
    /// Most held triangles of a waiting merge.
    pub(crate) next_held: u64,
    /// Whether blocks take memory too.
    pub(crate) blocks_in_memory: bool,
}

/// The cell and the block of a node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NodeScope {
    pub(crate) cell: Rect,
    /// The block; `None` above the blocks.
    pub(crate) block: Option<u32>,
    /// Whether the node covers all of the block.
    pub(crate) is_block: bool,
}

const ROOT: u32 = 0;

struct BoardState {
    /// The nodes above the blocks, then those of the divided blocks.
    nodes: Vec<BoardNode>,
    /// For each node, the seams that its children have passed up.
    arrived: Vec<[Option<Vec<Seam>>; 2]>,
    merges: Vec<Task>,
    /// Blocks that wait to be divided, in order.
    loaded: VecDeque<BlockPoints>,
    dividing: bool,
    /// Blocks with leaves that no thread has taken yet.
    divided: VecDeque<BlockLeaves>,
    /// Number of tiles of the blocks that were divided or finished earlier.
    tiles: u32,
    /// Number of blocks that have not arrived yet.
    to_come: usize,
    running: usize,
    /// Bytes of all seams that wait or are being merged.
    seam_bytes: u64,
    /// Time that threads were idle because no block had arrived, summed over the threads.
    starved: Duration,
    stopped: bool,
    /// Whether blocks are only divided, and no other tasks are given out.
    only_divide: bool,
}

/// Leaves of a block, with their nodes and points.
struct BlockLeaves {
    block: Arc<BlockPoints>,
    first_tile: u32,
    leaves: VecDeque<(u32, Range<usize>)>,
    taken: u32,
}

impl Board {
    /// Creates a board for the blocks, which are the leaves of `top`.
    pub(crate) fn new(top: &KdTree, merge_vertices: usize, threads: usize) -> Self {
        let mut nodes = Vec::new();
        add_nodes(&mut nodes, top, Rect::PLANE, None);
        let mut block_nodes = Vec::new();
        for (number, node) in (0u32..).zip(top.nodes()) {
            if let KdNode::Leaf(_) = node {
                nodes[number as usize].block = Some(block_nodes.len() as u32);
                block_nodes.push(number);
            }
        }
        Self {
            state: Mutex::new(BoardState {
                arrived: nodes.iter().map(|_| [None, None]).collect(),
                nodes,
                merges: Vec::new(),
                loaded: VecDeque::new(),
                dividing: false,
                divided: VecDeque::new(),
                tiles: 0,
                to_come: block_nodes.len(),
                running: 0,
                seam_bytes: 0,
                starved: Duration::ZERO,
                stopped: false,
                only_divide: false,
            }),
            changed: Condvar::new(),
            merge_vertices,
            threads,
            block_nodes,
        }
    }

    /// Leaves one block on the board, which becomes block 0. Its tiles are numbered from `first_tile`
    /// on.
    pub(crate) fn only(self, block: u32, first_tile: u32) -> Self {
        let node = self.block_nodes[block as usize];
        let mut state = self.state.into_inner();
        state.nodes[node as usize].block = Some(0);
        (state.to_come, state.tiles) = (1, first_tile);
        Self {
            state: Mutex::new(state),
            block_nodes: vec![node],
            ..self
        }
    }

    /// Adds a block. Blocks must come in order. Returns `false` if no more are wanted.
    pub(crate) fn add(&self, block: BlockPoints) -> bool {
        let mut state = self.state.lock();
        if state.stopped {
            return false;
        }
        state.to_come -= 1;
        state.loaded.push_back(block);
        self.changed.notify_all();
        true
    }

    /// Adds the seam of a block that an earlier build finished. Blocks must come in order.
    pub(crate) fn restore(&self, block: u32, tiles: u32, seam: Seam) {
        let mut state = self.state.lock();
        state.to_come -= 1;
        state.tiles += tiles;
        state.seam_bytes += seam.byte_size();
        self.pass_up(&mut state, self.block_nodes[block as usize], vec![seam]);
        self.changed.notify_all();
    }

    /// Adds the leaves of a divided block. Calls `prepare` with its first tile before any thread
    /// gets a leaf.
    pub(crate) fn divided(&self, block: BlockPoints, division: Division, prepare: impl FnOnce(u32)) {
        let mut state = self.state.lock();
        let first_tile = state.tiles;
        let root = self.block_nodes[block.number as usize];
        let cell = state.nodes[root as usize].cell;
        let first_node = state.nodes.len() as u32;
        let number = block.number;
        // The root of the block's tree exists already. The other nodes are appended after all
        // nodes.
        let index = |node: u32| if node == 0 { root } else { first_node + node - 1 };
        let mut inner = Vec::new();
        add_nodes(&mut inner, &division.tree, cell, Some(number));
        for node in &mut inner {
            node.parent = index(node.parent);
            node.children = node.children.map(index);
        }
        let BoardNode { parent, is_right, .. } = state.nodes[root as usize];
        inner[0].parent = parent;
        inner[0].is_right = is_right;
        state.nodes[root as usize] = inner[0];
        state.nodes.extend_from_slice(&inner[1..]);
        let count = state.nodes.len();
        state.arrived.resize_with(count, || [None, None]);
        let numbers = (0u32..).zip(division.tree.nodes());
        let leaves = numbers.filter(|(_, node)| matches!(node, KdNode::Leaf(_)));
        let leaves: VecDeque<_> = leaves.map(|(n, _)| index(n)).zip(division.leaves).collect();
        state.tiles += leaves.len() as u32;
        prepare(first_tile);
        if !state.only_divide {
            state.divided.push_back(BlockLeaves {
                block: Arc::new(block),
                first_tile,
                leaves,
                taken: 0,
            });
        }
        state.dividing = false;
        state.running -= 1;
        self.changed.notify_all();
    }

    /// Returns the next task. Waits for one while running tasks or blocks that have not arrived may
    /// still create some. Returns `None` if there will be no more.
    pub(crate) fn take(&self) -> Option<Task> {
        let mut state = self.state.lock();
        loop {
            if state.stopped {
                return None;
            }
            if let Some(task) = self.next(&mut state) {
                state.running += 1;
                return Some(task);
            }
            let starving = state.to_come > 0;
            if state.running == 0 && !starving {
                return None;
            }
            let began = Instant::now();
            self.changed.wait(&mut state);
            if starving {
                state.starved += began.elapsed();
            }
        }
    }

    /// Stops all tasks except dividing blocks.
    pub(crate) fn only_divide(&self) {
        let mut state = self.state.lock();
        state.only_divide = true;
        state.divided.clear();
        state.merges.clear();
    }

    fn next(&self, state: &mut BoardState) -> Option<Task> {
        if let Some(merge) = state.merges.pop() {
            return Some(merge);
        }
        if !state.dividing
            && let Some(block) = state.loaded.pop_front()
        {
            state.dividing = true;
            let idle = state.divided.is_empty() && state.running == 0;
            let threads = if idle { self.threads } else { self.threads.div_ceil(4) };
            return Some(Task::Divide { block, threads });
        }
        let leaves = state.divided.front_mut()?;
        let (node, points) = leaves.leaves.pop_front()?;
        let task = Task::Leaf {
            node,
            tile: TileId(leaves.first_tile + leaves.taken),
            block: Arc::clone(&leaves.block),
            points,
        };
        leaves.taken += 1;
        if leaves.leaves.is_empty() {
            state.divided.pop_front();
        }
        Some(task)
    }

    /// Returns the cell of a block.
    pub(crate) fn block_cell(&self, block: u32) -> Rect {
        self.state.lock().nodes[self.block_nodes[block as usize] as usize].cell
    }

    /// Returns the cell and the block of a node.
    pub(crate) fn scope(&self, node: u32) -> NodeScope {
        let state = self.state.lock();
        let BoardNode { cell, block, .. } = state.nodes[node as usize];
        NodeScope {
            cell,
            block,
            is_block: block.is_some_and(|block| self.block_nodes[block as usize] == node),
        }
    }

    /// Ends the task of `node` and takes its seam, which was made from seams of `merged_bytes`
    /// bytes. Returns the load of seams.
    pub(crate) fn done(&self, node: u32, seam: Seam, merged_bytes: u64) -> SeamLoad {
        let mut state = self.state.lock();
        state.running -= 1;
        state.seam_bytes += seam.byte_size();
        state.seam_bytes -= merged_bytes;
        self.pass_up(&mut state, node, vec![seam]);
        self.changed.notify_all();
        let merges = || {
            state.merges.iter().map(|task| match task {
                Task::Merge { seams, .. } => seams.as_slice(),
                _ => &[],
            })
        };
        let held = |seams: &[Seam]| seams.iter().map(|seam| seam.pending.held.len() as u64).sum();
        SeamLoad {
            bytes: state.seam_bytes,
            next_vertices: merges().map(total).max().unwrap_or(0) as u64,
            next_held: merges().map(held).max().unwrap_or(0),
            blocks_in_memory: state.to_come > 0 || !state.loaded.is_empty() || !state.divided.is_empty(),
        }
    }

    /// Ends a task that failed: its node will have no seam.
    pub(crate) fn abandon(&self) {
        self.state.lock().running -= 1;
        self.changed.notify_all();
    }

    /// Returns the time that threads were idle because no block had arrived, summed over the
    /// threads.
    pub(crate) fn starved(&self) -> Duration {
        self.state.lock().starved
    }

    /// Returns whether the board was stopped.
    pub(crate) fn is_stopped(&self) -> bool {
        self.state.lock().stopped
    }

    /// Stops the board: no thread gets another task.
    pub(crate) fn stop(&self) {
        let mut state = self.state.lock();
        state.stopped = true;
        // Blocks that no thread will take must not keep their memory.
        state.loaded.clear();
        state.divided.clear();
        self.changed.notify_all();
    }

    fn pass_up(&self, state: &mut BoardState, mut node: u32, mut seams: Vec<Seam>) {
        if state.only_divide {
            return;
        }
        while node != ROOT {
            let BoardNode { parent, is_right, .. } = state.nodes[node as usize];
            let BoardNode { children, block, .. } = state.nodes[parent as usize];
            let arrived = &mut state.arrived[parent as usize];
            arrived[usize::from(is_right)] = Some(seams);
            let [Some(left), Some(right)] = arrived else { return };
            let fits = total(left) + total(right) <= self.merge_vertices;
            if !fits && (left.len() > 1 || right.len() > 1) {
                // Merges the seams of each child first. They come back as one seam each.
                for (side, child) in arrived.iter_mut().zip(children) {
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
            let is_block = block.is_some_and(|block| self.block_nodes[block as usize] == parent);
            if parent == ROOT || is_block || !fits {
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

fn total(seams: &[Seam]) -> usize {
    seams.iter().map(|seam| seam.vertices.len()).sum()
}

/// Appends the nodes of a tree whose root has `cell`. Their links are numbered from 0.
fn add_nodes(nodes: &mut Vec<BoardNode>, tree: &KdTree, cell: Rect, block: Option<u32>) {
    nodes.extend(tree.node_cells_within(cell).into_iter().map(|cell| BoardNode {
        parent: ROOT,
        is_right: false,
        children: [ROOT; 2],
        cell,
        block,
    }));
    for (number, node) in (0u32..).zip(tree.nodes()) {
        if let KdNode::X { right, .. } | KdNode::Y { right, .. } = *node {
            let children = [number + 1, right];
            nodes[number as usize].children = children;
            for (child, is_right) in children.into_iter().zip([false, true]) {
                nodes[child as usize].parent = number;
                nodes[child as usize].is_right = is_right;
            }
        }
    }
}
