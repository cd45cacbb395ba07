//! The contours in a tile: where the planes of its triangles have the height of a level.
//!
//! In: a tile and some levels. Out: chains of points. A vertex whose z is the level's counts as above
//! it, so a triangle that a level crosses has exactly two crossed edges, and the contour leads from one
//! to the other, with the higher ground on its left. Chains are joined by the edges that they cross, and
//! never by coordinates, so flat ground and saddles need no rules of their own.
//!
//! ```text
//!          above
//!         /     \          start: the half-edge that leads down
//!   start ───────▶ end     end:   the half-edge that leads up,
//!       /         \               whose twin is a start
//!    below ───── below
//! ```
//!
//! Each triangle is traced by the tile that owns it. A chain that leaves these triangles ends at a
//! [`Junction`], where the chain of another tile continues it.

use std::ops::Range;
use std::sync::Arc;

use super::chain;
use super::clip::Clip;
use super::facet::{Corner, point_on_edge};
use super::levels::{Levels, LevelsError};
use super::surface::{Surface, TileSurface};
use crate::geometry::{HalfEdge, Point, Rect, TriangleId};
use crate::mesh::{Topology, Twin};
use crate::store::{Tile, VertexId};

/// Which contours are wanted.
///
/// The [example of `export_contours`](crate::export::export_contours) uses it.
#[derive(Clone, Debug)]
pub struct ContourOptions {
    levels: Levels,
    surface: Surface,
    clip: Option<Arc<Clip>>,
}

impl ContourOptions {
    /// Creates the options of contours at these levels.
    #[must_use]
    pub fn new(levels: Levels) -> Self {
        Self {
            levels,
            surface: Surface::default(),
            clip: None,
        }
    }

    /// Sets the triangles that count; by default those that are in no hole. Contours end where other
    /// triangles begin.
    #[must_use]
    pub fn surface(mut self, surface: Surface) -> Self {
        self.surface = surface;
        self
    }

    /// Cuts contours where they leave polygons. A contour along the boundary is inside.
    #[must_use]
    pub fn clip(mut self, clip: Option<Arc<Clip>>) -> Self {
        self.clip = clip;
        self
    }

    /// Returns the levels, the triangles that count, and the polygons in which the contours are.
    pub(crate) fn parts(self) -> (Levels, Surface, Option<Arc<Clip>>) {
        (self.levels, self.surface, self.clip)
    }
}

/// The triangles of a tile through which contours are traced.
pub(crate) struct Traced {
    surface: TileSurface,
    clip: Option<Arc<Clip>>,
}

impl Traced {
    pub(crate) fn new(surface: TileSurface, clip: Option<Arc<Clip>>) -> Self {
        Self { surface, clip }
    }

    /// Returns the polygons in which the contours are.
    pub(crate) fn clip(&self) -> Option<&Clip> {
        self.clip.as_deref()
    }

    /// Returns whether contours are traced through a triangle of the tile. This depends on the triangle and
    /// not on the tile, so that neighbours agree. What is left out is not in the polygons, so the contours
    /// in them are the same as without it.
    fn has(&self, tile: &Tile, triangle: TriangleId) -> bool {
        let reaches = |clip: &Arc<Clip>| clip.reaches(Rect::around(tile.triangle_points(triangle)));
        self.surface.has(tile, triangle) && self.clip.as_ref().is_none_or(reaches)
    }
}

/// Where two chains of a level meet: on an edge, named by its ends, the smaller one first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Junction {
    pub(crate) ends: [VertexId; 2],
    pub(crate) level: i64,
}

/// The ends of a chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ends {
    /// It has none.
    Closed,
    /// Its start and its end: a junction, or `None` at the border of the surface.
    Open([Option<Junction>; 2]),
}

/// A chain in a tile.
#[derive(Clone, Debug)]
pub(crate) struct TileChain {
    pub(crate) level: i64,
    /// The indices of its points in those of all chains.
    pub(crate) points: Range<usize>,
    pub(crate) ends: Ends,
}

/// Chains in a tile, with their points.
#[derive(Debug, Default)]
pub(crate) struct TileChains {
    pub(crate) points: Vec<Point>,
    pub(crate) chains: Vec<TileChain>,
}

/// The twin of a half-edge of a tile is not its counterpart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("half-edge {0} is not the twin of its twin")]
pub(crate) struct BadTwin(u32);

