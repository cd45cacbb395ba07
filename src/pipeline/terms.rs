//! What a build was told and given, beside points and segments.

use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use crate::constraints::polygons::check::InvertedPolygons;
use crate::constraints::polygons::put_right::PutRight;
use crate::geometry::Point;
use crate::input::SiteId;
use crate::memory::MemoryPlan;
use crate::pipeline::options::BuildOptions;
use crate::pipeline::records::Description;
use crate::pipeline::work_folder::WorkFolder;

/// What is known of a build before its points come.
#[derive(Clone, Debug)]
pub(crate) struct Terms {
    pub(crate) options: Arc<BuildOptions>,
    pub(crate) folder: Arc<WorkFolder>,
    /// From this record number on points are ends of segments, or sites; it is known once all others have come.
    pub(crate) first_end: Arc<AtomicU64>,
    /// Segments that came.
    pub(crate) segments: u64,
    pub(crate) memory: MemoryPlan,
}

/// What the caller gave, beside points and segments.
#[derive(Debug, Default)]
pub(crate) struct Given {
    pub(crate) points: u64,
    pub(crate) has_z: bool,
    /// One more than the largest record number.
    pub(crate) next_record: u64,
    pub(crate) description: Description,
    pub(crate) has_obstacles: bool,
    pub(crate) seeds: Vec<Point>,
    /// From this record number on points are those at which segments were split.
    pub(crate) first_crossing: u64,
    /// From this record number on points are sites.
    pub(crate) first_site: u64,
    pub(crate) site_ids: Vec<SiteId>,
    pub(crate) site_count: u64,
    /// Pairs of segments that crossed and were split.
    pub(crate) crossings: u64,
    /// Borders at which segments were split.
    pub(crate) borders: Vec<[Point; 2]>,
    /// Points at which segments were split.
    pub(crate) split_points: u64,
    /// Obstacles that are inside out, but for crossings of their rings that no vertex lies at, which are told of first.
    pub(crate) inverted_if_uncrossed: Option<InvertedPolygons>,
    /// What became of those that were put right.
    pub(crate) put_right: PutRight,
}
