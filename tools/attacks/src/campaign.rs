//! Runs the rounds of an attack one after the other, and sums up their results.

use std::collections::BTreeMap;
use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context as _, ensure};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// What every round needs.
pub struct Context {
    /// The program `tiletool`.
    pub tool: PathBuf,
}

impl Context {
    /// Creates a context with this tool, or with the one in the folder of this program.
    ///
    /// # Errors
    /// If there is no such file.
    pub fn new(tool: Option<PathBuf>) -> anyhow::Result<Self> {
        let tool = match tool {
            Some(tool) => tool.canonicalize()?,
            None => env::current_exe()?.with_file_name("tiletool"),
        };
        ensure!(
            tool.is_file(),
            "{}: there is no tool; build it in the same profile, or name it with --tool",
            tool.display()
        );
        Ok(Self { tool })
    }

    /// Returns a command that runs the tool in a folder; the arguments are separated by spaces.
    pub fn command(&self, folder: &Path, args: &str) -> Command {
        let mut command = Command::new(&self.tool);
        command.current_dir(folder).args(args.split(' ')).stdin(Stdio::null());
        command
    }

    /// Returns the path of the library `tools/faults`, to be preloaded.
    ///
    /// # Errors
    /// If the library is not there.
    pub fn preload(&self) -> anyhow::Result<PathBuf> {
        let own = env::current_exe()?;
        let found = ["libfaults.so", "deps/libfaults.so"].map(|name| own.with_file_name(name));
        let found = found.into_iter().find(|path| path.is_file());
        found.context("libfaults.so is not beside this program; build package faults in the same profile")
    }

    /// Runs the tool in a folder; the arguments are separated by spaces. Returns its standard
    /// output.
    ///
    /// # Errors
    /// If it fails; the error contains its error output.
    pub fn run(&self, folder: &Path, args: &str) -> anyhow::Result<String> {
        let output = self
            .command(folder, args)
            .output()
            .with_context(|| self.tool.display().to_string())?;
        let errors = String::from_utf8_lossy(&output.stderr);
        ensure!(output.status.success(), "tiletool {args}: {}: {errors}", output.status);
        Ok(String::from_utf8(output.stdout)?)
    }
}

/// Returns a random number below `end`, which must be far less than 2⁶⁴.
pub fn below(random: &mut ChaCha8Rng, end: u64) -> u64 {
    let wide = u128::from(random.next_u64()) * u128::from(end);
    (wide >> 64) as u64
}

/// What a round counted, by name: `("triangulations", 12)`.
pub type Counts = Vec<(&'static str, u64)>;

/// One round of an attack. Returns its counts, or an error that says which check failed.
pub type Round = fn(&Context, ChaCha8Rng) -> anyhow::Result<Counts>;

/// An attack ends after this number of failed rounds: more would say nothing new.
const MOST_FAILED: u64 = 10;

/// The totals of an attack's rounds.
#[derive(Default)]
pub struct Report {
    rounds: u64,
    failed: u64,
    counts: BTreeMap<&'static str, u64>,
}

impl Report {
    /// Runs rounds until the time or the number of rounds is used up.
    pub fn of(context: &Context, round: Round, seed: u64, seconds: u64, most: Option<u64>, name: &str) -> Self {
        let end = Instant::now() + Duration::from_secs(seconds);
        let mut report = Self::default();
        let is_over = |rounds| most.map_or(rounds > 0 && Instant::now() >= end, |most| rounds >= most);
        while !is_over(report.rounds) && report.failed < MOST_FAILED {
            let seed = seed + report.rounds;
            report.rounds += 1;
            match round(context, ChaCha8Rng::seed_from_u64(seed)) {
                Ok(counts) => counts
                    .into_iter()
                    .for_each(|(name, count)| *report.counts.entry(name).or_default() += count),
                Err(error) => {
                    report.failed += 1;
                    eprintln!("{name}: {error:#}\n  repeat it with: attacks {name} --seed {seed} --rounds 1");
                }
            }
        }
        report
    }

    /// Prints the totals in one line. Returns failure if a round failed.
    pub fn print(&self, name: &str) -> ExitCode {
        let counts: String = self
            .counts
            .iter()
            .map(|(name, count)| format!(", {count} {name}"))
            .collect();
        println!("{name}: {} rounds{counts}, {} failed", self.rounds, self.failed);
        ExitCode::from(u8::from(self.failed > 0))
    }
}
