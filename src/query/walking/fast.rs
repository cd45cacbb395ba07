//! Answers with bounds: fast ones, and those that are within a part of the truth.
//!
//! In: free places, and what the options ask for. Out: a short way along edges ([`edges`](crate::query::edges)), pulled taut
//! ([`taut`](crate::query::funnel)). Its length is not less than the true one. The true one is not less than the straight line, nor than a shortest way
//! along edges divided by [`STRETCH`], unless break lines make that bound void or the file does not say whether it has any.
//!
//! Where an answer is to be within a part of the truth and these bounds are not close enough, the wave is sent to the goal, not farther than
//! the fast way leads, until it arrives or its front has come close enough to that length.

use std::collections::VecDeque;

use futures::future::Either;
use futures::stream::Stream;

use crate::geometry::Point;
use crate::query::answer::{Distance, Path, PathOutcome, SiteFound, WayPoint, distance};
use crate::query::edges::{BreakLines, EdgeRun, Node, STRETCH, SitesAlongEdges};
use crate::query::free_space::Place;
use crate::query::funnel::{length, taut};
use crate::query::request::{Mode, QueryError, QueryOptions, Tiles, unfold};
use crate::query::route;
use crate::query::wavefront::{Approach, Goal, Places, Run};
use crate::store::TileReader;

/// How the search for a way along edges hurries to its goal: it may be longer than a shortest one by this factor. On Delaunay's triangulation
/// of random points ways along edges are about 1.05 times as long as straight ones; with less than that, the search goes through much
/// of what lies around the way.
const HASTE: f64 = 1.125;

/// A way found fast.
pub(crate) struct FastWay {
    pub(crate) way: Vec<WayPoint>,
    pub(crate) distance: Distance,
}

/// At most the distance of two points.
fn straight(a: Point, b: Point) -> f64 {
    Distance::of_legs(distance(a, b), 1).lower
}

/// At most the true length of ways that along edges have at least this one.
fn by_edges(tiles: &Tiles, along_edges: f64) -> f64 {
    match BreakLines::of(tiles.metadata()) {
        BreakLines::No => along_edges / STRETCH,
        BreakLines::Yes | BreakLines::Unknown => 0.0,
    }
}

/// At most the true length of a shortest way between two points, given what the one along edges has at least.
fn at_least(tiles: &Tiles, ends: [Point; 2], along_edges: f64) -> f64 {
    straight(ends[0], ends[1]).max(by_edges(tiles, along_edges))
}

/// Pulls a way along edges taut, and finds its bounds. It is at most `haste` times as long as a shortest one.
async fn pulled(tiles: &mut Tiles, nodes: &[Node], haste: f64) -> Result<FastWay, QueryError> {
    let (Some(first), Some(last)) = (nodes.first(), nodes.last()) else {
        return Err(QueryError::Uncertified {
            reason: "a way has no points".to_owned(),
        });
    };
    let along_edges = Distance::of_legs(last.length, nodes.len()).lower;
    let lower = at_least(tiles, [first.point, last.point], along_edges / haste);
    let mut way = taut(tiles, nodes).await.map_err(|error| error.at_least(lower))?;
    if way.is_empty() {
        way = vec![(first.point, None); 2];
    }
    let value = length(&way);
    let around = Distance::of_legs(value, way.len());
    Ok(FastWay {
        way,
        distance: Distance {
            value,
            lower: lower.min(value),
            upper: around.upper,
        },
    })
}

/// A way between two free places, found fast, if there is one.
pub(crate) async fn way(tiles: Tiles, from: &Place, to: &Place) -> Result<(Tiles, Option<FastWay>), QueryError> {
    let ends = [from.point, to.point];
    let (mut run, end) = EdgeRun::towards(tiles, from.clone(), to, HASTE).await?;
    let found = run.find(end).await;
    let bound = |along_edges| at_least(&run.tiles, ends, along_edges);
    let Some(node) = found.map_err(|error| error.bounded(bound))? else {
        return Ok((run.tiles, None));
    };
    let nodes = run.search.way(node);
    let way = pulled(&mut run.tiles, &nodes, HASTE).await?;
    Ok((run.tiles, Some(way)))
}

