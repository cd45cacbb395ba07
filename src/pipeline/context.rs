//! The settings and the input of a build, apart from points and segments.

use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use crate::constraints::polygons::check::{InvertedPolygons, Overlapping};
use crate::constraints::polygons::repair::PolygonRepair;
use crate::geometry::Point;
use crate::input::SiteId;
use crate::memory::MemoryPlan;
use crate::pipeline::options::BuildOptions;
use crate::pipeline::plan::NodeLimits;
use crate::pipeline::records::Description;
use crate::pipeline::work_folder::WorkFolder;
use crate::store::PolygonLine;

/// The settings of a build, known before its points arrive.
#[derive(Clone, Debug)]
pub(crate) struct BuildContext {
    pub(crate) options: Arc<BuildOptions>,
    pub(crate) folder: Arc<WorkFolder>,
    /// First record number of segment ends and sites. It is known once all other points have
    /// arrived.
    pub(crate) first_end: Arc<AtomicU64>,
    /// The number of the first run of points.
    pub(crate) first_run: u32,
    /// Number of segments that arrived.
    pub(crate) segments: u64,
    pub(crate) memory: MemoryPlan,
    /// Those of the interrupted build that is resumed.
    pub(crate) limits: Option<NodeLimits>,
}

/// The input of a build, apart from points and segments.
#[derive(Debug, Default)]
pub(crate) struct Given {
    pub(crate) points: u64,
    pub(crate) has_z: bool,
    /// One more than the largest record number.
    pub(crate) next_record: u64,
    pub(crate) description: Description,
    pub(crate) has_obstacles: bool,
    pub(crate) seeds: Vec<Point>,
    /// First record number of the points at which segments were split.
    pub(crate) first_crossing: u64,
    /// First record number of sites.
    pub(crate) first_site: u64,
    pub(crate) site_ids: Vec<SiteId>,
    pub(crate) site_count: u64,
    /// Number of pairs of segments that crossed and were split.
    pub(crate) crossings: u64,
    /// Borders at which segments were split.
    pub(crate) borders: Vec<[Point; 2]>,
    /// Number of points at which segments were split.
    pub(crate) split_points: u64,
    /// Obstacles that are inside out, provided that no rings cross where there is no vertex. Such
    /// crossings are reported first.
    pub(crate) inverted_if_uncrossed: Option<InvertedPolygons>,
    /// The first obstacle that overlaps itself, under the same condition.
    pub(crate) overlapping_if_uncrossed: Option<Overlapping>,
    /// The lines that belong to the polygon of a smaller line.
    pub(crate) polygon_lines: Vec<PolygonLine>,
    /// Result of correcting inverted obstacles.
    pub(crate) repair: PolygonRepair,
}
