//! The searches for a line: which sites can count on a stretch, and how far they are from where.

use std::collections::BTreeMap;

use super::envelope::Arc;
use super::interval::SiteAlong;
use super::line::{Line, Passed};
use crate::geometry::Point;
use crate::query::along::line;
use crate::query::answer::distance;
use crate::query::free_space::Place;
use crate::query::request::{QueryError, QueryOptions, Tiles};
use crate::query::wavefront::{Goal, Part, Places, Run, Shape, What};
use crate::store::{Vertex, VertexId};

/// A stretch is not halved any more after so many times.
const DEPTH: u32 = 16;
/// How far from the line, on the way to the middle of a triangle beside it, a search starts where the line itself runs along an edge.
const ASIDE: f64 = 1e-6;
/// A margin for rounding, far above it.
const SLACK: f64 = 1.0 + 1e-9;

/// A vertex with sites that may count, and how far from it that matters.
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

/// A part of the line that nothing blocks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch {
    pub(super) range: [f64; 2],
    /// How often it was halved.
    depth: u32,
}

impl Stretch {
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

/// The searches for a line, one after the other.
pub(crate) struct Search {
    tiles: Option<Tiles>,
    options: QueryOptions,
    pub(super) line: Line,
    pub(super) k: usize,
}

impl Search {
    pub(super) fn new(tiles: Tiles, options: QueryOptions, line: Line, k: usize) -> Self {
        Self {
            tiles: Some(tiles),
            options,
            line,
            k,
        }
    }

    /// What the line passes.
    pub(super) async fn pass(&mut self) -> Result<Passed, QueryError> {
        let mut tiles = self.tiles()?;
        let passed = self.line.pass(&mut tiles).await?;
        self.tiles = Some(tiles);
        Ok(passed)
    }

    fn tiles(&mut self) -> Result<Tiles, QueryError> {
        self.tiles.take().ok_or_else(|| QueryError::Uncertified {
            reason: "a search is under way already".to_owned(),
        })
    }

    /// Starts a search at a free place.
    async fn run(&mut self, source: Place, goal: Goal, limit: f64) -> Result<Run, QueryError> {
        let mut tiles = self.tiles()?;
        tiles.get(source.tile()).await?;
        Run::start(tiles, source, goal, limit, self.options.clone()).await
    }

    /// Where to search from for what is near a place on a stretch: points that are free, one for each side of the line if that
    /// runs along an edge.
    async fn anchors(&mut self, passed: &Passed, t: f64) -> Result<Vec<Place>, QueryError> {
        let mut tiles = self.tiles()?;
        let at = self.line.at(t);
        let here = passed
            .free
            .iter()
            .filter(|piece| piece.range[0] <= t && t <= piece.range[1]);
        let mut aside: Vec<Point> = here.clone().filter_map(|piece| piece.beside).collect();
        let mut anchors = Vec::new();
        if aside.is_empty() {
            let place = Place::find(&mut tiles, at).await?;
            if place.is_free {
                anchors.push(place);
            } else {
                // Rounded into an obstacle.
                aside.extend(
                    here.filter_map(|piece| piece.triangle)
                        .map(|corners| line::middle(&corners)),
                );
            }
        }
        for inside in aside {
            let near = Point::new(at.x + ASIDE * (inside.x - at.x), at.y + ASIDE * (inside.y - at.y));
            let mut place = Place::find(&mut tiles, near).await?;
            if !place.is_free {
                place = Place::find(&mut tiles, inside).await?;
            }
            if place.is_free {
                anchors.push(place);
            }
        }
        if anchors.is_empty() {
            // Outside, and rounded into what is free only up to its border.
            let place = Place::find(&mut tiles, at).await?;
            if let Some(free) = place.nearest_free(&mut tiles).await? {
                anchors.extend(Some(Place::find(&mut tiles, free).await?).filter(|place| place.is_free));
            }
        }
        self.tiles = Some(tiles);
        if anchors.is_empty() {
            let reason = format!(
                "the line is free at ({}, {}), but no point there can be found",
                at.x, at.y
            );
            return Err(QueryError::Uncertified { reason });
        }
        Ok(anchors)
    }

