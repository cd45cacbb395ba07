//! GeoTIFF: tiles of 256 by 256 cells, compressed, behind their index.
//!
//! The index comes first, so that a reader over a network finds a tile with two requests; with
//! overviews, the file is a Cloud Optimized GeoTIFF (OGC 21-026). The lengths of the tiles are known
//! at the end, so a temporary file takes the tiles meanwhile.
//!
//! Sources: TIFF 6.0; Adobe's Technical Note 3 for the predictor of floating-point numbers; OGC 19-008
//! for the keys.

use std::io::Write;
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use futures::future::{BoxFuture, FutureExt};

use super::job::{RasterJob, Unit};
use super::samples::Samples;
use super::tiff::{Image, Value, header};
use crate::crs::Crs;
use crate::export::error::ExportError;
use crate::export::output::{Output, Sink};
use crate::export::spool::Spool;
use crate::terrain::{Block, Grid};

/// The number of columns and rows of a tile.
const TILE: u32 = 256;
/// The code of a system that has none.
const USER_DEFINED: u16 = 32767;

/// Writes a raster, with overviews if they are requested.
pub(super) async fn write<W: Write + Send + 'static>(
    job: &mut RasterJob<'_>,
    samples: Samples,
    overviews: bool,
    scratch: &Path,
    output: &mut Output<W>,
) -> Result<(), ExportError> {
    let mut tiles = Tiles {
        spool: Spool::create(scratch).await?,
        lengths: Vec::new(),
    };
    let full = job.raster.clone();
    let crs = full.crs();
    let mut images = Vec::new();
    let mut places = Vec::new();
    for factor in factors(job.grid(), overviews) {
        job.raster = full.coarser(factor);
        let start = tiles.spool.length();
        write_tiles(job, samples, &mut tiles).await?;
        places.push(start..tiles.spool.length());
        images.push(Image {
            tags: tags(job.grid(), samples, crs.as_ref().filter(|_| factor == 1), factor > 1),
            tile_lengths: std::mem::take(&mut tiles.lengths),
        });
    }
    job.raster = full;
    output.push(header(&images)).await?;
    for place in places.into_iter().rev() {
        tiles.spool.copy(place, output).await?;
    }
    Ok(())
}

/// Returns the factors of the cells' sizes of all images.
fn factors(grid: &Grid, overviews: bool) -> Vec<u32> {
    let mut factors = vec![1];
    let mut last = *grid;
    while overviews && last.columns().max(last.rows()) > TILE {
        let factor = 2 * factors[factors.len() - 1];
        factors.push(factor);
        last = grid.coarser(factor);
    }
    factors
}

/// Computes an image, and appends its tiles, row by row.
async fn write_tiles(job: &mut RasterJob<'_>, samples: Samples, sink: &mut Tiles) -> Result<(), ExportError> {
    let unit = Unit {
        rows: TILE,
        may_split: true,
    };
    job.for_each_block(unit, async |job, block| {
        let [across, down] = [block.columns(), block.rows()].map(|cells| cells.div_ceil(TILE as usize));
        // Either a block has all columns or one row of tiles, so the tiles come in order.
        let tiles = (0..down).flat_map(|row| (0..across).map(move |column| (column, row)));
        let encode = move |block: &Block, tile| compressed(block, tile, samples);
        job.encode(&block, tiles.collect(), encode, sink).await
    })
    .await
}

/// The compressed tiles, in a temporary file.
struct Tiles {
    spool: Spool,
    /// The lengths of the tiles of the current image.
    lengths: Vec<u32>,
}

impl Sink for Tiles {
    fn push(&mut self, tile: Vec<u8>) -> BoxFuture<'_, Result<(), ExportError>> {
        self.lengths.push(tile.len() as u32);
        self.spool.append(tile).boxed()
    }
}

/// Returns a tile of a block, compressed. Cells beyond the block have no value.
fn compressed(block: &Block, (column, row): (usize, usize), samples: Samples) -> Vec<u8> {
    let size = TILE as usize;
    let columns = column * size..block.columns().min((column + 1) * size);
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    let (mut stored, mut bytes) = (Vec::new(), Vec::new());
    for row in row * size..(row + 1) * size {
        stored.clear();
        if row < block.rows() {
            stored.extend(block.row(row, columns.clone()).map(|value| samples.stored(value)));
        }
        stored.resize(size, samples.no_data());
        predicted(&stored, samples, &mut bytes);
        encoder.write_all(&bytes).expect("a vector takes everything");
    }
    encoder.finish().expect("a vector takes everything")
}

