//! Seeded attacks on the library and the tool. Each round of an attack makes its own input from its
//! seed, and checks the results.
//!
//! ```sh
//! cargo build --release -p tiletool -p attacks
//! target/release/attacks pslg --seed 1 --seconds 60
//! ```
//!
//! `tools/campaign HOURS` runs all attacks alternately, and prints totals. A failed round prints
//! the command that repeats it.

mod bytes;
mod campaign;
mod limits;
mod power;
mod pslg;
mod refusals;
mod stars;
mod web;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, ValueEnum};

use campaign::{Context, Report, Round};

/// Attacks the library and the tool with random input, and checks their answers.
#[derive(Parser)]
#[command(after_help = "Example: attacks pslg --seed 1 --seconds 60")]
struct Args {
    /// The attack.
    attack: Attack,
    /// Seed of the first round; each later round uses the next number.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Starts no round after this number of seconds.
    #[arg(long, default_value_t = 10)]
    seconds: u64,
    /// Runs at most this number of rounds.
    #[arg(long)]
    rounds: Option<u64>,
    /// The tool; by default the one in the folder of this program.
    #[arg(long)]
    tool: Option<PathBuf>,
}

/// The attacks, in the order in which `tools/campaign` runs them.
#[derive(Clone, Copy, ValueEnum)]
enum Attack {
    /// Random PSLGs, checked by brute force.
    Pslg,
    /// Tile files with changed bytes, with right and with wrong checksums.
    Bytes,
    /// Limits of the system, under which a command must do all or nothing.
    Refusals,
    /// Power cuts, replayed from logs of writes.
    Power,
    /// Stars of lines that share a vertex, deferred or added later.
    Stars,
    /// Commands with random budgets, under hard limits of memory.
    Limits,
    /// A web server that gives false answers.
    Web,
}

impl Attack {
    /// The function that runs one round.
    fn round(self) -> Round {
        match self {
            Self::Pslg => pslg::round,
            Self::Bytes => bytes::round,
            Self::Refusals => refusals::round,
            Self::Power => power::round,
            Self::Stars => stars::round,
            Self::Limits => limits::round,
            Self::Web => web::round,
        }
    }
}

fn main() -> ExitCode {
    let args = Args::parse();
    let name = args
        .attack
        .to_possible_value()
        .map_or_else(String::new, |value| value.get_name().to_owned());
    let context = match Context::new(args.tool) {
        Ok(context) => context,
        Err(error) => {
            eprintln!("attacks: {error:#}");
            return ExitCode::FAILURE;
        }
    };
    let report = Report::of(
        &context,
        args.attack.round(),
        args.seed,
        args.seconds,
        args.rounds,
        &name,
    );
    report.print(&name)
}
