//! The options that name files of lines and sites, and how these files are opened.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use delaunay_tiles::input::{Format, PolySource, SegmentSource, SiteSource};
use delaunay_tiles::store::{LineKind, LineSource};

use super::read::{LineInput, LineSet};
use crate::common;

/// Files of lines.
#[derive(Args, Clone, Debug)]
pub struct LineFiles {
    /// File of break lines, which do not block paths; may be repeated
    #[arg(long, value_name = "FILE", help_heading = "Lines and sites")]
    segments: Vec<PathBuf>,
    /// File of walls, which block paths; may be repeated
    #[arg(long, value_name = "FILE", help_heading = "Lines and sites")]
    walls: Vec<PathBuf>,
    /// File of polygons (GeoJSON, FlatGeobuf, Shapefile, GeoPackage) whose interiors are holes and
    /// whose rings block paths; may be repeated
    #[arg(long, value_name = "FILE", help_heading = "Lines and sites")]
    obstacles: Vec<PathBuf>,
}

/// Files of lines and sites.
#[derive(Args, Clone, Debug)]
pub struct LineArgs {
    #[command(flatten)]
    files: LineFiles,
    /// File of polygons (GeoJSON, FlatGeobuf, Shapefile, GeoPackage) of ponds: their rings become break
    /// lines, and all vertices in them get the lowest z of the shore; may be repeated
    ///
    /// Each polygon is a pond. The z of its shore is that of the triangulation of the points, and at
    /// corners with a z that z.
    #[arg(long, value_name = "FILE", help_heading = "Lines and sites")]
    flatten: Vec<PathBuf>,
    /// File of sites, which are points with an id, as GeoJSON, FlatGeobuf, Shapefile, GeoPackage, or
    /// as text with rows x,y[,id]; may be repeated
    #[arg(long, value_name = "FILE", help_heading = "Lines and sites")]
    sites: Vec<PathBuf>,
    /// Keep the edges of triangulations among the points' files, as break lines: of .node with .ele
    /// beside it, of .ply and .obj
    #[arg(long, help_heading = "Lines and sites")]
    keep_edges: bool,
    /// Column or property that holds a site's id [default: third column of text, otherwise the
    /// number of the record]
    #[arg(long, value_name = "FIELD", requires = "sites", help_heading = "Lines and sites")]
    site_id: Option<String>,
}

impl LineFiles {
    /// Returns whether no files are named.
    pub fn is_empty(&self) -> bool {
        let files = [&self.segments, &self.walls, &self.obstacles];
        files.iter().all(|files| files.is_empty())
    }

