//! Other ways to the same answers: the method of Wu's thesis, and those that it compares with; and what each of them costs.
//!
//! ```text
//!   visibility ──▶ edges      sites and obstacle edges by CDT distance          (Wu 2004)
//!   zhang ───────▶ nearby     by Euclidean distance, in a disc that grows       (Zhang, Papadias, Mouratidis, Zhu, EDBT 2004)
//!   xia ─────────▶ nearby     those that provisional paths run into             (Xia, Hsu, Tung, BNCOD 2004)
//!     │
//!     └──▶ local ──▶ query::visibility     what all of them ask of the few edges that they have
//! ```
//!
//! Each finds sites, and obstacle edges that paths to them may have to go round, and then shortest paths among these. They are here
//! to be measured against the [`wave`](super::wave), which needs none of it. All of them refuse files with break lines.

mod local;
mod nearby;
mod obstacles;
mod statistics;
#[cfg(test)]
mod tests;
mod visibility;
mod wave;
mod xia;
mod zhang;

use foldhash::{HashSet, HashSetExt};

use super::edges::BreakLines;
use super::place::Place;
use super::proximity::{Distance, PathOutcome, SiteFound};
use super::route;
use super::tiles::Tiles;
use super::wave::distance;
use super::{QueryError, QueryOptions};
use crate::geometry::Point;
use crate::store::{TileReader, VertexId};
use local::{Local, Reached};
use statistics::Clock;
pub use statistics::{Statistics, StepTime};

/// How distances among obstacles are found. The answers are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Method {
    /// The wave: the library's own, and the fastest.
    #[default]
    Wave,
    /// The method of Wu's thesis: candidates and obstacle edges by CDT distance, and a local visibility graph.
    Visibility {
        /// What the CDT distance is of the walking distance at most: [`Method::STRETCH`], unless someone proves less; at least
        /// [`Method::LEAST_STRETCH`].
        stretch: f64,
    },
    /// Candidates by Euclidean distance, and the obstacle edges in a disc that grows to the distance of the last one (Zhang et al. 2004).
    EuclidZhang,
    /// Candidates by Euclidean distance, and those obstacle edges that provisional paths run into (Xia et al. 2004).
    EuclidXia,
}

impl Method {
    /// A stretch factor that is proved: 4π√3/9, rounded up (Bose and Keil, "On the stretch factor of the constrained Delaunay
    /// triangulation", ISVD 2006).
    pub const STRETCH: f64 = 2.42;
    /// No stretch factor can be less: there are points whose Delaunay triangulation stretches a distance by so much (Xia and Zhang,
    /// "Toward the tight bound of the stretch factor of Delaunay triangulations", CCCG 2011).
    pub const LEAST_STRETCH: f64 = 1.5932;
}

/// An answer, and what it cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured<T> {
    /// The answer; as far as it was found, if the options' limits were reached.
    pub answer: T,
    /// If the options' limits were reached: all that the answer lacks is at least as far away.
    pub at_least: Option<f64>,
    /// What it cost.
    pub statistics: Statistics,
}

/// What a method found.
struct Gathered {
    local: Local,
    reached: Vec<Reached>,
    /// If a budget was used up: the sites that are not there are at least as far away.
    at_least: Option<f64>,
}

impl Gathered {
    fn all((local, reached): (Local, Vec<Reached>)) -> Self {
        Self {
            local,
            reached,
            at_least: None,
        }
    }

    /// No sites, before a budget was used up.
    fn nothing(source: &Place, at_least: f64) -> Self {
        Self {
            local: Local::new(source, None),
            reached: Vec::new(),
            at_least: Some(at_least),
        }
    }
}

/// Which sites are wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Wanted {
    /// So many, the nearest.
    Nearest(usize),
    /// Those within a distance.
    Within(f64),
}

impl Wanted {
    fn count(self) -> usize {
        match self {
            Self::Nearest(count) => count,
            Self::Within(_) => usize::MAX,
        }
    }

    fn limit(self) -> f64 {
        match self {
            Self::Nearest(_) => f64::INFINITY,
            Self::Within(radius) => radius,
        }
    }
}

/// A question on its way.
struct Asked {
    reader: TileReader,
    options: QueryOptions,
    tiles: Tiles,
    source: Place,
    clock: Clock,
    statistics: Statistics,
    /// Obstacle edges that were looked at, where they are not counted otherwise.
    considered: HashSet<[VertexId; 2]>,
}

