//! Tile files: those given to an experiment, and those that it makes from obstacles.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, bail};

use limited::{Ended, measure};

/// Returns whether a file has this suffix, in lower or upper case.
pub fn ends_in(file: &Path, suffix: &str) -> bool {
    file.extension().is_some_and(|its| its.eq_ignore_ascii_case(suffix))
}

/// Returns the path of this program, to run it again.
pub fn own_program() -> anyhow::Result<PathBuf> {
    std::env::current_exe().context("cannot find this program's own file")
}

/// Triangulates obstacles, from GeoJSON or a `.poly`, with these sites, in a process of its own
/// that is killed if `stop` is set. The tile file is in the work folder `scratch`, under this name.
pub fn triangulate(
    obstacles: &Path,
    sites: Option<&Path>,
    scratch: &Path,
    name: &str,
    stop: &AtomicBool,
) -> anyhow::Result<PathBuf> {
    // The process runs in another folder.
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