    /// Opens the files.
    pub fn open(self) -> anyhow::Result<LineInput> {
        let args = LineArgs {
            files: self,
            flatten: Vec::new(),
            sites: Vec::new(),
            keep_edges: false,
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
    /// Returns whether no files of lines or sites are named, and none of the inputs of points has
    /// lines.
    pub fn is_empty(&self, inputs: &[PathBuf]) -> bool {
        self.files.is_empty()
            && self.flatten.is_empty()
            && self.sites.is_empty()
            && !inputs.iter().any(|path| is_poly(path) || self.keeps(path))
    }

    /// Returns whether files of ponds are named.
    pub fn has_ponds(&self) -> bool {
        !self.flatten.is_empty()
    }

    /// Returns whether the edges of an input of points are to be kept.
    fn keeps(&self, path: &Path) -> bool {
        self.keep_edges && Format::from_path(path).is_some_and(Format::may_have_edges)
    }

    /// Returns whether some segments may refer to points by record number.
    pub fn has_pairs(&self, inputs: &[PathBuf]) -> bool {
        let is_pairs = |path: &PathBuf| {
            let suffix = path.extension().map(|suffix| suffix.to_ascii_lowercase());
            suffix.is_some_and(|suffix| suffix == "u32" || suffix == "u64")
        };
        self.files.segments.iter().chain(&self.files.walls).any(is_pairs)
            || inputs.iter().any(|path| is_poly(path) || self.keeps(path))
    }

    /// Opens the files, and those inputs of points that also have lines.
    pub fn open(&self, inputs: &[PathBuf]) -> anyhow::Result<LineInput> {
        let mut sets = vec![
            // First, because the first line determines the z where lines cross.
            LineSet::ponds(SegmentSource::open_obstacles(&self.flatten)?),
            open_set(LineKind::BreakLine, 0, &self.files.segments)?,
            open_set(LineKind::Wall, 0, &self.files.walls)?,
        ];
        if self.keep_edges && !inputs.iter().any(|path| self.keeps(path)) {
            bail!("--keep-edges: no input has edges; give a .node file with an .ele file beside it, a .ply or an .obj");
        }
        let mut records_before = Some(0u64);
        for path in inputs {
            if !is_poly(path) && !self.keeps(path) {
                // The number of its records is known only after it was read.
                records_before = None;
                continue;
            }
            let first = records_before.with_context(|| {
                format!(
                    "{}: give .poly files, and those whose edges are kept, before all other inputs, because their \
                     segments refer to record numbers",
                    common::shown(path)
                )
            });
            let points = if is_poly(path) {
                let poly = PolySource::open(path)?;
                let points = poly.points();
                sets.push(LineSet::poly(path, first?, poly));
                points
            } else {
                let (edges, points) = SegmentSource::open_edges(path, None)?;
                sets.push(LineSet::edges(first?, edges));
                points
            };
            // A file that claims so many points that this overflows is cut short.
            records_before = records_before.map(|before| before.saturating_add(points));
        }
        sets.push(open_set(LineKind::Obstacle, 0, &self.files.obstacles)?);
        let sites = SiteSource::open(&self.sites, self.site_id.as_deref())?;
        Ok(LineInput::new(sets, sites))
    }

    /// Returns a text that identifies the files, which are open as `input`, and the options beside
    /// them, so that a build with them can be resumed. `None` if one of them is not a regular file.
    pub fn identity(&self, input: &LineInput) -> Option<String> {
        let Self {
            files,
            flatten,
            sites,
            keep_edges,
            site_id,
        } = self;
        let roles = [
            ("pond", flatten),
            ("segments", &files.segments),
            ("walls", &files.walls),
            ("obstacles", &files.obstacles),
            ("sites", sites),
        ];
        let mut text = format!("\nkeep edges: {keep_edges}\nsite id: {site_id:?}");
        for (role, path) in roles
            .iter()
            .flat_map(|(role, paths)| paths.iter().map(move |path| (role, path)))
        {
            input.stamps().find(|(stamped, _)| stamped == path)?;
            write!(text, "\n{role}: {:?}", std::path::absolute(path).ok()?).ok()?;
        }
        // Those of the files that belong to them too, such as the columns of shapefiles.
        for (path, stamp) in input.stamps() {
            let path = std::path::absolute(path).ok()?;
            write!(text, "\n{path:?} {} {}", stamp.length, stamp.modified).ok()?;
        }
        Some(text)
    }

    /// Opens the files in the order in which their lines were added to a tile file: lines of the
    /// build first, then those of each edit. `added` is the list in the tile file's directory.
    /// Within a kind, the files are named in the order in which they were added.
    ///
    /// # Errors
    /// Fails if there are edits and the number of files of a kind differs from the number in
    /// `added`.
    pub fn open_as_added(&self, inputs: &[PathBuf], added: &[LineSource]) -> anyhow::Result<LineInput> {
        if added.iter().all(|source| source.edit == 0) {
            return self.open(inputs);
        }
        let polys = inputs.iter().filter(|path| is_poly(path)).count();
        let kept = inputs.iter().filter(|path| self.keeps(path)).count();
        let options = [
            (
                LineKind::BreakLine,
                "--segments",
                &self.files.segments,
                kept + self.flatten.len(),
            ),
            (LineKind::Wall, "--walls", &self.files.walls, polys),
            (LineKind::Obstacle, "--obstacles", &self.files.obstacles, 0),
        ];
        let mut of_build = self.clone();
        let mut of_edits = Vec::new();
        for (kind, option, files, of_points) in options {
            let of_kind: Vec<LineSource> = added.iter().filter(|source| source.kind == kind).cloned().collect();
            if of_kind.len() != files.len() + of_points {
                bail!(
                    "the {kind}s of the file come from {}, but {option} names {}; name all files in the order in which \
                     they were added",
                    common::counted(of_kind.len() as u64, "file", "files"),
                    files.len() + of_points
                );
            }
            let build_files = of_kind
                .iter()
                .filter(|source| source.edit == 0)
                .count()
                .saturating_sub(of_points);
            let (first, later) = files.split_at(build_files.min(files.len()));
            *of_build.files.of_kind(kind) = first.to_vec();
            of_edits.extend(later.iter().zip(of_kind.into_iter().skip(build_files + of_points)));
        }
        of_edits.sort_by_key(|(_, source): &(_, LineSource)| source.first);
        let mut lines = of_build.open(inputs)?;
        for (file, source) in of_edits {
            lines.add(open_set(source.kind, source.edit, std::slice::from_ref(file))?);
        }
        Ok(lines)
    }
}

/// Opens files of lines of one kind. `edit` is the number of the edit that added them, or 0 for the
/// build.
fn open_set(kind: LineKind, edit: u32, files: &[PathBuf]) -> anyhow::Result<LineSet> {
    let files = match kind {
        LineKind::Obstacle => SegmentSource::open_obstacles(files)?,
        _ => SegmentSource::open(files)?,
    };
    Ok(LineSet::files(kind, edit, files))
}

fn is_poly(path: &Path) -> bool {
    let name = path.to_string_lossy().to_ascii_lowercase();
    name.ends_with(".poly") || name.ends_with(".poly.gz")
}