/// Returns the levels that cross the triangles of a tile, in ranges of about as many crossings as the
/// tile has triangles, or of one level.
pub(crate) fn level_ranges(tile: &Tile, traced: &Traced, levels: &Levels) -> Result<Vec<Range<i64>>, LevelsError> {
    let mut heights: Option<[f64; 2]> = None;
    let counting = || {
        let counting = tile.owned_triangles().filter(|&t| traced.has(tile, t));
        counting.map(|triangle| extremes(tile, triangle))
    };
    for [low, high] in counting() {
        let [least, greatest] = heights.unwrap_or([low, high]);
        heights = Some([least.min(low), greatest.max(high)]);
    }
    let Some([least, greatest]) = heights else {
        return Ok(Vec::new());
    };
    levels.check(least, greatest)?;
    let all = levels.between(least, greatest);
    levels.check_count(&all)?;
    // How many more triangles each level crosses than the one before.
    let mut changes = vec![0i64; (all.end - all.start) as usize + 1];
    for [low, high] in counting() {
        let crossing = levels.between(low, high);
        changes[(crossing.start - all.start) as usize] += 1;
        changes[(crossing.end - all.start) as usize] -= 1;
    }
    let most = i64::from(tile.triangle_count());
    let mut ranges = Vec::new();
    let (mut start, mut crossed, mut crossings) = (all.start, 0, 0);
    for (level, change) in all.clone().zip(changes) {
        crossed += change;
        if level > start && crossings + crossed > most {
            ranges.push(start..level);
            (start, crossings) = (level, 0);
        }
        crossings += crossed;
    }
    ranges.push(start..all.end);
    ranges.retain(|range| !range.is_empty());
    Ok(ranges)
}

/// Returns the chains of some levels in a tile.
pub(crate) fn trace(tile: &Tile, traced: &Traced, levels: &Levels, within: Range<i64>) -> Result<TileChains, BadTwin> {
    let mut tracer = Tracer::new(tile, traced, levels, within);
    // What is left after all open chains are closed ones.
    for open in [true, false] {
        for triangle in tile.triangle_ids() {
            if tracer.firsts[triangle.index()].is_none() {
                continue;
            }
            for level in tracer.crossing(triangle) {
                tracer.trace_from(triangle, level, open)?;
            }
        }
    }
    Ok(tracer.found)
}

/// Returns the least and the greatest z of a triangle.
fn extremes(tile: &Tile, triangle: TriangleId) -> [f64; 2] {
    let [a, b, c] = tile.corners(triangle).map(|corner| tile.z(corner).unwrap_or(0.0));
    [a.min(b).min(c), a.max(b).max(c)]
}

/// What continues a chain beyond an edge.
enum Beyond {
    /// The triangle of this half-edge, which this tile traces.
    Traced(HalfEdge),
    /// A triangle of another tile, or nothing.
    Junction,
    /// Nothing.
    Border,
}

struct Tracer<'t> {
    tile: &'t Tile,
    traced: &'t Traced,
    levels: &'t Levels,
    within: Range<i64>,
    /// For each triangle that the tile traces the number of its first crossing. There is a number for
    /// each level of `within` that crosses the triangle, in order.
    firsts: Vec<Option<Number>>,
    /// Whether a crossing is in a chain.
    is_traced: Vec<bool>,
    found: TileChains,
}

/// A number from 0, in four bytes even in an option.
type Number = std::num::NonZeroU32;

impl<'t> Tracer<'t> {
    fn new(tile: &'t Tile, traced: &'t Traced, levels: &'t Levels, within: Range<i64>) -> Self {
        let mut tracer = Self {
            tile,
            traced,
            levels,
            within,
            firsts: vec![None; tile.triangle_count() as usize],
            is_traced: Vec::new(),
            found: TileChains::default(),
        };
        let mut next = Number::MIN;
        for triangle in tile.owned_triangles().filter(|&t| traced.has(tile, t)) {
            tracer.firsts[triangle.index()] = Some(next);
            next = next.saturating_add(tracer.crossing(triangle).count() as u32);
        }
        tracer.is_traced = vec![false; next.get() as usize];
        tracer
    }

    /// Returns the levels that cross a triangle.
    fn crossing(&self, triangle: TriangleId) -> Range<i64> {
        let [low, high] = extremes(self.tile, triangle);
        let Range { start, end } = self.levels.between(low, high);
        let start = start.max(self.within.start);
        start..end.min(self.within.end).max(start)
    }

