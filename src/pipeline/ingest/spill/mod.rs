//! Points that outgrow the memory are distributed, as they arrive, to a run on disk for each cell
//! of the plane.
//!
//! In: a sample and all points. Out: a [`BlockPlan`](crate::pipeline::plan::BlockPlan) of blocks
//! that fit in memory, each with its runs.
//!
//! ```text
//! sample ─▶ cells ─▶ points, one pass ─▶ run of each cell ─▶ long runs: split by own sample
//!                                                         └▶ short neighbours: one block
//! ```
//!
//! Cells are cut finer than blocks need to be, and joined once their points are counted. So points
//! are written once and read once, in any order, as long as the sample represents their
//! distribution. Where it does not, they are written and read twice: an example is a sorted stream
//! whose beginning served as the sample. (The design spools a stream to sample it, which writes and
//! reads everything twice.)

pub(crate) mod resplit;
pub(crate) mod run;

use std::io;
use std::path::{Path, PathBuf};

use crate::collections::bucket_sort::bucket_sort;
use crate::constraints::without_z::NO_Z;
use crate::geometry::Point;
use crate::input::PointBatch;
use crate::pipeline::ingest::point_store::PointStore;
pub(crate) use crate::pipeline::ingest::point_store::Record;
pub(crate) use crate::pipeline::plan::Run;
use crate::pipeline::threads::for_each_ahead;
use crate::store::KdTree;
use crate::store::divide::Item;
use crate::store::divide::divide;
pub(crate) use crate::store::format::cell_index::CellIndex;
pub(crate) use resplit::{damaged, read_points};
use run::RunWriter;

/// Number of points of a sample that are used: a cell of 1/512 has 128.
pub(crate) const SAMPLE: usize = 1 << 16;

/// Number of points that are sorted by cell at a time. They fit in the cache of a processor.
const AT_ONCE: usize = 1 << 13;

/// Number of pieces that may wait until they are added to the runs.
const SORTED_AHEAD: usize = 2;

/// Number of runs of which the files can stay open.
const OPEN_RUNS: u32 = 512;

/// Distributes points to the runs of cells.
#[derive(Debug)]
pub(crate) struct Spill {
    folder: PathBuf,
    tree: KdTree,
    index: CellIndex,
    runs: Vec<RunWriter>,
    /// Other runs of each cell, which are complete; empty if there are none.
    earlier: Vec<Vec<Run>>,
    has_z: bool,
}

/// The result of distributing points: the cells, and the runs of each.
#[derive(Debug)]
pub(crate) struct Spilled {
    pub(crate) tree: KdTree,
    pub(crate) runs: Vec<Vec<Run>>,
    pub(crate) has_z: bool,
}

impl Spilled {
    /// Returns the number of points of all runs.
    pub(crate) fn points(&self) -> u64 {
        self.runs.iter().flatten().map(|run| run.points).sum()
    }

    /// Returns the bytes of all runs.
    pub(crate) fn bytes(&self) -> u64 {
        self.runs.iter().flatten().map(|run| run.length).sum()
    }
}

/// Cuts the plane into about `cells` cells by a sample of at least one point.
pub(crate) fn cut(sample: &[Point], cells: usize) -> KdTree {
    let step = sample.len().div_ceil(SAMPLE);
    let items = sample.iter().step_by(step.max(1));
    let mut items: Vec<Item> = items.map(|&point| Item { point, position: 0 }).collect();
    let per_cell = items.len().div_ceil(cells.max(1)).max(1);
    divide(&mut items, per_cell, 1).tree
}

impl Spill {
    /// Starts with the leaves of `tree` as cells. Runs are numbered from `first_run` on. Their buffers
    /// take `buffers` bytes together.
    pub(crate) fn new(folder: &Path, tree: KdTree, buffers: usize, first_run: u32) -> Self {
        let count = tree.tiles();
        let buffer = buffers / count.max(1) as usize;
        let runs = (0..count).map(|cell| RunWriter::new(folder, first_run + cell, buffer, count <= OPEN_RUNS));
        Self {
            folder: folder.to_owned(),
            index: CellIndex::new(&tree),
            runs: runs.collect(),
            earlier: Vec::new(),
            tree,
            has_z: false,
        }
    }

    /// Lets the names of all files end with `suffix`.
    pub(crate) fn named(mut self, suffix: &str) -> Self {
        self.runs.iter_mut().for_each(|run| run.name(suffix));
        self
    }

    /// Adds runs of each cell that are complete, and says whether their points have z.
    pub(crate) fn behind(mut self, earlier: Vec<Vec<Run>>, has_z: bool) -> Self {
        (self.earlier, self.has_z) = (earlier, has_z);
        self
    }

    /// Returns the work folder.
    pub(crate) fn folder(&self) -> &Path {
        &self.folder
    }

    /// Distributes the points of a batch.
    pub(crate) fn push(&mut self, batch: &PointBatch) -> io::Result<()> {
        if !batch.z.is_empty() {
            begin_z(&mut self.runs, &mut self.has_z)?;
        }
        self.push_records(&records_of(batch))
    }

