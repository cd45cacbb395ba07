//! The nearest sites along a straight line: for someone on the move, or for all places of a street at once.
//!
//! Comes in: a line and a number. Goes out: its intervals, each with its nearest sites in order. Continuous nearest neighbours among
//! obstacles are a query of Gao and Zheng ("Continuous obstructed nearest neighbor queries in spatial databases", SIGMOD 2009),
//! who compute them on local visibility graphs. However:
//!
//! 1. The line is cut into stretches that nothing blocks. Along one of length *l*, each walking distance changes by *l* at most, so the
//!    sites within the k-th distance from its middle, and *l* more, are all that can count. Long stretches are halved.
//! 2. From each of these sites a wave goes out, as far as it can matter. It tells which parts of the line are seen from which root
//!    ([`wave::parts`](super::wave)), so the site's distance is known, exactly, as a function of the place on the line.
//! 3. Where the order of these functions changes ([`envelope`]), an interval ends.

mod envelope;
mod line;

use std::collections::BTreeMap;

use super::place::Place;
use super::proximity::Run;
use super::tiles::Tiles;
use super::wave::{Goal, Part, Places, Shape, What, distance};
use super::{QueryError, QueryOptions, representable};
use crate::geometry::Point;
use crate::store::{TileReader, Vertex, VertexId};
use envelope::{Arc, Span};
use line::{Line, Passed};

/// A stretch is not halved any more after so many times.
const DEPTH: u32 = 16;
/// How far from the line, on the way to the middle of a triangle beside it, a search starts where the line itself runs along an edge.
const ASIDE: f64 = 1e-6;
/// A margin for rounding, far above it.
const SLACK: f64 = 1.0 + 1e-9;

/// A part of a straight line on which the nearest sites, and their order, stay the same.
#[derive(Clone, Debug, PartialEq)]
pub struct AlongInterval {
    /// Where it starts: 0 at the start of the line, 1 at its end.
    pub from_t: f64,
    /// Where it ends.
    pub to_t: f64,
    /// The point where it starts, rounded.
    pub from: Point,
    /// The point where it ends, rounded.
    pub to: Point,
    /// The nearest sites, the nearest first; fewer than were asked for if no more can be reached. None: it lies in an obstacle.
    pub sites: Option<Vec<SiteAlong>>,
}

/// A site that is among the nearest on an interval.
#[derive(Clone, Debug, PartialEq)]
pub struct SiteAlong {
    /// Its number, from 0 over all inputs.
    pub number: u64,
    /// Its id, if the input gave it one.
    pub id: Option<String>,
    /// The vertex at which it lies.
    pub vertex: Vertex,
    /// How far it is from the start of the interval and from its end, within a part in 10^12.
    pub distances: [f64; 2],
}

/// A vertex with sites that may count, and how far from it that matters.
struct Candidate {
    vertex: Vertex,
    sites: Vec<(u64, Option<String>)>,
    limit: f64,
}

type Candidates = BTreeMap<VertexId, Candidate>;

struct Search {
    tiles: Option<Tiles>,
    options: QueryOptions,
    line: Line,
    k: usize,
    candidates: Candidates,
}

impl Search {
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

