//! Answers with bounds: fast ones, and those within a tolerance.
//!
//! The input is free points and the options. The output is a short path along edges
//! ([`edges`](crate::query::edges)), which is then shortened ([`funnel`](crate::query::funnel)).
//! Its length is at least the true distance. The true distance is at least the straight line, and
//! at least the shortest path along edges divided by [`STRETCH`], unless the file has break lines,
//! which invalidate that bound, or does not state whether it has any.
//!
//! If a tolerance is set and these bounds are not close enough, a wavefront runs to the goal, at
//! most as far as the length of the fast path, until it arrives or its front is close enough to
//! that length.

use std::collections::VecDeque;

use futures::future::Either;
use futures::stream::Stream;

use crate::geometry::Point;
use crate::query::answer::{Distance, Path, PathOutcome, SiteFound, WayPoint, distance};
use crate::query::edges::{BreakLines, EdgeRun, Node, STRETCH, SitesAlongEdges};
use crate::query::free_space::QueryPoint;
use crate::query::funnel::{length, shorten};
use crate::query::request::{Mode, QueryError, QueryOptions, Tiles, unfold};
use crate::query::route;
use crate::query::wavefront::{Approach, Goal, QueryPoints, WavefrontRun};
use crate::store::TileReader;

/// The weight of the heuristic in the search for a path along edges. The path may be longer than a
/// shortest one by this factor. In Delaunay triangulations of random points, paths along edges are
/// about 1.05 times as long as straight lines. With a lower weight, the search examines much of the
/// space round the path.
const WEIGHT: f64 = 1.125;

/// A path found by the fast search.
pub(crate) struct FastWay {
    pub(crate) way: Vec<WayPoint>,
    pub(crate) distance: Distance,
}

/// Returns a lower bound of the distance of two points.
fn straight(a: Point, b: Point) -> f64 {
    Distance::of_legs(distance(a, b), 1).lower
}

/// Returns a lower bound of the true length, given a lower bound of the length along edges.
fn by_edges(tiles: &Tiles, along_edges: f64) -> f64 {
    match BreakLines::of(tiles.metadata()) {
        BreakLines::No => along_edges / STRETCH,
        BreakLines::Yes | BreakLines::Unknown => 0.0,
    }
}

/// Returns a lower bound of the length of a shortest path between two points, given a lower bound
/// of the length along edges.
fn lower_bound(tiles: &Tiles, ends: [Point; 2], along_edges: f64) -> f64 {
    straight(ends[0], ends[1]).max(by_edges(tiles, along_edges))
}

