//! Answers by any method.

use super::context::{QueryContext, Wanted};
use super::local::{Gathered, Reached};
use super::statistics::{Clock, Measured, Statistics};
use super::stretch::Stretch;
use crate::geometry::Point;
use crate::query::answer::{Distance, PathOutcome, SiteFound, distance};
use crate::query::baselines::{visibility, wavefront, xia, zhang};
use crate::query::free_space::QueryPoint;
use crate::query::request::{QueryError, QueryOptions, Tiles};
use crate::query::route;
use crate::store::TileReader;

/// A method to find distances among obstacles. All methods give the same answers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Method {
    /// The wavefront: the method of this library, and the fastest.
    #[default]
    Wavefront,
    /// The method of Wu's thesis: candidates and obstacle edges by CDT distance, and a local
    /// visibility graph.
    Visibility {
        /// An upper bound of the ratio of CDT distance to walking distance: [`Stretch::PROVED`],
        /// unless a lower one is proved.
        stretch: Stretch,
    },
    /// Candidates by Euclidean distance, and the obstacle edges in a disc that grows to the
    /// distance of the last one (Zhang et al. 2004).
    EuclidZhang,
    /// Candidates by Euclidean distance, and the obstacle edges that provisional paths cross (Xia
    /// et al. 2004).
    EuclidXia,
}

async fn sites(context: &mut QueryContext, method: Method, wanted: Wanted) -> Result<Gathered, QueryError> {
    context.refuse_break_lines()?;
    let gathered = match method {
        Method::Visibility { stretch } => visibility::sites(context, stretch, wanted).await.map(Gathered::all),
        Method::EuclidXia => xia::sites(context, wanted).await.map(Gathered::all),
        // The wavefront has returned its answer before.
        Method::EuclidZhang | Method::Wavefront => zhang::sites(context, wanted).await,
    };
    match gathered {
        Err(QueryError::OutOfBudget { lower_bound }) => Ok(Gathered::nothing(&context.source, lower_bound)),
        gathered => gathered,
    }
}

async fn path(context: &mut QueryContext, method: Method, to: &QueryPoint) -> Result<Option<Reached>, QueryError> {
    context.refuse_break_lines()?;
    match method {
        Method::Visibility { stretch } => visibility::path(context, stretch, to).await,
        Method::EuclidXia => xia::path(context, to).await,
        // The wavefront has returned its answer before.
        Method::EuclidZhang | Method::Wavefront => zhang::path(context, to).await,
    }
}

/// Adds a path to each site, as far as the options' limits allow. Drops the sites from the first
/// one without a path on, and returns the distance of that one. `way_to` returns how a site was
/// reached.
async fn put_paths<'a>(
    context: &mut QueryContext,
    sites: &mut Vec<SiteFound>,
    way_to: impl Fn(&SiteFound) -> Option<&'a Reached>,
) -> Result<Option<f64>, QueryError> {
    let certify = context.options.certify;
    let mut limit = None;
    let mut count = 0;
    for site in &mut *sites {
        if let Some(reached) = way_to(site) {
            let to = QueryPoint::at(site.vertex);
            let ends = [&context.source, &to];
            match route::path(&mut context.tiles, &reached.way, ends, reached.length, certify).await {
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
    context.clock.lap("paths");
    Ok(limit)
}

impl TileReader {
    /// Returns the `k` sites nearest to a point by walking distance, by any method, with the cost.
    /// Sites with equal computed distances are ordered by number.
    ///
    /// If a stream suffices, prefer [`nearest_sites`](Self::nearest_sites). If a limit of the
    /// options is reached, the answer has what is certain by then: nothing with the visibility
    /// method and that of Xia et al.
    ///
    /// # Errors
    /// As [`nearest_sites`](Self::nearest_sites), but a limit is an error only if it is reached
    /// before the point is located. All methods except the wavefront also return
    /// [`QueryError::BreakLines`] if the file has break lines.
    pub async fn nearest_sites_by(
        &self,
        method: Method,
        at: Point,
        k: usize,
        options: QueryOptions,
    ) -> Result<Measured<Vec<SiteFound>>, QueryError> {
        self.sites_by(method, at, Wanted::Nearest(k), options).await
    }

    /// Returns the sites whose computed walking distance from a point is at most `radius`, by any
    /// method, with the cost.
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
        if method == Method::Wavefront {
            return wavefront::sites(self, at, wanted, options).await;
        }
        let mut clock = Clock::start();
        let mut tiles = Tiles::new(self, &options);
        let source = QueryPoint::find_free(&mut tiles, at).await?;
        clock.lap("locate");
        let mut context = QueryContext::new(self, &options, tiles, source, clock);
        let Gathered {
            local,
            reached,
            mut lower_bound,
        } = sites(&mut context, method, wanted).await?;
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
            lower_bound = put_paths(&mut context, &mut sites, way_to).await?.or(lower_bound);
        }
        Ok(Measured {
            answer: sites,
            lower_bound,
            statistics: context.finish(),
        })
    }

    /// Returns a shortest path between two points, by any method, with the cost.
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
        let query_points = [
            QueryPoint::find(&mut tiles, from).await?,
            QueryPoint::find(&mut tiles, to).await?,
        ];
        for (query_point, point) in query_points.iter().zip([from, to]) {
            if !query_point.is_free {
                let nearest_free = query_point.nearest_free(&mut tiles).await?;
                return Ok(Measured {
                    answer: PathOutcome::InsideObstacle { point, nearest_free },
                    lower_bound: None,
                    statistics: Statistics::default(),
                });
            }
        }
        let [source, to] = query_points;
        clock.lap("locate");
        if method == Method::Wavefront {
            return wavefront::path(self, [source, to], tiles, clock, options).await;
        }
        let mut context = QueryContext::new(self, &options, tiles, source, clock);
        // No path is shorter than the straight line.
        let straight = distance(context.source.point, to.point);
        let found = path(&mut context, method, &to)
            .await
            .map_err(|error| error.lower_bound(straight));
        let answer = match found? {
            Some(reached) => {
                let ends = [&context.source, &to];
                let path = route::path(&mut context.tiles, &reached.way, ends, reached.length, options.certify).await?;
                context.clock.lap("paths");
                PathOutcome::Found(path)
            }
            None => PathOutcome::Unreachable,
        };
        Ok(Measured {
            answer,
            lower_bound: None,
            statistics: context.finish(),
        })
    }
}
