//! The editor: takes lines and makes them constraints of a file.

use std::num::NonZero;
use std::path::Path;
use std::thread;

use crate::constraints::error::ConstraintError;
use crate::constraints::polygons::check::PolygonCheck;
use crate::constraints::polygons::counter::{PolygonCounter, by_ends};
use crate::constraints::polygons::lines::PolygonLines;
use crate::constraints::polygons::normalize::PolygonNormalizer;
use crate::constraints::segment::Segment;
use crate::constraints::without_z::NO_Z;
use crate::edit::drape::drape_ends;
use crate::edit::error::EditError;
use crate::edit::run::edit;
use crate::edit::summary::EditSummary;
use crate::edit::target::Target;
use crate::edit::work::{Piece, Work};
use crate::geometry::Point;
use crate::input::{MissingZ, SegmentBatch};
use crate::memory::EditShares;
use crate::store::{EdgeSource, LineKind, LinePart, LineSource};

/// An editor that makes lines constraints of a file on disk.
///
/// Ends that are not vertices of the file become vertices, within its hull. The file is locked
/// against other editors. Readers may have it open, and see it as it was when they opened it.
pub struct Editor {
    target: Target,
    memory: u64,
    /// The number of the first new line, which is the number of lines before the edit.
    first_line: u64,
    /// The number of this edit, from 1.
    number: u32,
    crs: Option<String>,
    lines: Vec<LineSource>,
    segments: Vec<Segment>,
    /// z at the ends of segments, as far as any have z.
    z: Vec<[f64; 2]>,
    missing_z: MissingZ,
    polygons: PolygonCheck,
    counter: PolygonCounter,
    polygon_lines: PolygonLines,
}

impl Editor {
    /// Opens a file to edit it within `memory` bytes of memory.
    ///
    /// # Errors
    /// Returns an error if the file cannot be opened, if another editor has it locked, or if it has
    /// vertices but no triangles.
    pub async fn open(path: impl AsRef<Path>, memory: u64) -> Result<Self, EditError> {
        let target = Target::lock(path.as_ref())?;
        let opened = target.read().await?;
        let (metadata, lists) = (opened.metadata(), opened.lists().await?);
        if metadata.vertices > 0 && metadata.triangles == 0 {
            return Err(EditError::NoTriangles(target.path));
        }
        Ok(Self {
            first_line: metadata.next_line,
            crs: lists.crs.clone(),
            number: lists.lines.last().map_or(0, |last| last.edit).saturating_add(1),
            // All segments are in memory, and a polygon takes no more than what is counted for
            // them.
            polygons: PolygonCheck::new(&target.path, u64::MAX),
            counter: PolygonCounter::default(),
            polygon_lines: PolygonLines::default(),
            target,
            memory,
            lines: Vec::new(),
            segments: Vec::new(),
            z: Vec::new(),
            missing_z: MissingZ::default(),
        })
    }

    /// Sets what to do with ends of lines that become vertices and have no z, in a file whose
    /// vertices have z. By default they take it from the triangulation before the edit
    /// ([`MissingZ::Drape`]).
    pub fn missing_z(&mut self, missing_z: MissingZ) {
        self.missing_z = missing_z;
    }

    /// Returns the coordinate reference system of the file, as it names it.
    #[must_use]
    pub fn crs(&self) -> Option<&str> {
        self.crs.as_deref()
    }

    /// Returns the number that the first new line gets in the file.
    #[must_use]
    pub fn first_line(&self) -> u64 {
        self.first_line
    }

    /// Sets the files that the lines come from, in the order of their numbers from 0 on.
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

    /// Adds segments. Their lines are numbered from `first_line` on, among the new lines.
    ///
    /// # Errors
    /// Returns an error if segments are given by record numbers, if only some of them have a
    /// polygon number, or if they take more than half of the memory.
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
            source: LinePart::whole(EdgeSource::new(kind, first + line)),
        });
        if !batch.z.is_empty() {
            self.z.resize(self.segments.len(), [NO_Z; 2]);
            self.z.extend_from_slice(&batch.z);
        }
        self.segments.extend(segments);
        EditShares::check_segments(self.memory, self.segments.len() as u64)?;
        if kind == LineKind::Obstacle {
            self.polygons.push(first, batch)?;
            for (key, line, _) in by_ends(first, batch).filter(|(_, _, [a, b])| a != b) {
                self.polygon_lines.take(self.counter.next(key, line), line);
            }
        }
        Ok(())
    }

    /// Makes the lines constraints. An obstacle that covers a place more than once is normalised, so
    /// that it covers it once. The file is unchanged until the very end.
    ///
    /// # Errors
    /// Returns an error if an end lies outside the hull or lacks a z
    /// ([`missing_z`](Self::missing_z)), if a line crosses a constraint, if a ring does not close,
    /// if a polygon is inside out, if an obstacle covers a place more than once and its rings cross,
    /// or if the system fails.
    pub async fn finish(self) -> Result<EditSummary, EditError> {
        let Self {
            target,
            memory,
            lines,
            mut segments,
            mut z,
            missing_z,
            mut polygons,
            polygon_lines,
            ..
        } = self;
        let faults = polygons.finish()?;
        if let Some(line) = faults.open {
            return Err(EditError::OpenRing { line });
        }
        if let Some(inverted) = faults.inverted {
            return Err(EditError::Inverted(inverted));
        }
        let normalizer = polygons.normalizer();
        drop(polygons);
        segments.shrink_to_fit();
        if missing_z == MissingZ::Drape {
            drape_ends(&target, &segments, &mut z, EditShares::for_draping(memory)).await?;
        }
        z.shrink_to_fit();
        let work = Work {
            new_records: 2 * segments.len() as u64,
            pieces: normalizer.map(|normalizer| normalized_pieces(&segments, normalizer)),
            segments,
            z,
            missing_z,
            lines,
            polygon_lines: polygon_lines.finish(),
            inverted: faults.inverted_if_uncrossed,
            overlapping: faults.overlapping_if_uncrossed,
            is_draft: false,
            threads: thread::available_parallelism().map_or(1, NonZero::get),
        };
        edit(target, work, memory, || false).await
    }
}

/// Returns the segments after obstacles were normalised, by the numbers of their ends. These are
/// ends of the segments of the same obstacle.
fn normalized_pieces(segments: &[Segment], mut normalizer: PolygonNormalizer) -> Vec<Piece> {
    let (mut pieces, mut ready, mut start) = (Vec::new(), Vec::new(), 0);
    let mut ends: Vec<(Point, u32)> = Vec::new();
    for (segment, number) in segments.iter().zip(0u32..) {
        normalizer.take(*segment, &mut ready);
        if normalizer.is_within() {
            continue;
        }
        // Ends of segments of no length become no vertices.
        let its = (start..=number).map(|number| (number, segments[number as usize].ends));
        let numbered = its
            .filter(|(_, [a, b])| a != b)
            .flat_map(|(number, ends)| [2 * number, 2 * number + 1].into_iter().zip(ends));
        ends.clear();
        ends.extend(numbered.map(|(end, point)| (point, end)));
        ends.sort_unstable_by(|(p, one), (q, other)| p.lex_cmp(*q).then(one.cmp(other)));
        let end_at = |point: Point| ends[ends.partition_point(|(other, _)| other.lex_cmp(point).is_lt())].1;
        pieces.extend(ready.drain(..).map(|segment| Piece {
            ends: segment.ends.map(end_at),
            source: segment.source,
        }));
        start = number + 1;
    }
    pieces
}
