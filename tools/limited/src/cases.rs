//! The commands of `tiletool` that obey `--memory`, with inputs made for them, to be run under a
//! hard limit one after the other.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, ensure};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::{Ended, Limit, Took, measure};

/// The sizes of the inputs.
#[derive(Clone, Copy, Debug)]
pub struct Sizes {
    /// The number of points of the inputs for builds with points, short lines, and sites.
    pub points: u64,
    /// The number of segments for each of these points, in the input with short lines.
    pub alpha: f64,
    /// The number of points of the inputs with long lines, with crossing lines, and with obstacles.
    pub fewer_points: u64,
    /// The number of segments that each cross nearly the whole square.
    pub long_segments: u64,
    /// The number of segments that cross each other.
    pub crossing_segments: u64,
    /// The number of sites.
    pub sites: u64,
    /// The number of square obstacles, and of short lines for `constrain`.
    pub squares: u64,
    /// The seed of all inputs.
    pub seed: u64,
}

/// A command.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Its name in a table.
    pub name: &'static str,
    /// The file that the program changes, which is made as a copy of another: (original, copy).
    pub copy: Option<(&'static str, &'static str)>,
    /// Its arguments, without `--memory`.
    pub args: &'static str,
    /// Whether it has the option `--memory`.
    pub has_memory: bool,
}

impl Case {
    /// Returns whether it builds a tile file from inputs.
    #[must_use]
    pub fn is_build(&self) -> bool {
        self.args.starts_with("build ")
    }

    /// Returns whether it reads the output of another case.
    #[must_use]
    pub fn reads(&self, other: &Self) -> bool {
        let made = other.args.split(' ').skip_while(|&arg| arg != "-o").nth(1);
        let read = self.copy.map(|(from, _)| from);
        made.is_some_and(|made| read == Some(made) || self.args.split(' ').any(|arg| arg == made))
    }
}

const fn case(name: &'static str, args: &'static str) -> Case {
    Case {
        name,
        copy: None,
        args,
        has_memory: true,
    }
}

/// All cases, in order: later ones read the outputs of earlier ones.
pub const ALL: [Case; 20] = [
    case("build, points", "build points.f64 -o points.tiles --force --quiet"),
    case(
        "build, lines",
        "build lines.f64 --segments lines.u32 -o lines.tiles --force --quiet",
    ),
    case(
        "build, deferral",
        "build long.f64 --segments long.u32 -o long.tiles --force --quiet",
    ),
    case(
        "build, split",
        "build few.f64 --walls crossing.csv --crossings split -o split.tiles --force --quiet",
    ),
    case(
        "build, sites",
        "build points.f64 --sites sites.csv -o sites.tiles --force --quiet",
    ),
    case(
        "build, obstacles",
        "build few.f64 --obstacles squares.geojson -o squares.tiles --force --quiet",
    ),
    case("verify", "verify points.tiles"),
    case("verify, points", "verify --deep points.tiles --against points.f64"),
    case(
        "verify, lines",
        "verify --deep lines.tiles --against lines.f64 --segments lines.u32",
    ),
    case(
        "verify, deferral",
        "verify --deep long.tiles --against long.f64 --segments long.u32",
    ),
    case(
        "verify, split",
        "verify --deep split.tiles --against few.f64 --walls crossing.csv",
    ),
    case(
        "verify, sites",
        "verify --deep sites.tiles --against points.f64 --sites sites.csv",
    ),
    case(
        "verify, obstacles",
        "verify --deep squares.tiles --against few.f64 --obstacles squares.geojson",
    ),
    case("digest", "digest --recompute lines.tiles"),
    case("export, ply", "export lines.tiles -o out.ply"),
    case("export, geojson", "export squares.tiles -o out.geojson"),
    case("inspect, plot", "inspect lines.tiles --plot out.png"),
    case("inspect, regions", "inspect lines.tiles --regions"),
    Case {
        copy: Some(("points.tiles", "changed.tiles")),
        ..case("constrain", "constrain changed.tiles --segments short.csv --quiet")
    },
    Case {
        has_memory: false,
        ..case("compact", "compact changed.tiles")
    },
];

