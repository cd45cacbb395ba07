//! Writing contours in one of the formats.

use std::io::Write;
use std::path::PathBuf;

use super::features::{Encoding, FeatureSink};
use super::job::ContourJob;
use crate::export::error::ExportError;
use crate::export::format::Format;
use crate::export::output::Output;
use crate::export::spool::Spool;
use crate::store::TileReader;
use crate::terrain::{ContourOptions, FileSurface, TerrainError};

/// How contours are written.
///
/// ```
/// use delaunay_tiles::export::{ContourOutput, Format};
///
/// let output = ContourOutput::new(Format::GeoJson).scratch("/tmp");
/// # let _ = output;
/// ```
#[derive(Clone, Debug)]
pub struct ContourOutput {
    format: Format,
    scratch: PathBuf,
}

impl ContourOutput {
    /// Creates the description of an output: GeoJSON or FlatGeobuf.
    #[must_use]
    pub fn new(format: Format) -> Self {
        Self {
            format,
            scratch: std::env::temp_dir(),
        }
    }

    /// Sets the folder for temporary files, which take the points of contours that pass through
    /// several tiles and, before they are copied behind their header, the features of a FlatGeobuf;
    /// the system's folder for temporary files by default.
    #[must_use]
    pub fn scratch(mut self, folder: impl Into<PathBuf>) -> Self {
        self.scratch = folder.into();
        self
    }
}

/// The summary and the output of an export of contours.
#[derive(Debug)]
#[non_exhaustive]
pub struct ExportedContours<W> {
    /// The number of contours.
    pub contours: u64,
    /// The number of points of all contours; of closed ones, the first one counts twice.
    pub points: u64,
    /// The number of bytes.
    pub bytes: u64,
    /// The output, flushed.
    pub output: W,
}

/// Writes the contours of the surface of a file. Must be awaited within a tokio runtime.
///
/// A contour is a line along which the planes of the triangles have the height of a level. It is exact,
/// but for the rounding of its points, which are on the edges that it crosses. The higher ground is on
/// its left. It is closed, or it ends at the hull, at a hole, or at triangles that do not count; and if
/// it is limited to [polygons](ContourOptions::clip), at their boundary, exact but for one rounding. A
/// vertex whose z is that of a level counts as above it. So flat ground at a level is above it too, and
/// where contours of a level meet in a vertex, they touch and do not cross.
///
/// Each contour is a line of x, y and z with the properties `z`, the height, and `closed`. A closed one
/// begins and ends at its lexicographically smallest point. The contours do not depend on tiles, threads
/// and memory, to the last bit. Their order depends on the tiles, and on nothing else. Of polygons, only
/// the tiles that meet the rectangle around them are read. The polygons, with
/// [`Clip::bytes`](crate::terrain::Clip::bytes), come on top of the memory that the reader may use.
///
/// The output gets chunks of one or two mebibytes, on threads for blocking work, so it needs no buffer.
/// `progress` is called with the number of tiles done and the total of those to be read.
///
/// # Errors
/// Fails if the file has no z, cannot be read or is damaged; if the surface has more than
/// [`Levels::MAX`](crate::terrain::Levels::MAX) levels; if the format is neither GeoJSON nor FlatGeobuf;
/// if the output or a temporary file fails; or if the memory that the reader may use does not suffice
/// for a tile, for the ends of contours that other tiles may continue, or for the longest contour.
///
/// # Examples
///
/// ```
/// # use delaunay_tiles::{BuildOptions, Builder, OpenOptions, Point, TileReader, input::PointBatch};
/// use delaunay_tiles::export::{ContourOutput, Format, export_contours};
/// use delaunay_tiles::terrain::{ContourOptions, Levels};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("slope.tiles");
/// # tokio::runtime::Runtime::new()?.block_on(async {
/// # let points: Vec<Point> = (0..2500).map(|i| Point::new(f64::from(i % 50), f64::from(i / 50))).collect();
/// # let z = points.iter().map(|p| p.x).collect();
/// # let options = BuildOptions::default().tile_vertices(100);
/// # let mut builder = Builder::new(&path, options)?;
/// # builder.push(&PointBatch { records: (0..2500).collect(), points, z }).await?;
/// # builder.finish().await?;
/// // A slope that rises to the east, by 49 over all.
/// let slope = TileReader::open(&path, OpenOptions::default()).await?;
/// let options = ContourOptions::new(Levels::new(10.0, 0.5)?);
/// let how = ContourOutput::new(Format::GeoJson);
/// let exported = export_contours(&slope, options, &how, Vec::new(), |_, _| {}).await?;
/// assert_eq!(exported.contours, 5);
/// let text = String::from_utf8(exported.output)?;
/// // The higher ground is on the left of a line to the south.
/// assert!(text.contains("\"z\":20.5,\"closed\":false"));
/// assert!(text.contains("[[20.5,49.0,20.5],"));
/// # Ok(())
/// # })
/// # }
/// ```
pub async fn export_contours<W: Write + Send + 'static>(
    reader: &TileReader,
    options: ContourOptions,
    how: &ContourOutput,
    output: W,
    mut progress: impl FnMut(u64, u64) + Send,
) -> Result<ExportedContours<W>, ExportError> {
    let encoding = Encoding::new(how.format)?;
    if !reader.metadata().has_z {
        let file = reader.name().to_owned();
        return Err(TerrainError::NoZ { file }.into());
    }
    let reader = reader.for_passes().await?;
    let (levels, surface, clip) = options.parts();
    let tiles = u64::from(reader.metadata().tiles);
    let mut before = 0;
    let mut advance = || {
        before += 1;
        // With the pass that follows.
        progress(before, 2 * tiles);
    };
    let surface = FileSurface::of(&reader, surface, &mut advance).await?;
    let output = Output::new(output, how.format.suffixes()[0]);
    let sink = FeatureSink::open(&reader, encoding, output, &how.scratch).await?;
    let spool = Spool::create(&how.scratch).await?;
    let job = ContourJob::new(reader.clone(), (surface, levels, clip), encoding, sink, spool);
    let sink = job.run(|done, of| progress(before + done, before + of)).await?;
    let (contours, points) = (sink.count, sink.points);
    let (output, bytes) = sink.finish(&reader).await?;
    Ok(ExportedContours {
        contours,
        points,
        bytes,
        output,
    })
}
