//! The state of a wavefront.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap, HashSet};
use std::hash::BuildHasherDefault;

use super::aims::Aims;
use super::found::{FoundTarget, Ready, Target};
use super::goal::Goal;
use super::queue::Queue;
use super::reached::Reached;
use super::regions::{HalfPlane, RegionShape, VisibleRegion, WholeTriangle};
use super::roots::{Root, SeenVertices};
use super::task::Task;
use super::waiting::Waiting;
use crate::collections::mix::Mix;
use crate::geometry::Point;
use crate::query::free_space::Mark;
use crate::store::{TileId, VertexId};

/// The approximate maximum number of triangles that one step passes.
pub(super) const PAUSE: u32 = 1 << 12;

/// The state of a wavefront.
#[derive(Debug)]
pub(crate) struct Wavefront {
    pub(super) source: Point,
    pub(super) outside_is_free: bool,
    pub(super) goal: Goal,
    /// The goals towards which the search is directed.
    pub(super) aims: Aims,
    /// Targets that are farther away are not wanted.
    pub(super) limit: f64,
    pub(super) queue: Queue,
    pub(super) waiting: Waiting,
    /// Whether adjacent waiting windows are joined.
    pub(super) joins: bool,
    /// The number of triangles passed before this step.
    pub(super) passed: u64,
    pub(super) roots: Vec<Root>,
    pub(super) seen: SeenVertices,
    /// The knowledge of the current tile; `elsewhere` has that of tiles visited before.
    pub(super) here: Reached,
    pub(super) current_tile: Option<TileId>,
    pub(super) elsewhere: HashMap<TileId, Reached, BuildHasherDefault<Mix>>,
    pub(super) ready: BinaryHeap<Reverse<Ready>>,
    /// The numbers of the targets that were reported.
    pub(super) reported: HashSet<u64, BuildHasherDefault<Mix>>,
    /// The number of triangles that this step may still pass.
    pub(super) pause: u32,
    /// The regions that were seen, if they are kept.
    pub(super) regions: Option<Vec<VisibleRegion>>,
    /// The triangles that were found to be within the limit as a whole, if they are kept.
    pub(super) whole: Option<Vec<WholeTriangle>>,
    /// The half-plane outside the hull that the source was found to see already.
    pub(super) seen_half_plane: Option<HalfPlane>,
}

impl Wavefront {
    /// Returns a lower bound of the lengths of all paths to targets that were not reported yet.
    pub(crate) fn front(&self) -> f64 {
        let ready = self.ready.peek().map(|ready| f64::from_bits(ready.0.key.0));
        ready.map_or(self.queue.front(), |ready| ready.min(self.queue.front()))
    }

    /// Returns the number of triangles that the wavefront has passed. A triangle counts once for
    /// each window that passed it.
    pub(crate) fn passed(&self) -> u64 {
        self.passed + u64::from(PAUSE - self.pause)
    }

    /// Returns the number of roots. No path has more legs than that number plus one.
    pub(crate) fn root_count(&self) -> usize {
        self.roots.len()
    }

    /// Returns the number of roots on the path to a root.
    pub(crate) fn depth(&self, root: u32) -> usize {
        self.roots[root as usize].depth as usize
    }

    /// Returns the points on the path to a root, the source first, with their vertices.
    pub(crate) fn way(&self, root: u32) -> Vec<(Point, Option<VertexId>)> {
        let mut way = Vec::new();
        let mut at = Some(root);
        while let Some(root) = at.map(|at| &self.roots[at as usize]) {
            way.push((root.point, root.vertex));
            at = root.parent;
        }
        way.reverse();
        way
    }

    /// Returns the vertex of a root; `None` for a source that is not a vertex.
    pub(crate) fn root_vertex(&self, root: u32) -> Option<VertexId> {
        self.roots.get(root as usize).and_then(|root| root.vertex)
    }

    /// Returns the vertices that were reached.
    #[cfg(feature = "baselines")]
    pub(crate) fn reached(&self) -> impl Iterator<Item = VertexId> {
        let reached = self.seen.iter().filter(|(_, seen)| seen.mark.is_some());
        reached.map(|(&vertex, _)| vertex)
    }

    /// Lets the wavefront stay in a tile for longer, with a lead of at most `most`. Called when a
    /// tile has to be read again.
    pub(crate) fn lead(&mut self, most: f64) {
        self.queue.lead(most);
    }

    /// Returns the tiles that will most likely be needed after `after`, the likeliest first.
    pub(crate) fn ahead(&self, after: TileId) -> Vec<TileId> {
        let mut soon: Vec<(f64, TileId)> = self.queue.top().filter(|&(_, tile)| tile != after).collect();
        soon.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut tiles: Vec<TileId> = Vec::new();
        for (_, tile) in soon {
            if !tiles.contains(&tile) {
                tiles.push(tile);
            }
        }
        tiles
    }

    pub(super) fn push(&mut self, length: f64, tile: Option<TileId>, task: Task) {
        if length <= self.limit {
            self.queue.push(length, tile, task);
        }
    }

    pub(super) fn report(&mut self, target: Target, number: u64, length: f64, root: u32) {
        if self.reported.contains(&number) {
            return;
        }
        self.ready.push(Reverse(Ready {
            key: (length.to_bits(), number),
            value: FoundTarget { target, length, root },
        }));
    }

    pub(super) fn report_point(&mut self, goal: u32, length: f64, root: u32) {
        self.report(Target::Point(goal), goal.into(), length, root);
    }

    /// Returns whether vertices with this mark are targets.
    pub(super) fn is_reported(&self, mark: Mark) -> bool {
        match self.goal {
            Goal::Sites => mark.has_site(),
            Goal::Points(_) => false,
            Goal::Vertices => true,
        }
    }

    /// Keeps regions from now on.
    pub(crate) fn keep_regions(&mut self) {
        self.regions.get_or_insert_default();
    }

    /// Returns the triangles of the regions seen since they were last taken.
    pub(crate) fn explored(&self) -> impl Iterator<Item = [Point; 3]> {
        let regions = self.regions.iter().flatten().filter_map(VisibleRegion::triangle);
        regions.chain(self.whole.iter().flatten().map(|whole| whole.corners))
    }

    /// Takes the regions seen since they were last taken.
    pub(crate) fn take_regions(&mut self) -> Vec<VisibleRegion> {
        self.regions.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Returns the position of a root, and the length of the path to it.
    pub(crate) fn root_at(&self, root: u32) -> (Point, f64) {
        let root = &self.roots[root as usize];
        (root.point, root.length)
    }

    /// Keeps a region, if regions are kept.
    #[inline]
    pub(crate) fn keep(&mut self, root: u32, shape: RegionShape) {
        if let Some(regions) = &mut self.regions {
            regions.push(VisibleRegion { root, shape });
        }
    }
}
