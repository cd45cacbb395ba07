//! Passes the inputs of a build to its builder.

use std::sync::Arc;

use delaunay_tiles::crs::Crs;
use delaunay_tiles::input::PointSource;
use delaunay_tiles::store::Source;
use delaunay_tiles::{BuildSummary, Builder, Description, Planned};
use tokio::sync::Notify;

use super::report::InputCounts;
use crate::common;
use crate::crs::{self, CrsArgs, Extents};
use crate::lines::LineInput;
use crate::points::{PointsRead, push_points};
use crate::task::reading;

/// The open inputs of a build.
pub(super) struct Inputs {
    pub(super) source: PointSource,
    pub(super) lines: LineInput,
    /// Whether options leave out some of the points.
    pub(super) is_filtered: bool,
    pub(super) crs: CrsArgs,
}

impl Inputs {
    /// Builds from lines and points, or plans tasks if `is_planned` is set. The input is read on a thread of
    /// its own, ahead of the builder.
    pub(super) async fn build(
        self,
        builder: Builder,
        is_planned: bool,
        cancelled: Arc<Notify>,
    ) -> anyhow::Result<(Planned, InputCounts)> {
        let Self {
            source,
            lines,
            is_filtered,
            crs,
        } = self;
        if !builder.needs_points() {
            // The lines were not read again, so errors and notes give their numbers.
            let fed = Fed { lines, crs, is_planned };
            let built = fed.resume(&source, builder).await;
            return built.map_err(|error| fed.lines.name_in(error));
        }
        let (builder, lines) = common::on_thread("lines", move || lines.feed(builder)).await?;
        let fed = Fed { lines, crs, is_planned };
        let built = fed.build_points(source, builder, is_filtered, &cancelled).await;
        built.map_err(|error| fed.lines.name_in(error))
    }
}

/// The inputs of a build whose lines were passed to the builder.
struct Fed {
    lines: LineInput,
    crs: CrsArgs,
    is_planned: bool,
}

impl Fed {
    async fn build_points(
        &self,
        source: PointSource,
        mut builder: Builder,
        is_filtered: bool,
        cancelled: &Notify,
    ) -> anyhow::Result<(Planned, InputCounts)> {
        let mut extents = self.lines.extents().clone();
        let (source, read) = if builder.input_tasks().is_some() {
            let (read, corners);
            (builder, read, corners) =
                common::on_thread("inputs", move || reading::take(builder, &common::interruption())).await?;
            extents.add_points(&corners);
            (source, read)
        } else {
            let source = push_points(source, &mut builder, 0, !is_filtered, &mut extents, cancelled).await?;
            let read = PointsRead::of(&source);
            (source, read)
        };
        let read = self.describe(&source, &read, &mut builder, &extents)?;
        self.finish(&source, builder, read).await
    }

    /// Goes on with a build whose inputs an interrupted one read.
    async fn resume(&self, source: &PointSource, builder: Builder) -> anyhow::Result<(Planned, InputCounts)> {
        let read = serde_json::from_str(&builder.description().memo).unwrap_or_default();
        self.finish(source, builder, read).await
    }

    async fn finish(
        &self,
        source: &PointSource,
        builder: Builder,
        mut read: InputCounts,
    ) -> anyhow::Result<(Planned, InputCounts)> {
        let done = match self.is_planned {
            true => builder.plan_tasks().await?,
            false => Planned::Built(Box::new(builder.finish().await?)),
        };
        if let Planned::Built(summary) = &done {
            // They come first, since they tell of faults.
            let of_summary = self.notes(source, summary, read.records);
            read.notes.splice(..0, of_summary);
        }
        Ok((done, read))
    }

    /// Describes the inputs, which were read, to the builder.
    fn describe(
        &self,
        source: &PointSource,
        points: &PointsRead,
        builder: &mut Builder,
        extents: &Extents,
    ) -> anyhow::Result<InputCounts> {
        let lines = &self.lines;
        let mut read = InputCounts::new(points, lines);
        // A GeoJSON file may name its system at its end.
        let agreement = self
            .crs
            .agree(source.crs_of_files().iter().chain(lines.crs_of_files()))?;
        let of_lines = lines.sources();
        let names = points.sources.iter().map(|(name, _)| &**name);
        let names = names.chain(of_lines.iter().map(|lines| &*lines.name));
        let crs = agreement.crs().cloned().or_else(|| extents.of_plain_geojson(names));
        read.notes.extend(crs::note(crs.as_ref()));
        read.notes.extend(extents.notes());
        let mut next_record = 0;
        let sources = points.sources.iter().map(|(name, records)| {
            let first = next_record;
            next_record += records;
            Source {
                name: name.clone(),
                records: *records,
                first,
            }
        });
        builder.describe(Description {
            sources: sources.collect(),
            lines: of_lines,
            crs: crs.as_ref().map(Crs::text).map(str::to_owned),
            memo: serde_json::to_string(&read)?,
        });
        Ok(read)
    }

    /// Returns the notes that follow from the summary.
    fn notes(&self, source: &PointSource, summary: &BuildSummary, records: u64) -> Vec<String> {
        let mut notes = Vec::new();
        if summary.points == 0 && !source.sources().is_empty() {
            notes.push(match records {
                0 => "the input has no points".to_owned(),
                records => format!(
                    "no point of the input was taken, of {}",
                    common::counted(records, "record", "records")
                ),
            });
        }
        if let Some(first) = summary.first_inverted {
            notes.push(self.lines.inverted_note(summary.inverted_parts, first));
        }
        if summary.sites_in_holes > 0 {
            let sites = common::counted(summary.sites_in_holes, "site is", "sites are");
            notes.push(format!("{sites} inside obstacles or other holes, where no path leads"));
        }
        notes.extend(draped_note(summary));
        if summary.without_z > 0 {
            let vertices = common::counted(summary.without_z, "vertex", "vertices");
            notes.push(format!("{vertices} without z got z = 0"));
        }
        notes
    }
}

/// Returns the note on vertices that took their z from the surface.
fn draped_note(summary: &BuildSummary) -> Option<String> {
    if summary.draped == 0 {
        return None;
    }
    let draped = common::counted(summary.draped, "vertex", "vertices");
    let outside = match summary.draped_outside {
        0 => String::new(),
        outside => format!(
            ", {} of them outside the hull of the points, from its nearest point",
            common::thousands(outside)
        ),
    };
    Some(format!(
        "{draped} without z took it from the triangulation of the points{outside} (--missing-z error rejects them)"
    ))
}
