//! Which files have lines and sites, and how these are opened.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use delaunay_tiles::input::{PolySource, SegmentSource, SiteSource};
use delaunay_tiles::store::{LineKind, LineSource};

use super::read::{Lines, Set};
use crate::common;

/// Which lines there are.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Lines and sites")]
pub struct LineFiles {
    /// Files of break lines, which do not block the way; each of these options may be given more than once
    #[arg(long, value_name = "FILE")]
    segments: Vec<PathBuf>,
    /// Files of lines that block the way
    #[arg(long, value_name = "FILE")]
    walls: Vec<PathBuf>,
    /// Files of polygons (GeoJSON) whose interiors are holes; their rings block the way
    #[arg(long, value_name = "FILE")]
    obstacles: Vec<PathBuf>,
}

/// Which lines and sites there are.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Lines and sites")]
pub struct LineArgs {
    #[command(flatten)]
    files: LineFiles,
    /// Files of sites: points with an id, as GeoJSON or text (x,y, and perhaps an id)
    #[arg(long, value_name = "FILE")]
    sites: Vec<PathBuf>,
    /// The column or property that is a site's id; by default the third column of text, else the number of the record
    #[arg(long, value_name = "FIELD", requires = "sites")]
    site_id: Option<String>,
}

impl LineFiles {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        let files = [&self.segments, &self.walls, &self.obstacles];
        files.iter().all(|files| files.is_empty())
    }

    /// Opens the files.
    pub fn open(self) -> anyhow::Result<Lines> {
        let args = LineArgs {
            files: self,
            sites: Vec::new(),
            site_id: None,
        };
        args.open(&[])
    }

    fn of_kind(&mut self, kind: LineKind) -> &mut Vec<PathBuf> {
        match kind {
            LineKind::BreakLine => &mut self.segments,
            LineKind::Wall => &mut self.walls,
            LineKind::Obstacle => &mut self.obstacles,
        }
    }
}

impl LineArgs {
    /// Whether there are none, and none of the inputs of points has lines too.
    pub fn is_empty(&self, inputs: &[PathBuf]) -> bool {
        self.files.is_empty() && self.sites.is_empty() && !inputs.iter().any(|path| is_poly(path))
    }

    /// Whether some segments may be given by the record numbers of points.
    pub fn has_pairs(&self, inputs: &[PathBuf]) -> bool {
        let is_pairs = |path: &PathBuf| {
            let suffix = path.extension().map(|suffix| suffix.to_ascii_lowercase());
            suffix.is_some_and(|suffix| suffix == "u32" || suffix == "u64")
        };
        self.files.segments.iter().chain(&self.files.walls).any(is_pairs) || inputs.iter().any(|path| is_poly(path))
    }

    /// Opens the files, and what of the inputs of points has lines too.
    pub fn open(&self, inputs: &[PathBuf]) -> anyhow::Result<Lines> {
        let mut sets = vec![
            open_set(LineKind::BreakLine, 0, &self.files.segments)?,
            open_set(LineKind::Wall, 0, &self.files.walls)?,
        ];
        let mut before = Some(0);
        for path in inputs {
            if !is_poly(path) {
                // How many records it has is known only when it was read.
                before = None;
                continue;
            }
            let poly = PolySource::open(path)?;
            let first = before.with_context(|| {
                format!(
                    "{}: give .poly files before all other inputs, since their segments count records",
                    common::shown(path)
                )
            })?;
            before = Some(first + poly.points());
            sets.push(Set::poly(path, first, poly));
        }
        sets.push(open_set(LineKind::Obstacle, 0, &self.files.obstacles)?);
        let sites = SiteSource::open(&self.sites, self.site_id.as_deref())?;
        Ok(Lines::new(sets, sites))
    }

    /// Opens the files in the order in which their lines were added to a tile file, whose directory says `added`: lines of the
    /// build first, then those of each edit. Within a kind the files are given in that order.
    ///
    /// # Errors
    /// If there are edits, and the number of files of a kind is not the number of those that were added.
    pub fn open_as_added(&self, inputs: &[PathBuf], added: &[LineSource]) -> anyhow::Result<Lines> {
        if added.iter().all(|source| source.edit == 0) {
            return self.open(inputs);
        }
        let polys = inputs.iter().filter(|path| is_poly(path)).count();
        let given = [
            (LineKind::BreakLine, "--segments", &self.files.segments, 0),
            (LineKind::Wall, "--walls", &self.files.walls, polys),
            (LineKind::Obstacle, "--obstacles", &self.files.obstacles, 0),
        ];
        let mut of_build = self.clone();
        let mut of_edits = Vec::new();
        for (kind, option, files, polys) in given {
            let of_kind: Vec<LineSource> = added.iter().filter(|source| source.kind == kind).cloned().collect();
            if of_kind.len() != files.len() + polys {
                bail!(
                    "lines were added to it from {} files of {kind}s, and {option} names {}; name all files, in the order in \
                     which they were added",
                    of_kind.len(),
                    files.len() + polys
                );
            }
            let built = of_kind
                .iter()
                .filter(|source| source.edit == 0)
                .count()
                .saturating_sub(polys);
            let (first, later) = files.split_at(built.min(files.len()));
            *of_build.files.of_kind(kind) = first.to_vec();
            of_edits.extend(later.iter().zip(of_kind.into_iter().skip(built + polys)));
        }
        of_edits.sort_by_key(|(_, source): &(_, LineSource)| source.first);
        let mut lines = of_build.open(inputs)?;
        for (file, source) in of_edits {
            lines.add(open_set(source.kind, source.edit, std::slice::from_ref(file))?);
        }
        Ok(lines)
    }
}

/// Opens files of lines of one kind, which an edit added, or the build, which is 0.
fn open_set(kind: LineKind, edit: u32, files: &[PathBuf]) -> anyhow::Result<Set> {
    let files = match kind {
        LineKind::Obstacle => SegmentSource::open_obstacles(files)?,
        _ => SegmentSource::open(files)?,
    };
    Ok(Set::files(kind, edit, files))
}

fn is_poly(path: &Path) -> bool {
    let name = path.to_string_lossy().to_ascii_lowercase();
    name.ends_with(".poly") || name.ends_with(".poly.gz")
}