/// Replaces `bytes` by the samples of a row as the predictor leaves them: for floating-point numbers
/// the first bytes of all, then the second ones, and so on, the most significant ones first; then, for
/// all samples, the difference of each byte to the one before.
fn predicted(stored: &[f64], samples: Samples, bytes: &mut Vec<u8>) {
    let count = stored.len();
    bytes.clear();
    bytes.resize(count * samples.bytes(), 0);
    for (i, &value) in stored.iter().enumerate() {
        let mut put = |big_endian: &[u8]| {
            for (plane, &byte) in big_endian.iter().enumerate() {
                bytes[plane * count + i] = byte;
            }
        };
        match samples {
            Samples::Float64 => put(&value.to_be_bytes()),
            Samples::Float32 => put(&(value as f32).to_be_bytes()),
            Samples::Byte => put(&[value as u8]),
        }
    }
    for i in (1..bytes.len()).rev() {
        bytes[i] = bytes[i].wrapping_sub(bytes[i - 1]);
    }
}

/// Returns the tags of an image, beside those of its tiles.
fn tags(grid: &Grid, samples: Samples, crs: Option<&Crs>, is_overview: bool) -> Vec<(u16, Value)> {
    let is_float = samples != Samples::Byte;
    let short = |value: u16| Value::Short(vec![value]);
    let mut tags = vec![
        (254, Value::Long(vec![u32::from(is_overview)])),
        (256, Value::Long(vec![grid.columns()])),
        (257, Value::Long(vec![grid.rows()])),
        (258, short(8 * samples.bytes() as u16)),
        // Deflate; black is 0; one sample; together.
        (259, short(8)),
        (262, short(1)),
        (277, short(1)),
        (284, short(1)),
        (317, short(if is_float { 3 } else { 2 })),
        (322, Value::Long(vec![TILE])),
        (323, Value::Long(vec![TILE])),
        (339, short(if is_float { 3 } else { 1 })),
        (42113, Value::Ascii(samples.no_data().to_string())),
    ];
    if !is_overview {
        let (size, bounds) = (grid.resolution(), grid.bounds());
        tags.push((33550, Value::Double(vec![size, size, 0.0])));
        let corner = vec![0.0, 0.0, 0.0, bounds.min_x, bounds.max_y, 0.0];
        tags.push((33922, Value::Double(corner)));
        tags.extend(geo_keys(crs));
    }
    tags
}

/// Returns the tags of the coordinate reference system: by its code, or else by its text.
fn geo_keys(crs: Option<&Crs>) -> Vec<(u16, Value)> {
    const MODEL: u16 = 1024;
    const PIXEL_IS_AREA: [u16; 4] = [1025, 0, 1, 1];
    const CITATION: u16 = 1026;
    const GEOGRAPHIC: u16 = 2048;
    const PROJECTED: u16 = 3072;
    const PROJECTED_CITATION: u16 = 3073;
    const TEXTS: u16 = 34737;
    let is_geographic = crs.and_then(Crs::is_geographic);
    let code = crs.and_then(Crs::epsg).and_then(|code| u16::try_from(code).ok());
    let model = is_geographic.map(|is_geographic| [MODEL, 0, 1, if is_geographic { 2 } else { 1 }]);
    let mut keys: Vec<[u16; 4]> = model.into_iter().chain([PIXEL_IS_AREA]).collect();
    let mut text = None;
    match (crs, is_geographic, code) {
        (Some(_), Some(is_geographic), Some(code)) => {
            keys.push([if is_geographic { GEOGRAPHIC } else { PROJECTED }, 0, 1, code]);
        }
        (Some(crs), Some(false), None) if crs.wkt().is_some() => {
            // As GDAL and Esri's programs write systems without a code.
            let wkt = format!("ESRI PE String = {}|", crs.wkt().unwrap_or_default());
            keys.push([PROJECTED, 0, 1, USER_DEFINED]);
            keys.push([PROJECTED_CITATION, TEXTS, wkt.len() as u16, 0]);
            text = Some(wkt);
        }
        (Some(crs), ..) => {
            let citation: String = crs.text().chars().filter(char::is_ascii).take(2000).collect();
            let citation = citation.replace('|', " ") + "|";
            keys.push([CITATION, TEXTS, citation.len() as u16, 0]);
            text = Some(citation);
        }
        (None, ..) => {}
    }
    keys.sort_unstable();
    let directory = [[1, 1, 0, keys.len() as u16]].into_iter().chain(keys).flatten();
    let mut tags = vec![(34735, Value::Short(directory.collect()))];
    tags.extend(text.map(|text| (TEXTS, Value::Ascii(text))));
    tags
}
