//! Sites from files: points with an id, among which queries find the nearest.
//!
//! In: paths, and the name of the field that is the id. Out: [`SiteBatch`]es. [`SiteSource`] tells the formats. Only there with
//! the feature `text` or `geojson`, without which there is no format.
//!
//! **Memory**: a batch, and one row of text or one feature's positions, since the id may come behind them.

#[cfg(feature = "geojson")]
mod geojson;
mod id;
mod sink;
#[cfg(feature = "text")]
mod text;

pub use id::SiteId;

use super::bytes::ByteInput;
use super::files::{Files, name_of};
use super::{FileStamp, Format, InputError, Reading};
use crate::geometry::Point;
use crate::shown;
use sink::Sink;
use std::fmt;
use std::path::{Path, PathBuf};

/// A batch of sites in input order.
#[derive(Clone, Debug, Default)]
pub struct SiteBatch {
    /// The places: valid and normalized points.
    pub points: Vec<Point>,
    /// Their elevations: finite, or NaN where a site has none. Empty if the source has none
    /// ([`SiteSource::has_z`]), else as long as `points`.
    pub z: Vec<f64>,
    /// Their ids; as long as `points`.
    pub ids: Vec<SiteId>,
}

impl SiteBatch {
    /// The number of sites.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether the batch has no sites.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Removes all sites and keeps the memory.
    pub fn clear(&mut self) {
        self.points.clear();
        self.z.clear();
        self.ids.clear();
    }
}

/// A blocking stream of the sites of several files.
///
/// | suffix | what |
/// |---|---|
/// | `.csv` and the like | rows `x,y` or `x,y,id`, or the columns that a header names (for x, y and z as with points) |
/// | `.geojson` and the like | each position of a Point or MultiPoint; other geometries are passed over, and a note tells how many |
///
/// Both may be gzip'd. **The id** is, if a field is chosen:
///
/// - text: the column of that name in the header, capitals notwithstanding, or else of that number from 1;
/// - GeoJSON: the feature's property of that name, or, if it is `id` and there is no such property (or it is null), the
///   feature's member `id`. All positions of a feature have the same id.
///
/// Without a choice it is text's column named `id`, or its third one if that has no name (there is no header, or the
/// header's third field is empty); else, and in GeoJSON, the number of the site from 0 over all files. A record without the id
/// that is due is an error. That ids differ is not checked.
///
/// **z** is known at open, by the header or the first position of each file. If any file has z,
/// sites without one have NaN; if none has, z that comes later is left out.
///
/// ```
/// use delaunay_tiles::input::{SiteBatch, SiteId, SiteSource};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # if !cfg!(feature = "text") { return Ok(()); }
/// let dir = tempfile::tempdir()?;
/// let path = dir.path().join("hydrants.csv");
/// std::fs::write(&path, "x,y,id\n1.5,2,H-17\n3,4,18\n")?;
///
/// let mut source = SiteSource::open(&[path], None)?;
/// let mut batch = SiteBatch::default();
/// assert!(source.next_batch(&mut batch)?);
/// assert_eq!(batch.ids, [SiteId::Text("H-17".to_owned()), SiteId::Number(18)]);
/// # Ok(())
/// # }
/// ```
pub struct SiteSource {
    files: Files<Box<dyn Reader>>,
    sites: u64,
    has_z: bool,
    /// Sites of the file at hand that had no z.
    padded: u64,
    notes: Vec<String>,
    done: Vec<(String, u64)>,
    /// The sites of the files that are done.
    done_sites: u64,
}

/// What a format does.
trait Reader: Send {
    /// Whether its sites have z. Known from the start.
    fn has_z(&self) -> bool;