    fn z(&self, half_edge: HalfEdge) -> f64 {
        self.tile.z(self.tile.origin(half_edge)).unwrap_or(0.0)
    }

    /// Returns the half-edge of a triangle at which the contour of a level enters it, or leaves it.
    fn crossed(&self, triangle: TriangleId, height: f64, enters: bool) -> HalfEdge {
        let is_crossed = |half_edge: &HalfEdge| {
            let [from, to] = [*half_edge, half_edge.next()].map(|end| self.z(end) >= height);
            (from, to) == (enters, !enters)
        };
        let half_edges = HalfEdge::of_triangle(triangle);
        let found = half_edges.into_iter().find(is_crossed);
        found.expect("a level crosses two edges of a triangle")
    }

    fn beyond(&self, half_edge: HalfEdge) -> Result<Beyond, BadTwin> {
        let twin = match self.tile.twin(half_edge) {
            Twin::HalfEdge(twin) => twin,
            Twin::Elsewhere => return Ok(Beyond::Junction),
            Twin::Hull => return Ok(Beyond::Border),
        };
        let triangle = twin.triangle();
        if self.firsts[triangle.index()].is_some() {
            // Otherwise chains could run into each other, and never end.
            let is_counterpart = self.tile.twin(twin) == Twin::HalfEdge(half_edge)
                && self.tile.origin(twin) == self.tile.destination(half_edge)
                && self.tile.origin(half_edge) == self.tile.destination(twin);
            return match is_counterpart {
                true => Ok(Beyond::Traced(twin)),
                false => Err(BadTwin(half_edge.0)),
            };
        }
        let is_of_other = !self.tile.owns(triangle) && self.traced.has(self.tile, triangle);
        Ok(if is_of_other { Beyond::Junction } else { Beyond::Border })
    }

    fn junction(&self, half_edge: HalfEdge, level: i64) -> Junction {
        let mut ends = self.tile.ends(half_edge).map(|end| end.id);
        ends.sort_unstable();
        Junction { ends, level }
    }

    fn point(&self, half_edge: HalfEdge, height: f64) -> Point {
        let ends = [half_edge, half_edge.next()].map(|end| Corner {
            point: self.tile.point(self.tile.origin(end)),
            z: self.z(end),
        });
        point_on_edge(ends, height)
    }

    /// Marks a crossing as traced. Returns whether it was not.
    fn mark(&mut self, triangle: TriangleId, level: i64) -> bool {
        let first = self.firsts[triangle.index()].map_or(0, |first| first.get() as usize - 1);
        let crossing = first + (level - self.crossing(triangle).start) as usize;
        !std::mem::replace(&mut self.is_traced[crossing], true)
    }

    /// Traces the chain of a level that starts in a triangle, if it is `open`; or that passes through
    /// it, if all open ones are traced.
    fn trace_from(&mut self, triangle: TriangleId, level: i64, open: bool) -> Result<(), BadTwin> {
        let height = self.levels.height(level);
        let entry = self.crossed(triangle, height, true);
        let start = match self.beyond(entry)? {
            Beyond::Traced(_) if open => return Ok(()),
            Beyond::Traced(_) | Beyond::Border => None,
            Beyond::Junction => Some(self.junction(entry, level)),
        };
        let first = self.found.points.len();
        let mut points = Vec::new();
        let mut at = triangle;
        let mut ends = Ends::Closed;
        while self.mark(at, level) {
            if points.is_empty() {
                points.push(self.point(entry, height));
            }
            let exit = self.crossed(at, height, false);
            chain::push(&mut points, self.point(exit, height));
            match self.beyond(exit)? {
                Beyond::Traced(next) => at = next.triangle(),
                Beyond::Junction => ends = Ends::Open([start, Some(self.junction(exit, level))]),
                Beyond::Border => ends = Ends::Open([start, None]),
            }
            if ends != Ends::Closed {
                break;
            }
        }
        let is_complete = matches!(ends, Ends::Closed | Ends::Open([None, None]));
        if points.is_empty() || is_complete && !chain::complete(&mut points, ends == Ends::Closed) {
            return Ok(());
        }
        self.found.points.append(&mut points);
        self.found.chains.push(TileChain {
            level,
            points: first..self.found.points.len(),
            ends,
        });
        Ok(())
    }
}