    /// Distributes the points of batches, on up to two threads.
    pub(crate) fn push_batches(
        &mut self,
        batches: impl Iterator<Item = PointBatch> + Send,
        threads: usize,
    ) -> io::Result<()> {
        let (index, cells) = (&self.index, self.runs.len());
        let pieces = batches.flat_map(|batch| {
            let (records, has_z) = (records_of(&batch), !batch.z.is_empty());
            let starts = (0..records.len()).step_by(AT_ONCE);
            starts.map(move |start| {
                let records = &records[start..records.len().min(start + AT_ONCE)];
                let points = sorted_by_cell(records, index, cells);
                Piece { points, has_z }
            })
        });
        push_pieces(&mut self.runs, &mut self.has_z, pieces, threads)
    }

    /// Distributes all points of a store, on up to two threads.
    pub(crate) fn push_store(&mut self, store: &PointStore, threads: usize) -> io::Result<()> {
        let attributes = &store.attributes;
        let record = |item: &Item| Record {
            point: item.point,
            z: attributes.z(item.position),
            record: attributes.record(item.position),
        };
        let (index, cells) = (&self.index, self.runs.len());
        let pieces = store.items.chunks(AT_ONCE).map(|items| Piece {
            points: sorted_by_cell(&items.iter().map(record).collect::<Vec<_>>(), index, cells),
            has_z: attributes.has_z(),
        });
        push_pieces(&mut self.runs, &mut self.has_z, pieces, threads)
    }

    /// Distributes points with their attributes, which have z if the runs do.
    fn push_records(&mut self, records: &[Record]) -> io::Result<()> {
        records.chunks(AT_ONCE).try_for_each(|records| {
            let sorted = sorted_by_cell(records, &self.index, self.runs.len());
            append(&mut self.runs, sorted, self.has_z)
        })
    }

    /// Writes the buffers. Returns the current runs and the tree of their cells.
    pub(crate) fn flush(&mut self) -> io::Result<(Vec<Run>, KdTree)> {
        let runs = self.runs.iter_mut().map(RunWriter::flushed);
        let earlier = self.earlier.iter().flatten().cloned().map(Ok);
        Ok((earlier.chain(runs).collect::<io::Result<_>>()?, self.tree.clone()))
    }

    /// Writes the buffers and returns the result.
    pub(crate) fn finish(self) -> io::Result<Spilled> {
        let mut runs = self.earlier;
        runs.resize(self.runs.len(), Vec::new());
        for (cell, run) in runs.iter_mut().zip(self.runs) {
            cell.push(run.finish()?);
        }
        Ok(Spilled {
            tree: self.tree,
            runs,
            has_z: self.has_z,
        })
    }
}

/// Points that are sorted by cell.
struct Piece {
    points: Vec<(u32, Record)>,
    has_z: bool,
}

/// Adds pieces to the runs. With more than one thread, they are made on another one.
fn push_pieces(
    runs: &mut [RunWriter],
    has_z: &mut bool,
    pieces: impl Iterator<Item = Piece> + Send,
    threads: usize,
) -> io::Result<()> {
    for_each_ahead(threads, "tile-sort", SORTED_AHEAD, pieces, |piece| {
        if piece.has_z {
            begin_z(runs, has_z)?;
        }
        append(runs, piece.points, *has_z)
    })
}

/// Switches to points with z.
fn begin_z(runs: &mut [RunWriter], has_z: &mut bool) -> io::Result<()> {
    if !*has_z {
        *has_z = true;
        runs.iter_mut().try_for_each(RunWriter::flush)?;
    }
    Ok(())
}

/// Returns the points of a batch with their attributes.
fn records_of(batch: &PointBatch) -> Vec<Record> {
    let numbered = batch.points.iter().zip(&batch.records).enumerate();
    let record = |(index, (&point, &record)): (usize, (&Point, &u64))| Record {
        point,
        z: batch.z.get(index).copied().unwrap_or(NO_Z),
        record,
    };
    numbered.map(record).collect()
}

/// Sorts points by cell, so that the buffers of a run are fetched into the processor's cache once
/// for all its points. Within a cell, the order remains.
fn sorted_by_cell(records: &[Record], index: &CellIndex, cells: usize) -> Vec<(u32, Record)> {
    let points: Vec<Point> = records.iter().map(|record| record.point).collect();
    let mut cell_of = Vec::with_capacity(points.len());
    index.cells_of(&points, &mut cell_of);
    let numbers = Vec::from_iter(0..records.len() as u32);
    let by_cell = bucket_sort(&numbers, cells, |&number| cell_of[number as usize], |&number| number);
    let of_number = |number: u32| (cell_of[number as usize], records[number as usize]);
    by_cell.into_iter().map(of_number).collect()
}

/// Adds points to the runs of their cells.
fn append(runs: &mut [RunWriter], points: Vec<(u32, Record)>, has_z: bool) -> io::Result<()> {
    points.into_iter().try_for_each(|(cell, Record { point, z, record })| {
        runs[cell as usize].push(point.normalized(), has_z.then_some(z), record)
    })
}
