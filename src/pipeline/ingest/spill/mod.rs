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

use crate::constraints::without_z::NO_Z;
use crate::geometry::Point;
use crate::input::PointBatch;
use crate::pipeline::ingest::point_store::PointStore;
pub(crate) use crate::pipeline::ingest::point_store::Record;
pub(crate) use crate::pipeline::plan::Run;
use crate::store::KdTree;
use crate::store::divide::Item;
use crate::store::divide::divide;
pub(crate) use crate::store::format::cell_index::CellIndex;
pub(crate) use resplit::{damaged, read_points};
use run::RunWriter;

/// Number of points of a sample that are used: a cell of 1/512 has 128.
pub(crate) const SAMPLE: usize = 1 << 16;

/// Distributes points to the runs of cells.
#[derive(Debug)]
pub(crate) struct Spill {
    folder: PathBuf,
    tree: KdTree,
    index: CellIndex,
    runs: Vec<RunWriter>,
    has_z: bool,
    /// The cell of each point of a batch; reused to keep its memory.
    cells: Vec<u32>,
}

/// The result of distributing points: the cells, and the run of each.
#[derive(Debug)]
pub(crate) struct Spilled {
    pub(crate) tree: KdTree,
    pub(crate) runs: Vec<Run>,
    pub(crate) has_z: bool,
}

impl Spill {
    /// Cuts the plane into about `cells` cells by a sample of at least one point. Runs are numbered
    /// from `first_run` on. Their buffers take `buffers` bytes together.
    pub(crate) fn new(folder: &Path, sample: &[Point], cells: usize, buffers: usize, first_run: u32) -> Self {
        let step = sample.len().div_ceil(SAMPLE);
        let items = sample.iter().step_by(step.max(1));
        let mut items: Vec<Item> = items.map(|&point| Item { point, position: 0 }).collect();
        let per_cell = items.len().div_ceil(cells.max(1)).max(1);
        let tree = divide(&mut items, per_cell, 1).tree;
        let count = tree.tiles();
        let buffer = buffers / count.max(1) as usize;
        let runs = (0..count).map(|cell| RunWriter::new(folder, first_run + cell, buffer));
        Self {
            folder: folder.to_owned(),
            index: CellIndex::new(&tree),
            runs: runs.collect(),
            tree,
            has_z: false,
            cells: Vec::new(),
        }
    }

    /// Returns the work folder.
    pub(crate) fn folder(&self) -> &Path {
        &self.folder
    }

    /// Distributes the points of a batch.
    pub(crate) fn push(&mut self, batch: &PointBatch) -> io::Result<()> {
        if !batch.z.is_empty() {
            self.begin_z()?;
        }
        self.cells.clear();
        self.index.cells_of(&batch.points, &mut self.cells);
        for (index, (&cell, &point)) in self.cells.iter().zip(&batch.points).enumerate() {
            let z = self.has_z.then(|| batch.z.get(index).copied().unwrap_or(NO_Z));
            self.runs[cell as usize].push(point.normalized(), z, batch.records[index])?;
        }
        Ok(())
    }

    /// Distributes all points of a store.
    pub(crate) fn push_store(&mut self, store: &PointStore) -> io::Result<()> {
        let attributes = &store.attributes;
        if attributes.has_z() {
            self.begin_z()?;
        }
        for item in &store.items {
            self.push_record(Record {
                point: item.point,
                z: attributes.z(item.position),
                record: attributes.record(item.position),
            })?;
        }
        Ok(())
    }

    fn push_record(&mut self, Record { point, z, record }: Record) -> io::Result<()> {
        let cell = self.index.cell_of(point);
        self.runs[cell as usize].push(point, self.has_z.then_some(z), record)
    }

    /// Switches to points with z.
    fn begin_z(&mut self) -> io::Result<()> {
        if !self.has_z {
            self.has_z = true;
            for run in &mut self.runs {
                run.flush()?;
            }
        }
        Ok(())
    }

    /// Writes the buffers. Returns the current runs and the tree of their cells.
    pub(crate) fn flush(&mut self) -> io::Result<(Vec<Run>, KdTree)> {
        let runs: io::Result<_> = self.runs.iter_mut().map(RunWriter::flushed).collect();
        Ok((runs?, self.tree.clone()))
    }

    /// Writes the buffers and returns the result.
    pub(crate) fn finish(self) -> io::Result<Spilled> {
        let runs = self.runs.into_iter().map(RunWriter::finish);
        Ok(Spilled {
            tree: self.tree,
            runs: runs.collect::<io::Result<_>>()?,
            has_z: self.has_z,
        })
    }
}
