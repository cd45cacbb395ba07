//! Answers by any method.

use super::asked::{Asked, Wanted};
use super::local::{Gathered, Reached};
use super::statistics::{Clock, Measured, Statistics};
use super::stretch::Stretch;
use crate::geometry::Point;
use crate::query::answer::{Distance, PathOutcome, SiteFound, distance};
use crate::query::baselines::{visibility, wave, xia, zhang};
use crate::query::free_space::Place;
use crate::query::request::{QueryError, QueryOptions, Tiles};
use crate::query::route;
use crate::store::TileReader;

/// How distances among obstacles are found. The answers are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Method {
    /// The wave: the library's own, and the fastest.
    #[default]
    Wave,
    /// The method of Wu's thesis: candidates and obstacle edges by CDT distance, and a local visibility graph.
    Visibility {
        /// What the CDT distance is of the walking distance at most: [`Stretch::PROVED`], unless someone proves less.
        stretch: Stretch,
    },
    /// Candidates by Euclidean distance, and the obstacle edges in a disc that grows to the distance of the last one (Zhang et al. 2004).
    EuclidZhang,
    /// Candidates by Euclidean distance, and those obstacle edges that provisional paths run into (Xia et al. 2004).
    EuclidXia,
}

async fn sites(asked: &mut Asked, method: Method, wanted: Wanted) -> Result<Gathered, QueryError> {
    asked.refuse_break_lines()?;
    let gathered = match method {
        Method::Visibility { stretch } => visibility::sites(asked, stretch, wanted).await.map(Gathered::all),
        Method::EuclidXia => xia::sites(asked, wanted).await.map(Gathered::all),
        // The wave has answered before it came to this.
        Method::EuclidZhang | Method::Wave => zhang::sites(asked, wanted).await,
    };
    match gathered {
        Err(QueryError::OutOfBudget { at_least }) => Ok(Gathered::nothing(&asked.source, at_least)),
        gathered => gathered,
    }
}

async fn path(asked: &mut Asked, method: Method, to: &Place) -> Result<Option<Reached>, QueryError> {
    asked.refuse_break_lines()?;
    match method {
        Method::Visibility { stretch } => visibility::path(asked, stretch, to).await,
        Method::EuclidXia => xia::path(asked, to).await,
        // The wave has answered before it came to this.
        Method::EuclidZhang | Method::Wave => zhang::path(asked, to).await,
    }
}

/// Puts a path to each site, as far as the options' limits allow: the sites from the first without one on are dropped, and the
/// distance of that one is returned. `way_to` is how a site was reached.
async fn put_paths<'a>(
    asked: &mut Asked,
    sites: &mut Vec<SiteFound>,
    way_to: impl Fn(&SiteFound) -> Option<&'a Reached>,
) -> Result<Option<f64>, QueryError> {
    let certify = asked.options.certify;
    let mut limit = None;
    let mut count = 0;
    for site in &mut *sites {
        if let Some(reached) = way_to(site) {
            let to = Place::at(site.vertex);
            let ends = [&asked.source, &to];
            match route::path(&mut asked.tiles, &reached.way, ends, reached.length, certify).await {
                Err(QueryError::OutOfBudget { .. }) => {
                    limit = Some(site.distance.lower);
                    break;
                }
                path => site.path = Some(path?),
            }
        }
        count += 1;
    }
    sites.truncate(count);
    asked.clock.lap("paths");
    Ok(limit)
}

impl TileReader {
    /// The `k` sites nearest to a point by walking distance, by any method, with what that cost. Of sites that are equally far away, as
    /// computed, the first by number.
    ///
    /// Where a stream will do, [`nearest_sites`](Self::nearest_sites) is the better one. If the options' limits are reached, the answer is what is
    /// certain by then: with the visibility method, and that of Xia et al., nothing.
    ///
    /// # Errors
    /// As [`nearest_sites`](Self::nearest_sites), but that of limits only if they are reached before the point is found; by other methods
    /// than the wave also [`QueryError::BreakLines`] if the file has any.
    pub async fn nearest_sites_by(
        &self,
        method: Method,
        at: Point,
        k: usize,
        options: QueryOptions,
    ) -> Result<Measured<Vec<SiteFound>>, QueryError> {
        self.sites_by(method, at, Wanted::Nearest(k), options).await
    }

