//! Sites from files: points with an id, among which queries find the nearest.
//!
//! Without the features `text` and `geojson` there is no format.
//!
//! **Memory**: a batch, and one row of text or one feature's positions, since the id may come behind them.

use crate::input::bytes::ByteInput;
use crate::input::error::{InputError, RecordKind};
#[cfg(feature = "geojson")]
use crate::input::formats::geojson;
#[cfg(feature = "text")]
use crate::input::formats::text;
use crate::input::options::Format;
use crate::input::reader::Started;
use crate::input::sites::SiteBatch;
use crate::input::source::stream::{Records, Source};
use std::path::{Path, PathBuf};

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
pub type SiteSource = Source<SiteBatch>;

/// How a file with sites is written.
#[derive(Clone, Copy)]
pub enum SiteFormat {
    Text,
    GeoJson,
}

impl SiteFormat {
    fn from_path(path: &Path) -> Option<Self> {
        match Format::from_path(path)? {
            Format::Text => Some(Self::Text),
            Format::GeoJson => Some(Self::GeoJson),
            _ => None,
        }
    }
}

impl Records for SiteBatch {
    type Format = SiteFormat;

    const SPANS_FILES: bool = false;

    fn may_be_gzip(_: SiteFormat) -> bool {
        true
    }

    #[cfg_attr(
        not(any(feature = "text", feature = "geojson")),
        allow(unused_variables, reason = "sites are read from text and GeoJSON alone")
    )]
    fn start(format: SiteFormat, input: ByteInput, id_field: &Option<String>) -> Started<Self> {
        match format {
            #[cfg(feature = "text")]
            SiteFormat::Text => Ok(Box::new(text::Sites::new(input, id_field.as_deref())?)),
            #[cfg(feature = "geojson")]
            SiteFormat::GeoJson => Ok(Box::new(geojson::Sites::new(input, id_field.as_deref())?)),
            #[cfg(not(feature = "text"))]
            SiteFormat::Text => Err(Format::Text.missing(&input.path)),
            #[cfg(not(feature = "geojson"))]
            SiteFormat::GeoJson => Err(Format::GeoJson.missing(&input.path)),
        }
    }
}

impl Source<SiteBatch> {
    /// Opens files with sites, and looks at each one's beginning. The id comes from the field of this name, if one is given.
    ///
    /// # Errors
    /// A file that does not exist, whose name tells no format, that is broken at its beginning, or a text without a column for the id.
    pub fn open(paths: &[PathBuf], id_field: Option<&str>) -> Result<Self, InputError> {
        let id_field = id_field.map(str::to_owned);
        Self::of_files(paths, id_field, SiteFormat::from_path, RecordKind::Site)
    }

    /// Sites so far.
    #[must_use]
    pub fn sites(&self) -> u64 {
        self.records
    }
}