impl Asked {
    /// Refuses files with break lines.
    fn refuse_break_lines(&self) -> Result<(), QueryError> {
        match BreakLines::of(self.tiles.metadata()) {
            BreakLines::Yes => Err(self.tiles.break_lines()),
            // Those that a file does not tell of are met.
            BreakLines::No | BreakLines::Unknown => Ok(()),
        }
    }

    async fn sites(&mut self, method: Method, wanted: Wanted) -> Result<Gathered, QueryError> {
        self.refuse_break_lines()?;
        let gathered = match method {
            Method::Visibility { stretch } => visibility::sites(self, stretch, wanted).await.map(Gathered::all),
            Method::EuclidXia => xia::sites(self, wanted).await.map(Gathered::all),
            // The wave has answered before it came to this.
            Method::EuclidZhang | Method::Wave => zhang::sites(self, wanted).await,
        };
        match gathered {
            Err(QueryError::OutOfBudget { at_least }) => Ok(Gathered::nothing(&self.source, at_least)),
            gathered => gathered,
        }
    }

    async fn path(&mut self, method: Method, to: &Place) -> Result<Option<Reached>, QueryError> {
        self.refuse_break_lines()?;
        match method {
            Method::Visibility { stretch } => visibility::path(self, stretch, to).await,
            Method::EuclidXia => xia::path(self, to).await,
            // The wave has answered before it came to this.
            Method::EuclidZhang | Method::Wave => zhang::path(self, to).await,
        }
    }
}

/// Whether a method can be used.
fn check(method: Method) -> Result<(), QueryError> {
    match method {
        Method::Visibility { stretch } if !(stretch >= Method::LEAST_STRETCH && stretch.is_finite()) => {
            Err(QueryError::Stretch { stretch })
        }
        _ => Ok(()),
    }
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
    /// [`QueryError::Stretch`] if a stretch factor is too small.
    pub async fn nearest_sites_by(
        &self,
        method: Method,
        at: Point,
        k: usize,
        options: QueryOptions,
    ) -> Result<Measured<Vec<SiteFound>>, QueryError> {
        check(method)?;
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
        check(method)?;
        self.sites_by(method, at, Wanted::Within(radius), options).await
    }

    async fn sites_by(
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
        } = asked.sites(method, wanted).await?;
        let mut sites = Vec::new();
        for reached in &reached {
            let candidate = &local.candidates[reached.candidate];
            for (number, id) in &candidate.sites {
                sites.push(SiteFound {
                    number: *number,
                    id: id.clone(),
                    vertex: candidate.vertex,
                    distance: Distance::of_legs(reached.length, reached.way.len() - 1),
                    path: None,
                });
            }
        }
        sites.sort_by(|a, b| {
            let by_distance = a.distance.value.total_cmp(&b.distance.value);
            by_distance.then(a.number.cmp(&b.number))
        });
        sites.truncate(wanted.count());
        if options.paths {
            let mut count = 0;
            for site in &mut sites {
                let reached = reached
                    .iter()
                    .find(|reached| local.candidates[reached.candidate].vertex == site.vertex);
                if let Some(reached) = reached {
                    let to = Place::at(site.vertex);
                    let ends = [&asked.source, &to];
                    let path = route::path(&mut asked.tiles, &reached.way, ends, reached.length, options.certify).await;
                    match path {
                        Err(QueryError::OutOfBudget { .. }) => {
                            at_least = Some(site.distance.lower);
                            break;
                        }
                        path => site.path = Some(path?),
                    }
                }
                count += 1;
            }
            sites.truncate(count);
            asked.clock.lap("paths");
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
        check(method)?;
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
        let found = asked.path(method, &to).await.map_err(|error| error.at_least(straight));
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

impl Asked {
    fn new(reader: &TileReader, options: &QueryOptions, tiles: Tiles, source: Place, clock: Clock) -> Self {
        Self {
            reader: reader.clone(),
            options: options.clone(),
            tiles,
            source,
            clock,
            statistics: Statistics::default(),
            considered: HashSet::new(),
        }
    }

    /// Lets others have their turn, and fails if the time is over.
    async fn pause(&self) -> Result<(), QueryError> {
        tokio::task::yield_now().await;
        self.tiles.check_time()
    }

    /// Gives the tiles away for a while.
    fn lend_tiles(&mut self) -> Tiles {
        std::mem::replace(&mut self.tiles, Tiles::new(&self.reader, &self.options))
    }

    fn finish(self) -> Statistics {
        Statistics {
            tiles: self.tiles.count(),
            times: self.clock.times,
            ..self.statistics
        }
    }
}
