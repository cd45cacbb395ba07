//! Input tasks: what they distributed, and the list of them.

use std::path::Path;

use delaunay_tiles::{DistributedInput, InputTasks, TaskOptions};
use serde::Serialize;

use super::numbers::{left, ranges};
use super::reading::{distribute, names};
use crate::common::{self, bytes, counted, shown, thousands};

/// The output of `--json` for an input that was distributed.
#[derive(Serialize)]
struct InputReport {
    input: u32,
    points: u64,
    bytes_written: u64,
    seconds: f64,
}

#[derive(Serialize)]
struct InputsReport {
    inputs: Vec<InputReport>,
}

/// The tasks of the inputs of a build: the output of `--json`, whose keys are stable, and the report for
/// people.
#[derive(Serialize)]
pub struct InputList {
    /// Bytes of memory that each needs.
    memory: u64,
    inputs: Vec<InputEntry>,
}

#[derive(Serialize)]
struct InputEntry {
    name: String,
    records: u64,
    is_done: bool,
}

impl InputList {
    pub fn of(tasks: &InputTasks) -> Self {
        let mut names = names(tasks).into_iter();
        let entry = |input| {
            let records = tasks.records(input);
            InputEntry {
                name: names.next().unwrap_or_default(),
                records: records.end - records.start,
                is_done: tasks.is_done(input),
            }
        };
        Self {
            memory: tasks.memory(),
            inputs: (0..tasks.inputs()).map(entry).collect(),
        }
    }

    /// Returns the report for people. `file` is that of the build.
    pub fn report(&self, file: &Path) -> String {
        let records = self.inputs.iter().map(|input| input.records).sum();
        let left = left(self.inputs.iter().map(|input| input.is_done));
        let head = format!(
            "{}: {} of {} in all, each distributed with {}\n",
            shown(file),
            counted(self.inputs.len() as u64, "input", "inputs"),
            counted(records, "record", "records"),
            bytes(self.memory),
        );
        let next = match left[..] {
            [] => {
                "all are distributed; the command of the build with --tasks --resume plans blocks, and without --tasks \
                   completes the file\n"
                    .to_owned()
            }
            [first, ..] => format!(
                "{} left: {}\ndistribute each on any machine that shares the folder, such as\n  tiletool task {} --input \
                 {first}\nand then plan blocks by the command of the build with --tasks --resume in place of --tasks=inputs\n",
                thousands(left.len() as u64),
                ranges(&left),
                shown(file),
            ),
        };
        head + &next
    }
}

/// Distributes inputs, and prints what was done.
pub fn run(file: &Path, tasks: &InputTasks, inputs: &[u32], options: TaskOptions, is_json: bool) -> anyhow::Result<()> {
    let stop = common::interruption();
    let mut report = InputsReport { inputs: Vec::new() };
    for &input in inputs {
        let done = distribute(tasks, input, (options.memory, options.threads), &stop);
        let DistributedInput {
            points,
            bytes_written,
            seconds,
            ..
        } = done.map_err(|error| error.context(shown(file)))?;
        if !is_json {
            let points = counted(points, "point", "points");
            let written = bytes(bytes_written);
            common::print_summary(
                "the result",
                &format!("input {input}: {points}, {written} written, {seconds:.1} s\n"),
            )?;
        }
        report.inputs.push(InputReport {
            input,
            points,
            bytes_written,
            seconds,
        });
    }
    match is_json {
        true => common::print_json("the result", &report),
        false => Ok(()),
    }
}