    /// Puts sites into the sink until it is full (true) or the file is at its end (false).
    fn fill(&mut self, sink: &mut Sink<'_>) -> Result<bool, InputError>;

    /// What a person should know, when the file is at its end.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
}

impl SiteSource {
    /// Opens files with sites, and looks at each one's beginning. The id comes from the field of this name, if one is given.
    ///
    /// # Errors
    /// A file that does not exist, whose name tells no format, that is broken at its beginning, or a text without a column for the id.
    pub fn open(paths: &[PathBuf], id_field: Option<&str>) -> Result<Self, InputError> {
        let is_known = |path: &&PathBuf| matches!(Format::from_path(path), Some(Format::Text | Format::GeoJson));
        if let Some(path) = paths.iter().find(|path| !is_known(path)) {
            return Err(InputError::UnknownSites { path: path.clone() });
        }
        let field = id_field.map(str::to_owned);
        let start = move |path: &Path, input| start(path, input, field.as_deref());
        let mut has_z = false;
        Ok(Self {
            files: Files::open(paths, |_| true, Box::new(start), |reader| has_z |= reader.has_z())?,
            sites: 0,
            has_z,
            padded: 0,
            notes: Vec::new(),
            done: Vec::new(),
            done_sites: 0,
        })
    }

    /// Sites so far.
    #[must_use]
    pub fn sites(&self) -> u64 {
        self.sites
    }

    /// Whether the batches have z: if the header or the first position of any file has.
    #[must_use]
    pub fn has_z(&self) -> bool {
        self.has_z
    }

    /// The files that are done, in order: the name of each, without its folder, and how many sites it had.
    #[must_use]
    pub fn sources(&self) -> &[(String, u64)] {
        &self.done
    }

    /// Bytes read so far, as they are in the files.
    #[must_use]
    pub fn bytes_read(&self) -> u64 {
        self.files.bytes_read()
    }

    /// How far the reading is, and the way to stop it.
    #[must_use]
    pub fn reading(&self) -> &Reading {
        self.files.reading()
    }

    /// The regular files among the inputs, as they were when they were looked at.
    #[must_use]
    pub fn stamps(&self) -> &[(PathBuf, FileStamp)] {
        self.files.stamps()
    }

    /// What a person should know about the files that are done.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Clears the batch and fills it with the next sites, at most 8192; false if there are none left.
    ///
    /// # Errors
    /// A file that is broken or cannot be read, a record that is no valid point or has no id. An error ends the stream.
    pub fn next_batch(&mut self, batch: &mut SiteBatch) -> Result<bool, InputError> {
        batch.clear();
        let filled = self.fill(batch);
        if filled.is_err() {
            self.files.clear();
            batch.clear();
        }
        filled?;
        Ok(!batch.is_empty())
    }

    fn fill(&mut self, batch: &mut SiteBatch) -> Result<(), InputError> {
        while let Some((path, reader)) = self.files.current()? {
            let filled = reader.fill(&mut Sink {
                batch,
                path,
                wants_z: self.has_z,
                first: self.sites,
                padded: &mut self.padded,
            });
            let more = match filled {
                Ok(more) => more,
                Err(error) => return Err(self.files.explain(error)),
            };
            self.sites += batch.len() as u64;
            if !more {
                self.done.push((name_of(path), self.sites - self.done_sites));
                self.done_sites = self.sites;
                self.notes.extend(reader.notes());
                let padded = std::mem::take(&mut self.padded);
                if padded > 0 {
                    let path = shown::path(path);
                    self.notes
                        .push(format!("{path}: {padded} sites have no z, and others have"));
                }
                self.files.next_file()?;
            }
            if !batch.is_empty() {
                return Ok(());
            }
        }
        Ok(())
    }
}

impl fmt::Debug for SiteSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SiteSource")
            .field("paths", &self.files.paths().collect::<Vec<_>>())
            .field("sites", &self.sites)
            .finish_non_exhaustive()
    }
}

fn start(path: &Path, input: ByteInput, id_field: Option<&str>) -> Result<Box<dyn Reader>, InputError> {
    match Format::from_path(path) {
        #[cfg(feature = "text")]
        Some(Format::Text) => Ok(Box::new(text::Text::new(input, id_field)?)),
        #[cfg(feature = "geojson")]
        Some(Format::GeoJson) => Ok(Box::new(geojson::Points::new(input, id_field)?)),
        #[cfg(not(feature = "text"))]
        Some(Format::Text) => Err(super::source::missing(path, Format::Text)),
        #[cfg(not(feature = "geojson"))]
        Some(Format::GeoJson) => Err(super::source::missing(path, Format::GeoJson)),
        _ => Err(InputError::UnknownSites { path: path.to_owned() }),
    }
}
