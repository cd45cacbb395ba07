//! Tile files: those that an experiment is given, and those that it has this program make of obstacles.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, bail};

use limited::{Ended, measure};

/// Whether a file's name ends so, in small letters or large ones.
pub fn ends_in(file: &Path, suffix: &str) -> bool {
    file.extension().is_some_and(|its| its.eq_ignore_ascii_case(suffix))
}

/// The file of this program, to run it once more.
pub fn own_program() -> anyhow::Result<PathBuf> {
    std::env::current_exe().context("cannot find this program's own file")
}

/// Triangulates obstacles, as GeoJSON or a `.poly`, with these sites, in a process of its own that goes away if `stop` is set. The tile
/// file lies in the work folder `scratch`, under this name.
pub fn triangulate(
    obstacles: &Path,
    sites: Option<&Path>,
    scratch: &Path,
    name: &str,
    stop: &AtomicBool,
) -> anyhow::Result<PathBuf> {
    // The process runs in its own folder.
    let found = |path: &Path| {
        let whole = path.canonicalize();
        whole.with_context(|| format!("cannot find {}", path.display()))
    };
    let scratch = found(scratch)?;
    let mut build = Command::new(own_program()?);
    build.args(["tool", "build", "--quiet", "-o", name]);
    if !ends_in(obstacles, "poly") {
        build.arg("--obstacles");
    }
    build.arg(found(obstacles)?);
    if let Some(sites) = sites {
        build.arg("--sites").arg(found(sites)?);
    }
    let took = measure(build, &scratch, None, stop)?;
    if took.ended != Ended::Done {
        bail!("{} cannot be triangulated: {}", obstacles.display(), took.complaint());
    }
    Ok(scratch.join(name))
}
