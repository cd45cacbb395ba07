//! Lines and sites from files: the same options for `build` and for `verify --against`.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::{FileStamp, PolySource, Reading, SegmentBatch, SegmentSource, SiteBatch, SiteSource};
use delaunay_tiles::store::{LineKind, LineSource, VerifyError};
use delaunay_tiles::{
    BuildError, Builder, Crossings, Editor, Inverted, InvertedPolygons, MemoryShortage, MemoryUse, MissingZ, Steiner,
    WithoutZ, shown,
};

use crate::common;

/// Crossings that a build tells of.
const TOLD: usize = 10;

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

/// What to do with what has no z.
#[derive(Args, Clone, Copy, Debug)]
pub struct MissingZArgs {
    /// What to do with points, ends of lines, crossing points and sites that have no z where other
    /// vertices have, and do not lie where one of those lies: error names the first; zero gives
    /// them z = 0
    #[arg(
        long,
        value_name = "error|zero",
        default_value = "error",
        hide_possible_values = true,
        help_heading = "Lines and sites"
    )]
    missing_z: MissingZArg,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MissingZArg {
    Error,
    Zero,
}

impl MissingZArgs {
    /// The library's option.
    pub fn option(self) -> MissingZ {
        match self.missing_z {
            MissingZArg::Error => MissingZ::Error,
            MissingZArg::Zero => MissingZ::Zero,
        }
    }
}

/// What a build does with lines.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Lines and sites")]
pub struct LineRules {
    /// What to do with lines that cross: error names the first ten pairs; split makes vertices of their crossing points
    #[arg(
        long,
        value_name = "error|split",
        default_value = "error",
        hide_possible_values = true
    )]
    crossings: CrossingsArg,
    /// Whether vertices are added where lines cross the borders of the cells that points are spilled to: only this makes the
    /// triangles depend on --memory
    #[arg(
        long,
        value_name = "never|borders",
        default_value = "never",
        hide_possible_values = true
    )]
    steiner: SteinerArg,
    /// What is outside of all lines, up to the convex hull: kept, or a hole
    #[arg(long, value_name = "keep|hole", default_value = "keep", hide_possible_values = true)]
    exterior: Exterior,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum CrossingsArg {
    Error,
    Split,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SteinerArg {
    Never,
    Borders,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Exterior {
    Keep,
    Hole,
}

/// Lines of one kind.
struct Set {
    kind: LineKind,
    /// The number of its first line, once it is begun.
    first: u64,
    /// 0: the build. Else the number of the edit that added them.
    edit: u32,
    source: Source,
}

enum Source {
    Files(SegmentSource),
    /// Of this file; its points come behind so many records.
    Poly(PathBuf, u64, Option<PolySource>, u64),
}

/// Lines and sites, open.
pub struct Lines {
    sets: Vec<Set>,
    /// How many of them were read.
    done: usize,
    sites: SiteSource,
    /// Lines of all sets that were read.
    lines: u64,
    /// Points in holes.
    seeds: Vec<Point>,
}

impl LineRules {
    /// Whether regions that reach the hull are holes.
    pub fn exterior_is_hole(&self) -> bool {
        self.exterior == Exterior::Hole
    }

    /// What to do with lines that cross.
    pub fn crossings(&self) -> Crossings {
        match self.crossings {
            CrossingsArg::Error => Crossings::Error,
            CrossingsArg::Split => Crossings::Split,
        }
    }

    /// Whether vertices are added where none is needed.
    pub fn steiner(&self) -> Steiner {
        match self.steiner {
            SteinerArg::Never => Steiner::Never,
            SteinerArg::Borders => Steiner::Borders,
        }
    }
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
        let mut sets = Vec::new();
        let mut add = |kind, source| {
            sets.push(Set {
                kind,
                first: u64::MAX,
                edit: 0,
                source,
            });
        };
        add(
            LineKind::BreakLine,
            Source::Files(SegmentSource::open(&self.files.segments)?),
        );
        add(LineKind::Wall, Source::Files(SegmentSource::open(&self.files.walls)?));
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
            add(LineKind::Wall, Source::Poly(path.clone(), first, Some(poly), 0));
        }
        add(
            LineKind::Obstacle,
            Source::Files(SegmentSource::open_obstacles(&self.files.obstacles)?),
        );
        Ok(Lines {
            sets,
            done: 0,
            sites: SiteSource::open(&self.sites, self.site_id.as_deref())?,
            lines: 0,
            seeds: Vec::new(),
        })
    }
}

impl LineArgs {
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
            let files = std::slice::from_ref(file);
            let files = match source.kind {
                LineKind::Obstacle => SegmentSource::open_obstacles(files)?,
                _ => SegmentSource::open(files)?,
            };
            lines.sets.push(Set {
                kind: source.kind,
                first: u64::MAX,
                edit: source.edit,
                source: Source::Files(files),
            });
        }
        Ok(lines)
    }
}