/// Shortens a path along edges, and determines its bounds. The path along edges is at most `weight`
/// times as long as a shortest one.
async fn shortened(tiles: &mut Tiles, nodes: &[Node], weight: f64) -> Result<FastWay, QueryError> {
    let (Some(first), Some(last)) = (nodes.first(), nodes.last()) else {
        return Err(QueryError::Uncertified {
            reason: "a path has no points".to_owned(),
        });
    };
    let along_edges = Distance::of_legs(last.length, nodes.len()).lower;
    let lower = lower_bound(tiles, [first.point, last.point], along_edges / weight);
    let mut way = shorten(tiles, nodes).await.map_err(|error| error.lower_bound(lower))?;
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

/// Returns a fast path between two free points, if one exists.
pub(crate) async fn way(
    tiles: Tiles,
    from: &QueryPoint,
    to: &QueryPoint,
) -> Result<(Tiles, Option<FastWay>), QueryError> {
    let ends = [from.point, to.point];
    let (mut run, end) = EdgeRun::towards(tiles, from.clone(), to, WEIGHT).await?;
    let found = run.find(end).await;
    let bound = |along_edges| lower_bound(&run.tiles, ends, along_edges);
    let Some(node) = found.map_err(|error| error.bounded(bound))? else {
        return Ok((run.tiles, None));
    };
    let nodes = run.search.way(node);
    let way = shortened(&mut run.tiles, &nodes, WEIGHT).await?;
    Ok((run.tiles, Some(way)))
}

/// Converts a fast path to a [`Path`].
async fn path_of(tiles: &mut Tiles, way: &FastWay, ends: [&QueryPoint; 2], certify: bool) -> Result<Path, QueryError> {
    let mut points = way.way.clone();
    // The query points know the vertices of the ends.
    for (point, query_point) in [(0, ends[0]), (points.len() - 1, ends[1])] {
        points[point].1 = query_point.vertex();
    }
    let path = route::path_with(tiles, &points, ends, way.distance, [certify, false]).await;
    path.map_err(|error| error.lower_bound(way.distance.lower))
}

/// Returns a path between two free points that need not be exact, and the number of tiles used.
pub(crate) async fn path(
    tiles: Tiles,
    from: QueryPoint,
    to: QueryPoint,
    options: QueryOptions,
) -> Result<(PathOutcome, u64), QueryError> {
    let (mut tiles, found) = way(tiles, &from, &to).await?;
    let Some(mut found) = found else {
        return Ok((PathOutcome::Unreachable, tiles.count()));
    };
    if let Mode::Within(tolerance) = options.mode.check()?
        && found.distance.upper > (1.0 + tolerance) * found.distance.lower
    {
        let goal = Goal::Points(QueryPoints::new([&to]));
        // Everything that is pruned is longer, despite rounding.
        let limit = found.distance.upper * (1.0 + 1e-9);
        let certify = options.certify;
        let mut run = WavefrontRun::start(tiles, from.clone(), goal, limit, options).await?;
        let close = run.next_beyond(found.distance.upper / (1.0 + tolerance)).await;
        match close.map_err(|error| error.bounded(|front| front.max(found.distance.lower)))? {
            Approach::Found(exact) => {
                let path = run.path(&exact, &to).await?;
                return Ok((PathOutcome::Found(path), run.tiles.count()));
            }
            Approach::AtLeast(front) => {
                found.distance.lower = found.distance.lower.max(front).min(found.distance.value)
            }
        }
        let path = path_of(&mut run.tiles, &found, [&from, &to], certify).await?;
        return Ok((PathOutcome::Found(path), run.tiles.count()));
    }
    let path = path_of(&mut tiles, &found, [&from, &to], options.certify).await?;
    Ok((PathOutcome::Found(path), tiles.count()))
}

/// Sites in the order of their distance along edges, each with its shortened path.
struct FastSites {
    sites: SitesAlongEdges,
    options: QueryOptions,
}

impl FastSites {
    /// Starts a search at a free point.
    async fn start(reader: &TileReader, at: Point, options: QueryOptions) -> Result<Self, QueryError> {
        let sites = SitesAlongEdges::start(reader, at, &options).await?;
        Ok(Self { sites, options })
    }

    async fn next(&mut self) -> Result<Option<SiteFound>, QueryError> {
        let found = self.sites.next().await;
        let run = &mut self.sites.vertices.run;
        let bound = |along_edges| by_edges(&run.tiles, along_edges);
        let Some((mut site, node)) = found.map_err(|error| error.bounded(bound))? else {
            return Ok(None);
        };
        let nodes = run.search.way(node);
        let known = by_edges(&run.tiles, site.distance.lower);
        let way = shortened(&mut run.tiles, &nodes, 1.0)
            .await
            .map_err(|error| error.lower_bound(known))?;
        site.distance = way.distance;
        if self.options.paths {
            let (source, to) = (run.source().clone(), QueryPoint::at(site.vertex));
            let path = path_of(&mut run.tiles, &way, [&source, &to], self.options.certify).await;
            site.path = Some(path.map_err(|error| error.lower_bound(known))?);
        }
        Ok(Some(site))
    }
}

/// Returns the first `count` sites of mode fast, and the number of tiles used.
pub(crate) async fn first_sites(
    reader: &TileReader,
    at: Point,
    count: usize,
    options: QueryOptions,
) -> Result<(Vec<SiteFound>, u64), QueryError> {
    let mut sites = FastSites::start(reader, at, options).await?;
    let mut found = Vec::new();
    while found.len() < count {
        match sites.next().await? {
            Some(site) => found.push(site),
            None => break,
        }
    }
    Ok((found, sites.sites.vertices.run.tiles.count()))
}

/// Returns the stream of [`TileReader::nearest_sites`] in mode fast.
pub(crate) fn sites(
    reader: TileReader,
    at: Point,
    options: QueryOptions,
) -> impl Stream<Item = Result<SiteFound, QueryError>> + Send + Unpin + 'static + use<> {
    let start = async move { FastSites::start(&reader, at, options).await };
    unfold(start, |mut sites: FastSites| async move {
        Ok(sites.next().await?.map(|site| (site, sites)))
    })
}

/// The paths that were found, nearest first, and the error that ended the search, if any.
struct FastPaths {
    found: VecDeque<(usize, Path)>,
    failed: Option<QueryError>,
}

/// Returns a path to one of several points, if one exists.
async fn path_to(
    mut tiles: Tiles,
    from: &QueryPoint,
    to: Point,
    certify: bool,
) -> Result<(Tiles, Option<Path>), QueryError> {
    let to = QueryPoint::find(&mut tiles, to).await?;
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

/// Returns the stream of [`TileReader::shortest_paths`] in mode fast, which searches for each path
/// separately.
pub(crate) fn paths(
    reader: TileReader,
    from: Point,
    to: Vec<Point>,
    options: QueryOptions,
) -> impl Stream<Item = Result<(usize, Path), QueryError>> + Send + Unpin + 'static + use<> {
    let start = async move {
        let mut tiles = Tiles::new(&reader, &options);
        let source = QueryPoint::find_free(&mut tiles, from).await?;
        let (mut found, mut failed) = (Vec::new(), None);
        for (&point, number) in to.iter().zip(0..) {
            match path_to(tiles, &source, point, options.certify).await {
                Ok((still, path)) => {
                    tiles = still;
                    found.extend(path.map(|path| (number, path)));
                }
                Err(QueryError::OutOfBudget { .. }) => {
                    let rest = to[number..].iter().map(|&point| straight(from, point));
                    let lower_bound = rest.fold(f64::INFINITY, f64::min);
                    failed = Some(QueryError::OutOfBudget { lower_bound });
                    break;
                }
                Err(error) => return Err(error),
            }
        }
        found.sort_by(|a, b| a.1.distance.value.total_cmp(&b.1.distance.value));
        Ok(FastPaths {
            found: found.into(),
            failed,
        })
    };
    unfold(start, |mut paths: FastPaths| async move {
        match (paths.found.pop_front(), paths.failed.take()) {
            (Some(found), failed) => {
                paths.failed = failed;
                Ok(Some((found, paths)))
            }
            (None, Some(error)) => Err(error),
            (None, None) => Ok(None),
        }
    })
}

/// Returns one of two streams, depending on the mode.
pub(crate) fn by_mode<A, B>(mode: Mode, fast: impl FnOnce() -> A, exact: impl FnOnce() -> B) -> Either<A, B> {
    match mode {
        Mode::Fast => Either::Left(fast()),
        Mode::Exact | Mode::Within(_) => Either::Right(exact()),
    }
}
