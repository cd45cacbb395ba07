//! S.-W. Wu's thesis (I/O-Efficient Algorithm for Constrained Delaunay Triangulation with Applications to Proximity Search, NUS 2004):
//! CDT distance prunes, and a local visibility graph finds what is left.
//!
//! With *t* what the CDT distance is of the walking distance at most, and *r* what the walking distance of the wanted sites is at
//! most: they are among those within CDT distance l₁ = r·t, and the obstacle edges that matter have an end within l₂ = r·t(t+3)/2.
//! For k nearest, r is the CDT distance of the k-th. From a query point that is no vertex one walks to the nearest corner v of
//! its triangle first, d away, and searches from there with r + d in place of r.
//!
//! ```text
//!        P ╱ ╲            Why: say a path P among the edges that are kept, no longer than r, meets another edge e first at x. P and the
//!     ┌───x─────e──┐      edges C to the same site, no longer than l₁, make a loop of at most r(1+t). Edges cross neither C nor each
//!     q    ╲    v  s      other, and P does not cross e twice, or it would be shorter along e. So an end v of e lies in the loop,
//!     └───────C────┘      within half of its length from x, and from q by way of P and e: at most r + r(1+t)/2, by CDT t times that.
//! ```
//!
//! However: C is known when all candidates are. No site that is farther away than r as the crow flies is one; with c, the longest of the
//! rest, the ends lie within t·(r + (r+c)/2), which is l₂ where c = l₁ and mostly much less, and within (r+c)/2 as the crow flies,
//! so that the search need not go where no way to there is short enough. And an edge that is farther away than r as the crow flies
//! is on no path of length r. Whole edges count, not obstacles.

use foldhash::{HashMap, HashSet};

use super::asked::{Asked, Wanted};
use super::local::{Local, Reached};
use super::nearby::distance_of_segment;
use super::obstacles::{ObstacleEdge, edges_at};
use super::stretch::Stretch;
use crate::query::answer::distance;
use crate::query::edges::{Corner, EdgeRun, Within};
use crate::query::free_space::{Ground, Place, Spot};
use crate::query::request::{Contradiction, QueryError};
use crate::store::{Tile, Vertex, VertexId};

/// Sums of lengths may be less than they are by no more than this part.
const MARGIN: f64 = 1.0 + 1e-9;

/// Vertices with sites, by CDT distance.
struct Site {
    vertex: Vertex,
    length: f64,
    sites: Vec<(u64, Option<String>)>,
}

