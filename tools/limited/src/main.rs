//! Measures the commands of `tiletool` that take `--memory`, each under a hard limit slightly above
//! it, and prints a table of their peaks.
//!
//! ```sh
//! cargo build --release -p tiletool -p limited
//! target/release/limited --points 10000000
//! ```

use std::env;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

use anyhow::ensure;
use bytesize::ByteSize;
use clap::Parser;

use limited::cases::{self, Runner, Sizes};
use limited::{Limit, Took};

/// Measures the commands of `tiletool` under hard limits of memory.
///
/// Exit code 1: a command failed, was killed, or had more resident memory than the limit.
#[derive(Parser)]
#[command(after_help = "Example: limited --points 1000000 --memory 64MiB --only verify")]
struct Args {
    /// The tool; by default the one in the folder of this program
    #[arg(long)]
    tool: Option<PathBuf>,
    /// Number of points of the larger inputs; others have a tenth
    #[arg(long, default_value_t = 10_000_000)]
    points: u64,
    /// The values of --memory
    #[arg(long, value_delimiter = ',', default_value = "64MiB,128MiB,256MiB")]
    memory: Vec<ByteSize>,
    /// The difference between the hard limit and --memory
    #[arg(long, default_value = "16MiB")]
    more: ByteSize,
    /// Only the cases whose names contain this text, and the builds, which they need
    #[arg(long)]
    only: Option<String>,
    /// The folder for the work folder; it needs about 250 bytes a point
    #[arg(long)]
    folder: Option<PathBuf>,
    /// The seed of the inputs
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("limited: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Runs all cases; returns whether all succeeded.
fn run(args: &Args) -> anyhow::Result<bool> {
    let tool = match &args.tool {
        Some(tool) => tool.canonicalize()?,
        None => env::current_exe()?.with_file_name("tiletool"),
    };
    ensure!(
        tool.is_file(),
        "{}: there is no tool; build it, or give its path with --tool",
        tool.display()
    );
    let folder = args.folder.clone().unwrap_or_else(env::temp_dir);
    let folder = tempfile::tempdir_in(folder)?;
    let (points, stop) = (args.points, AtomicBool::new(false));
    let sizes = Sizes {
        points,
        alpha: 0.5,
        fewer_points: points / 10,
        long_segments: 1000.min(points / 1000),
        crossing_segments: points / 500,
        sites: points / 50,
        squares: points / 100,
        seed: args.seed,
    };
    cases::prepare(&tool, folder.path(), sizes)?;
    let mut all_well = true;
    for memory in args.memory.iter().map(|memory| memory.as_u64()) {
        let limit = Limit::new(memory + args.more.as_u64());
        let runner = Runner {
            tool: &tool,
            folder: folder.path(),
            limit: &limit,
            stop: &stop,
        };
        println!(
            "--memory {}: {}\n",
            ByteSize::b(memory).display().iec(),
            limit.describe()
        );
        println!(
            "| command | peak | without code | user s | system s | outcome |\n| --- | --: | --: | --: | --: | --- |"
        );
        for case in &cases::ALL {
            let is_wanted = args.only.as_ref().is_none_or(|only| case.name.contains(only.as_str()));
            if !is_wanted && !case.is_build() {
                continue;
            }
            let took = runner.run(case, memory, &[])?;
            let fault = cases::fault(&took, limit.bytes);
            all_well &= fault.is_none();
            println!("{}", row(case.name, &took, fault));
        }
        println!();
    }
    Ok(all_well)
}

fn row(name: &str, took: &Took, fault: Option<String>) -> String {
    let mebibytes =
        |bytes: Option<u64>| bytes.map_or("?".to_owned(), |bytes| format!("{:.1} MiB", bytes as f64 / 1048576.0));
    let seconds = |seconds: Option<f64>| seconds.map_or("?".to_owned(), |seconds| format!("{seconds:.1}"));
    format!(
        "| {name} | {} | {} | {} | {} | {} |",
        mebibytes(took.peak),
        mebibytes(took.own_peak),
        seconds(took.user_seconds),
        seconds(took.system_seconds),
        fault.unwrap_or("done".to_owned())
    )
}
