//! The contents of a file of points, and of what comes with the points: faces, segments, holes.

use crate::input::about::About;
use crate::input::describe::info::Contents;
use crate::input::error::InputError;
use crate::input::format::Format;
use crate::input::formats::poly::beside;
use crate::input::lines::SegmentBatch;
use crate::input::options::{InputOptions, MissingZ, Returns};
use crate::input::points::PointBatch;
use crate::input::source::{PointSource, PolySource, SegmentSource};
use crate::input::watch::Reading;
use std::num::NonZeroU64;
use std::path::Path;

/// Reads all points.
pub fn scan(
    path: &Path,
    format: Format,
    options: &InputOptions,
    reading: &Reading,
) -> Result<(Contents, About, Vec<String>), InputError> {
    let mut source = PointSource::open_followed(path, &all(options, format), reading)?;
    let (mut contents, mut batch) = (Contents::new(), PointBatch::default());
    while source.next_batch(&mut batch)? {
        let z = batch.z.iter().copied().chain(std::iter::repeat(f64::NAN));
        for (&point, z) in batch.points.iter().zip(z) {
            contents.add_position(point, z);
        }
    }
    let counts = source.counts();
    contents.counts.points = counts.points;
    contents.counts.withheld = counts.withheld;
    contents.counts.invalid = counts.invalid;
    contents.crs = source.crs_of_files().first().map(|(_, crs)| crs.clone());
    let about = source.about().clone();
    contents.fields.clone_from(&about.fields);
    let mut notes = source.notes().to_vec();
    if format == Format::Poly {
        scan_poly(path, &mut contents, reading)?;
    } else if format.may_have_edges() && (format != Format::Node || has_elements(path)) {
        match scan_faces(path, format, reading) {
            Ok((faces, edges, of_faces)) => {
                (contents.counts.faces, contents.counts.edges) = (faces, edges);
                // That there are none is no news of a file of points.
                notes.extend(of_faces.into_iter().filter(|_| faces > 0));
            }
            // The points are sound, and a build without the faces takes them.
            Err(error @ (InputError::Malformed { .. } | InputError::Record { .. })) => {
                notes.push(format!("the faces cannot be read: {error}"));
            }
            Err(error) => return Err(error),
        }
    }
    Ok((contents, about, notes))
}

/// Reads all faces. Returns their number, that of their edges, and notes.
fn scan_faces(path: &Path, format: Format, reading: &Reading) -> Result<(u64, u64, Vec<String>), InputError> {
    let (mut source, _) = SegmentSource::open_edges(path, format)?;
    scan_segments(&mut source, reading)?;
    let faces = source.sources().iter().map(|(_, faces)| faces).sum();
    Ok((faces, source.segments(), source.notes().to_vec()))
}

/// Reads a file of pairs of record numbers.
pub fn scan_pairs(path: &Path, reading: &Reading) -> Result<Contents, InputError> {
    let mut contents = Contents::new();
    let mut pairs = SegmentSource::open(&[path.to_owned()])?;
    scan_segments(&mut pairs, reading)?;
    contents.counts.segments = pairs.segments();
    Ok(contents)
}

/// Returns the options that select all points.
fn all(options: &InputOptions, format: Format) -> InputOptions {
    InputOptions {
        is_description: true,
        ..options.clone()
    }
    .format(format)
    .classes(Vec::new())
    .returns(Returns::All)
    .keep_withheld(false)
    .bounds(None)
    .every(NonZeroU64::MIN)
    .copc_level(None)
    .copc_resolution(None)
    .skip_invalid(true)
    .missing_z(MissingZ::Zero)
}

/// Returns whether there is a file with the triangles of a `.node` file beside it.
fn has_elements(node: &Path) -> bool {
    beside(node, "node", "ele").is_some_and(|path| path.exists())
}

/// Reads all segments.
fn scan_segments(source: &mut SegmentSource, reading: &Reading) -> Result<(), InputError> {
    let mut batch = SegmentBatch::default();
    while source.next_batch(&mut batch)? {
        reading.check()?;
    }
    Ok(())
}

fn scan_poly(path: &Path, contents: &mut Contents, reading: &Reading) -> Result<(), InputError> {
    let (mut poly, mut batch) = (PolySource::open(path)?, SegmentBatch::default());
    while poly.next_batch(&mut batch)? {
        reading.check()?;
    }
    contents.counts.segments = poly.segments();
    contents.counts.holes = poly.holes()?.len() as u64;
    Ok(())
}
