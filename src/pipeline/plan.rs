//! The blocks that conquest goes by.

use std::path::{Path, PathBuf};

use crate::store::{KdNode, KdTree, TileId};

/// A part of the plane whose points fit in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Block {
    pub(crate) points: u64,
    /// Where these are.
    pub(crate) runs: Vec<Run>,
}

/// All blocks.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Plan {
    /// The cuts above the blocks, which are its leaves.
    pub(crate) tree: KdTree,
    pub(crate) blocks: Vec<Block>,
    /// Points that came in.
    pub(crate) points: u64,
    /// Of these, points that were merged with others while they passed.
    pub(crate) merged: u64,
    pub(crate) has_z: bool,
    /// Bytes of runs that were written as points came.
    pub(crate) bytes_written: u64,
    /// Bytes of runs that were split again, and of those that came of it.
    pub(crate) bytes_read: u64,
    pub(crate) bytes_rewritten: u64,
}

impl Plan {
    /// The plan of points that are all in memory: one block.
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

/// A finished run.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Run {
    /// Its number, which is in the name of its file.
    pub(crate) number: u32,
    pub(crate) points: u64,
    /// Bytes of the file.
    pub(crate) length: u64,
}

impl Run {
    /// The file of the run in the work folder.
    pub(crate) fn path(&self, folder: &Path) -> PathBuf {
        path_of_run(folder, self.number)
    }
}

/// The file of a run by its number.
pub(crate) fn path_of_run(folder: &Path, number: u32) -> PathBuf {
    folder.join(format!("run-{number}"))
}
