//! The files of input tasks: the plan of all, and the output of each.

use std::io::{self, Write};

use crate::pipeline::plan::Run;
use crate::pipeline::resume::checked_file;
use crate::pipeline::resume::codec::{Stored, decoded, stored};
use crate::pipeline::work_folder::WorkFolder;
use crate::store::KdTree;

const PLAN: &[u8; 8] = b"dtinpt01";
const INPUT: &[u8; 8] = b"dtdist01";

/// The plan of input tasks.
#[derive(Clone, Debug)]
pub(crate) struct SavedInputs {
    /// Distinguishes these tasks from all others.
    pub(super) id: u64,
    /// Inputs, and options that determine the output.
    pub(crate) identity: String,
    /// The memory budget in bytes.
    pub(super) memory: u64,
    /// Bytes of the buffers of all cells together.
    pub(super) buffers: usize,
    pub(super) cells: KdTree,
    /// The first record number of each input, and behind the last one.
    pub(super) first_records: Vec<u64>,
    /// Any text for whoever does the tasks.
    pub(super) memo: String,
}

/// The output of a task, besides the runs.
#[derive(Clone, Debug)]
pub(super) struct SavedInput {
    /// That of the tasks.
    pub(super) id: u64,
    /// Those that have points.
    pub(super) runs: Vec<Run>,
    pub(super) has_z: bool,
    /// Any text for whoever takes the input.
    pub(super) memo: String,
}

stored! {
    SavedInputs { id, identity, memory, buffers, cells, first_records, memo }
    SavedInput { id, runs, has_z, memo }
}

impl SavedInputs {
    /// Reads the plan. Returns `None` if there is none, or if it is damaged.
    pub(crate) fn load(folder: &WorkFolder) -> io::Result<Option<Self>> {
        Ok(checked_file::read(&folder.inputs(), PLAN)?.and_then(|body| decoded(&body)))
    }

    pub(super) fn save(&self, folder: &WorkFolder) -> io::Result<()> {
        let mut body = Vec::new();
        self.put(&mut body);
        checked_file::write(&folder.inputs(), PLAN, &body)
    }

    /// Returns the number of inputs.
    pub(super) fn inputs(&self) -> u32 {
        self.first_records.len().saturating_sub(1) as u32
    }

    /// Returns the number of the run of the first cell of an input, or behind those of all inputs.
    pub(super) fn first_run(&self, input: u32) -> u32 {
        input * self.cells.tiles()
    }
}

impl SavedInput {
    /// Reads the output of a task of these tasks. Returns `None` if there is none, or if it is damaged.
    pub(super) fn load(folder: &WorkFolder, input: u32, id: u64) -> io::Result<Option<Self>> {
        let saved: Option<Self> = checked_file::read(&folder.input(input), INPUT)?.and_then(|body| decoded(&body));
        Ok(saved.filter(|saved| saved.id == id))
    }

    /// Writes it under its name at once. Others may do the same.
    pub(super) fn save(&self, folder: &WorkFolder, input: u32) -> io::Result<()> {
        let mut body = Vec::new();
        self.put(&mut body);
        let mut file = WorkFolder::replace(&folder.input(input))?;
        file.write_all(&checked_file::bytes(INPUT, &body))?;
        file.as_file().sync_all()?;
        file.persist(folder.input(input))?;
        Ok(())
    }

    /// Returns the number of its points.
    pub(super) fn points(&self) -> u64 {
        self.runs.iter().map(|run| run.points).sum()
    }

    /// Returns whether all runs are there, as far as their lengths tell.
    pub(super) fn is_whole(&self, folder: &WorkFolder) -> bool {
        let is_there = |run: &Run| {
            let found = run.path(folder.spill()).metadata();
            found.is_ok_and(|found| found.len() == run.length)
        };
        self.runs.iter().all(is_there)
    }
}