    /// The sites whose walking distance from a point, as computed, is not larger than `radius`, by any method, with what that cost.
    ///
    /// # Errors
    /// As [`nearest_sites_by`](Self::nearest_sites_by).
    pub async fn sites_within_by(
        &self,
        method: Method,
        at: Point,
        radius: f64,
        options: QueryOptions,
    ) -> Result<Measured<Vec<SiteFound>>, QueryError> {
        self.sites_by(method, at, Wanted::Within(radius), options).await
    }

    pub(super) async fn sites_by(
        &self,
        method: Method,
        at: Point,
        wanted: Wanted,
        options: QueryOptions,
    ) -> Result<Measured<Vec<SiteFound>>, QueryError> {
        if method == Method::Wave {
            return wave::sites(self, at, wanted, options).await;
        }
        let mut clock = Clock::start();
        let mut tiles = Tiles::new(self, &options);
        let source = Place::find_free(&mut tiles, at).await?;
        clock.lap("locate");
        let mut asked = Asked::new(self, &options, tiles, source, clock);
        let Gathered {
            local,
            reached,
            mut at_least,
        } = sites(&mut asked, method, wanted).await?;
        let mut sites = Vec::new();
        for reached in &reached {
            let candidate = &local.candidates[reached.candidate];
            let distance = Distance::of_legs(reached.length, reached.way.len() - 1);
            sites.extend(candidate.sites.iter().map(|(number, id)| SiteFound {
                number: *number,
                id: id.clone(),
                vertex: candidate.vertex,
                distance,
                path: None,
            }));
        }
        sites.sort_by(|a, b| {
            let by_distance = a.distance.value.total_cmp(&b.distance.value);
            by_distance.then(a.number.cmp(&b.number))
        });
        sites.truncate(wanted.count());
        if options.paths {
            let way_to = |site: &SiteFound| {
                let mut reached = reached.iter();
                reached.find(|reached| local.candidates[reached.candidate].vertex == site.vertex)
            };
            at_least = put_paths(&mut asked, &mut sites, way_to).await?.or(at_least);
        }
        Ok(Measured {
            answer: sites,
            at_least,
            statistics: asked.finish(),
        })
    }

    /// A shortest path between two points, by any method, with what that cost.
    ///
    /// # Errors
    /// As [`shortest_path`](Self::shortest_path) and [`nearest_sites_by`](Self::nearest_sites_by).
    pub async fn shortest_path_by(
        &self,
        method: Method,
        from: Point,
        to: Point,
        options: QueryOptions,
    ) -> Result<Measured<PathOutcome>, QueryError> {
        let mut clock = Clock::start();
        let mut tiles = Tiles::new(self, &options);
        let places = [Place::find(&mut tiles, from).await?, Place::find(&mut tiles, to).await?];
        for (place, point) in places.iter().zip([from, to]) {
            if !place.is_free {
                let nearest_free = place.nearest_free(&mut tiles).await?;
                return Ok(Measured {
                    answer: PathOutcome::InsideObstacle { point, nearest_free },
                    at_least: None,
                    statistics: Statistics::default(),
                });
            }
        }
        let [source, to] = places;
        clock.lap("locate");
        if method == Method::Wave {
            return wave::path(self, [source, to], tiles, clock, options).await;
        }
        let mut asked = Asked::new(self, &options, tiles, source, clock);
        // No path is shorter than the straight line.
        let straight = distance(asked.source.point, to.point);
        let found = path(&mut asked, method, &to)
            .await
            .map_err(|error| error.at_least(straight));
        let answer = match found? {
            Some(reached) => {
                let ends = [&asked.source, &to];
                let path = route::path(&mut asked.tiles, &reached.way, ends, reached.length, options.certify).await?;
                asked.clock.lap("paths");
                PathOutcome::Found(path)
            }
            None => PathOutcome::Unreachable,
        };
        Ok(Measured {
            answer,
            at_least: None,
            statistics: asked.finish(),
        })
    }
}
