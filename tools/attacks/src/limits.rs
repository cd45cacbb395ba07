//! Runs commands that take `--memory`, with inputs, budgets, tiles and threads of random sizes,
//! under a hard limit 16 MiB above the budget.
//!
//! A command may report that the memory is too little. It must not be killed, and its peak must not
//! exceed the limit (see [`cases::fault`]).

use std::sync::atomic::AtomicBool;

use anyhow::Context as _;
use limited::cases::{self, Case, Runner, Sizes};
use limited::{Ended, Limit};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;

use crate::campaign::{Context, Counts};

/// The difference between the hard limit and the budget, in bytes.
const MORE: u64 = 16 << 20;

/// Runs some commands, each of which needs the output of an earlier one.
pub fn round(context: &Context, mut random: ChaCha8Rng) -> anyhow::Result<Counts> {
    let folder = tempfile::tempdir()?;
    let mut between = |least: u64, most: u64| least + random.next_u64() % (most - least);
    let sizes = Sizes {
        points: between(50_000, 800_000),
        alpha: between(1, 100) as f64 / 100.0,
        fewer_points: between(20_000, 300_000),
        long_segments: between(1, 400),
        crossing_segments: between(1, 20_000),
        sites: between(1, 50_000),
        squares: between(1, 40_000),
        seed: between(0, 1 << 40),
    };
    let memory = between(40 << 20, 160 << 20);
    let more = [
        "--tile-vertices".to_owned(),
        between(2000, 80_000).to_string(),
        "--threads".to_owned(),
        between(1, 9).to_string(),
    ];
    cases::prepare(&context.tool, folder.path(), sizes)?;
    let (limit, stop) = (Limit::new(memory + MORE), AtomicBool::new(false));
    let runner = Runner {
        tool: &context.tool,
        folder: folder.path(),
        limit: &limit,
        stop: &stop,
    };
    let builds: Vec<&Case> = cases::ALL.iter().filter(|case| case.is_build()).collect();
    let build = builds[between(0, builds.len() as u64) as usize];
    let others = cases::ALL.iter().filter(|case| !case.is_build() && case.reads(build));
    let (mut commands, mut refusals) = (0, 0);
    for case in std::iter::once(build).chain(others) {
        let more = if case.is_build() { more.as_slice() } else { &[] };
        let took = runner.run(case, memory, more)?;
        commands += 1;
        if took.ended == Ended::Failed(1) && took.complaint().contains("MiB") {
            refusals += 1;
            if case.is_build() {
                break;
            }
        } else if let Some(fault) = cases::fault(&took, memory + MORE) {
            let what = || format!("{} {} with {memory} bytes, {sizes:?}", case.args, more.join(" "));
            return Err(anyhow::anyhow!(fault)).with_context(what);
        }
    }
    Ok(vec![("commands", commands), ("refusals", refusals)])
}