/// The path of a way that was found fast.
async fn path_of(tiles: &mut Tiles, way: &FastWay, ends: [&Place; 2], certify: bool) -> Result<Path, QueryError> {
    let mut points = way.way.clone();
    // The ends are known by their places.
    for (point, place) in [(0, ends[0]), (points.len() - 1, ends[1])] {
        points[point].1 = place.vertex();
    }
    let path = route::path_with(tiles, &points, ends, way.distance, [certify, false]).await;
    path.map_err(|error| error.at_least(way.distance.lower))
}

/// A path between two free places that need not be exact; with how many tiles it took.
pub(crate) async fn path(
    tiles: Tiles,
    from: Place,
    to: Place,
    options: QueryOptions,
) -> Result<(PathOutcome, u64), QueryError> {
    let (mut tiles, found) = way(tiles, &from, &to).await?;
    let Some(mut found) = found else {
        return Ok((PathOutcome::Unreachable, tiles.count()));
    };
    if let Mode::Within(tolerance) = options.mode.check()?
        && found.distance.upper > (1.0 + tolerance) * found.distance.lower
    {
        let goal = Goal::Places(Places::new([&to]));
        // What is pruned is longer, whatever was rounded.
        let limit = found.distance.upper * (1.0 + 1e-9);
        let certify = options.certify;
        let mut run = Run::start(tiles, from.clone(), goal, limit, options).await?;
        let close = run.next_beyond(found.distance.upper / (1.0 + tolerance)).await;
        match close.map_err(|error| error.bounded(|front| front.max(found.distance.lower)))? {
            Approach::Found(exact) => {
                let path = run.path(&exact, &to).await?;
                return Ok((PathOutcome::Found(path), run.tiles.count()));
            }
            Approach::Beyond(front) => found.distance.lower = found.distance.lower.max(front).min(found.distance.value),
        }
        let path = path_of(&mut run.tiles, &found, [&from, &to], certify).await?;
        return Ok((PathOutcome::Found(path), run.tiles.count()));
    }
    let path = path_of(&mut tiles, &found, [&from, &to], options.certify).await?;
    Ok((PathOutcome::Found(path), tiles.count()))
}

/// Sites by their way along edges, each with that pulled taut.
struct FastSites {
    sites: SitesAlongEdges,
    radius: f64,
    options: QueryOptions,
}

impl FastSites {
    async fn next(&mut self) -> Result<Option<SiteFound>, QueryError> {
        loop {
            let found = self.sites.next().await;
            let run = &mut self.sites.vertices.run;
            let bound = |along_edges| by_edges(&run.tiles, along_edges);
            let Some((mut site, node)) = found.map_err(|error| error.bounded(bound))? else {
                return Ok(None);
            };
            let nodes = run.search.way(node);
            let may_be_near = nodes
                .first()
                .is_some_and(|from| distance(from.point, site.vertex.point) <= self.radius);
            if !may_be_near {
                continue;
            }
            let known = by_edges(&run.tiles, site.distance.lower);
            let way = pulled(&mut run.tiles, &nodes, 1.0)
                .await
                .map_err(|error| error.at_least(known))?;
            let is_near = way.distance.value <= self.radius;
            if !is_near {
                continue;
            }
            site.distance = way.distance;
            if self.options.paths {
                let (source, to) = (run.source().clone(), Place::at(site.vertex));
                let path = path_of(&mut run.tiles, &way, [&source, &to], self.options.certify).await;
                site.path = Some(path.map_err(|error| error.at_least(known))?);
            }
            return Ok(Some(site));
        }
    }
}

