//! Xia, Hsu and Tung, "A fast filter for obstructed nearest neighbor queries" (BNCOD 2004): only obstacles that are run into count.
//!
//! Shortest paths among the obstacle edges that are known so far are provisional, and no longer than the true ones. In an inner loop the
//! obstacles that the paths to the nearest candidates run into are added, until these meet no edge that is not known: then they are the
//! true ones. Candidates are all sites within the Euclidean distance of the k-th. However: of an obstacle only the boundary that
//! hangs together within the provisional distance is added; all candidates are searched for at once; and a path that ends at a vertex, or
//! bends there, meets all edges of it.

use foldhash::{HashSet, HashSetExt};
use futures::TryStreamExt;
use futures::stream::BoxStream;

use super::asked::{Asked, Wanted};
use super::local::{Local, Reached};
use super::nearby::{Center, Met, Nearby, distance_of_segment};
use super::obstacles::{ObstacleEdge, edges_at};
use crate::geometry::Point;
use crate::query::euclidean::Near;
use crate::query::free_space::{Ground, Place};
use crate::query::request::{Contradiction, QueryError};
use crate::store::Vertex;

/// Sites as the crow flies, nearest first.
pub(super) struct Air {
    stream: BoxStream<'static, Result<Near, QueryError>>,
    next: Option<Near>,
}

impl Air {
    async fn new(asked: &mut Asked) -> Result<Self, QueryError> {
        let stream = asked.reader.sites_by_air(asked.source.point, asked.options.clone());
        let mut this = Self {
            stream: Box::pin(stream),
            next: None,
        };
        this.next = this.stream.try_next().await?;
        Ok(this)
    }

    /// Adds candidates until there are so many sites, and all within a distance. Returns whether there were any.
    async fn add(
        &mut self,
        asked: &mut Asked,
        local: &mut Local,
        count: usize,
        distance: f64,
    ) -> Result<bool, QueryError> {
        let mut is_new = false;
        while let Some(near) = self
            .next
            .take_if(|near| near.distance <= distance || local.site_count() < count)
        {
            is_new = true;
            let tile = asked.tiles.get(near.vertex.id.tile).await?;
            let sites = tile.sites_at(near.vertex.id.index);
            local.add_candidate(
                near.vertex,
                sites.map(|site| (site.number, site.id.map(str::to_owned))).collect(),
            );
            self.next = self.stream.try_next().await?;
        }
        Ok(is_new)
    }
}

/// The legs of provisional paths, and what they run into.
struct Legs {
    /// Those that were walked, by the bits of their ends.
    walked: HashSet<[u64; 4]>,
}

impl Legs {
    /// Adds the obstacles that ways run into, as far as they are within a distance. Returns whether there were any.
    async fn walk(
        &mut self,
        asked: &mut Asked,
        local: &mut Local,
        reached: &[Reached],
        within: f64,
    ) -> Result<bool, QueryError> {
        let mut is_new = false;
        for leg in reached.iter().flat_map(|reached| reached.way.windows(2)) {
            let [(from, vertex), (to, _)] = [leg[0], leg[1]];
            let key = [from.x, from.y, to.x, to.y].map(f64::to_bits);
            if from == to || !self.walked.insert(key) {
                continue;
            }
            let at_vertex = vertex.map(|id| Place::at(Vertex { id, point: from }));
            let place = at_vertex.as_ref().unwrap_or(&asked.source);
            let mut nearby = Nearby::start(&mut asked.tiles, place, Center::Segment([from, to])).await?;
            while let Some(met) = nearby.next(&mut asked.tiles, 0.0).await? {
                if let Met::Edge(edge) = met
                    && local.add_edge(&edge)
                {
                    is_new = true;
                    add_boundary(asked, local, edge, within).await?;
                }
            }
            asked.considered.extend(nearby.walls);
        }
        asked.statistics.edges_considered = asked.considered.len() as u64;
        Ok(is_new)
    }
}

/// Adds what hangs together with an edge within a distance from the source.
async fn add_boundary(asked: &mut Asked, local: &mut Local, edge: ObstacleEdge, within: f64) -> Result<(), QueryError> {
    let at: Point = asked.source.point;
    let mut open = edge.ends.to_vec();
    while let Some(vertex) = open.pop() {
        if local.is_complete(vertex.id) {
            continue;
        }
        let tile = asked.tiles.get(vertex.id.tile).await?;
        if !tile.has_vertex(vertex.id.index) {
            let reason = Contradiction::NoVertex(vertex.id.index);
            return Err(asked.tiles.damaged(tile.id(), reason));
        }
        let ground = Ground::of(&asked.tiles, &tile);
        let mut edges = Vec::new();
        let found = edges_at(ground, vertex.id.index, |edge| edges.push(edge));
        found.map_err(|reason| asked.tiles.damaged(tile.id(), reason))?;
        let mut is_complete = true;
        for edge in edges {
            asked.considered.insert(edge.key());
            if distance_of_segment(edge.ends.map(|end| end.point), at) > within {
                is_complete = false;
            } else if local.add_edge(&edge) {
                open.push(edge.ends[1]);
            }
        }
        if is_complete {
            local.complete(vertex.id);
        }
    }
    Ok(())
}

/// The nearest sites, or those within a radius.
pub(super) async fn sites(asked: &mut Asked, wanted: Wanted) -> Result<(Local, Vec<Reached>), QueryError> {
    let air = Air::new(asked).await?;
    // If a budget is used up: no site is nearer than the first one as the crow flies.
    let nearest = air.next.as_ref().map_or(f64::INFINITY, |near| near.distance);
    let found = settle(asked, air, wanted).await;
    found.map_err(|error| error.at_least(nearest))
}

/// Adds obstacles and candidates until provisional paths are the true ones.
async fn settle(asked: &mut Asked, mut air: Air, wanted: Wanted) -> Result<(Local, Vec<Reached>), QueryError> {
    let mut local = Local::new(&asked.source, None);
    let mut legs = Legs { walked: HashSet::new() };
    match wanted {
        Wanted::Within(radius) => air.add(asked, &mut local, 0, radius).await?,
        Wanted::Nearest(count) => air.add(asked, &mut local, count, 0.0).await?,
    };
    let count = wanted.count();
    loop {
        let found = local.nearest(count, wanted.limit(), asked).await?;
        asked.pause().await?;
        let farthest = found.last().map_or(0.0, |found| found.length);
        if legs.walk(asked, &mut local, &found, farthest).await? {
            continue;
        }
        if matches!(wanted, Wanted::Within(_)) {
            return Ok((local, found));
        }
        let reached = found.iter().map(|found| local.candidates[found.candidate].sites.len());
        let is_new = if reached.sum::<usize>() >= count {
            air.add(asked, &mut local, 0, farthest).await?
        } else {
            // Some cannot be reached, so others are wanted.
            let more = 2 * local.site_count().max(1);
            air.add(asked, &mut local, more, 0.0).await?
        };
        if !is_new {
            asked.clock.lap("collect");
            return Ok((local, found));
        }
    }
}

/// The shortest path to a target.
pub(super) async fn path(asked: &mut Asked, to: &Place) -> Result<Option<Reached>, QueryError> {
    let mut local = Local::new(&asked.source, Some(to));
    let mut legs = Legs { walked: HashSet::new() };
    loop {
        let found = local.target(f64::INFINITY, asked).await?;
        asked.pause().await?;
        let Some(found) = found else { return Ok(None) };
        if !legs
            .walk(asked, &mut local, std::slice::from_ref(&found), found.length)
            .await?
        {
            asked.clock.lap("collect");
            return Ok(Some(found));
        }
    }
}
