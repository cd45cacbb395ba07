//! What a file of any format holds, without building anything from it.
//!
//! In: a path, and the options that tell how to read it. Out: a [`FileInfo`]. The whole file is
//! read, by the same readers as in a build, so that what is counted is what a build would find.
//!
//! | module | contents |
//! |---|---|
//! | `info` | the counts, bounds and fields of a file |
//! | `points` | the scan of a file of points, and of the faces or segments with them |
//! | `shapes` | the scan of vector data, layer by layer |

mod info;
mod points;
mod shapes;

pub use info::{Contents, FileInfo, ItemCounts};

use crate::input::content;
use crate::input::error::{InputError, Location, RecordKind};
use crate::input::formats::vector::Vector;
use crate::input::options::InputOptions;
use crate::input::watch::{Reading, Watched};
use std::path::Path;

/// The bytes that begin gzip.
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// Reads a file of any format, and returns what it holds: records by kind, fields, bounds, and
/// coordinate reference system.
///
/// Of the options, those that tell how to read the file count ([`format`](InputOptions::format),
/// [`columns`](InputOptions::columns), [`dims`](InputOptions::dims)), and not those that select
/// points. Invalid records are counted, and withheld ones; neither are in the bounds. A path
/// `FILE.gpkg:LAYER` limits the result to one layer. `reading` shows the progress and can stop the
/// reading; PLY, OBJ, `.node` and `.poly` are read a second time for their faces or segments, which
/// it does not show.
///
/// Memory is bounded as for the sources.
///
/// # Errors
/// Fails if the file does not exist, is empty, has no known format, or is broken.
///
/// ```
/// use delaunay_tiles::input::{InputOptions, Reading, describe};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let dir = tempfile::tempdir()?;
/// let path = dir.path().join("square.obj");
/// std::fs::write(&path, "v 0 0 5\nv 1 0 5\nv 1 1 6\nv 0 1 5\nf 1 2 3\nf 1 3 4\n")?;
///
/// let info = describe(&path, &InputOptions::default(), &Reading::default())?;
/// let contents = &info.contents[0];
/// assert_eq!((contents.counts.points, contents.counts.faces), (4, 2));
/// assert_eq!((contents.bounds.max_x, contents.z), (1.0, Some([5.0, 6.0])));
/// # Ok(())
/// # }
/// ```
pub fn describe(path: &Path, options: &InputOptions, reading: &Reading) -> Result<FileInfo, InputError> {
    let file = Watched::open(path, reading, None)?;
    let (bytes, head) = (file.watch.size(), file.head());
    drop(file);
    if bytes == Some(0) {
        let hint = "is it the right file, and was it written to the end?";
        return Err(InputError::malformed(path, Location::File, "the file is empty", hint));
    }
    let mut info = FileInfo {
        path: path.to_owned(),
        format: String::new(),
        variety: None,
        bytes,
        is_gzip: head.starts_with(&GZIP),
        contents: Vec::new(),
        las: None,
        notes: Vec::new(),
    };
    let suffix = path.extension().and_then(|suffix| suffix.to_str());
    let suffix = suffix.map(str::to_ascii_lowercase).unwrap_or_default();
    if options.format.is_none() && matches!(&*suffix, "u32" | "u64") {
        info.contents.push(points::scan_pairs(path, reading)?);
        info.is_gzip = false;
        info.format = suffix;
        return Ok(info);
    }
    let Some(format) = options.format.or_else(|| content::format_of(path)) else {
        return Err(InputError::UnknownFormat {
            path: path.to_owned(),
            kind: RecordKind::Point,
        });
    };
    info.format = format.to_string();
    if let Some(vector) = Vector::of(format) {
        info.contents = shapes::scan(path, vector, reading)?;
        return Ok(info);
    }
    let (contents, about, notes) = points::scan(path, format, options, reading)?;
    info.is_gzip &= format != crate::input::Format::F64;
    info.contents.push(contents);
    info.variety = about.variety;
    info.las = about.las;
    info.notes = notes;
    Ok(info)
}
