//! The searches for a line: which sites can be among the nearest on an interval, and their
//! distances.

use std::collections::BTreeMap;

use super::envelope::Arc;
use super::interval::SiteAlong;
use super::line::{LineSections, QueryLine};
use crate::geometry::Point;
use crate::query::along::line;
use crate::query::answer::distance;
use crate::query::free_space::QueryPoint;
use crate::query::request::{QueryError, QueryOptions, Tiles};
use crate::query::wavefront::{Goal, QueryPoints, RegionShape, Target, VisibleRegion, WavefrontRun};
use crate::store::{Vertex, VertexId};

/// The maximum number of times that an interval is halved.
const DEPTH: u32 = 16;
/// Where the line runs along an edge, a search starts beside it: this fraction of the way to the
/// middle of a triangle there.
const ASIDE: f64 = 1e-6;
/// A margin well above rounding errors.
const SLACK: f64 = 1.0 + 1e-9;

/// A vertex with sites that may be among the nearest, and the distance up to which that matters.
pub(crate) struct Candidate {
    pub(super) vertex: Vertex,
    pub(super) sites: Vec<(u64, Option<String>)>,
    pub(super) limit: f64,
}

pub(crate) type Candidates = BTreeMap<VertexId, Candidate>;

fn take(candidates: &mut Candidates, found: Candidate) {
    let known = candidates.entry(found.vertex.id).or_insert_with(|| Candidate {
        vertex: found.vertex,
        sites: Vec::new(),
        limit: 0.0,
    });
    known.limit = known.limit.max(found.limit);
    for site in found.sites {
        if !known.sites.contains(&site) {
            known.sites.push(site);
        }
    }
}

/// An interval of the line that nothing blocks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FreeInterval {
    pub(super) range: [f64; 2],
    /// The number of times that the interval was halved.
    depth: u32,
}

impl FreeInterval {
    pub(super) fn whole(range: [f64; 2]) -> Self {
        Self { range, depth: 0 }
    }

    fn middle(&self) -> f64 {
        self.range[0] + 0.5 * (self.range[1] - self.range[0])
    }

    pub(super) fn halves(&self) -> [Self; 2] {
        let [low, high] = self.range;
        let (middle, depth) = (self.middle(), self.depth + 1);
        [[low, middle], [middle, high]].map(|range| Self { range, depth })
    }
}

/// The searches for a line, which run one after the other.
pub(crate) struct LineSearch {
    tiles: Option<Tiles>,
    options: QueryOptions,
    pub(super) line: QueryLine,
    pub(super) k: usize,
}

impl LineSearch {
    pub(super) fn new(tiles: Tiles, options: QueryOptions, line: QueryLine, k: usize) -> Self {
        Self {
            tiles: Some(tiles),
            options,
            line,
            k,
        }
    }

    /// Determines the sections of the line.
    pub(super) async fn pass(&mut self) -> Result<LineSections, QueryError> {
        let mut tiles = self.tiles()?;
        let sections = self.line.pass(&mut tiles).await?;
        self.tiles = Some(tiles);
        Ok(sections)
    }

    fn tiles(&mut self) -> Result<Tiles, QueryError> {
        self.tiles.take().ok_or_else(|| QueryError::Uncertified {
            reason: "a search is already running".to_owned(),
        })
    }

    /// Starts a wavefront at a free point.
    async fn run(&mut self, source: QueryPoint, goal: Goal, limit: f64) -> Result<WavefrontRun, QueryError> {
        let mut tiles = self.tiles()?;
        tiles.get(source.tile()).await?;
        WavefrontRun::start(tiles, source, goal, limit, self.options.clone()).await
    }

    /// Returns the free points from which to search for what is near position `t`: one for each
    /// side of the line if it runs along an edge.
    async fn anchors(&mut self, sections: &LineSections, t: f64) -> Result<Vec<QueryPoint>, QueryError> {
        let mut tiles = self.tiles()?;
        let at = self.line.at(t);
        let here = sections
            .free
            .iter()
            .filter(|section| section.range[0] <= t && t <= section.range[1]);
        let mut aside: Vec<Point> = here.clone().filter_map(|section| section.beside).collect();
        let mut anchors = Vec::new();
        if aside.is_empty() {
            let query_point = QueryPoint::find(&mut tiles, at).await?;
            if query_point.is_free {
                anchors.push(query_point);
            } else {
                // Rounding moved the point into an obstacle.
                aside.extend(
                    here.filter_map(|section| section.triangle)
                        .map(|corners| line::middle(&corners)),
                );
            }
        }
        for inside in aside {
            let near = Point::new(at.x + ASIDE * (inside.x - at.x), at.y + ASIDE * (inside.y - at.y));
            let mut query_point = QueryPoint::find(&mut tiles, near).await?;
            if !query_point.is_free {
                query_point = QueryPoint::find(&mut tiles, inside).await?;
            }
            if query_point.is_free {
                anchors.push(query_point);
            }
        }
        if anchors.is_empty() {
            // The point is outside the hull, and rounding moved it across the boundary of the free
            // space.
            let query_point = QueryPoint::find(&mut tiles, at).await?;
            if let Some(free) = query_point.nearest_free(&mut tiles).await? {
                anchors
                    .extend(Some(QueryPoint::find(&mut tiles, free).await?).filter(|query_point| query_point.is_free));
            }
        }
        self.tiles = Some(tiles);
        if anchors.is_empty() {
            let reason = format!(
                "the line is free at ({}, {}), but no free point was found there",
                at.x, at.y
            );
            return Err(QueryError::Uncertified { reason });
        }
        Ok(anchors)
    }

