//! Makes blocks from runs: splits long runs again, and joins short neighbours.

use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::{fs, io};

use crate::geometry::Point;
use crate::pipeline::ingest::point_store::Record;
use crate::pipeline::ingest::spill::run::{HEADER, chunk_length, decode_chunk};
use crate::pipeline::ingest::spill::{SAMPLE, Spill, Spilled, cut};
use crate::pipeline::options::{DuplicateRule, Duplicates, Progress};
use crate::pipeline::plan::{Block, BlockPlan, Run};
use crate::shown;
use crate::store::{KdNode, KdTree, TileId};

/// Limits of splitting.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SplitLimits {
    /// Most points of a block.
    pub(crate) block_points: u64,
    /// Most cells that points are distributed to at once.
    pub(crate) cells: usize,
    /// Bytes of the buffers of all cells together.
    pub(crate) buffers: usize,
}

/// A part of the plane: a cell with its runs, or two parts.
enum RunTree {
    Cell(Vec<Run>),
    Cut { cut: KdNode, children: Box<[RunTree; 2]> },
}

/// The state while runs are split.
struct Splitting<'a> {
    folder: &'a Path,
    limits: SplitLimits,
    rule: DuplicateRule,
    progress: &'a Progress,
    has_z: bool,
    next_run: u32,
    merged: u64,
    bytes_read: u64,
    bytes_rewritten: u64,
}

/// Makes blocks from runs. Each fits in memory, and no two neighbours in the tree could be one
/// block.
pub(crate) fn plan_blocks(
    spilled: Spilled,
    folder: &Path,
    limits: SplitLimits,
    rule: DuplicateRule,
    progress: &Progress,
) -> io::Result<BlockPlan> {
    let mut splitting = Splitting {
        folder,
        limits,
        rule,
        progress,
        has_z: spilled.has_z,
        next_run: spilled
            .runs
            .iter()
            .flatten()
            .map(|run| run.number + 1)
            .max()
            .unwrap_or(0),
        merged: 0,
        bytes_read: 0,
        bytes_rewritten: 0,
    };
    let bytes_written = spilled.bytes();
    let points = spilled.points();
    if points == 0 {
        return Ok(BlockPlan::default());
    }
    let subtree = splitting.split(run_tree(spilled))?;
    let (mut nodes, mut blocks) = (Vec::new(), Vec::new());
    join(subtree, limits.block_points, &mut nodes, &mut blocks);
    Ok(BlockPlan {
        tree: KdTree::new(nodes).map_err(io::Error::other)?,
        blocks,
        points,
        merged: splitting.merged,
        has_z: splitting.has_z,
        bytes_read: splitting.bytes_read,
        bytes_written,
        bytes_rewritten: splitting.bytes_rewritten,
    })
}

fn run_tree(spilled: Spilled) -> RunTree {
    fn below(tree: &KdTree, node: u32, runs: &mut [Vec<Run>]) -> RunTree {
        match tree.nodes()[node as usize] {
            KdNode::Leaf(cell) => RunTree::Cell(std::mem::take(&mut runs[cell.0 as usize])),
            cut @ (KdNode::X { right, .. } | KdNode::Y { right, .. }) => RunTree::Cut {
                cut,
                children: Box::new([below(tree, node + 1, runs), below(tree, right, runs)]),
            },
        }
    }
    let Spilled { tree, mut runs, .. } = spilled;
    below(&tree, 0, &mut runs)
}

