//! Segments from files, as one blocking stream of batches.
//!
//! In: paths. Out: [`SegmentBatch`]es: segments by their ends, valid and normalized, or by the record numbers of points.
//!
//! | suffix | what |
//! |---|---|
//! | `.geojson` and the like | lines, and the rings of polygons: a segment between each position and the next; points are passed over |
//! | `.csv` and the like | rows `x1,y1,x2,y2`, with or without a header; further columns are not read |
//! | `.u32`, `.u64` | pairs of record numbers of points, raw and little-endian |
//!
//! All but the first may be gzip'd. Segments are numbered from 0 over all files. Of GeoJSON, one geometry's segments are in memory at a
//! time, since only its end tells for sure what it is.

#[cfg(any(feature = "text", feature = "geojson"))]
mod ends;
#[cfg(feature = "geojson")]
mod geojson;
mod pairs;
#[cfg(feature = "text")]
mod text;

use super::InputError;
use super::bytes::{ByteInput, open_file};
use crate::geometry::Point;
use std::collections::VecDeque;
use std::fmt;
use std::fs::Metadata;
use std::path::{Path, PathBuf};

/// Segments in a full batch.
const BATCH: usize = 8192;

/// A batch of segments.
#[derive(Clone, Debug, Default)]
pub struct SegmentBatch {
    /// Segments by their ends: valid and normalized points.
    pub ends: Vec<[Point; 2]>,
    /// Segments by the record numbers of two points.
    pub records: Vec<[u64; 2]>,
}

impl SegmentBatch {
    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty() && self.records.is_empty()
    }

    fn len(&self) -> usize {
        self.ends.len() + self.records.len()
    }
}

/// A blocking stream of the segments of several files.
pub struct SegmentSource {
    paths: VecDeque<PathBuf>,
    reader: Option<Box<dyn Reader>>,
    segments: u64,
}

/// What a format does.
trait Reader: Send {
    /// Puts segments into the batch until it is full (true) or the file is at its end (false). The first one that it adds has
    /// this number.
    fn fill(&mut self, first: u64, batch: &mut SegmentBatch) -> Result<bool, InputError>;
}

/// The format of a file with segments.
#[derive(Clone, Copy)]
enum Format {
    Pairs { bytes: usize },
    Text,
    GeoJson,
}

impl Format {
    fn from_path(path: &Path) -> Option<Self> {
        let suffix = path.extension().and_then(|suffix| suffix.to_str());
        match suffix.map(str::to_ascii_lowercase).as_deref() {
            Some("u32") => return Some(Self::Pairs { bytes: 4 }),
            Some("u64") => return Some(Self::Pairs { bytes: 8 }),
            _ => {}
        }
        match super::Format::from_path(path)? {
            super::Format::Text => Some(Self::Text),
            super::Format::GeoJson => Some(Self::GeoJson),
            _ => None,
        }
    }
}

impl SegmentSource {
    /// Opens the files, in this order, one after the other.
    ///
    /// # Errors
    /// A file whose name tells no format.
    pub fn open(paths: &[PathBuf]) -> Result<Self, InputError> {
        if let Some(path) = paths.iter().find(|path| Format::from_path(path).is_none()) {
            return Err(InputError::UnknownSegments { path: path.clone() });
        }
        Ok(Self {
            paths: paths.iter().cloned().collect(),
            reader: None,
            segments: 0,
        })
    }

    /// Segments so far.
    #[must_use]
    pub fn segments(&self) -> u64 {
        self.segments
    }

    /// Clears the batch and fills it with the next segments; false if there are none left.
    ///
    /// # Errors
    /// A file that is broken or cannot be read, or an end that is no valid point. An error ends the stream.
    pub fn next_batch(&mut self, batch: &mut SegmentBatch) -> Result<bool, InputError> {
        batch.ends.clear();
        batch.records.clear();
        let filled = self.fill(batch);
        if filled.is_err() {
            self.paths.clear();
            self.reader = None;
        }
        filled?;
        self.segments += batch.len() as u64;
        Ok(!batch.is_empty())
    }

    fn fill(&mut self, batch: &mut SegmentBatch) -> Result<(), InputError> {
        loop {
            let reader = match &mut self.reader {
                Some(reader) => reader,
                none => match self.paths.pop_front() {
                    Some(path) => none.insert(open(&path)?),
                    None => return Ok(()),
                },
            };
            let more = reader.fill(self.segments, batch)?;
            if !more {
                self.reader = None;
            }
            if !batch.is_empty() {
                return Ok(());
            }
        }
    }
}

impl fmt::Debug for SegmentSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SegmentSource")
            .field("paths", &self.paths)
            .field("segments", &self.segments)
            .finish_non_exhaustive()
    }
}

fn open(path: &Path) -> Result<Box<dyn Reader>, InputError> {
    let unknown = || InputError::UnknownSegments { path: path.to_owned() };
    let format = Format::from_path(path).ok_or_else(unknown)?;
    let (file, metadata) = open_file(path)?;
    let size = metadata.as_ref().map(Metadata::len);
    let unzip = !matches!(format, Format::Pairs { .. });
    let input = ByteInput::new(path.into(), Box::new(file), size, unzip)?;
    match format {
        Format::Pairs { bytes } => Ok(Box::new(pairs::Pairs::new(input, bytes))),
        #[cfg(feature = "text")]
        Format::Text => Ok(Box::new(text::Text::new(input)?)),
        #[cfg(feature = "geojson")]
        Format::GeoJson => Ok(Box::new(geojson::Lines::new(input)?)),
        #[cfg(not(all(feature = "text", feature = "geojson")))]
        absent => Err(InputError::MissingFeature {
            path: path.to_owned(),
            what: "segments in this format".to_owned(),
            feature: if matches!(absent, Format::Text) {
                "text"
            } else {
                "geojson"
            },
        }),
    }
}
