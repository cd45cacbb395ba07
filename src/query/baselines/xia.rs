//! The method of Xia, Hsu and Tung, "A fast filter for obstructed nearest neighbor queries" (BNCOD
//! 2004): only obstacles that paths cross count.
//!
//! Shortest paths among the obstacle edges that are known so far are provisional, and no longer
//! than the true ones. An inner loop adds the obstacles that the paths to the nearest candidates
//! cross, until these paths meet no unknown edge. Then they are the true shortest paths. The
//! candidates are all sites within the Euclidean distance of the k-th. This implementation differs:
//! it adds only the part of an obstacle's boundary that is connected within the provisional
//! distance; it searches for all candidates at once; and a path that ends or bends at a vertex
//! meets all edges of the vertex.

use foldhash::{HashSet, HashSetExt};
use futures::TryStreamExt;
use futures::stream::BoxStream;

use super::context::{QueryContext, Wanted};
use super::local::{Local, Reached};
use super::nearby::{Center, Met, Nearby, distance_of_segment};
use super::obstacles::{ObstacleEdge, edges_at};
use crate::geometry::Point;
use crate::query::euclidean::Near;
use crate::query::free_space::{FreeSpace, QueryPoint};
use crate::query::request::{Contradiction, QueryError};
use crate::store::Vertex;

/// Sites by Euclidean distance, nearest first.
pub(super) struct EuclideanSites {
    stream: BoxStream<'static, Result<Near, QueryError>>,
    next: Option<Near>,
}

impl EuclideanSites {
    async fn new(context: &mut QueryContext) -> Result<Self, QueryError> {
        let stream = context
            .reader
            .sites_by_euclidean_distance(context.source.point, context.options.clone());
        let mut this = Self {
            stream: Box::pin(stream),
            next: None,
        };
        this.next = this.stream.try_next().await?;
        Ok(this)
    }

    /// Adds candidates until there are `count` sites, and all within `distance`. Returns whether
    /// any was added.
    async fn add(
        &mut self,
        context: &mut QueryContext,
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
            let tile = context.tiles.get(near.vertex.id.tile).await?;
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

/// The legs of provisional paths, and the obstacles that they cross.
struct Legs {
    /// The legs that were walked, by the bits of their ends.
    walked: HashSet<[u64; 4]>,
}

impl Legs {
    /// Adds the obstacles that paths cross, as far as they are within a distance. Returns whether
    /// any was added.
    async fn walk(
        &mut self,
        context: &mut QueryContext,
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
            let at_vertex = vertex.map(|id| QueryPoint::at(Vertex { id, point: from }));
            let query_point = at_vertex.as_ref().unwrap_or(&context.source);
            let mut nearby = Nearby::start(&mut context.tiles, query_point, Center::Segment([from, to])).await?;
            while let Some(met) = nearby.next(&mut context.tiles, 0.0).await? {
                if let Met::Edge(edge) = met
                    && local.add_edge(&edge)
                {
                    is_new = true;
                    add_boundary(context, local, edge, within).await?;
                }
            }
            context.considered.extend(nearby.walls);
        }
        context.statistics.edges_considered = context.considered.len() as u64;
        Ok(is_new)
    }
}

/// Adds the edges that are connected to an edge within a distance from the source.
async fn add_boundary(
    context: &mut QueryContext,
    local: &mut Local,
    edge: ObstacleEdge,
    within: f64,
) -> Result<(), QueryError> {
    let at: Point = context.source.point;
    let mut open = edge.ends.to_vec();
    while let Some(vertex) = open.pop() {
        if local.is_complete(vertex.id) {
            continue;
        }
        let tile = context.tiles.get(vertex.id.tile).await?;
        if !tile.has_vertex(vertex.id.index) {
            let reason = Contradiction::NoVertex(vertex.id.index);
            return Err(context.tiles.damaged(tile.id(), reason));
        }
        let space = FreeSpace::of(&context.tiles, &tile);
        let mut edges = Vec::new();
        let found = edges_at(space, vertex.id.index, |edge| edges.push(edge));
        found.map_err(|reason| context.tiles.damaged(tile.id(), reason))?;
        let mut is_complete = true;
        for edge in edges {
            context.considered.insert(edge.key());
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

/// Returns the nearest sites, or those within a radius.
pub(super) async fn sites(context: &mut QueryContext, wanted: Wanted) -> Result<(Local, Vec<Reached>), QueryError> {
    let euclidean = EuclideanSites::new(context).await?;
    // If a limit is reached: no site is nearer than the Euclidean distance of the first one.
    let nearest = euclidean.next.as_ref().map_or(f64::INFINITY, |near| near.distance);
    let found = settle(context, euclidean, wanted).await;
    found.map_err(|error| error.lower_bound(nearest))
}

/// Adds obstacles and candidates until provisional paths are the true shortest paths.
async fn settle(
    context: &mut QueryContext,
    mut euclidean: EuclideanSites,
    wanted: Wanted,
) -> Result<(Local, Vec<Reached>), QueryError> {
    let mut local = Local::new(&context.source, None);
    let mut legs = Legs { walked: HashSet::new() };
    match wanted {
        Wanted::Within(radius) => euclidean.add(context, &mut local, 0, radius).await?,
        Wanted::Nearest(count) => euclidean.add(context, &mut local, count, 0.0).await?,
    };
    let count = wanted.count();
    loop {
        let found = local.nearest(count, wanted.limit(), context).await?;
        context.pause().await?;
        let farthest = found.last().map_or(0.0, |found| found.length);
        if legs.walk(context, &mut local, &found, farthest).await? {
            continue;
        }
        if matches!(wanted, Wanted::Within(_)) {
            return Ok((local, found));
        }
        let reached = found.iter().map(|found| local.candidates[found.candidate].sites.len());
        let is_new = if reached.sum::<usize>() >= count {
            euclidean.add(context, &mut local, 0, farthest).await?
        } else {
            // Some candidates cannot be reached, so more are needed.
            let more = 2 * local.site_count().max(1);
            euclidean.add(context, &mut local, more, 0.0).await?
        };
        if !is_new {
            context.clock.lap("collect");
            return Ok((local, found));
        }
    }
}

/// Returns the shortest path to a target.
pub(super) async fn path(context: &mut QueryContext, to: &QueryPoint) -> Result<Option<Reached>, QueryError> {
    let mut local = Local::new(&context.source, Some(to));
    let mut legs = Legs { walked: HashSet::new() };
    loop {
        let found = local.target(f64::INFINITY, context).await?;
        context.pause().await?;
        let Some(found) = found else { return Ok(None) };
        if !legs
            .walk(context, &mut local, std::slice::from_ref(&found), found.length)
            .await?
        {
            context.clock.lap("collect");
            return Ok(Some(found));
        }
    }
}
