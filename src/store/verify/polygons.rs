//! Checks that each polygon covers each point 0 or 1 times.
//!
//! The depths of regions are sums over all polygons, in which those of one polygon can cancel those
//! of another. So the edges of each polygon are collected from the tiles, and swept by themselves.
//! Polygons are collected together as far as the memory allows, and each part of them takes one
//! pass over the tiles that have edges of polygons. A polygon that does not fit in memory is swept
//! in strips, each of which takes a pass.
//!
//! The lines must be known: in a file without a list of its lines, several polygons may have the
//! same number.

use std::ops::Range;
use std::sync::Arc;

use futures::stream::StreamExt;

use crate::geometry::Point;
use crate::mesh::windings::sweep::{self, Outcome, Sweep};
use crate::shown;
use crate::store::error::ReadError;
use crate::store::format::edge_source::LineKind;
use crate::store::format::ids::TileId;
use crate::store::format::line_source::LineSource;
use crate::store::format::lists::Lists;
use crate::store::format::polygon_lines::{PolygonLine, polygon_of};
use crate::store::format::tile::Tile;
use crate::store::pass::{Needs, PassPlan, PassReader, list_for, spawn};
use crate::store::verify::error::VerifyError;

/// An edge of a polygon, which has this number. The interior is on its left.
type PolygonEdge = (u64, [Point; 2]);

/// Bytes of an edge while polygons are collected and swept.
const BYTES: u64 = size_of::<PolygonEdge>() as u64 + sweep::BYTES;
/// The minimum number of edges that are in memory at once.
const LEAST_EDGES: u64 = 1 << 12;
/// The number of ranges into which a range of polygons is divided at once.
const BUCKETS: u64 = 1 << 12;
/// About how many edges of a polygon determine where it is cut into strips.
const SAMPLE: u64 = 1 << 14;

/// The edges of polygons in a file.
#[derive(Default)]
pub(super) struct ObstacleEdges {
    /// The tiles that have such edges.
    tiles: Vec<TileId>,
    /// The number of edges, each counted once for each of its sources.
    count: u64,
}

impl ObstacleEdges {
    pub(super) fn add(&mut self, tile: TileId, count: u64) {
        if count > 0 {
            self.tiles.push(tile);
            self.count += count;
        }
    }
}

/// The check of the polygons of one file.
struct PolygonCheck<'a> {
    reader: &'a PassReader,
    tiles: Vec<TileId>,
    lines: Arc<Vec<PolygonLine>>,
    plan: PassPlan,
    /// The number of edges that may be in memory at once.
    at_once: u64,
}

/// The edges that a pass collects: of these polygons, as far as they meet the strip of these x.
#[derive(Clone)]
struct Wanted {
    polygons: Range<u64>,
    strip: Option<[f64; 2]>,
}

impl PassReader {
    /// Checks every polygon. `edges` was collected from all tiles.
    pub(super) async fn verify_polygons(&self, edges: ObstacleEdges) -> Result<(), VerifyError> {
        let lists = &self.directory().lists;
        let obstacles = lists.lines.iter().filter(|of| of.kind == LineKind::Obstacle);
        let first = obstacles.clone().map(|of| of.first).min();
        let end = obstacles.map(|of| of.first + of.lines).max();
        let (Some(first), Some(end), 1..) = (first, end, edges.count) else {
            return Ok(());
        };
        let needs = |edges: u64| Needs {
            fixed: edges.saturating_mul(BYTES),
            ..Needs::default()
        };
        let (plan, at_once) = self.plan_lookups(needs, LEAST_EDGES..edges.count, BYTES)?;
        let check = PolygonCheck {
            reader: self,
            tiles: edges.tiles,
            lines: Arc::new(lists.polygon_lines.clone()),
            plan,
            at_once: at_once as u64,
        };
        let mut left = vec![(first..end, edges.count)];
        while let Some((polygons, count)) = left.pop() {
            if count == 0 {
                continue;
            }
            if count <= check.at_once {
                check.sweep(Wanted { polygons, strip: None }).await?;
            } else if polygons.end - polygons.start <= 1 {
                check.sweep_in_strips(polygons, count).await?;
            } else {
                // The first polygons are checked first.
                left.extend(check.divide(polygons).await?.into_iter().rev());
            }
        }
        Ok(())
    }
}