impl Splitting<'_> {
    /// Splits all cells that have too many points.
    fn split(&mut self, subtree: RunTree) -> io::Result<RunTree> {
        match subtree {
            RunTree::Cut { cut, children } => {
                let [left, right] = *children;
                Ok(RunTree::Cut {
                    cut,
                    children: Box::new([self.split(left)?, self.split(right)?]),
                })
            }
            RunTree::Cell(runs) if points_of(&runs) > self.limits.block_points => {
                let subtree = self.split_cell(&runs)?;
                self.split(subtree)
            }
            whole => Ok(whole),
        }
    }

    /// Distributes the points of a cell to cells of their own. Either at least two of them get points, or
    /// many equal points are merged into one.
    fn split_cell(&mut self, runs: &[Run]) -> io::Result<RunTree> {
        let all = points_of(runs);
        let _span = tracing::debug_span!("split", run = runs[0].number, points = all).entered();
        // Of thousands of inputs, each may have a run here: only one is open at a time.
        let runs = || runs.iter().filter(|run| run.points > 0);
        let mut sample = Vec::new();
        for run in runs() {
            let share = u128::from(run.points) * SAMPLE as u128 / u128::from(all);
            sample.extend(RunReader::open(run.path(self.folder), run.length)?.sample(share as usize)?);
        }
        let cells = (4 * all / self.limits.block_points).min(self.limits.cells as u64) as usize;
        let tree = cut(&sample, cells.max(4));
        let mut heavy = HeavyPoints::of(&sample, self.rule);
        let mut spill = Spill::new(self.folder, tree, self.limits.buffers, self.next_run);
        spill.has_z = self.has_z;
        for run in runs() {
            self.distribute(run, &mut heavy, &mut spill)?;
        }
        let before = heavy.taken;
        let kept: Vec<Record> = heavy.kept().collect();
        spill.push_records(&kept)?;
        self.merged = self.merged.wrapping_sub(kept.len() as u64).wrapping_add(before);
        let spilled = spill.finish()?;
        self.next_run += spilled.runs.len() as u32;
        self.bytes_read += runs().map(|run| run.length).sum::<u64>();
        self.bytes_rewritten += spilled.bytes();
        for run in runs() {
            fs::remove_file(run.path(self.folder))?;
        }
        Ok(run_tree(spilled))
    }

    /// Distributes the points of a run, but for those at heavy positions.
    fn distribute(&self, run: &Run, heavy: &mut HeavyPoints, spill: &mut Spill) -> io::Result<()> {
        let mut reader = RunReader::open(run.path(self.folder), run.length)?;
        let (mut chunk, mut records) = (Vec::new(), Vec::new());
        while reader.next(&mut chunk)? {
            if self.progress.is_cancelled() {
                return Err(io::ErrorKind::Interrupted.into());
            }
            records.clear();
            let decoded = decode_chunk(&chunk, |record| records.push(record));
            decoded.map_err(|problem| damaged(&reader.path, problem))?;
            records.retain(|&record| !heavy.take(record));
            spill.push_records(&records)?;
        }
        Ok(())
    }
}

/// Joins neighbours that together have no more than `most` points into one block. A cell without
/// points is joined with its neighbour.
fn join(subtree: RunTree, most: u64, nodes: &mut Vec<KdNode>, blocks: &mut Vec<Block>) {
    match subtree {
        RunTree::Cut { cut, children } if points(&children[0]) + points(&children[1]) > most => {
            let [left, right] = *children;
            if points(&left) == 0 {
                return join(right, most, nodes, blocks);
            } else if points(&right) == 0 {
                return join(left, most, nodes, blocks);
            }
            let index = nodes.len();
            nodes.push(cut);
            join(left, most, nodes, blocks);
            let behind = nodes.len() as u32;
            if let KdNode::X { right, .. } | KdNode::Y { right, .. } = &mut nodes[index] {
                *right = behind;
            }
            join(right, most, nodes, blocks);
        }
        whole => {
            let mut block = Block::default();
            gather(whole, &mut block);
            nodes.push(KdNode::Leaf(TileId(blocks.len() as u32)));
            blocks.push(block);
        }
    }
}

fn points(subtree: &RunTree) -> u64 {
    match subtree {
        RunTree::Cell(runs) => points_of(runs),
        RunTree::Cut { children, .. } => children.iter().map(points).sum(),
    }
}

fn points_of(runs: &[Run]) -> u64 {
    runs.iter().map(|run| run.points).sum()
}

fn gather(subtree: RunTree, block: &mut Block) {
    match subtree {
        RunTree::Cell(runs) => {
            block.points += points_of(&runs);
            block.runs.extend(runs.into_iter().filter(|run| run.points > 0));
        }
        RunTree::Cut { children, .. } => children.into_iter().for_each(|subtree| gather(subtree, block)),
    }
}

/// Positions shared by so large a share of a run's points that these are merged as they pass.
struct HeavyPoints {
    points: Vec<(Point, Vec<Record>)>,
    rule: DuplicateRule,
    taken: u64,
}

