//! The method of S.-W. Wu's thesis (I/O-Efficient Algorithm for Constrained Delaunay Triangulation
//! with Applications to Proximity Search, NUS 2004): CDT distance prunes, and a local visibility
//! graph finds the answers among the rest.
//!
//! Let *t* be an upper bound of the ratio of CDT distance to walking distance, and *r* an upper
//! bound of the walking distance of the wanted sites. The sites are among those within CDT distance
//! l₁ = r·t, and the obstacle edges that matter have an end within l₂ = r·t(t+3)/2. For k nearest
//! sites, r is the CDT distance of the k-th. If the query point is not a vertex, the search walks
//! to the nearest corner v of its triangle first, at distance d, and continues from there with
//! r + d in place of r.
//!
//! ```text
//!        P ╱ ╲          Why: let P be a path among the edges that are kept, no longer than r,
//!     ┌───x─────e──┐    that meets another edge e first at x. P and the edges C to the same
//!     q    ╲    v  s    site, no longer than l₁, form a loop of at most r(1+t). Edges cross
//!     └───────C────┘    neither C nor each other, and P does not cross e twice, or it would be
//!                       shorter along e. So an end v of e is in the loop, within half of its
//!                       length from x, and from q by way of P and e at most r + r(1+t)/2; by
//!                       CDT, t times that.
//! ```
//!
//! This implementation differs: C is known once all candidates are known. Sites with a Euclidean
//! distance above r are no candidates. Let c be the length of the longest C of the rest. Then the
//! ends are within t·(r + (r+c)/2), which is l₂ if c = l₁ and usually much less, and within a
//! Euclidean distance of (r+c)/2. So the search skips vertices from which no path to that disc is
//! short enough. An edge with a Euclidean distance above r is on no path of length r. Whole edges
//! count, not obstacles.

use foldhash::{HashMap, HashSet};

use super::context::{QueryContext, Wanted};
use super::local::{Local, Reached};
use super::nearby::distance_of_segment;
use super::obstacles::{ObstacleEdge, edges_at};
use super::stretch::Stretch;
use crate::query::answer::distance;
use crate::query::edges::{Corner, EdgeRun, Within};
use crate::query::free_space::{FreeSpace, Position, QueryPoint};
use crate::query::request::{Contradiction, QueryError};
use crate::store::{Tile, Vertex, VertexId};

/// The factor that covers the rounding errors of sums of lengths.
const MARGIN: f64 = 1.0 + 1e-9;

/// A vertex with sites, by CDT distance.
struct Site {
    vertex: Vertex,
    length: f64,
    sites: Vec<(u64, Option<String>)>,
}

/// What the search along edges has found.
#[derive(Default)]
struct Collected {
    sites: Vec<Site>,
    edges: HashMap<[VertexId; 2], ObstacleEdge>,
    met: HashSet<VertexId>,
}

impl Collected {
    fn site_count(&self) -> usize {
        self.sites.iter().map(|site| site.sites.len()).sum()
    }

    /// Notes the sites and edges at a vertex of a tile.
    fn take(&mut self, tile: &Tile, vertex: VertexId, length: f64, outside_is_free: bool) -> Result<(), Contradiction> {
        if !self.met.insert(vertex) {
            return Ok(());
        }
        let space = FreeSpace { tile, outside_is_free };
        edges_at(space, vertex.index, |edge| {
            self.edges.entry(edge.key()).or_insert(edge);
        })?;
        let sites: Vec<_> = tile
            .sites_at(vertex.index)
            .map(|site| (site.number, site.id.map(str::to_owned)))
            .collect();
        if !sites.is_empty() {
            self.sites.push(Site {
                vertex: tile.vertex(vertex.index),
                length,
                sites,
            });
        }
        Ok(())
    }
}

/// A search along edges, from the corner that replaces the source.
struct Walk {
    run: EdgeRun,
    /// The distance of the corner from the source.
    gap: f64,
    stretch: f64,
    collected: Collected,
    /// The next vertex, which was found but not noted yet.
    ahead: Option<(VertexId, f64)>,
    is_over: bool,
}

