//! The source of sites: points with an id, among which queries find the nearest.
//!
//! Without the features of text and of vector data, no format is available.
//!
//! **Memory**: a batch, and one row of text or the positions of one feature, since the id may
//! follow them.

use crate::input::bytes::ByteInput;
use crate::input::content;
use crate::input::error::{InputError, RecordKind};
use crate::input::format::Format;
use crate::input::formats::shapes::Sites;
#[cfg(feature = "text")]
use crate::input::formats::text;
use crate::input::formats::vector::Vector;
use crate::input::reader::Started;
use crate::input::sites::SiteBatch;
use crate::input::source::stream::{Records, Source, start_stream};
use crate::input::watch::Watched;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A blocking stream of the sites of several files.
///
/// | suffix | contents |
/// |---|---|
/// | `.csv` and the like | rows `x,y` or `x,y,id`, or the columns that a header names (for x, y and z as with points) |
/// | `.geojson` and the like, `.fgb`, `.shp`, `.gpkg` | each position of a Point or MultiPoint; other geometries are skipped, and a note tells how many |
///
/// All but `.gpkg` may be compressed with gzip. `FILE.gpkg:LAYER` names one of several layers. A file
/// with another suffix is recognised by its content, if that is vector data. **The id**, if a field is selected, is:
///
/// - in text, the column with that name in the header, ignoring case, otherwise the column with
///   that number, counted from 1;
/// - in GeoJSON, the feature's property with that name. If the name is `id` and that property is
///   missing or null, the id is the feature's member `id`. All positions of a feature have the same
///   id;
/// - in FlatGeobuf, GeoPackage, and the `.dbf` file beside a `.shp` file, the field with that name.
///
/// If no field is selected, the id in text is the column named `id`, otherwise the third column if
/// that has no name (there is no header, or the header's third field is empty). In all other cases,
/// and always in vector data, the id is the number of the site, counted from 0 over all files. A record
/// without the expected id is an error. Whether ids are distinct is not checked.
///
/// **z** is known at open, from the header or the first position of each file. If any file has z,
/// sites without z have NaN. If no file has z at open, z that appears later is dropped.
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
pub type SiteSource = Source<SiteBatch>;

/// The format of a file with sites.
#[derive(Clone, Copy)]
pub enum SiteFormat {
    Text,
    Vector(Vector),
}

impl SiteFormat {
    fn of_sites(path: &Path) -> Option<Self> {
        match content::format_of(path)? {
            Format::Text => Some(Self::Text),
            format => Vector::of(format).map(Self::Vector),
        }
    }
}

impl Records for SiteBatch {
    type Format = SiteFormat;

    const SPANS_FILES: bool = false;

    fn content(format: SiteFormat) -> Option<Format> {
        match format {
            SiteFormat::Text => Some(Format::Text),
            SiteFormat::Vector(vector) => Some(vector.format()),
        }
    }

    fn may_be_gzip(_: SiteFormat) -> bool {
        true
    }

    fn start(format: SiteFormat, input: ByteInput, id_field: &Option<String>) -> Started<Self> {
        match format {
            #[cfg(feature = "text")]
            SiteFormat::Text => Ok(Box::new(text::Sites::new(input, id_field.as_deref())?)),
            #[cfg(not(feature = "text"))]
            SiteFormat::Text => Err(Format::Text.missing(&input.path)),
            SiteFormat::Vector(vector) => {
                let path = Arc::clone(&input.path);
                Ok(Box::new(Sites::new(vector.start(input)?, &path, id_field.as_deref())?))
            }
        }
    }

    fn start_file(format: SiteFormat, file: Watched<Arc<File>>, id_field: &Option<String>) -> Started<Self> {
        match format {
            SiteFormat::Vector(vector) => {
                let path = Arc::clone(&file.watch.path);
                Ok(Box::new(Sites::new(
                    vector.start_file(file)?,
                    &path,
                    id_field.as_deref(),
                )?))
            }
            SiteFormat::Text => start_stream(format, file, id_field),
        }
    }
}

impl Source<SiteBatch> {
    /// Opens files with sites and examines the beginning of each. With `id_field`, the id is read
    /// from the field of that name.
    ///
    /// # Errors
    /// Fails if a file does not exist, its name does not indicate a format or it is broken at its
    /// beginning, or if a text has no column for the id.
    pub fn open(paths: &[PathBuf], id_field: Option<&str>) -> Result<Self, InputError> {
        let id_field = id_field.map(str::to_owned);
        Self::of_files(paths, id_field, SiteFormat::of_sites, RecordKind::Site)
    }

    /// Returns the number of sites read so far.
    #[must_use]
    pub fn sites(&self) -> u64 {
        self.records
    }
}