impl HeavyPoints {
    /// Finds the positions that more than a sixteenth of the sample shares.
    fn of(sample: &[Point], rule: DuplicateRule) -> Self {
        let mut sorted = sample.to_vec();
        sorted.sort_unstable_by(|a, b| a.lex_cmp(*b));
        let groups = sorted.chunk_by(|a, b| a == b);
        let heavy = groups.filter(|group| group.len() > 1 && group.len() > sample.len() / 16);
        Self {
            points: heavy.map(|group| (group[0], Vec::new())).collect(),
            rule,
            taken: 0,
        }
    }

    /// Takes a point if it is at such a position. Returns whether it did.
    fn take(&mut self, record: Record) -> bool {
        let Some((_, kept)) = self.points.iter_mut().find(|(point, _)| *point == record.point) else {
            return false;
        };
        self.taken += 1;
        if self.rule.duplicates == Duplicates::Error && record.record < self.rule.first_end {
            // The error names the first two.
            kept.push(record);
            kept.sort_unstable_by_key(|kept| kept.record);
            kept.truncate(2);
        } else if let Some(one) = kept.first_mut() {
            if self.rule.prefers((record.z, record.record), (one.z, one.record)) {
                *one = record;
            }
        } else {
            kept.push(record);
        }
        true
    }

    fn kept(self) -> impl Iterator<Item = Record> {
        self.points.into_iter().flat_map(|(_, kept)| kept)
    }
}

/// Reads a run chunk by chunk.
struct RunReader {
    path: PathBuf,
    file: File,
    offset: u64,
    length: u64,
}

impl RunReader {
    fn open(path: PathBuf, length: u64) -> io::Result<Self> {
        Ok(Self {
            file: File::open(&path)?,
            path,
            offset: 0,
            length,
        })
    }

    /// Returns the length of the chunk at the offset; 0 at the end.
    fn peek(&self) -> io::Result<usize> {
        if self.offset == self.length {
            return Ok(0);
        }
        let mut header = [0; HEADER];
        self.file.read_exact_at(&mut header, self.offset)?;
        chunk_length(&header, self.length - self.offset).map_err(|problem| damaged(&self.path, problem))
    }

    /// Reads the next chunk. Returns `false` at the end.
    fn next(&mut self, chunk: &mut Vec<u8>) -> io::Result<bool> {
        let length = self.peek()?;
        chunk.resize(length, 0);
        self.file.read_exact_at(chunk, self.offset)?;
        self.offset += length as u64;
        Ok(length > 0)
    }

    /// Samples about `most` points, at least one, from chunks all over the run.
    fn sample(&mut self, most: usize) -> io::Result<Vec<Point>> {
        /// Most chunks sampled.
        const CHUNKS: usize = 64;
        let mut starts = Vec::new();
        loop {
            match self.peek()? {
                0 => break,
                length => {
                    starts.push(self.offset);
                    self.offset += length as u64;
                }
            }
        }
        let (mut sample, mut chunk) = (Vec::new(), Vec::new());
        let chunks = most.clamp(1, CHUNKS);
        for start in starts.iter().step_by(starts.len().div_ceil(chunks).max(1)) {
            self.offset = *start;
            self.next(&mut chunk)?;
            let mut points = Vec::new();
            decode_chunk(&chunk, |record| points.push(record.point)).map_err(|problem| damaged(&self.path, problem))?;
            let step = points.len().div_ceil((most / chunks).max(1));
            sample.extend(points.into_iter().step_by(step.max(1)));
        }
        Ok(sample)
    }
}

/// Passes the points of a run to `take`, chunk by chunk.
pub(crate) fn read_points(run: &Run, folder: &Path, take: &mut dyn FnMut(&[Point])) -> io::Result<()> {
    if run.length == 0 {
        return Ok(());
    }
    let mut reader = RunReader::open(run.path(folder), run.length)?;
    let (mut chunk, mut points) = (Vec::new(), Vec::new());
    while reader.next(&mut chunk)? {
        points.clear();
        decode_chunk(&chunk, |record| points.push(record.point)).map_err(|problem| damaged(&reader.path, problem))?;
        take(&points);
    }
    Ok(())
}

/// Returns an I/O error for a damaged run.
pub(crate) fn damaged(path: &Path, problem: &str) -> io::Error {
    let message = format!("{}: {problem}: the work is damaged, start again", shown::path(path));
    io::Error::new(io::ErrorKind::InvalidData, message)
}
