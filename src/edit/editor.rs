//! The editor: takes lines, and makes them constraints of a file.

use std::num::NonZero;
use std::path::Path;
use std::thread;

use crate::constraints::error::ConstraintError;
use crate::constraints::polygons::check::PolygonCheck;
use crate::constraints::segment::Segment;
use crate::constraints::without_z::NO_Z;
use crate::edit::error::EditError;
use crate::edit::run::edit;
use crate::edit::summary::EditSummary;
use crate::edit::target::Target;
use crate::edit::work::Work;
use crate::geometry::Point;
use crate::input::{MissingZ, SegmentBatch};
use crate::memory::EditShares;
use crate::store::{EdgeSource, LineKind, LineSource};

/// Makes lines constraints of a file on disk.
///
/// Ends that are no vertices of it become some, within its hull. The file is locked against other editors; readers may have it open and
/// see it as it was when they opened it.
pub struct Editor {
    target: Target,
    memory: u64,
    /// The lines that there were before.
    first_line: u64,
    /// The number of this edit, from 1 on.
    number: u32,
    lines: Vec<LineSource>,
    segments: Vec<Segment>,
    /// z at their ends, as far as any have one.
    z: Vec<[f64; 2]>,
    missing_z: MissingZ,
    polygons: PolygonCheck,
}

impl Editor {
    /// Begins to edit a file within so many bytes of memory.
    ///
    /// # Errors
    /// If it cannot be opened, or somebody else edits it.
    pub async fn open(path: impl AsRef<Path>, memory: u64) -> Result<Self, EditError> {
        let target = Target::lock(path.as_ref())?;
        let opened = target.read().await?;
        let metadata = &opened.directory().metadata;
        if metadata.vertices > 0 && metadata.triangles == 0 {
            return Err(EditError::NoTriangles(target.path));
        }
        Ok(Self {
            first_line: metadata.lines.last().map_or(0, |last| last.first + last.lines),
            number: metadata.lines.last().map_or(0, |last| last.edit).saturating_add(1),
            // All segments are in memory, and a polygon takes no more than what they are counted for.
            polygons: PolygonCheck::new(&target.path, u64::MAX),
            target,
            memory,
            lines: Vec::new(),
            segments: Vec::new(),
            z: Vec::new(),
            missing_z: MissingZ::default(),
        })
    }

    /// Says what to do with ends of lines that become vertices and have no z, in a file whose
    /// vertices have z.
    pub fn missing_z(&mut self, missing_z: MissingZ) {
        self.missing_z = missing_z;
    }

    /// The number that the first new line gets in the file.
    #[must_use]
    pub fn first_line(&self) -> u64 {
        self.first_line
    }

    /// Says which files the lines come from, in the order of their numbers from 0 on.
    pub fn add_sources(&mut self, sources: Vec<LineSource>) {
        let (first_line, edit) = (self.first_line, self.number);
        let numbered = sources.into_iter().map(|source| LineSource {
            name: source.name,
            kind: source.kind,
            first: first_line + source.first,
            lines: source.lines,
            edit,
        });
        self.lines.extend(numbered);
    }

    /// Takes segments; their lines are numbered from `first_line` on, among those that are new.
    ///
    /// # Errors
    /// If they are given by record numbers, do not all tell of which polygon they are, or take more than half of the memory.
    pub fn push(&mut self, kind: LineKind, first_line: u64, batch: &SegmentBatch) -> Result<(), EditError> {
        if !batch.records.is_empty() {
            return Err(EditError::Records);
        }
        let (segments, polygons) = (batch.ends.len(), batch.polygons.len());
        if polygons != 0 && polygons != segments {
            return Err(ConstraintError::PolygonNumbers { segments, polygons }.into());
        }
        let first = self.first_line + first_line;
        let segments = batch.ends.iter().zip(&batch.lines).map(|(&ends, &line)| Segment {
            ends: ends.map(Point::normalized),
            source: EdgeSource::new(kind, first + line),
        });
        if !batch.z.is_empty() {
            self.z.resize(self.segments.len(), [NO_Z; 2]);
            self.z.extend_from_slice(&batch.z);
        }
        self.segments.extend(segments);
        EditShares::check_segments(self.memory, self.segments.len() as u64)?;
        if kind == LineKind::Obstacle {
            self.polygons.push(first, batch)?;
        }
        Ok(())
    }

    /// Makes the lines constraints. The file is as before until the very end.
    ///
    /// # Errors
    /// If an end lies outside the hull or lacks a z ([`missing_z`](Self::missing_z)), a line
    /// crosses a constraint, a ring does not close, a polygon is inside out, or the system refuses.
    pub async fn finish(self) -> Result<EditSummary, EditError> {
        let Self {
            target,
            memory,
            lines,
            mut segments,
            mut z,
            missing_z,
            mut polygons,
            ..
        } = self;
        let faults = polygons.finish()?;
        if let Some(line) = faults.open {
            return Err(EditError::OpenRing { line });
        }
        if let Some(inverted) = faults.inverted {
            return Err(EditError::Inverted(inverted));
        }
        drop(polygons);
        segments.shrink_to_fit();
        z.shrink_to_fit();
        let work = Work {
            new_records: 2 * segments.len() as u64,
            segments,
            z,
            missing_z,
            lines,
            inverted: faults.inverted_if_uncrossed,
            is_draft: false,
            threads: thread::available_parallelism().map_or(1, NonZero::get),
        };
        edit(target, work, memory, || false).await
    }
}
