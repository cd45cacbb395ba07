//! The nearest sites by searches that aim.
//!
//! No site is nearer by walking than by Euclidean distance. So the sites that are nearest by
//! Euclidean distance are candidates; their walking distances are found by searches that aim
//! ([`aimed`](crate::query::aimed)). The *k*-th shortest of them is an upper bound, and all other
//! sites within it by Euclidean distance are candidates, too (Zhao, Taniar and Harabor, SoCS 2018).
//!
//! Where sites are sparse, this is much less work than a wavefront to everything up to the *k*-th
//! site. Where they are dense, the wavefront is less. In a labyrinth, Euclidean distances say
//! little: then the searches that aim give up, and the wavefront starts after all.

use std::collections::HashSet;

use super::candidates::Candidates;
use crate::query::aimed::{Expectation, passes};
use crate::query::answer::{Distance, SiteFound};
use crate::query::euclidean::EuclideanSearch;
use crate::query::free_space::QueryPoint;
use crate::query::request::{QueryError, QueryOptions, Search, Tiles};
use crate::store::{Tile, TileReader};

/// The number of triangles that searches that aim may pass before they give up, besides as many as
/// the wavefront is expected to pass.
const TRIAL: f64 = 20_000.0;
/// More sites than this within the upper bound are too many, besides four times as many as wanted.
const MANY: usize = 64;
/// The part of a site's work that is left if searches for several sites are one search.
const SHARED: f64 = 0.6;

/// The nearest sites, nearest first, and the error that ended the search for more.
pub(super) struct NearestSites {
    pub(super) sites: Vec<SiteFound>,
    pub(super) failed: Option<QueryError>,
}

/// The outcome of a search for the nearest sites.
pub(super) enum Outcome {
    Found(NearestSites),
    /// A wavefront should find them.
    Wavefront(Option<Tiles>),
}

/// Returns the first sites as the options request, unless a wavefront should find them. `source` is
/// in the tile that was used last.
pub(super) async fn first_sites(
    reader: &TileReader,
    mut tiles: Tiles,
    source: &QueryPoint,
    options: &QueryOptions,
) -> Result<Outcome, QueryError> {
    let Some(count) = options.first.filter(|_| options.search != Search::Wavefront) else {
        return Ok(Outcome::Wavefront(Some(tiles)));
    };
    let tile = tiles.last().await?;
    let wavefront = wavefront_to(count, &tile);
    if options.search == Search::Auto && wavefront < aimed_at(count, &tile) {
        return Ok(Outcome::Wavefront(Some(tiles)));
    }
    let most = match options.search {
        Search::Aimed => u64::MAX,
        _ => (wavefront + TRIAL) as u64,
    };
    let expectation = Expectation::new(tiles.density_at(tile.id()));
    let search = NearestSearch {
        count,
        most,
        euclidean: EuclideanSearch::new(reader, source.point, true),
        candidates: Candidates::new(source.clone(), expectation, options.clone()),
        tiles: Some(tiles),
    };
    search.run().await
}

/// Returns the number of triangles per site in a tile.
fn triangles_per_site(tile: &Tile) -> f64 {
    f64::from(tile.triangle_count()) / f64::from(tile.site_count()).max(0.5)
}

/// Returns the number of triangles that a wavefront to the nearest sites is expected to pass.
fn wavefront_to(count: usize, tile: &Tile) -> f64 {
    passes(1.2 * triangles_per_site(tile) * count as f64)
}

/// Returns the same of searches that aim: the sum over the sites of ellipses and the triangles
/// along the way.
fn aimed_at(count: usize, tile: &Tile) -> f64 {
    let (each, count) = (triangles_per_site(tile), count as f64);
    let ellipses = 2.3 * 0.116 * each * count * (count + 1.0) / 2.0;
    let ways = 2.3 * 1.1 * each.sqrt() * count.powf(1.5) * 2.0 / 3.0;
    let start = 200.0 * count;
    (ellipses + ways + start) * if count > 4.0 { SHARED } else { 1.0 }
}

struct NearestSearch {
    count: usize,
    most: u64,
    euclidean: EuclideanSearch,
    candidates: Candidates,
    tiles: Option<Tiles>,
}

impl NearestSearch {
    async fn run(mut self) -> Result<Outcome, QueryError> {
        let found = match self.search().await {
            Ok(true) => self.answer(f64::INFINITY, None),
            Ok(false) => return Ok(Outcome::Wavefront(self.tiles)),
            Err(QueryError::OutOfBudget { .. }) => {
                // Sites that are nearer than all that are not known are known to be the nearest.
                let bound = self.candidates.bound().min(self.euclidean.bound());
                let lower_bound = Distance::of_legs(bound, 1).lower;
                self.answer(lower_bound, Some(QueryError::OutOfBudget { lower_bound }))
            }
            Err(error) => return Err(error),
        };
        Ok(Outcome::Found(found))
    }

    /// Finds the nearest sites. Returns whether they were found with the work allowed.
    async fn search(&mut self) -> Result<bool, QueryError> {
        let mut wanted = self.count;
        loop {
            while self.candidates.len() < wanted && self.add_candidate().await? {}
            if !self.reach(f64::INFINITY).await? {
                return Ok(false);
            }
            let missing = self.count.saturating_sub(self.candidates.found());
            if missing == 0 || self.euclidean.bound() == f64::INFINITY {
                break;
            }
            // Some candidates cannot be reached.
            wanted = self.candidates.len().saturating_add(missing);
        }
        // Everything that is pruned is longer, despite rounding.
        let limit = self.candidates.length(self.count) * (1.0 + 1e-9);
        let many = self
            .count
            .saturating_mul(3)
            .saturating_add(self.candidates.len() + MANY);
        while self.euclidean.bound() <= limit && self.add_candidate().await? {
            if self.candidates.len() > many && self.most < u64::MAX {
                return Ok(false);
            }
        }
        self.reach(limit).await
    }

    /// Adds the next site by Euclidean distance. Returns whether there is one.
    async fn add_candidate(&mut self) -> Result<bool, QueryError> {
        let Some(tiles) = &mut self.tiles else { return Ok(false) };
        let Some(near) = self.euclidean.next(tiles).await? else {
            return Ok(false);
        };
        self.candidates.add(tiles, near).await?;
        Ok(true)
    }

    /// Finds the distances of the candidates. Returns whether that took no more work than allowed.
    async fn reach(&mut self, limit: f64) -> Result<bool, QueryError> {
        let Some(tiles) = self.tiles.take() else {
            return Ok(false);
        };
        let (tiles, is_complete) = self.candidates.reach(tiles, limit, self.most).await?;
        self.tiles = tiles;
        Ok(is_complete)
    }

    /// Returns the sites whose distance is at most `limit`.
    fn answer(self, limit: f64, failed: Option<QueryError>) -> NearestSites {
        let mut numbers = HashSet::new();
        let mut sites = self.candidates.sites(limit);
        sites.sort_by_key(|site| (site.distance.value.to_bits(), site.number));
        // As in a wavefront, a number stands for one site.
        sites.retain(|site| numbers.insert(site.number));
        sites.truncate(self.count);
        let failed = failed.filter(|_| sites.len() < self.count);
        NearestSites { sites, failed }
    }
}