/// Writes the inputs of all cases to a folder.
///
/// # Errors
/// If the tool fails, or a file cannot be written.
pub fn prepare(tool: &Path, folder: &Path, sizes: Sizes) -> anyhow::Result<()> {
    let Sizes {
        points,
        alpha,
        fewer_points: few,
        long_segments: long,
        seed,
        ..
    } = sizes;
    for args in [
        format!("generate uniform -n {points} --seed {seed} -o points.f64"),
        format!("generate uniform -n {points} --pslg {alpha} --seed {seed} -o lines.f64"),
        format!("generate uniform -n {few} --long-segments {long} --seed {seed} -o long.f64"),
        format!("generate uniform -n {few} --seed {seed} -o few.f64"),
    ] {
        let output = Command::new(tool).current_dir(folder).args(args.split(' ')).output();
        let output = output.with_context(|| format!("cannot run {}", tool.display()))?;
        ensure!(
            output.status.success(),
            "{args}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    for (name, text) in [
        ("crossing.csv", crossing(&mut random, sizes.crossing_segments)),
        ("sites.csv", sites(&mut random, sizes.sites)),
        ("short.csv", short(&mut random, sizes.squares)),
        ("squares.geojson", squares(&mut random, sizes.squares)),
    ] {
        fs::write(folder.join(name), text).with_context(|| format!("cannot write {name}"))?;
    }
    Ok(())
}

/// Runs cases in the folder of their inputs.
#[derive(Debug)]
pub struct Runner<'a> {
    /// The tool.
    pub tool: &'a Path,
    /// The folder.
    pub folder: &'a Path,
    /// The hard limit.
    pub limit: &'a Limit,
    /// If set, ends the command with an error.
    pub stop: &'a AtomicBool,
}

impl Runner<'_> {
    /// Runs a case with `memory` bytes as `--memory`, and with additional arguments.
    ///
    /// # Errors
    /// If the case cannot be run, or is stopped.
    pub fn run(&self, case: &Case, memory: u64, more: &[String]) -> anyhow::Result<Took> {
        if let Some((from, to)) = case.copy {
            fs::copy(self.folder.join(from), self.folder.join(to)).with_context(|| format!("cannot copy {from}"))?;
        }
        let mut command = self.limit.command(self.tool.as_os_str());
        command.args(case.args.split(' ')).args(more);
        if case.has_memory {
            command.args(["--memory", &format!("{memory}B")]);
        }
        measure(command, self.folder, self.limit.watched(), self.stop)
    }
}

/// Returns what is wrong with the end of a case, or `None`: it must have succeeded, and its peak
/// must be at most `limit` bytes.
///
/// The peak is that of the resident memory. A test build's code is larger than that of a release
/// build, so in a test build only memory that belongs to no file is counted.
#[must_use]
pub fn fault(took: &Took, limit: u64) -> Option<String> {
    let peak = if cfg!(debug_assertions) {
        took.own_peak
    } else {
        took.peak
    };
    match took.ended {
        Ended::Done => peak
            .filter(|&peak| peak > limit)
            .map(|peak| format!("{} MiB were resident", peak >> 20)),
        Ended::Killed(signal) => Some(format!("killed by signal {signal}")),
        Ended::Failed(code) => Some(format!("exit code {code}: {}", took.complaint())),
    }
}

/// Returns a number from 0 to 1.
fn share(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

/// Returns segments up to 0.02 long, many of which cross.
fn crossing(random: &mut ChaCha8Rng, count: u64) -> String {
    let mut text = String::new();
    for _ in 0..count {
        let [x, y] = [0.01, 0.01].map(|least| least + 0.98 * share(random));
        let [dx, dy] = [0.02, 0.02].map(|length| length * (share(random) - 0.5));
        let _ = writeln!(text, "{x},{y},{},{}", x + dx, y + dy);
    }
    text
}

fn sites(random: &mut ChaCha8Rng, count: u64) -> String {
    let mut text = "x,y,id\n".to_owned();
    for id in 0..count {
        let _ = writeln!(text, "{},{},{id}", share(random), share(random));
    }
    text
}

/// Returns the centre and the width of each cell of a grid.
fn cells(count: u64) -> impl Iterator<Item = (f64, f64, f64)> {
    let columns = count.max(1).isqrt();
    let width = 0.98 / columns as f64;
    (0..columns * columns).map(move |cell| {
        let [column, row] = [cell % columns, cell / columns].map(|at| 0.01 + width * (at as f64 + 0.5));
        (column, row, width)
    })
}

/// Returns segments that do not cross.
fn short(random: &mut ChaCha8Rng, count: u64) -> String {
    let mut text = String::new();
    for (x, y, width) in cells(count) {
        let [dx, dy] = [width; 2].map(|width| 0.9 * width * (share(random) - 0.5));
        let _ = writeln!(
            text,
            "{},{},{},{}",
            x - dx / 2.0,
            y - dy / 2.0,
            x + dx / 2.0,
            y + dy / 2.0
        );
    }
    text
}

/// Returns squares side by side that do not touch.
fn squares(random: &mut ChaCha8Rng, count: u64) -> String {
    let mut text = r#"{"type":"FeatureCollection","features":["#.to_owned();
    for (number, (x, y, width)) in cells(count).enumerate() {
        let half = width * (0.1 + 0.3 * share(random));
        let [a, b, c, d] = [x - half, y - half, x + half, y + half];
        let _ = write!(
            text,
            r#"{}{{"type":"Feature","properties":{{}},"geometry":{{"type":"Polygon","coordinates":[[[{a},{b}],[{c},{b}],[{c},{d}],[{a},{d}],[{a},{b}]]]}}}}"#,
            if number > 0 { "," } else { "" },
        );
    }
    text + "]}"
}