impl PolygonCheck<'_> {
    /// Calls `compute` for each tile, and passes the results to `take`, in order.
    async fn for_each_tile<T: Send + 'static>(
        &self,
        compute: impl Fn(&Tile, &[PolygonLine]) -> T + Clone + Send + 'static,
        mut take: impl FnMut(T) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        let tiles = self.tiles.iter().map(|&tile| (tile, ())).collect();
        let lines = Arc::clone(&self.lines);
        let mut results = self
            .reader
            .for_some_tiles(tiles, self.plan, move |tile, ()| compute(&tile, &lines));
        while let Some(result) = results.next().await {
            take(result?)?;
        }
        Ok(())
    }

    /// Divides a range of polygons into ranges, each with the number of its edges. A range with more
    /// edges than fit in memory is a `BUCKETS`-th, or one polygon.
    async fn divide(&self, polygons: Range<u64>) -> Result<Vec<(Range<u64>, u64)>, ReadError> {
        let width = (polygons.end - polygons.start).div_ceil(BUCKETS);
        let (start, end) = (polygons.start, polygons.end);
        let buckets = (end - start).div_ceil(width) as usize;
        let mut counts = vec![0u64; buckets];
        let count = move |tile: &Tile, lines: &[PolygonLine]| {
            let mut counts = vec![0u32; buckets];
            for (polygon, _) in edges(tile, lines).filter(|edge| (start..end).contains(&edge.0)) {
                counts[((polygon - start) / width) as usize] += 1;
            }
            counts
        };
        let add = |of_tile: Vec<u32>| {
            for (count, more) in counts.iter_mut().zip(of_tile) {
                *count += u64::from(more);
            }
            Ok(())
        };
        self.for_each_tile(count, add).await?;
        let mut parts: Vec<(Range<u64>, u64)> = Vec::new();
        for (bucket, count) in (0..).zip(counts) {
            let first = start + bucket * width;
            let its = first..end.min(first.saturating_add(width));
            match parts.last_mut() {
                Some((range, total)) if *total + count <= self.at_once => {
                    (range.end, *total) = (its.end, *total + count);
                }
                _ => parts.push((its, count)),
            }
        }
        Ok(parts)
    }

    /// Collects edges and sweeps each of their polygons.
    async fn sweep(&self, wanted: Wanted) -> Result<(), VerifyError> {
        let mut collected: Vec<PolygonEdge> = list_for(self.at_once as usize);
        let (needs, strip) = (self.at_once, wanted.strip);
        let collect = move |tile: &Tile, lines: &[PolygonLine]| {
            let wanted = edges(tile, lines).filter(|edge| wanted.has(edge));
            wanted.collect::<Vec<PolygonEdge>>()
        };
        let take = |of_tile: Vec<PolygonEdge>| {
            collected.extend(of_tile);
            match collected.len() as u64 > needs {
                true => Err(self.reader.too_little_memory(2 * collected.len() as u64 * BYTES)),
                false => Ok(()),
            }
        };
        self.for_each_tile(collect, take).await?;
        match spawn(move || first_fault(collected, strip)).await? {
            Some((polygon, reason)) => Err(self.error(polygon, reason)),
            None => Ok(()),
        }
    }

    /// Sweeps a polygon that does not fit in memory. It has `count` edges.
    async fn sweep_in_strips(&self, polygons: Range<u64>, count: u64) -> Result<(), VerifyError> {
        let every = count.div_ceil(SAMPLE).max(1);
        let mut sample: Vec<f64> = Vec::new();
        let wanted = Wanted { polygons, strip: None };
        let its = wanted.clone();
        let choose = move |tile: &Tile, lines: &[PolygonLine]| {
            let chosen = |&(_, [Point { x, y }, _]): &PolygonEdge| {
                let bits = x.to_bits() ^ y.to_bits().rotate_left(32);
                (bits.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32).is_multiple_of(every)
            };
            let wanted = edges(tile, lines).filter(|edge| its.has(edge)).filter(chosen);
            wanted.map(|(_, [a, _])| a.x).collect::<Vec<f64>>()
        };
        let add = |of_tile: Vec<f64>| {
            sample.extend(of_tile);
            Ok(())
        };
        self.for_each_tile(choose, add).await?;
        sample.sort_unstable_by(f64::total_cmp);
        let step = (self.at_once / 4 / every).max(1) as usize;
        let mut cuts = vec![f64::NEG_INFINITY];
        cuts.extend(sample.into_iter().step_by(step).skip(1));
        cuts.push(f64::INFINITY);
        cuts.dedup();
        for strip in cuts.windows(2) {
            let strip = Some([strip[0], strip[1]]);
            let polygons = wanted.polygons.clone();
            self.sweep(Wanted { polygons, strip }).await?;
        }
        Ok(())
    }

    /// Returns the error for a polygon, which names its file and line.
    fn error(&self, polygon: u64, reason: String) -> VerifyError {
        let lists: &Lists = &self.reader.directory().lists;
        let has = |of: &&LineSource| of.first <= polygon && polygon - of.first < of.lines;
        let file = lists.lines.iter().find(has);
        VerifyError::Polygon {
            polygon,
            file: file.map_or_else(String::new, |of| shown::text(&of.name).into_owned()),
            line: polygon - file.map_or(0, |of| of.first),
            reason,
        }
    }
}

impl Wanted {
    fn has(&self, (polygon, [a, b]): &PolygonEdge) -> bool {
        let meets = |[left, right]: [f64; 2]| a.x.max(b.x) >= left && a.x.min(b.x) <= right;
        self.polygons.contains(polygon) && self.strip.is_none_or(meets)
    }
}

/// Returns the edges of polygons that belong to a tile, one for each source.
fn edges<'a>(tile: &'a Tile, lines: &'a [PolygonLine]) -> impl Iterator<Item = PolygonEdge> + 'a {
    tile.owned_constraints().flat_map(move |edge| {
        let [a, b] = tile.ends(edge).map(|end| end.point);
        tile.edge_sources(edge).filter_map(move |source| {
            let ends = match source.depth_change() {
                0 => return None,
                1.. => [a, b],
                _ => [b, a],
            };
            Some((polygon_of(lines, source.number()), ends))
        })
    })
}

/// Returns the first polygon that does not cover each point 0 or 1 times, and why.
fn first_fault(mut collected: Vec<PolygonEdge>, strip: Option<[f64; 2]>) -> Option<(u64, String)> {
    collected.sort_unstable_by_key(|edge| edge.0);
    collected.chunk_by(|one, other| one.0 == other.0).find_map(|its| {
        let outcome = Sweep::new(its.iter().map(|edge| edge.1)).run(strip, &mut |_| {});
        let reason = match outcome {
            Outcome::Open => "has a ring that does not close".to_owned(),
            Outcome::Crosses => "has edges that cross each other".to_owned(),
            Outcome::Seen { first: Some(point), .. } => format!("is inside out at ({}, {})", point.x, point.y),
            Outcome::Seen {
                overlap: Some(point), ..
            } => {
                format!("covers a part more than once at ({}, {})", point.x, point.y)
            }
            Outcome::Seen { .. } => return None,
        };
        Some((its[0].0, reason))
    })
}