impl LineFiles {
    fn of_kind(&mut self, kind: LineKind) -> &mut Vec<PathBuf> {
        match kind {
            LineKind::BreakLine => &mut self.segments,
            LineKind::Wall => &mut self.walls,
            LineKind::Obstacle => &mut self.obstacles,
        }
    }
}

fn is_poly(path: &Path) -> bool {
    let name = path.to_string_lossy().to_ascii_lowercase();
    name.ends_with(".poly") || name.ends_with(".poly.gz")
}

impl Lines {
    /// Fills the batch with the next segments. Returns their kind, and the number of the first line of these files.
    pub fn next_batch(&mut self, batch: &mut SegmentBatch) -> anyhow::Result<Option<(LineKind, u64)>> {
        self.next_batch_until(u32::MAX, batch)
    }

    /// The same, but only for lines of the build and of edits up to number `last_edit`.
    pub fn next_batch_until(
        &mut self,
        last_edit: u32,
        batch: &mut SegmentBatch,
    ) -> anyhow::Result<Option<(LineKind, u64)>> {
        while let Some(set) = self.sets.get_mut(self.done).filter(|set| set.edit <= last_edit) {
            set.first = self.lines;
            match &mut set.source {
                Source::Files(files) => {
                    if files.next_batch(batch)? {
                        return Ok(Some((set.kind, set.first)));
                    }
                    self.lines += files.sources().iter().map(|(_, lines)| lines).sum::<u64>();
                }
                Source::Poly(_, records, poly, segments) => {
                    if let Some(poly) = poly
                        && poly.next_batch(batch)?
                    {
                        for ends in &mut batch.records {
                            *ends = ends.map(|record| record + *records);
                        }
                        return Ok(Some((set.kind, set.first)));
                    }
                    if let Some(poly) = poly.take() {
                        *segments = poly.segments();
                        self.lines += *segments;
                        self.seeds.extend(poly.holes()?);
                    }
                }
            }
            self.done += 1;
        }
        batch.clear();
        Ok(None)
    }

    /// Fills the batch with the next sites; false if there are none left.
    pub fn next_sites(&mut self, batch: &mut SiteBatch) -> anyhow::Result<bool> {
        Ok(self.sites.next_batch(batch)?)
    }

    /// Points in holes, once all segments were read.
    pub fn seeds(&self) -> &[Point] {
        &self.seeds
    }

    /// Gives all of them to a builder.
    pub fn feed(mut self, mut builder: Builder) -> anyhow::Result<(Builder, Self)> {
        let mut batch = SegmentBatch::default();
        while let Some((kind, first)) = self.next_batch(&mut batch)? {
            builder.push_lines(kind, first, &batch)?;
        }
        builder.push_seeds(&self.seeds)?;
        let mut sites = SiteBatch::default();
        while self.next_sites(&mut sites)? {
            builder.push_sites(&sites)?;
        }
        Ok((builder, self))
    }

    /// Gives all of them to an editor.
    pub fn feed_editor(mut self, mut editor: Editor) -> anyhow::Result<(Editor, Self)> {
        let mut batch = SegmentBatch::default();
        while let Some((kind, first)) = self.next_batch(&mut batch)? {
            editor.push(kind, first, &batch)?;
        }
        editor.add_sources(self.sources());
        Ok((editor, self))
    }

    /// Segments that were read.
    pub fn segments(&self) -> u64 {
        let of_set = |set: &Set| match &set.source {
            Source::Files(files) => files.segments(),
            Source::Poly(.., segments) => *segments,
        };
        self.sets.iter().map(of_set).sum()
    }

    /// How far the reading of the files is, and the way to stop it.
    pub fn readings(&self) -> impl Iterator<Item = &Reading> {
        fn of_set(set: &Set) -> Option<&Reading> {
            match &set.source {
                Source::Files(files) => Some(files.reading()),
                Source::Poly(_, _, poly, _) => poly.as_ref().map(PolySource::reading),
            }
        }
        self.sets.iter().filter_map(of_set).chain([self.sites.reading()])
    }

    /// The regular files, as they were when they were opened. To be asked before they are read.
    pub fn stamps(&self) -> impl Iterator<Item = &(PathBuf, FileStamp)> {
        fn of_set(set: &Set) -> &[(PathBuf, FileStamp)] {
            match &set.source {
                Source::Files(files) => files.stamps(),
                Source::Poly(_, _, poly, _) => poly.as_ref().map_or(&[], PolySource::stamps),
            }
        }
        self.sets.iter().flat_map(of_set).chain(self.sites.stamps())
    }

    /// Bytes read of all files but those of points.
    pub fn bytes_read(&self) -> u64 {
        let of_set = |set: &Set| match &set.source {
            Source::Files(files) => files.bytes_read(),
            Source::Poly(..) => 0,
        };
        self.sets.iter().map(of_set).sum::<u64>() + self.sites.bytes_read()
    }

