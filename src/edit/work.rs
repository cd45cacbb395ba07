//! What an edit is to do.

use crate::constraints::polygons::check::InvertedPolygons;
use crate::constraints::segment::Segment;
use crate::constraints::without_z::NO_Z;
use crate::input::MissingZ;
use crate::store::LineSource;

/// What an edit is to do.
pub(crate) struct Work {
    /// To become constraints.
    pub(crate) segments: Vec<Segment>,
    /// z at the ends of some, or [`NO_Z`].
    pub(crate) z: Vec<[f64; 2]>,
    /// What to do with those that have none and become vertices, if the file has z.
    pub(crate) missing_z: MissingZ,
    /// Lines that are new, to be entered in the directory.
    pub(crate) lines: Vec<LineSource>,
    /// Record numbers for the ends of the segments, in order; 0 if their ends were vertices before.
    pub(crate) new_records: u64,
    /// Obstacles that are inside out, if their rings cross at vertices only. The file stays as it was if they do.
    pub(crate) inverted: Option<InvertedPolygons>,
    /// Whether nobody relies on the file yet, so that it need not be on the medium when this is done.
    pub(crate) is_draft: bool,
    /// Threads that put tiles together, if the memory lets them.
    pub(crate) threads: usize,
}

impl Work {
    /// z at an end, by its number among all ends, or [`NO_Z`].
    pub(crate) fn z_of(&self, end: u32) -> f64 {
        self.z.get(end as usize / 2).map_or(NO_Z, |z| z[end as usize % 2])
    }
}
