//! Asks the library.

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{AlongInterval, Footing, Near, PathOutcome, QueryError, QueryOptions, Search, SiteFound};
use delaunay_tiles::store::TileReader;
use futures::{Stream, TryStreamExt};

use crate::answer::{Answer, Located, QueryResult, Status};
use crate::area;
use crate::question::Question;

/// The kind of a query, with its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ask {
    /// Where a point is.
    Locate,
    /// The nearest sites, or vertices, by Euclidean distance.
    Nearest {
        /// How many to find.
        k: u32,
        /// Whether to find vertices even if the file has sites.
        vertices: bool,
    },
    /// The nearest sites by walking distance.
    Knn {
        /// How many to find.
        k: u32,
        /// How sites are searched for.
        search: Search,
    },
    /// All sites within a walking distance.
    Range {
        /// The distance.
        radius: f64,
        /// Whether to find the area within that distance too.
        area: bool,
    },
    /// A shortest path.
    Path,
    /// The nearest sites along a line.
    Along {
        /// How many sites on each interval.
        k: u32,
    },
}

/// Limits of the items that a query returns.
#[derive(Clone, Copy, Debug)]
struct Most {
    items: usize,
    /// The number of points of all items, after which no more are taken.
    points: usize,
}

/// An item of a stream that ends nearest first.
trait Item {
    /// Returns about how many points the item has.
    fn weight(&self) -> usize;
    /// Returns a lower bound of the distances of all later items.
    fn reached(&self) -> f64;
}

impl Item for Near {
    fn weight(&self) -> usize {
        1
    }

    fn reached(&self) -> f64 {
        self.distance
    }
}

impl Item for SiteFound {
    fn weight(&self) -> usize {
        1 + self.path.as_ref().map_or(0, |path| path.points.len())
    }

    fn reached(&self) -> f64 {
        self.distance.lower
    }
}

impl Item for AlongInterval {
    fn weight(&self) -> usize {
        1 + self.sites.as_ref().map_or(0, Vec::len)
    }

    fn reached(&self) -> f64 {
        0.0
    }
}

/// Returns the first items of a stream, and how the stream ended.
async fn first<T: Item>(
    mut stream: impl Stream<Item = Result<T, QueryError>> + Unpin,
    most: Most,
) -> anyhow::Result<(Status, Vec<T>)> {
    let (mut found, mut points): (Vec<T>, usize) = (Vec::new(), 0);
    while found.len() < most.items {
        if points >= most.points {
            let reached = found.last().map_or(0.0, Item::reached);
            return Ok((Status::Budget(reached), found));
        }
        match stream.try_next().await {
            Ok(Some(item)) => {
                points = points.saturating_add(item.weight());
                found.push(item);
            }
            Ok(None) => break,
            Err(error) => return Ok((Status::of(error)?, found)),
        }
    }
    Ok((Status::Ok, found))
}

impl Ask {
    /// Returns the answer to a question.
    ///
    /// # Errors
    /// Returns the errors of the library that no [`Status`] says.
    pub async fn answer(
        self,
        reader: &TileReader,
        question: Question,
        options: QueryOptions,
    ) -> anyhow::Result<Answer> {
        self.answer_up_to(reader, question, options, usize::MAX).await
    }

    /// Returns the answer to a question. If its items have `points` points or more, those that are farther
    /// away are left out, and the status says that a limit was reached.
    ///
    /// # Errors
    /// Returns the errors of the library that no [`Status`] says.
    pub async fn answer_up_to(
        self,
        reader: &TileReader,
        question: Question,
        options: QueryOptions,
        points: usize,
    ) -> anyhow::Result<Answer> {
        let all = Most {
            items: usize::MAX,
            points,
        };
        let (mut status, found) = match (self, question) {
            (_, Question::At(at)) => self.answer_at(reader, at, options.clone(), points).await?,
            (Self::Along { k }, Question::Way(from, to)) => {
                let intervals = reader.nearest_along(from, to, k as usize, options.clone());
                let (status, intervals) = first(intervals, all).await?;
                (status, QueryResult::Along(intervals))
            }
            (_, Question::Way(from, to)) => answer_way(reader, from, to, options.clone()).await?,
        };
        let mut area = None;
        if let (Self::Range { radius, area: true }, Question::At(at), Status::Ok) = (self, question, status) {
            let (end, found) = area::within(reader, at, radius, options).await?;
            (status, area) = (end, Some(found));
        }
        Ok(Answer {
            question,
            status,
            found,
            cost: None,
            area,
        })
    }

    async fn answer_at(
        self,
        reader: &TileReader,
        at: Point,
        options: QueryOptions,
        points: usize,
    ) -> anyhow::Result<(Status, QueryResult)> {
        let most = |items| Most { items, points };
        Ok(match self {
            Self::Locate => {
                let located = Located::find(reader, at).await?;
                let status = match reader.footing(at, options).await {
                    Ok(Footing::Free) => Status::Ok,
                    Ok(Footing::InsideObstacle { nearest_free }) => Status::Inside(at, nearest_free),
                    // A file without triangles has no obstacles.
                    Err(QueryError::NoTriangles { .. }) => Status::Ok,
                    Err(error) => Status::of(error)?,
                };
                (status, QueryResult::Location(located))
            }
            Self::Nearest { k, vertices } => {
                let of_sites = !vertices && reader.metadata().sites > 0;
                let (status, near) = if of_sites {
                    first(reader.sites_by_euclidean_distance(at, options), most(k as usize)).await?
                } else {
                    first(reader.vertices_by_euclidean_distance(at, options), most(k as usize)).await?
                };
                (status, QueryResult::Near(near))
            }
            Self::Knn { k, search } => {
                let options = options.first(k as usize).search(search);
                let (status, sites) = first(reader.nearest_sites(at, options), most(k as usize)).await?;
                (status, QueryResult::Sites(sites))
            }
            Self::Range { radius, .. } => {
                let (status, sites) = first(reader.sites_within(at, radius, options), most(usize::MAX)).await?;
                (status, QueryResult::Sites(sites))
            }
            Self::Path | Self::Along { .. } => unreachable!("a way has two ends"),
        })
    }
}

async fn answer_way(
    reader: &TileReader,
    from: Point,
    to: Point,
    options: QueryOptions,
) -> anyhow::Result<(Status, QueryResult)> {
    let outcome = match reader.shortest_path(from, to, options).await {
        Ok(outcome) => outcome,
        Err(error) => return Ok((Status::of(error)?, QueryResult::Path(None))),
    };
    Ok(path_found(outcome))
}

/// Returns how a query for a path ended, and the path.
pub fn path_found(outcome: PathOutcome) -> (Status, QueryResult) {
    match outcome {
        PathOutcome::Found(path) => (Status::Ok, QueryResult::Path(Some(path))),
        PathOutcome::Unreachable => (Status::Unreachable, QueryResult::Path(None)),
        PathOutcome::InsideObstacle { point, nearest_free } => {
            (Status::Inside(point, nearest_free), QueryResult::Path(None))
        }
    }
}