    /// Finds the sites that can be among the nearest somewhere on a stretch. False: it is to be halved first.
    pub(super) async fn find_candidates(
        &mut self,
        passed: &Passed,
        stretch: &Stretch,
        into: &mut Candidates,
    ) -> Result<bool, QueryError> {
        let [low, high] = stretch.range;
        let middle = stretch.middle();
        let half = 0.5 * (high - low) * self.line.length();
        let can_halve = stretch.depth < DEPTH && low < middle && middle < high;
        let mut found = Vec::new();
        for anchor in self.anchors(passed, middle).await? {
            // All of the stretch is within this of the anchor.
            let reach = (half + distance(anchor.point, self.line.at(middle))) * SLACK;
            if !self.near(anchor, reach, can_halve, &mut found).await? {
                return Ok(false);
            }
        }
        found.into_iter().for_each(|found| take(into, found));
        Ok(true)
    }

    /// The sites that can be among the nearest within `reach` of an anchor. False: too many.
    async fn near(
        &mut self,
        anchor: Place,
        reach: f64,
        can_halve: bool,
        found: &mut Vec<Candidate>,
    ) -> Result<bool, QueryError> {
        let most = 2 * self.k + 16;
        let mut run = self.run(anchor, Goal::Sites, f64::INFINITY).await?;
        let mut far = f64::INFINITY;
        let mut sites = Vec::new();
        while let Some(next) = run.next().await? {
            let What::Site { number, id, vertex } = next.what else {
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

    /// The arcs of a candidate, named by the place of its first site.
    pub(super) async fn arcs(
        &mut self,
        passed: &Passed,
        vertex: Vertex,
        limit: f64,
        site: usize,
    ) -> Result<Vec<Arc>, QueryError> {
        let goal = Goal::Places(Places::new([]));
        let mut run = self.run(Place::at(vertex), goal, limit).await?;
        run.keep_parts();
        let mut arcs = Vec::new();
        while let Some(parts) = run.next_parts().await? {
            for part in parts {
                let (at, length) = run.root_at(part.root);
                for range in ranges(self.line, passed, part, at) {
                    arcs.push(Arc {
                        site,
                        root: part.root,
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

    /// The nearest sites of a line that is a free point.
    pub(super) async fn at_a_point(&mut self, at: Place) -> Result<Vec<SiteAlong>, QueryError> {
        let mut sites = Vec::new();
        let mut run = self.run(at, Goal::Sites, f64::INFINITY).await?;
        while sites.len() < self.k
            && let Some(found) = run.next().await?
        {
            if let What::Site { number, id, vertex } = found.what {
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

/// The ranges of the line in a part that is seen from a root.
fn ranges(line: Line, passed: &Passed, part: Part, root: Point) -> Vec<[f64; 2]> {
    let between = |range: [f64; 2], [right, left]: [Point; 2]| {
        let range = line.clip(range, root, right, true)?;
        line.clip(range, root, left, false)
    };
    match part.shape {
        Shape::Triangle { corners, between: rays } => {
            let range = passed.range_of(corners);
            let seen = range.and_then(|range| match rays {
                None => Some(range),
                Some(rays) => between(range, rays),
            });
            seen.into_iter().collect()
        }
        Shape::Beyond {
            edge: [right, left],
            between: rays,
        } => {
            let seen = |range| between(line.clip(range, right, left, false)?, rays);
            passed.outside().filter_map(seen).collect()
        }
        Shape::Half { side, except } => {
            let seen = |range| {
                let range = line.clip(range, root, side.towards, side.is_left)?;
                match except {
                    None => Some(range),
                    Some(except) => line.clip(range, root, except.towards, !except.is_left),
                }
            };
            passed.outside().filter_map(seen).collect()
        }
    }
}
