//! Where the readers of segments put them: numbered, with z for all ends or for none.

use super::SegmentBatch;
use crate::input::spot::Spot;
use crate::input::{InputError, Place};
use crate::shown;
use std::path::Path;

/// Segments in a full batch.
const BATCH: usize = 8192;

/// The way from one file into one batch.
pub(super) struct Sink<'a> {
    pub batch: &'a mut SegmentBatch,
    pub path: &'a Path,
    /// Whether the batches have z.
    pub wants_z: bool,
    /// Segments before this batch.
    pub first_segment: u64,
    /// Lines of the files before.
    pub first_line: u64,
    /// Polygons of the files before.
    pub first_polygon: u64,
    pub odd: &'a mut OddEnds,
}

/// Ends whose z is not as the others'.
#[derive(Default)]
pub(super) struct OddEnds {
    /// Those that had none.
    pub padded: u64,
    /// Those whose z was left out.
    pub cut: u64,
}

impl OddEnds {
    /// What a person should know of them.
    pub fn notes(&self, path: &Path) -> Vec<String> {
        let path = shown::path(path);
        let padded = (self.padded > 0).then(|| format!("{path}: {} ends have no z, and others have", self.padded));
        let cut = (self.cut > 0).then(|| {
            let cut = self.cut;
            format!("{path}: the z of {cut} ends is not kept, since the first position of no file has one")
        });
        padded.into_iter().chain(cut).collect()
    }
}

impl Sink<'_> {
    /// Whether the batch should be handed out before more is put in.
    pub fn is_full(&self) -> bool {
        self.room() == 0
    }

    /// The number of segments that the batch still takes.
    pub fn room(&self) -> usize {
        BATCH.saturating_sub(self.batch.len())
    }

    /// Takes a segment of this line of the file.
    pub fn segment(&mut self, ends: [Spot; 2], line: u64) {
        self.batch.ends.push(ends.map(|end| end.point));
        self.batch.lines.push(self.first_line + line);
        for end in ends {
            self.odd.padded += u64::from(self.wants_z && end.z.is_none());
            self.odd.cut += u64::from(!self.wants_z && end.z.is_some());
        }
        if self.wants_z {
            self.batch.z.push(ends.map(|end| end.z.unwrap_or(f64::NAN)));
        }
    }

    /// Takes a segment of this polygon of the file, which is of this line.
    #[cfg(feature = "geojson")]
    pub fn side(&mut self, ends: [Spot; 2], line: u64, polygon: u64) {
        self.segment(ends, line);
        self.batch.polygons.push(self.first_polygon + polygon);
    }

    /// Takes a segment between two records.
    pub fn pair(&mut self, records: [u64; 2], line: u64) {
        self.batch.records.push(records);
        self.batch.lines.push(self.first_line + line);
    }

    /// The error of a segment that is none; so many others still wait to be put in before it.
    pub fn wrong_segment(&self, waiting: u64, place: Place, found: String) -> InputError {
        InputError::Segment {
            path: self.path.to_owned(),
            segment: self.first_segment + self.batch.len() as u64 + waiting,
            place,
            found,
        }
    }

    /// The error of an obstacle, by its line of the file.
    pub fn wrong_obstacle(&self, line: u64, place: Place, found: String) -> InputError {
        InputError::Obstacle {
            path: self.path.to_owned(),
            obstacle: self.first_line + line,
            place,
            found,
        }
    }
}
