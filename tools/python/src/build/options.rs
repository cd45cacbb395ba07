//! The keyword arguments of a build, and of reading files of points.

use std::num::NonZeroU64;
use std::path::PathBuf;
use std::sync::Arc;

use delaunay_tiles::geometry::Rect;
use delaunay_tiles::input::{InputOptions, MissingZ, SegmentSource};
use delaunay_tiles::store::LineKind;
use delaunay_tiles::{BuildOptions, Crossings, Progress};
use pyo3::prelude::*;
use tiletool::input_args::{FormatArgs, InputArgs};

use crate::error::{Failure, Outcome};

/// The keyword arguments of a build.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct BuildArguments {
    memory: Option<u64>,
    threads: Option<usize>,
    tile_vertices: usize,
    duplicates: String,
    crossings: String,
    exterior: String,
    missing_z: String,
    compress: bool,
    work_folder: Option<PathBuf>,
    overwrite: bool,
    resume: bool,
    identity: Option<String>,
}

/// The names of what becomes of vertices without z.
pub const MISSING_Z: [(&str, MissingZ); 3] = [
    ("drape", MissingZ::Drape),
    ("zero", MissingZ::Zero),
    ("error", MissingZ::Error),
];

/// Returns the value of a name, or an error that lists the names.
pub fn choice<T: Copy>(argument: &str, given: &str, choices: &[(&str, T)]) -> Outcome<T> {
    let found = choices.iter().find(|(name, _)| *name == given);
    found.map(|(_, value)| *value).ok_or_else(|| {
        let names: Vec<String> = choices.iter().map(|(name, _)| format!("'{name}'")).collect();
        Failure::value(format!("{argument} must be {}, not '{given}'", names.join(" or ")))
    })
}

impl BuildArguments {
    /// Returns the options for the library.
    pub fn options(self, progress: &Arc<Progress>) -> Outcome<BuildOptions> {
        let mut options = BuildOptions::default()
            .tile_vertices(self.tile_vertices)
            .compress(self.compress)
            .force(self.overwrite)
            .resume(self.resume)
            .resumable(self.identity)
            .work_folder(self.work_folder)
            .progress(Arc::clone(progress));
        options.threads = self.threads.unwrap_or(options.threads);
        options.memory = self.memory.unwrap_or(options.memory);
        options.duplicates = self
            .duplicates
            .parse()
            .map_err(|error| Failure::value(format!("{error}")))?;
        let crossings = [("error", Crossings::Error), ("split", Crossings::Split)];
        options.crossings = choice("crossings", &self.crossings, &crossings)?;
        options.exterior_is_hole = choice("exterior", &self.exterior, &[("keep", false), ("hole", true)])?;
        options.missing_z = choice("missing_z", &self.missing_z, &MISSING_Z)?;
        Ok(options)
    }
}

/// The keyword arguments of reading files of points.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct ReadArguments {
    format: Option<String>,
    columns: Option<String>,
    dims: u8,
    classes: Vec<u8>,
    returns: String,
    keep_withheld: bool,
    bounds: Option<(f64, f64, f64, f64)>,
    every: u64,
    level: Option<u8>,
    resolution: Option<f64>,
    skip_invalid: bool,
}

impl ReadArguments {
    /// Returns the options for the library.
    pub fn options(self, missing_z: MissingZ) -> Outcome<InputOptions> {
        Ok(self.of_tool()?.options().missing_z(missing_z))
    }

    /// Returns the options of the tool.
    pub fn of_tool(self) -> Outcome<InputArgs> {
        let wrong = |error: &dyn std::fmt::Display| Failure::value(error.to_string());
        let format = self
            .format
            .map(|format| format.parse())
            .transpose()
            .map_err(|error| wrong(&error))?;
        let columns = self
            .columns
            .map(|columns| columns.parse())
            .transpose()
            .map_err(|error| wrong(&error))?;
        let bounds = self
            .bounds
            .map(|(min_x, min_y, max_x, max_y)| Rect::new(min_x, min_y, max_x, max_y));
        Ok(InputArgs {
            format: FormatArgs {
                format,
                columns,
                dims: self.dims,
            },
            classes: self.classes,
            returns: self.returns.parse().map_err(|error| wrong(&error))?,
            keep_withheld: self.keep_withheld,
            drop_withheld: false,
            bounds,
            every: NonZeroU64::new(self.every).ok_or_else(|| Failure::value("every must be above 0"))?,
            level: self.level,
            resolution: self.resolution,
            skip_invalid: self.skip_invalid,
        })
    }
}

/// The kind of lines that a build takes.
#[derive(Clone, Copy)]
pub enum Role {
    Ponds,
    Lines(LineKind),
}

impl Role {
    /// Returns the role with the name of a keyword argument.
    pub fn named(name: &str) -> Outcome<Self> {
        let roles = [
            ("lines", Self::Lines(LineKind::BreakLine)),
            ("walls", Self::Lines(LineKind::Wall)),
            ("obstacles", Self::Lines(LineKind::Obstacle)),
            ("ponds", Self::Ponds),
        ];
        choice("kind", name, &roles)
    }

    /// Opens files of lines with this role.
    pub fn open(self, paths: &[PathBuf]) -> Outcome<SegmentSource> {
        Ok(match self.takes_polygons() {
            true => SegmentSource::open_obstacles(paths)?,
            false => SegmentSource::open(paths)?,
        })
    }

    /// Returns whether only polygons have this role.
    pub fn takes_polygons(self) -> bool {
        matches!(self, Self::Ponds | Self::Lines(LineKind::Obstacle))
    }
}