impl Walk {
    async fn start(context: &mut QueryContext, stretch: Stretch) -> Result<Self, QueryError> {
        let corners = corners(context).await?;
        let gap = corners
            .first()
            .map_or(0.0, |corner| distance(corner.point, context.source.point));
        let tiles = context.lend_tiles();
        let run = if corners.is_empty() {
            EdgeRun::start(tiles, context.source.clone()).await?
        } else {
            EdgeRun::from_corners(tiles, context.source.clone(), &corners).await?
        };
        let mut this = Self {
            run,
            gap,
            stretch: stretch.get(),
            collected: Collected::default(),
            ahead: None,
            is_over: false,
        };
        this.run.refuse_break_lines()?;
        Ok(this)
    }

    /// Continues to all vertices within a length, or until `sites` sites are found.
    async fn go(&mut self, limit: f64, sites: usize) -> Result<(), QueryError> {
        loop {
            if let Some((vertex, length)) = self.ahead {
                if length > limit * MARGIN {
                    return Ok(());
                }
                self.ahead = None;
                let outside_is_free = self.run.tiles.outside_is_free();
                let taken = self.collected.take(self.run.tile(), vertex, length, outside_is_free);
                taken.map_err(|reason| self.run.tiles.damaged(vertex.tile, reason))?;
                if self.collected.site_count() >= sites {
                    return Ok(());
                }
            }
            let next = self.run.next().await.map_err(|error| self.nothing_within(error))?;
            let Some(number) = next else {
                self.is_over = true;
                return Ok(());
            };
            let node = self.run.node(number);
            self.ahead = node.vertex.vertex().map(|vertex| (vertex, node.length));
        }
    }

    /// Replaces the lower bound of a limit error: from the corner, no site is nearer than the first
    /// along edges, divided by the stretch factor.
    fn nothing_within(&self, error: QueryError) -> QueryError {
        let QueryError::OutOfBudget { lower_bound } = error else {
            return error;
        };
        let first = self.collected.sites.first().map_or(lower_bound, |site| site.length);
        error.lower_bound((first / (self.stretch * MARGIN) - self.gap).max(0.0))
    }

    /// Collects what matters for sites within `radius`.
    async fn gather(&mut self, context: &QueryContext, radius: f64, longest: Longest<'_>) -> Result<Local, QueryError> {
        let stretch = self.stretch;
        let from_corner = radius + self.gap;
        let at = context.source.point;
        let is_near = |site: &Site| distance(site.vertex.point, at) <= radius * MARGIN;
        let (target, longest) = match longest {
            Longest::Of(to, length) => (Some(to), length),
            Longest::OfSites => {
                self.go(from_corner * stretch, usize::MAX).await?;
                let within = self.collected.sites.iter().filter(|site| is_near(site));
                (None, within.map(|site| site.length).fold(0.0, f64::max))
            }
        };
        let count = self.collected.sites.len();
        let half_loop = 0.5 * (from_corner + longest);
        let l2 = stretch * (from_corner + half_loop);
        self.run.search.narrow(l2 * MARGIN, at, half_loop * MARGIN);
        self.go(l2, usize::MAX).await?;
        let mut local = Local::new(&context.source, target);
        for edge in self.collected.edges.values() {
            if distance_of_segment(edge.ends.map(|end| end.point), at) <= radius * MARGIN {
                local.add_edge(edge);
            }
        }
        if target.is_none() {
            for site in self.collected.sites[..count].iter().filter(|site| is_near(site)) {
                local.add_candidate(site.vertex, site.sites.clone());
            }
        }
        Ok(local)
    }

    fn finish(self, context: &mut QueryContext) {
        context.statistics.edges_considered = self.collected.edges.len() as u64;
        context.tiles = self.run.tiles;
        context.clock.lap("collect");
    }
}

/// The length of the longest path along edges to a candidate.
enum Longest<'p> {
    /// To be determined from the sites.
    OfSites,
    /// The path to this target, with its length.
    Of(&'p QueryPoint, f64),
}

