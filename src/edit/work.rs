//! The input of an edit.

use crate::constraints::polygons::check::InvertedPolygons;
use crate::constraints::segment::Segment;
use crate::constraints::without_z::NO_Z;
use crate::input::MissingZ;
use crate::store::LineSource;

/// The input of an edit.
pub(crate) struct Work {
    /// The segments that become constraints.
    pub(crate) segments: Vec<Segment>,
    /// z at the ends of some segments, or [`NO_Z`].
    pub(crate) z: Vec<[f64; 2]>,
    /// What to do with ends that have no z and become vertices, if the file has z.
    pub(crate) missing_z: MissingZ,
    /// New lines for the directory.
    pub(crate) lines: Vec<LineSource>,
    /// Number of record numbers for the ends of the segments, in order; 0 if the ends were vertices
    /// before.
    pub(crate) new_records: u64,
    /// Obstacles that are inside out, if their rings cross at vertices only. In that case the edit
    /// fails and the file is unchanged.
    pub(crate) inverted: Option<InvertedPolygons>,
    /// Whether the file is still a draft that nothing relies on, so that it need not be on the
    /// medium when the edit is done.
    pub(crate) is_draft: bool,
    /// Number of threads that decode and encode tiles, if the memory allows it.
    pub(crate) threads: usize,
}

impl Work {
    /// Returns the z at an end, by its number among all ends, or [`NO_Z`].
    pub(crate) fn z_of(&self, end: u32) -> f64 {
        self.z.get(end as usize / 2).map_or(NO_Z, |z| z[end as usize % 2])
    }
}