    /// Finds the sites that can be among the nearest somewhere on an interval. Returns `false` if
    /// the interval must be halved first.
    pub(super) async fn find_candidates(
        &mut self,
        sections: &LineSections,
        interval: &FreeInterval,
        into: &mut Candidates,
    ) -> Result<bool, QueryError> {
        let [low, high] = interval.range;
        let middle = interval.middle();
        let half = 0.5 * (high - low) * self.line.length();
        let can_halve = interval.depth < DEPTH && low < middle && middle < high;
        let mut found = Vec::new();
        for anchor in self.anchors(sections, middle).await? {
            // Every point of the interval is within this distance of the anchor.
            let reach = (half + distance(anchor.point, self.line.at(middle))) * SLACK;
            if !self.near(anchor, reach, can_halve, &mut found).await? {
                return Ok(false);
            }
        }
        found.into_iter().for_each(|found| take(into, found));
        Ok(true)
    }

    /// Finds the sites that can be among the nearest within `reach` of an anchor. Returns `false`
    /// if there are too many.
    async fn near(
        &mut self,
        anchor: QueryPoint,
        reach: f64,
        can_halve: bool,
        found: &mut Vec<Candidate>,
    ) -> Result<bool, QueryError> {
        let most = 2 * self.k + 16;
        let mut run = self.run(anchor, Goal::Sites, f64::INFINITY).await?;
        let mut far = f64::INFINITY;
        let mut sites = Vec::new();
        while let Some(next) = run.next().await? {
            let Target::Site { number, id, vertex } = next.target else {
                continue;
            };
            if next.length > (far + 2.0 * reach) * SLACK {
                break;
            }
            sites.push((number, id, vertex, next.length));
            if sites.len() == self.k {
                far = next.length;
            }
            if can_halve && sites.len() > most && 4.0 * reach > far {
                break;
            }
        }
        self.tiles = Some(run.tiles);
        if can_halve && sites.len() > most && 4.0 * reach > far {
            return Ok(false);
        }
        found.extend(sites.into_iter().map(|(number, id, vertex, length)| Candidate {
            vertex,
            sites: vec![(number, id)],
            limit: (far.min(length) + reach) * SLACK,
        }));
        Ok(true)
    }

    /// Returns the arcs of a candidate; `site` is the index of its first site.
    pub(super) async fn arcs(
        &mut self,
        sections: &LineSections,
        vertex: Vertex,
        limit: f64,
        site: usize,
    ) -> Result<Vec<Arc>, QueryError> {
        let goal = Goal::Points(QueryPoints::new([]));
        let mut run = self.run(QueryPoint::at(vertex), goal, limit).await?;
        run.keep_regions();
        let mut arcs = Vec::new();
        while let Some(regions) = run.next_regions().await? {
            for region in regions {
                let (at, length) = run.root_at(region.root);
                for range in ranges(self.line, sections, region, at) {
                    arcs.push(Arc {
                        site,
                        root: region.root,
                        range,
                        at,
                        length,
                    });
                }
            }
        }
        self.tiles = Some(run.tiles);
        Ok(arcs)
    }

    /// Returns the nearest sites of a line that is a single free point.
    pub(super) async fn at_a_point(&mut self, at: QueryPoint) -> Result<Vec<SiteAlong>, QueryError> {
        let mut sites = Vec::new();
        let mut run = self.run(at, Goal::Sites, f64::INFINITY).await?;
        while sites.len() < self.k
            && let Some(found) = run.next().await?
        {
            if let Target::Site { number, id, vertex } = found.target {
                sites.push(SiteAlong {
                    number,
                    id,
                    vertex,
                    distances: [found.length; 2],
                });
            }
        }
        Ok(sites)
    }
}

/// Returns the ranges of the line in a region that a root sees.
fn ranges(line: QueryLine, sections: &LineSections, region: VisibleRegion, root: Point) -> Vec<[f64; 2]> {
    let between = |range: [f64; 2], [right, left]: [Point; 2]| {
        let range = line.clip(range, root, right, true)?;
        line.clip(range, root, left, false)
    };
    match region.shape {
        RegionShape::Triangle { corners, between: rays } => {
            let range = sections.range_of(corners);
            let seen = range.and_then(|range| match rays {
                None => Some(range),
                Some(rays) => between(range, rays),
            });
            seen.into_iter().collect()
        }
        RegionShape::BehindHullEdge {
            edge: [right, left],
            between: rays,
        } => {
            let seen = |range| between(line.clip(range, right, left, false)?, rays);
            sections.outside().filter_map(seen).collect()
        }
        RegionShape::HalfPlane { half_plane, except } => {
            let seen = |range| {
                let range = line.clip(range, root, half_plane.towards, half_plane.is_left)?;
                match except {
                    None => Some(range),
                    Some(except) => line.clip(range, root, except.towards, !except.is_left),
                }
            };
            sections.outside().filter_map(seen).collect()
        }
    }
}
