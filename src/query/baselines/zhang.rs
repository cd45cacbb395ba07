//! Zhang, Papadias, Mouratidis and Zhu, "Spatial queries in the presence of obstacles" (EDBT 2004): Euclidean distance prunes.
//!
//! The *k* nearest sites as the crow flies are the first candidates. The obstacle edges in the disc round the source that reaches to the
//! last of them make a local visibility graph; the distance to the k-th site in it is provisional. If that is beyond the disc, the disc
//! grows to it, with the candidates and edges that it meets then. A path within the disc meets no other edge, so what is
//! within is right. However, and always to its advantage: the unit is the edge, not the obstacle, so a large island costs only its shore
//! nearby; the triangulation is the index; one search serves all candidates of a round, where the paper makes one for each; and the
//! visibility graph is made only where that search comes, where the paper makes all of it.

use super::asked::{Asked, Wanted};
use super::local::{Gathered, Local, Reached};
use super::nearby::{Center, Met, Nearby};
use crate::query::answer::distance;
use crate::query::free_space::Place;
use crate::query::request::QueryError;

/// Things in a disc round the source.
struct Disc {
    local: Local,
    nearby: Nearby,
    radius: f64,
    /// All within so far is in it.
    known: f64,
}

impl Disc {
    async fn new(asked: &mut Asked, target: Option<&Place>) -> Result<Self, QueryError> {
        let center = Center::Point(asked.source.point);
        Ok(Self {
            local: Local::new(&asked.source, target),
            nearby: Nearby::start(&mut asked.tiles, &asked.source, center).await?,
            radius: 0.0,
            known: 0.0,
        })
    }

    /// Grows to a radius.
    async fn grow(&mut self, asked: &mut Asked, radius: f64) -> Result<(), QueryError> {
        self.radius = radius;
        self.grow_until(asked, usize::MAX).await
    }

    /// Grows until it has so many sites, or all that there are.
    async fn grow_to(&mut self, asked: &mut Asked, sites: usize) -> Result<(), QueryError> {
        self.radius = f64::INFINITY;
        self.grow_until(asked, sites).await
    }

    async fn grow_until(&mut self, asked: &mut Asked, sites: usize) -> Result<(), QueryError> {
        let mut count = 0u32;
        loop {
            count = count.wrapping_add(1);
            if count.is_multiple_of(1 << 10) {
                asked.pause().await?;
            }
            match self.nearby.next(&mut asked.tiles, self.radius).await? {
                Some(Met::Edge(edge)) => {
                    self.local.add_edge(&edge);
                }
                Some(Met::Sites(vertex, sites_here, far)) => {
                    self.local.add_candidate(vertex, sites_here);
                    if self.local.site_count() >= sites && self.radius > far {
                        // As far away, there may be more.
                        self.radius = far;
                    }
                }
                None => break,
            }
        }
        asked.statistics.edges_considered = self.nearby.walls.len() as u64;
        self.known = self.radius;
        Ok(())
    }

    /// Whether all that there is is in it.
    fn is_all(&self) -> bool {
        self.nearby.front() == f64::INFINITY
    }
}

/// What is certain of the sites so far: those within a distance.
#[derive(Default)]
struct Certain {
    found: Vec<Reached>,
    within: f64,
}

/// The nearest sites, or those within a radius.
pub(super) async fn sites(asked: &mut Asked, wanted: Wanted) -> Result<Gathered, QueryError> {
    let mut disc = Disc::new(asked, None).await?;
    let mut certain = Certain::default();
    match rounds(asked, wanted, &mut disc, &mut certain).await {
        Ok(found) => Ok(Gathered::all((disc.local, found))),
        Err(QueryError::OutOfBudget { .. }) => {
            let Certain { mut found, within } = certain;
            found.retain(|found| found.length <= within);
            Ok(Gathered {
                local: disc.local,
                reached: found,
                at_least: Some(within),
            })
        }
        Err(error) => Err(error),
    }
}

async fn rounds(
    asked: &mut Asked,
    wanted: Wanted,
    disc: &mut Disc,
    certain: &mut Certain,
) -> Result<Vec<Reached>, QueryError> {
    let count = wanted.count();
    match wanted {
        Wanted::Within(radius) => disc.grow(asked, radius).await?,
        Wanted::Nearest(count) => disc.grow_to(asked, count).await?,
    }
    loop {
        let found = disc.local.nearest(count, wanted.limit(), asked).await?;
        asked.pause().await?;
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
            disc.grow(asked, farthest).await?;
        } else {
            *certain = Certain {
                found,
                within: disc.known,
            };
            // Some cannot be reached, so others are wanted.
            let more = 2 * disc.local.site_count().max(1);
            disc.grow_to(asked, more).await?;
        }
    }
}

/// The shortest path to a target.
pub(super) async fn path(asked: &mut Asked, to: &Place) -> Result<Option<Reached>, QueryError> {
    let mut disc = Disc::new(asked, Some(to)).await?;
    let mut radius = distance(asked.source.point, to.point);
    loop {
        disc.grow(asked, radius).await?;
        let found = disc.local.target(f64::INFINITY, asked).await?;
        asked.pause().await?;
        match found {
            Some(found) if found.length > radius => radius = found.length,
            found => return Ok(found),
        }
    }
}
