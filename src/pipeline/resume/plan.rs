//! The plan of a build: its blocks, and all of its input but points and segments.

use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::{fs, io};

use crate::pipeline::context::Given;
use crate::pipeline::ingest::drape::Draping;
use crate::pipeline::plan::{BlockPlan, NodeLimits};
use crate::pipeline::resume::codec::{Stored, decoded, stored};

/// A plan, and the build that it belongs to.
#[derive(Debug)]
pub(crate) struct SavedPlan {
    pub(crate) settings: SavedSettings,
    pub(crate) given: Given,
    pub(crate) plan: BlockPlan,
    /// How vertices take their z from the surface, if there is one.
    pub(crate) draping: Option<Draping>,
}

/// The settings of a build, and the sizes of what has arrived.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct SavedSettings {
    /// Inputs, and options that determine the output.
    pub(crate) identity: String,
    /// The memory budget in bytes.
    pub(crate) memory: u64,
    /// Bytes that segments keep, and sites and seeds.
    pub(crate) arrivals: [u64; 2],
    pub(crate) limits: NodeLimits,
    /// First record number of segment ends and sites.
    pub(crate) first_end: u64,
    /// Number of segments, which are in a file of their own.
    pub(crate) segments: u64,
}

stored! {
    SavedSettings { identity, memory, arrivals, limits, first_end, segments }
}

const MAGIC: &[u8; 8] = b"dtplan06";

/// Writes a plan to `path` atomically: the file is renamed to `path` once it is complete and
/// synced.
pub(crate) fn save(
    path: &Path,
    settings: &SavedSettings,
    given: &Given,
    plan: &BlockPlan,
    draping: Option<&Draping>,
) -> io::Result<()> {
    let mut out = Vec::new();
    settings.put(&mut out);
    given.put(&mut out);
    plan.put(&mut out);
    draping.is_some().put(&mut out);
    if let Some(draping) = draping {
        draping.put(&mut out);
    }
    let unfinished = path.with_extension("new");
    let mut file = File::create(&unfinished)?;
    file.write_all(MAGIC)?;
    file.write_all(&crc32c::crc32c(&out).to_le_bytes())?;
    file.write_all(&out)?;
    file.sync_all()?;
    fs::rename(unfinished, path)
}

impl SavedPlan {
    /// Reads a plan. Returns `None` if `path` does not exist or holds no valid plan.
    pub(crate) fn load(path: &Path) -> io::Result<Option<Self>> {
        let bytes = match fs::read(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            read => read?,
        };
        let Some((header, body)) = bytes.split_at_checked(12) else {
            return Ok(None);
        };
        if header[..8] != MAGIC[..] || header[8..] != crc32c::crc32c(body).to_le_bytes() {
            return Ok(None);
        }
        let parts = decoded(body);
        Ok(parts.map(|((settings, given), (plan, draping))| Self {
            settings,
            given,
            plan,
            draping,
        }))
    }
}
