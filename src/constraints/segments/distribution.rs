//! The distribution of all segments to blocks, and to a file for a build that may be resumed.
//!
//! ```text
//! spool ─▶ segments ─┬─▶ saved            on the thread that reads
//!                    └─▶ cells ─▶ blocks  on another
//! ```

use std::panic::resume_unwind;
use std::path::Path;
use std::sync::{Arc, mpsc};
use std::{mem, thread};

use crate::constraints::error::ConstraintError;
use crate::constraints::segment::Segment;
use crate::constraints::segments::blocks::{BlockSegments, BlockWriter};
use crate::constraints::segments::saved::SegmentFile;
use crate::constraints::segments::spool::SegmentSpool;
use crate::io::start_scoped;
use crate::store::KdTree;

/// The number of lists of segments that wait for their distribution.
const LISTS_AHEAD: usize = 4;

/// All segments of a build, distributed to blocks.
#[derive(Debug)]
pub(crate) struct Distributed {
    /// The segments of each block, or the error of writing them.
    pub(crate) blocks: Result<BlockSegments, ConstraintError>,
    /// The number of segments that were saved.
    pub(crate) saved: u64,
}

impl SegmentSpool {
    /// Distributes the segments to the blocks, which are the leaves of the tree, on up to two
    /// threads. Each block gets the segments that meet its cell. They stay in memory if they take
    /// at most `memory` bytes there.
    ///
    /// Saves all segments to the file `saved`, if there is one, and syncs it. They are saved even
    /// if the distribution fails, so that the build can be resumed.
    ///
    /// Errors are those of [`for_each_chunk`](Self::for_each_chunk), and those of the file.
    pub(crate) fn distribute(
        self,
        tree: &KdTree,
        memory: u64,
        saved: Option<&Path>,
        threads: usize,
    ) -> Result<Distributed, ConstraintError> {
        self.store().fill_no_memory();
        let (count, store) = (self.len(), Arc::clone(self.store()));
        let mut file = saved.map(SegmentFile::create).transpose()?;
        let begin = || BlockSegments::writer(tree, count, memory, Arc::clone(&store));
        let blocks: Result<_, ConstraintError> = thread::scope(|scope| {
            let (ahead, incoming) = mpsc::sync_channel::<Vec<Segment>>(LISTS_AHEAD);
            let begin = &begin;
            let distribute = move || {
                let mut blocks = begin();
                incoming.iter().try_for_each(|segments| blocks.push(&segments))?;
                blocks.finish()
            };
            let distributor = (threads > 1).then(|| start_scoped(scope, "tile-segments", distribute));
            match distributor {
                Some(Ok(distributor)) => {
                    // It takes no more once it has failed.
                    self.save_all(file.as_mut(), |segments| drop(ahead.send(mem::take(segments))))?;
                    drop(ahead);
                    Ok(distributor.join().unwrap_or_else(|panic| resume_unwind(panic)))
                }
                _ => {
                    let mut blocks = Ok(begin());
                    self.save_all(file.as_mut(), |segments| {
                        if let Err(error) = blocks.as_mut().map_or(Ok(()), |blocks| blocks.push(segments)) {
                            blocks = Err(error);
                        }
                    })?;
                    Ok(blocks.and_then(BlockWriter::finish))
                }
            }
        });
        Ok(Distributed {
            blocks: blocks?.map_err(|error| ConstraintError::io(store.folder(), "spill segments in", error)),
            saved: file.map_or(Ok(0), SegmentFile::finish)?,
        })
    }

    /// Passes all segments to `take`, once each is in the file.
    fn save_all(
        mut self,
        mut file: Option<&mut SegmentFile>,
        mut take: impl FnMut(&mut Vec<Segment>),
    ) -> Result<(), ConstraintError> {
        self.give_last(|segments| {
            file.as_mut().map_or(Ok(()), |file| file.push(segments))?;
            take(segments);
            Ok(())
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::geometry::Point;
    use crate::store::{EdgeSource, KdNode, LineKind, TileId};

    use super::*;

    #[test]
    fn segments_are_saved_even_if_the_distribution_fails() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lines");
        let tree = KdTree::new(vec![KdNode::Leaf(TileId(0))]).unwrap();
        let lines: Vec<u64> = (0..20_000).collect();
        // The first segment has no length.
        let ends: Vec<[Point; 2]> = (lines.iter().map(|&i| i as f64))
            .map(|i| {
                [
                    Point::new(i, 0.0),
                    Point::new(2.0 * i, if i == 0.0 { 0.0 } else { 1.0 }),
                ]
            })
            .collect();
        let expected: Vec<Segment> = (1..ends.len())
            .map(|at| Segment {
                ends: ends[at],
                source: EdgeSource::new(LineKind::Wall, lines[at]).into(),
            })
            .collect();
        for (threads, can_spill) in [(1, true), (1, false), (2, true), (2, false)] {
            let spill = folder.path().join(if can_spill { "." } else { "none" });
            let mut spool = SegmentSpool::new(&spill, 16 << 20);
            spool.push(&ends, &[], LineKind::Wall, &lines).unwrap();
            let distributed = spool.distribute(&tree, 0, Some(&path), threads).unwrap();
            assert_eq!(distributed.saved, expected.len() as u64);
            match distributed.blocks {
                Ok(blocks) if can_spill => assert_eq!(blocks.take(0).unwrap(), expected),
                Err(error) if !can_spill => assert!(error.to_string().contains("none"), "{error}"),
                other => panic!("{other:?}"),
            }
            let mut restored = SegmentSpool::new(folder.path(), 16 << 20);
            restored.restore(&path, distributed.saved).unwrap();
            let mut all = Vec::new();
            let take = |segments: &[Segment]| {
                all.extend_from_slice(segments);
                Ok(())
            };
            restored.for_each_chunk(take).unwrap();
            assert_eq!(all, expected);
        }
    }
}
