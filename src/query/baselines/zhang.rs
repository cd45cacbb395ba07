//! The method of Zhang, Papadias, Mouratidis and Zhu, "Spatial queries in the presence of
//! obstacles" (EDBT 2004): Euclidean distance prunes.
//!
//! The *k* nearest sites by Euclidean distance are the first candidates. The obstacle edges in the
//! disc round the source that reaches to the last of them form a local visibility graph. The
//! distance of the k-th site in that graph is provisional. If it is beyond the disc, the disc grows
//! to that distance, with the candidates and edges that it then meets. A path within the disc meets
//! no other edge, so the distances within it are correct. This implementation differs, always in
//! favour of the method: the unit is the edge, not the obstacle, so a large island costs only its
//! shore nearby; the triangulation is the index; one search serves all candidates of a round, where
//! the paper makes one for each; and only the part of the visibility graph that this search reaches
//! is built, where the paper builds all of it.

use super::context::{QueryContext, Wanted};
use super::local::{Gathered, Local, Reached};
use super::nearby::{Center, Met, Nearby};
use crate::query::answer::distance;
use crate::query::free_space::QueryPoint;
use crate::query::request::QueryError;

/// The candidates and edges in a disc round the source.
struct Disc {
    local: Local,
    nearby: Nearby,
    radius: f64,
    /// The radius within which everything is included.
    known: f64,
}

impl Disc {
    async fn new(context: &mut QueryContext, target: Option<&QueryPoint>) -> Result<Self, QueryError> {
        let center = Center::Point(context.source.point);
        Ok(Self {
            local: Local::new(&context.source, target),
            nearby: Nearby::start(&mut context.tiles, &context.source, center).await?,
            radius: 0.0,
            known: 0.0,
        })
    }

    /// Grows the disc to a radius.
    async fn grow(&mut self, context: &mut QueryContext, radius: f64) -> Result<(), QueryError> {
        self.radius = radius;
        self.grow_until(context, usize::MAX).await
    }

    /// Grows the disc until it has `sites` sites, or everything.
    async fn grow_to(&mut self, context: &mut QueryContext, sites: usize) -> Result<(), QueryError> {
        self.radius = f64::INFINITY;
        self.grow_until(context, sites).await
    }

    async fn grow_until(&mut self, context: &mut QueryContext, sites: usize) -> Result<(), QueryError> {
        let mut count = 0u32;
        loop {
            count = count.wrapping_add(1);
            if count.is_multiple_of(1 << 10) {
                context.pause().await?;
            }
            match self.nearby.next(&mut context.tiles, self.radius).await? {
                Some(Met::Edge(edge)) => {
                    self.local.add_edge(&edge);
                }
                Some(Met::Sites(vertex, sites_here, far)) => {
                    self.local.add_candidate(vertex, sites_here);
                    if self.local.site_count() >= sites && self.radius > far {
                        // There may be more sites at the same distance.
                        self.radius = far;
                    }
                }
                None => break,
            }
        }
        context.statistics.edges_considered = self.nearby.walls.len() as u64;
        self.known = self.radius;
        Ok(())
    }

    /// Returns whether the disc contains everything.
    fn is_all(&self) -> bool {
        self.nearby.front() == f64::INFINITY
    }
}

/// The sites that are certain so far: those within a distance.
#[derive(Default)]
struct Certain {
    found: Vec<Reached>,
    within: f64,
}

/// Returns the nearest sites, or those within a radius.
pub(super) async fn sites(context: &mut QueryContext, wanted: Wanted) -> Result<Gathered, QueryError> {
    let mut disc = Disc::new(context, None).await?;
    let mut certain = Certain::default();
    match rounds(context, wanted, &mut disc, &mut certain).await {
        Ok(found) => Ok(Gathered::all((disc.local, found))),
        Err(QueryError::OutOfBudget { .. }) => {
            let Certain { mut found, within } = certain;
            found.retain(|found| found.length <= within);
            Ok(Gathered {
                local: disc.local,
                reached: found,
                lower_bound: Some(within),
            })
        }
        Err(error) => Err(error),
    }
}

async fn rounds(
    context: &mut QueryContext,
    wanted: Wanted,
    disc: &mut Disc,
    certain: &mut Certain,
) -> Result<Vec<Reached>, QueryError> {
    let count = wanted.count();
    match wanted {
        Wanted::Within(radius) => disc.grow(context, radius).await?,
        Wanted::Nearest(count) => disc.grow_to(context, count).await?,
    }
    loop {
        let found = disc.local.nearest(count, wanted.limit(), context).await?;
        context.pause().await?;
        if matches!(wanted, Wanted::Within(_)) {
            return Ok(found);
        }
        let reached = found
            .iter()
            .map(|found| disc.local.candidates[found.candidate].sites.len());
        let is_enough = reached.sum::<usize>() >= count;
        let farthest = found.last().map_or(0.0, |found| found.length);
        if is_enough || disc.is_all() {
            if farthest <= disc.radius {
                return Ok(found);
            }
            *certain = Certain {
                found,
                within: disc.known,
            };
            disc.grow(context, farthest).await?;
        } else {
            *certain = Certain {
                found,
                within: disc.known,
            };
            // Some candidates cannot be reached, so more are needed.
            let more = 2 * disc.local.site_count().max(1);
            disc.grow_to(context, more).await?;
        }
    }
}

/// Returns the shortest path to a target.
pub(super) async fn path(context: &mut QueryContext, to: &QueryPoint) -> Result<Option<Reached>, QueryError> {
    let mut disc = Disc::new(context, Some(to)).await?;
    let mut radius = distance(context.source.point, to.point);
    loop {
        disc.grow(context, radius).await?;
        let found = disc.local.target(f64::INFINITY, context).await?;
        context.pause().await?;
        match found {
            Some(found) if found.length > radius => radius = found.length,
            found => return Ok(found),
        }
    }
}