    /// The files, for the directory.
    pub fn sources(&self) -> Vec<LineSource> {
        let mut sources = Vec::new();
        for set in &self.sets {
            let mut first = set.first;
            let mut add = |name: String, lines: u64| {
                sources.push(LineSource {
                    name,
                    kind: set.kind,
                    first,
                    lines,
                    edit: set.edit,
                });
                first += lines;
            };
            match &set.source {
                Source::Files(files) => files
                    .sources()
                    .iter()
                    .for_each(|(name, lines)| add(name.clone(), *lines)),
                Source::Poly(path, _, _, segments) => add(common::file_name(path), *segments),
            }
        }
        sources
    }

    /// What a person should know.
    pub fn notes(&self) -> Vec<String> {
        let of_set = |set: &Set| match &set.source {
            Source::Files(files) => files.notes().to_vec(),
            Source::Poly(..) => Vec::new(),
        };
        let mut notes: Vec<String> = self.sets.iter().flat_map(of_set).collect();
        notes.extend_from_slice(self.sites.notes());
        notes
    }

    /// Where a line comes from.
    pub fn name(&self, line: u64) -> String {
        let set = self.sets.iter().rev().find(|set| set.first <= line);
        let name = set.and_then(|set| match &set.source {
            Source::Files(files) => files.origin(line - set.first).map(|origin| origin.to_string()),
            Source::Poly(path, ..) => Some(format!(
                "{}: segment {} (counted from 0)",
                common::shown(path),
                line - set.first
            )),
        });
        name.unwrap_or_else(|| format!("line {line}"))
    }

    /// Where a site comes from.
    fn site_name(&self, site: u64) -> String {
        let mut first = 0;
        for (name, sites) in self.sites.sources() {
            if site < first + sites {
                return format!("{}: site {} (counted from 0)", shown::text(name), site - first);
            }
            first += sites;
        }
        format!("site {site}")
    }

    /// Says of parts of polygons that are inside out where the first one is.
    pub fn inverted_note(&self, parts: u64, first: Inverted) -> String {
        let parts = match parts {
            1 => "1 part of a polygon is".to_owned(),
            parts => format!("{} parts of polygons are", common::thousands(parts)),
        };
        format!(
            "{parts} inside out, since rings are nested wrongly or cross, and covered all the same; the first is of {} at \
             ({}, {})",
            self.name(first.obstacle),
            first.point.x,
            first.point.y
        )
    }

    /// Says of an error that speaks of lines by their numbers which they are.
    pub fn name_in(&self, error: anyhow::Error) -> anyhow::Error {
        if let Some(VerifyError::Line { line, .. }) = error.downcast_ref() {
            let name = self.name(line.number());
            return error.context(name);
        }
        match error.downcast_ref() {
            Some(&BuildError::OpenRing { obstacle })
            | Some(&BuildError::Memory(MemoryShortage {
                of: MemoryUse::Polygon { obstacle },
                ..
            })) => error.context(self.name(obstacle)),
            Some(BuildError::Inverted(InvertedPolygons { first, polygons })) => {
                let others = match polygons {
                    1 => String::new(),
                    polygons => format!("; {} polygons are inside out", common::thousands(*polygons)),
                };
                anyhow::anyhow!(
                    "{} is inside out at ({}, {}): a hole of it lies outside of it or in another of its holes, or a ring of it \
                     runs round there the other way{others}\nput it right, or give --crossings split, which covers such parts too",
                    self.name(first.obstacle),
                    first.point.x,
                    first.point.y
                )
            }
            Some(BuildError::NoZ { first, count }) => {
                let (x, y) = (first.point.x, first.point.y);
                let what = match (first.what, first.line) {
                    (WithoutZ::End | WithoutZ::Crossing, Some(line)) => self.name(line.number()),
                    (WithoutZ::Site(site), _) => self.site_name(site),
                    (WithoutZ::Point(record), _) => format!("the point of record {record}"),
                    _ => "a point where lines end or cross".to_owned(),
                };
                let all = match count {
                    1 => "one vertex".to_owned(),
                    count => format!("{} vertices", common::thousands(*count)),
                };
                anyhow::anyhow!(
                    "{what} has no z at ({x}, {y}), where no point with z lies; {all} would get z = 0, and others have z\n\
                     give z to all, or give --missing-z zero"
                )
            }
            Some(BuildError::Crossings { first, count }) => {
                let mut text = match count {
                    1 => "two lines cross:".to_owned(),
                    count => format!("{} pairs of segments cross:", common::thousands(*count)),
                };
                for crossing in first {
                    let [one, other] = crossing.lines.map(|line| self.name(line.number()));
                    let (x, y) = (crossing.point.x, crossing.point.y);
                    text += &if one == other {
                        format!("\n  {one} crosses itself at ({x}, {y})")
                    } else {
                        format!("\n  {one} and {other} at ({x}, {y})")
                    };
                }
                // Segments that are there twice cross twice, and are told of once.
                if first.len() == TOLD && *count > TOLD as u64 {
                    text += "\n  and others";
                }
                text += "\nlet them meet in a point, leave one of each pair out, or give --crossings split";
                anyhow::anyhow!(text)
            }
            _ => error,
        }
    }
}