/// Returns the corner nearest to a source that is not a vertex, in each sector that contains the
/// source. Returns nothing if the source is a vertex.
async fn corners(context: &mut QueryContext) -> Result<Vec<Corner>, QueryError> {
    let at = context.source.point;
    let outside_is_free = context.tiles.outside_is_free();
    let nearest = |ends: &[Vertex]| {
        let by_distance = |a: &&Vertex, b: &&Vertex| distance(a.point, at).total_cmp(&distance(b.point, at));
        ends.iter().min_by(by_distance).copied()
    };
    let mut corners = Vec::new();
    let mut add = |vertex: Vertex, within| {
        corners.push(Corner {
            vertex: vertex.id.into(),
            point: vertex.point,
            within,
        });
    };
    match context.source.position {
        Position::Vertex(_) => {}
        Position::Triangle(triangle) => {
            let ends = triangle.vertices;
            if let Some(index) = (0..3).min_by(|&a, &b| {
                let far = |index: usize| distance(ends[index].point, at);
                far(a).total_cmp(&far(b))
            }) {
                add(ends[index], Within::RightOf(ends[(index + 2) % 3].id));
            }
        }
        Position::Edge { ends: [a, b] } => {
            let Some(corner) = nearest(&[a, b]) else {
                return Ok(corners);
            };
            for [from, to] in [[a, b], [b, a]] {
                match context.tiles.half_edge_between(from.id, to.id).await? {
                    Some((tile, half_edge)) if tile.is_hole(half_edge.triangle()) => {}
                    Some((tile, half_edge)) => {
                        let vertices = tile.vertices(half_edge.triangle());
                        if let Some(index) = vertices.iter().position(|vertex| vertex.id == corner.id) {
                            add(corner, Within::RightOf(vertices[(index + 2) % 3].id));
                        }
                    }
                    None if outside_is_free => add(corner, Within::Outside),
                    None => {}
                }
            }
        }
        Position::Outside(edge) => {
            let mut ends = Vec::new();
            for id in edge {
                let tile = context.tiles.get(id.tile).await?;
                if !tile.has_vertex(id.index) {
                    return Err(context.tiles.damaged(id.tile, Contradiction::NoVertex(id.index)));
                }
                ends.push(tile.vertex(id.index));
            }
            if let Some(corner) = nearest(&ends) {
                add(corner, Within::Outside);
            }
        }
    }
    Ok(corners)
}

/// Returns the nearest sites, or those within a radius.
pub(super) async fn sites(
    context: &mut QueryContext,
    stretch: Stretch,
    wanted: Wanted,
) -> Result<(Local, Vec<Reached>), QueryError> {
    let mut walk = Walk::start(context, stretch).await?;
    let radius = match wanted {
        Wanted::Within(radius) => radius,
        Wanted::Nearest(count) => {
            walk.go(f64::INFINITY, count).await?;
            walk.collected.sites.last().map_or(0.0, |site| site.length) + walk.gap
        }
    };
    let local = walk.gather(context, radius, Longest::OfSites).await?;
    walk.finish(context);
    let limit = match wanted {
        Wanted::Within(radius) => radius,
        Wanted::Nearest(_) => radius * MARGIN,
    };
    let found = local.nearest(wanted.count(), limit, context).await?;
    Ok((local, found))
}

/// Returns the shortest path to a target.
pub(super) async fn path(
    context: &mut QueryContext,
    stretch: Stretch,
    to: &QueryPoint,
) -> Result<Option<Reached>, QueryError> {
    let (mut run, end) = EdgeRun::towards(context.lend_tiles(), context.source.clone(), to, 1.0).await?;
    run.refuse_break_lines()?;
    let length = run.find(end).await?.map(|node| run.node(node).length);
    context.tiles = run.tiles;
    let Some(length) = length else {
        context.clock.lap("collect");
        return Ok(None);
    };
    let mut walk = Walk::start(context, stretch).await?;
    let longest = Longest::Of(to, length + walk.gap);
    let local = walk.gather(context, length, longest).await?;
    walk.finish(context);
    let found = local.target(length * MARGIN, context).await?;
    Ok(found)
}
