//! The blocks that conquest goes by.

use super::run::Run;
use crate::store::{KdNode, KdTree, TileId};

/// A part of the plane whose points fit in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::build) struct Block {
    pub(in crate::build) points: u64,
    /// Where these are.
    pub(in crate::build) runs: Vec<Run>,
}

/// All blocks.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::build) struct Plan {
    /// The cuts above the blocks, which are its leaves.
    pub(in crate::build) tree: KdTree,
    pub(in crate::build) blocks: Vec<Block>,
    /// Points that came in.
    pub(in crate::build) points: u64,
    /// Of these, points that were merged with others while they passed.
    pub(in crate::build) merged: u64,
    pub(in crate::build) has_z: bool,
    /// Bytes of runs that were written as points came.
    pub(in crate::build) bytes_written: u64,
    /// Bytes of runs that were split again, and of those that came of it.
    pub(in crate::build) bytes_read: u64,
    pub(in crate::build) bytes_rewritten: u64,
}

impl Plan {
    /// The plan of points that are all in memory: one block.
    pub(in crate::build) fn in_memory(points: u64, has_z: bool) -> Self {
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
