//! The wavefront, measured like the other methods.

use foldhash::{HashSet, HashSetExt};

use super::context::Wanted;
use super::obstacles::edges_at;
use super::statistics::{Clock, Measured, Statistics};
use crate::geometry::Point;
use crate::query::answer::{Distance, PathOutcome, SiteFound};
use crate::query::free_space::{FreeSpace, QueryPoint};
use crate::query::request::{QueryError, QueryOptions, Tiles};
use crate::query::wavefront::{Goal, QueryPoints, Target, WavefrontRun};
use crate::store::{TileReader, VertexId};

/// Returns the cost of a run.
async fn cost(
    reader: &TileReader,
    run: &WavefrontRun,
    clock: Clock,
    candidates: usize,
) -> Result<Statistics, QueryError> {
    let mut statistics = Statistics {
        candidates: candidates as u64,
        nodes_swept: run.wavefront.root_count() as u64,
        rounds: 1,
        tiles: run.tiles.count(),
        times: clock.times,
        ..Statistics::default()
    };
    // These lookups are not timed, because the wavefront itself does not need them.
    let mut reached: Vec<VertexId> = run.wavefront.reached().collect();
    reached.sort_unstable();
    let mut edges = HashSet::new();
    for of_tile in reached.chunk_by(|a, b| a.tile == b.tile) {
        let tile = reader.tile(of_tile[0].tile).await?;
        let space = FreeSpace::of(&run.tiles, &tile);
        for vertex in of_tile {
            let found = edges_at(space, vertex.index, |edge| {
                edges.insert(edge.key());
            });
            found.map_err(|reason| run.tiles.damaged(vertex.tile, reason))?;
        }
    }
    statistics.edges_considered = edges.len() as u64;
    Ok(statistics)
}

/// Returns the nearest sites, or those within a radius.
pub(super) async fn sites(
    reader: &TileReader,
    at: Point,
    wanted: Wanted,
    options: QueryOptions,
) -> Result<Measured<Vec<SiteFound>>, QueryError> {
    let mut clock = Clock::start();
    let mut run = WavefrontRun::from_point(reader, at, Goal::Sites, wanted.limit(), options).await?;
    clock.lap("locate");
    let (mut answer, mut lower_bound) = (Vec::new(), None);
    while answer.len() < wanted.count() {
        let found = match run.next().await {
            Ok(Some(found)) => found,
            Ok(None) => break,
            Err(QueryError::OutOfBudget { lower_bound: rest }) => {
                lower_bound = Some(rest);
                break;
            }
            Err(error) => return Err(error),
        };
        let Target::Site { number, id, vertex } = found.target.clone() else {
            continue;
        };
        let mut site = SiteFound {
            number,
            id,
            vertex,
            distance: Distance::of_legs(found.length, run.legs(&found)),
            path: None,
        };
        if run.options.paths {
            clock.lap("wavefront");
            match run.path(&found, &QueryPoint::at(vertex)).await {
                Err(QueryError::OutOfBudget { .. }) => {
                    lower_bound = Some(site.distance.lower);
                    break;
                }
                path => site.path = Some(path?),
            }
            clock.lap("paths");
        }
        answer.push(site);
    }
    clock.lap("wavefront");
    let statistics = cost(reader, &run, clock, answer.len()).await?;
    Ok(Measured {
        answer,
        lower_bound,
        statistics,
    })
}

/// Returns the shortest path to a target.
pub(super) async fn path(
    reader: &TileReader,
    ends: [QueryPoint; 2],
    tiles: Tiles,
    clock: Clock,
    options: QueryOptions,
) -> Result<Measured<PathOutcome>, QueryError> {
    let mut clock = clock;
    let [from, to] = ends;
    let goal = Goal::Points(QueryPoints::new([&to]));
    let mut run = WavefrontRun::start(tiles, from, goal, f64::INFINITY, options).await?;
    let found = run.next().await?;
    clock.lap("wavefront");
    let answer = match found {
        Some(found) => PathOutcome::Found(run.path(&found, &to).await?),
        None => PathOutcome::Unreachable,
    };
    clock.lap("paths");
    let statistics = cost(reader, &run, clock, 1).await?;
    Ok(Measured {
        answer,
        lower_bound: None,
        statistics,
    })
}
