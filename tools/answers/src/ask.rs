//! Asks the library.

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{Footing, PathOutcome, QueryError, QueryOptions, Search};
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

/// Returns up to `most` items of a stream, and how the stream ended.
async fn first<T>(
    mut stream: impl Stream<Item = Result<T, QueryError>> + Unpin,
    most: usize,
) -> anyhow::Result<(Status, Vec<T>)> {
    let mut found = Vec::new();
    while found.len() < most {
        match stream.try_next().await {
            Ok(Some(item)) => found.push(item),
            Ok(None) => break,
            Err(error) => return Ok((Status::of(error)?, found)),
        }
    }
    Ok((Status::Ok, found))
}

impl Ask {
    /// Returns the answer to a question.
    pub async fn answer(
        self,
        reader: &TileReader,
        question: Question,
        options: QueryOptions,
    ) -> anyhow::Result<Answer> {
        let (mut status, found) = match (self, question) {
            (_, Question::At(at)) => self.answer_at(reader, at, options.clone()).await?,
            (Self::Along { k }, Question::Way(from, to)) => {
                let intervals = reader.nearest_along(from, to, k as usize, options.clone());
                let (status, intervals) = first(intervals, usize::MAX).await?;
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
    ) -> anyhow::Result<(Status, QueryResult)> {
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
                    first(reader.sites_by_euclidean_distance(at, options), k as usize).await?
                } else {
                    first(reader.vertices_by_euclidean_distance(at, options), k as usize).await?
                };
                (status, QueryResult::Near(near))
            }
            Self::Knn { k, search } => {
                let options = options.first(k as usize).search(search);
                let (status, sites) = first(reader.nearest_sites(at, options), k as usize).await?;
                (status, QueryResult::Sites(sites))
            }
            Self::Range { radius, .. } => {
                let (status, sites) = first(reader.sites_within(at, radius, options), usize::MAX).await?;
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
