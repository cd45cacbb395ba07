//! The edges of an existing triangulation, from the files that have its vertices.

use crate::input::bytes::ByteInput;
use crate::input::error::{InputError, Location, RecordKind};
use crate::input::format::Format;
use crate::input::formats::node::Vertices;
use crate::input::formats::poly::beside;
use crate::input::formats::text_lines::Lines;
use crate::input::formats::{obj, ply};
use crate::input::lines::SegmentBatch;
use crate::input::source::lines::LineFormat;
use crate::input::source::stream::Source;
use crate::input::watch::{Watched, note};
use crate::shown;
use std::path::{Path, PathBuf};

impl Source<SegmentBatch> {
    /// Opens a file with a triangulation or another mesh, for the edges of its faces. Returns the
    /// source, and the number of points in the file. Without `format`, the name determines it:
    ///
    /// | format | edges |
    /// |---|---|
    /// | `.node` | of the triangles in the `.ele` file beside it |
    /// | `.ply` | of the element `face`; of the element `edge` if there are no faces |
    /// | `.obj` | of faces and lines |
    ///
    /// All may be compressed with gzip. Faces may have any number of corners, up to 65,536 in PLY.
    /// The segments are [pairs of record numbers](SegmentBatch::records), as a
    /// [`PointSource`](crate::input::PointSource) with no other input counts them. If the point
    /// source has other inputs before this file, add the number of their records. A line is a face.
    ///
    /// An edge between two faces comes once, with the first of them. Only if these are far apart in
    /// the file, it may come twice.
    ///
    /// The file is opened two or three times, so it cannot be a pipe.
    ///
    /// # Errors
    /// As for [`Self::open`]. Also fails if there is no `.ele` file beside a `.node` file.
    ///
    /// ```
    /// use delaunay_tiles::input::{SegmentBatch, SegmentSource};
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let dir = tempfile::tempdir()?;
    /// let path = dir.path().join("square.obj");
    /// std::fs::write(&path, "v 0 0 5\nv 1 0 5\nv 1 1 5\nv 0 1 5\nf 1 2 3\nf 1 3 4\n")?;
    ///
    /// let (mut source, points) = SegmentSource::open_edges(&path, None)?;
    /// let mut batch = SegmentBatch::default();
    /// assert!(source.next_batch(&mut batch)?);
    /// assert_eq!((points, batch.records.len()), (4, 5));
    /// # Ok(())
    /// # }
    /// ```
    pub fn open_edges(path: &Path, format: impl Into<Option<Format>>) -> Result<(Self, u64), InputError> {
        let mut source = Self::new(());
        let file = Watched::open(path, &source.reading, None)?;
        let watch = file.watch.clone();
        if watch.size().is_none() {
            let hint = "a file with edges is read twice, for its points and for its edges";
            let problem = "this is not a regular file";
            return Err(InputError::malformed(path, Location::File, problem, hint));
        }
        let examined = ByteInput::new(file, true).and_then(|input| {
            Ok(match format.into().or_else(|| Format::from_path(path)) {
                Some(Format::Node) => {
                    let mut vertices = Vertices::new(Lines::new(input)?, false)?;
                    vertices.next_row()?;
                    let (base, points) = (vertices.base().unwrap_or(0), vertices.claimed);
                    let elements = LineFormat::Elements { base, points };
                    (elements_beside(path)?, elements, points)
                }
                Some(Format::Ply) => {
                    let points = ply::vertices(input)?;
                    (path.to_owned(), LineFormat::PlyFaces { points }, points)
                }
                Some(Format::Obj) => {
                    let points = obj::vertices(input)?;
                    (path.to_owned(), LineFormat::ObjFaces { points }, points)
                }
                _ => {
                    let (path, kind) = (path.to_owned(), RecordKind::Face);
                    return Err(InputError::UnknownFormat { path, kind });
                }
            })
        });
        let (with_edges, format, points) = examined.map_err(|error| watch.explain(error))?;
        note(&mut source.stamps, &watch);
        source.add_file(&with_edges, format)?;
        Ok((source, points))
    }
}

/// Returns the path of the file with the triangles of a `.node` file.
fn elements_beside(node: &Path) -> Result<PathBuf, InputError> {
    let hint = "put that file there, or read the points without edges";
    let missing = |problem: String| InputError::malformed(node, Location::File, problem, hint);
    let name = || missing("its triangles cannot be found, because its name does not end in .node".to_owned());
    let path = beside(node, "node", "ele").ok_or_else(name)?;
    match path.exists() {
        true => Ok(path),
        false => Err(missing(format!(
            "its triangles would be in {}, which does not exist",
            shown::path(&path)
        ))),
    }
}