    /// Finds the sites that can be among the nearest somewhere on a stretch.
    async fn find_candidates(&mut self, passed: &Passed, stretch: [f64; 2]) -> Result<(), QueryError> {
        let mut open = vec![(stretch, 0)];
        while let Some(([low, high], depth)) = open.pop() {
            let middle = low + 0.5 * (high - low);
            let half = 0.5 * (high - low) * self.line.length();
            let anchors = self.anchors(passed, middle).await?;
            let can_halve = depth < DEPTH && low < middle && middle < high;
            let mut found = Vec::new();
            let mut is_enough = true;
            for anchor in anchors {
                // All of the stretch is within this of the anchor.
                let reach = (half + distance(anchor.point, self.line.at(middle))) * SLACK;
                is_enough &= self.near(anchor, reach, can_halve, &mut found).await?;
                if !is_enough {
                    break;
                }
            }
            if is_enough {
                found.into_iter().for_each(|found| self.take(found));
            } else {
                open.push(([middle, high], depth + 1));
                open.push(([low, middle], depth + 1));
            }
        }
        Ok(())
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

    fn take(&mut self, found: Candidate) {
        let known = self.candidates.entry(found.vertex.id).or_insert_with(|| Candidate {
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

    /// The arcs of a candidate, named by the place of its first site.
    async fn arcs(&mut self, passed: &Passed, vertex: Vertex, limit: f64, site: usize) -> Result<Vec<Arc>, QueryError> {
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

impl TileReader {
    /// The `k` nearest sites by walking distance from each point of a straight line, as intervals of the line on which they,
    /// and their order, stay the same. The intervals come in order and cover the line; those in obstacles have no list.
    ///
    /// Within an interval the order is that of the distances; sites whose distances agree within a part in 10^12 come by their
    /// numbers. Where an interval ends, two distances are equal to within a part in 10^9, or something blocks the way along the line.
    /// A line of one point is one interval.
    ///
    /// # Errors
    /// As [`shortest_path`](Self::shortest_path); the options' limits hold for all searches together.
    pub async fn nearest_along(
        &self,
        from: Point,
        to: Point,
        k: usize,
        options: QueryOptions,
    ) -> Result<Vec<AlongInterval>, QueryError> {
        let found = along(self, from, to, k, options).await;
        // What was not found can be anywhere.
        found.map_err(|error| error.at_least(0.0))
    }
}

async fn along(
    reader: &TileReader,
    from: Point,
    to: Point,
    k: usize,
    options: QueryOptions,
) -> Result<Vec<AlongInterval>, QueryError> {
    let [from, to] = [from, to].map(|p| Point::new(representable(p.x), representable(p.y)).normalized());
    let mut tiles = Tiles::new(reader, &options);
    // Also tells whether they are points, and whether there are triangles.
    let start = Place::find(&mut tiles, from).await?;
    Place::find(&mut tiles, to).await?;
    let line = Line { from, to };
    let mut search = Search {
        tiles: None,
        options,
        line,
        k,
        candidates: Candidates::new(),
    };
    if from == to {
        search.tiles = Some(tiles);
        return Ok(vec![search.at_a_point(start).await?]);
    }
    let passed = line.pass(&mut tiles).await?;
    search.tiles = Some(tiles);
    if k > 0 {
        for stretch in passed.stretches() {
            search.find_candidates(&passed, stretch).await?;
        }
    }
    let candidates = std::mem::take(&mut search.candidates);
    let (mut sites, mut arcs) = (Vec::new(), Vec::new());
    for candidate in candidates.into_values() {
        let own = search
            .arcs(&passed, candidate.vertex, candidate.limit, sites.len())
            .await?;
        for (number, id) in candidate.sites {
            let site = sites.len();
            arcs.extend(own.iter().map(|&arc| Arc { site, ..arc }));
            sites.push((number, id, candidate.vertex));
        }
    }
    let arcs = envelope::joined(arcs);
    let order: Vec<u64> = sites.iter().map(|&(number, ..)| number).collect();
    let mut intervals = Vec::new();
    let mut end = 0.0;
    let blocked = |range: [f64; 2]| interval(line, range, None);
    for run in passed.runs() {
        if end < run[0] {
            intervals.push(blocked([end, run[0]]));
        }
        end = run[1];
        let spans = envelope::nearest(line, run, &arcs, k, &order);
        intervals.extend(spans.into_iter().map(|Span { range, sites: near }| {
            let near = near.into_iter().map(|(site, distances)| {
                let (number, id, vertex) = sites[site].clone();
                SiteAlong {
                    number,
                    id,
                    vertex,
                    distances,
                }
            });
            interval(line, range, Some(near.collect()))
        }));
    }
    if end < 1.0 {
        intervals.push(blocked([end, 1.0]));
    }
    Ok(intervals)
}

fn interval(line: Line, [from_t, to_t]: [f64; 2], sites: Option<Vec<SiteAlong>>) -> AlongInterval {
    AlongInterval {
        from_t,
        to_t,
        from: line.at(from_t),
        to: line.at(to_t),
        sites,
    }
}

impl Search {
    /// The only interval of a line that is a point.
    async fn at_a_point(&mut self, at: Place) -> Result<AlongInterval, QueryError> {
        let is_free = at.is_free;
        let mut sites = Vec::new();
        if is_free {
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
        }
        Ok(interval(self.line, [0.0, 1.0], is_free.then_some(sites)))
    }
}