/// The first sites of mode fast, with how many tiles they took.
pub(crate) async fn first_sites(
    reader: &TileReader,
    at: Point,
    count: usize,
    options: QueryOptions,
) -> Result<(Vec<SiteFound>, u64), QueryError> {
    let mut sites = FastSites {
        sites: SitesAlongEdges::start(reader, at, f64::INFINITY, &options).await?,
        radius: f64::INFINITY,
        options,
    };
    let mut found = Vec::new();
    while found.len() < count {
        match sites.next().await? {
            Some(site) => found.push(site),
            None => break,
        }
    }
    Ok((found, sites.sites.vertices.run.tiles.count()))
}

/// Sites as [`TileReader::sites_within`] gives them in mode fast.
pub(crate) fn sites(
    reader: TileReader,
    at: Point,
    radius: f64,
    options: QueryOptions,
) -> impl Stream<Item = Result<SiteFound, QueryError>> + Send + Unpin + 'static + use<> {
    let start = async move {
        // What is farther away along edges is farther away than the radius.
        let limit = radius * STRETCH;
        let sites = SitesAlongEdges::start(&reader, at, limit, &options).await?;
        Ok(FastSites { sites, radius, options })
    };
    unfold(start, |mut sites: FastSites| async move {
        Ok(sites.next().await?.map(|site| (site, sites)))
    })
}

/// Paths that were found, nearest first, and why there are no more.
struct Several {
    found: VecDeque<(usize, Path)>,
    failed: Option<QueryError>,
}

/// A path to one of several points, if there is one.
async fn one(mut tiles: Tiles, from: &Place, to: Point, certify: bool) -> Result<(Tiles, Option<Path>), QueryError> {
    let to = Place::find(&mut tiles, to).await?;
    if !to.is_free {
        return Ok((tiles, None));
    }
    let (mut tiles, found) = way(tiles, from, &to).await?;
    let path = match found {
        Some(found) => Some(path_of(&mut tiles, &found, [from, &to], certify).await?),
        None => None,
    };
    Ok((tiles, path))
}

/// Paths as [`TileReader::shortest_paths`] gives them in mode fast: each is looked for by itself.
pub(crate) fn paths(
    reader: TileReader,
    from: Point,
    to: Vec<Point>,
    options: QueryOptions,
) -> impl Stream<Item = Result<(usize, Path), QueryError>> + Send + Unpin + 'static + use<> {
    let start = async move {
        let mut tiles = Tiles::new(&reader, &options);
        let source = Place::find_free(&mut tiles, from).await?;
        let (mut found, mut failed) = (Vec::new(), None);
        for (&point, number) in to.iter().zip(0..) {
            match one(tiles, &source, point, options.certify).await {
                Ok((still, path)) => {
                    tiles = still;
                    found.extend(path.map(|path| (number, path)));
                }
                Err(QueryError::OutOfBudget { .. }) => {
                    let rest = to[number..].iter().map(|&point| straight(from, point));
                    let at_least = rest.fold(f64::INFINITY, f64::min);
                    failed = Some(QueryError::OutOfBudget { at_least });
                    break;
                }
                Err(error) => return Err(error),
            }
        }
        found.sort_by(|a, b| a.1.distance.value.total_cmp(&b.1.distance.value));
        Ok(Several {
            found: found.into(),
            failed,
        })
    };
    unfold(start, |mut several: Several| async move {
        match (several.found.pop_front(), several.failed.take()) {
            (Some(found), failed) => {
                several.failed = failed;
                Ok(Some((found, several)))
            }
            (None, Some(error)) => Err(error),
            (None, None) => Ok(None),
        }
    })
}

/// One of two streams, by the mode.
pub(crate) fn by_mode<A, B>(mode: Mode, fast: impl FnOnce() -> A, exact: impl FnOnce() -> B) -> Either<A, B> {
    match mode {
        Mode::Fast => Either::Left(fast()),
        Mode::Exact | Mode::Within(_) => Either::Right(exact()),
    }
}