/// What was met along edges.
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
        let ground = Ground { tile, outside_is_free };
        edges_at(ground, vertex.index, |edge| {
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

/// A search along edges, from the corner that stands for the source.
struct Walk {
    run: EdgeRun,
    /// How far the corner is from the source.
    gap: f64,
    stretch: f64,
    collected: Collected,
    /// The next vertex, which was found but not noted.
    ahead: Option<(VertexId, f64)>,
    is_over: bool,
}

impl Walk {
    async fn start(asked: &mut Asked, stretch: Stretch) -> Result<Self, QueryError> {
        let corners = corners(asked).await?;
        let gap = corners
            .first()
            .map_or(0.0, |corner| distance(corner.point, asked.source.point));
        let tiles = asked.lend_tiles();
        let run = if corners.is_empty() {
            EdgeRun::start(tiles, asked.source.clone(), f64::INFINITY).await?
        } else {
            EdgeRun::from_corners(tiles, asked.source.clone(), &corners).await?
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

    /// Goes on to all within a length, or until there are so many sites.
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

    /// What is known when a budget is used up: from the corner no site is nearer than the first along edges, divided by the stretch factor.
    fn nothing_within(&self, error: QueryError) -> QueryError {
        let QueryError::OutOfBudget { at_least } = error else {
            return error;
        };
        let first = self.collected.sites.first().map_or(at_least, |site| site.length);
        error.at_least((first / (self.stretch * MARGIN) - self.gap).max(0.0))
    }

    /// Gathers what matters for sites within `radius`.
    async fn gather(&mut self, asked: &Asked, radius: f64, longest: Longest<'_>) -> Result<Local, QueryError> {
        let stretch = self.stretch;
        let from_corner = radius + self.gap;
        let at = asked.source.point;
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
        let mut local = Local::new(&asked.source, target);
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

    fn finish(self, asked: &mut Asked) {
        asked.statistics.edges_considered = self.collected.edges.len() as u64;
        asked.tiles = self.run.tiles;
        asked.clock.lap("collect");
    }
}

/// What the longest way along edges to a candidate is.
enum Longest<'p> {
    /// To be found among the sites.
    OfSites,
    /// That to a target.
    Of(&'p Place, f64),
}

/// The corner nearest to a source that is no vertex, in each sector that the source lies in; none if it is one.
async fn corners(asked: &mut Asked) -> Result<Vec<Corner>, QueryError> {
    let at = asked.source.point;
    let outside_is_free = asked.tiles.outside_is_free();
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
    match asked.source.spot {
        Spot::Vertex(_) => {}
        Spot::Triangle(triangle) => {
            let ends = triangle.vertices;
            if let Some(place) = (0..3).min_by(|&a, &b| {
                let far = |place: usize| distance(ends[place].point, at);
                far(a).total_cmp(&far(b))
            }) {
                add(ends[place], Within::RightOf(ends[(place + 2) % 3].id));
            }
        }
        Spot::Edge { ends: [a, b] } => {
            let Some(corner) = nearest(&[a, b]) else {
                return Ok(corners);
            };
            for [from, to] in [[a, b], [b, a]] {
                match asked.tiles.side_between(from.id, to.id).await? {
                    Some((tile, side)) if tile.is_hole(side.triangle()) => {}
                    Some((tile, side)) => {
                        let vertices = tile.vertices(side.triangle());
                        if let Some(place) = vertices.iter().position(|vertex| vertex.id == corner.id) {
                            add(corner, Within::RightOf(vertices[(place + 2) % 3].id));
                        }
                    }
                    None if outside_is_free => add(corner, Within::Outside),
                    None => {}
                }
            }
        }
        Spot::Outside(edge) => {
            let mut ends = Vec::new();
            for id in edge {
                let tile = asked.tiles.get(id.tile).await?;
                if !tile.has_vertex(id.index) {
                    return Err(asked.tiles.damaged(id.tile, Contradiction::NoVertex(id.index)));
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

/// The nearest sites, or those within a radius.
pub(super) async fn sites(
    asked: &mut Asked,
    stretch: Stretch,
    wanted: Wanted,
) -> Result<(Local, Vec<Reached>), QueryError> {
    let mut walk = Walk::start(asked, stretch).await?;
    let radius = match wanted {
        Wanted::Within(radius) => radius,
        Wanted::Nearest(count) => {
            walk.go(f64::INFINITY, count).await?;
            walk.collected.sites.last().map_or(0.0, |site| site.length) + walk.gap
        }
    };
    let local = walk.gather(asked, radius, Longest::OfSites).await?;
    walk.finish(asked);
    let limit = match wanted {
        Wanted::Within(radius) => radius,
        Wanted::Nearest(_) => radius * MARGIN,
    };
    let found = local.nearest(wanted.count(), limit, asked).await?;
    Ok((local, found))
}

/// The shortest path to a target.
pub(super) async fn path(asked: &mut Asked, stretch: Stretch, to: &Place) -> Result<Option<Reached>, QueryError> {
    let (mut run, end) = EdgeRun::towards(asked.lend_tiles(), asked.source.clone(), to, 1.0).await?;
    run.refuse_break_lines()?;
    let length = run.find(end).await?.map(|node| run.node(node).length);
    asked.tiles = run.tiles;
    let Some(length) = length else {
        asked.clock.lap("collect");
        return Ok(None);
    };
    let mut walk = Walk::start(asked, stretch).await?;
    let longest = Longest::Of(to, length + walk.gap);
    let local = walk.gather(asked, length, longest).await?;
    walk.finish(asked);
    let found = local.target(length * MARGIN, asked).await?;
    Ok(found)
}
