//! The blocks in which the points are conquered.

use std::path::{Path, PathBuf};

use crate::store::{KdNode, KdTree, TileId, front_end_for};

/// A part of the plane whose points fit in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Block {
    pub(crate) points: u64,
    /// The runs that hold the points.
    pub(crate) runs: Vec<Run>,
}

/// All blocks of a build.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct BlockPlan {
    /// The cuts above the blocks. Its leaves are the blocks.
    pub(crate) tree: KdTree,
    pub(crate) blocks: Vec<Block>,
    /// Number of points that arrived.
    pub(crate) points: u64,
    /// Number of these points that were merged with others while runs were split.
    pub(crate) merged: u64,
    pub(crate) has_z: bool,
    /// Bytes of the runs that were written as points arrived.
    pub(crate) bytes_written: u64,
    /// Bytes of the runs that were split again, and bytes of the runs that this wrote.
    pub(crate) bytes_read: u64,
    pub(crate) bytes_rewritten: u64,
}

impl BlockPlan {
    /// Returns the bytes before the first core in the file, for tiles of this size.
    pub(crate) fn front_end(&self, tile_vertices: usize) -> u64 {
        front_end_for(2 * self.points.div_ceil(tile_vertices as u64))
    }

    /// Returns the plan for `points` points that are all in memory: one block.
    pub(crate) fn in_memory(points: u64, has_z: bool) -> Self {
        let blocks = u32::from(points > 0);
        let nodes = (0..blocks).map(|block| KdNode::Leaf(TileId(block)));
        let block = Block {
            points,
            ..Block::default()
        };
        Self {
            tree: KdTree::new(nodes.collect()).unwrap_or_default(),
            blocks: vec![block; blocks as usize],
            points,
            has_z,
            ..Self::default()
        }
    }
}

/// What decides which nodes are merged at once and which segments are deferred. It belongs to the
/// plan, not to whoever carries it out, so that the file is the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct NodeLimits {
    /// The most seam vertices that a merge of more than two nodes takes.
    pub(crate) merge_vertices: usize,
    pub(crate) held: HeldLimits,
}

/// The most triangles that may be held in a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct HeldLimits {
    pub(crate) in_leaf: usize,
    /// In a node above the leaves.
    pub(crate) in_node: usize,
}

/// A finished run.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Run {
    /// Number of the run, which is part of its file's name.
    pub(crate) number: u32,
    pub(crate) points: u64,
    /// Bytes of the file.
    pub(crate) length: u64,
}

impl Run {
    /// Returns the path of the run's file in the work folder.
    pub(crate) fn path(&self, folder: &Path) -> PathBuf {
        path_of_run(folder, self.number)
    }
}

/// Returns the path of the file of run `number`.
pub(crate) fn path_of_run(folder: &Path, number: u32) -> PathBuf {
    folder.join(format!("run-{number}"))
}
