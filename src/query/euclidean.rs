//! Vertices and sites by Euclidean distance, regardless of obstacles.
//!
//! Cells of the k-d tree and vertices are in one queue, ordered by distance (Hjaltason and Samet,
//! "Distance browsing in spatial databases", ACM TODS 24, 1999). So only tiles that can contain the
//! next nearest are read.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use futures::stream;
use futures::stream::Stream;

use super::request::{QueryError, QueryOptions, Tiles};
use crate::collections::keyed::Keyed;
use crate::geometry::{Point, Rect};
use crate::query::answer::distance::distance_to_rect;
use crate::store::{Cell, CellContent, Tile, TileId, TileReader, Vertex};

/// A vertex or a site, found by Euclidean distance.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Near {
    /// The vertex, or the vertex of the site.
    pub vertex: Vertex,
    /// The distance, rounded.
    pub distance: f64,
    /// The number of the site, if sites were requested.
    pub site: Option<u64>,
    /// The id of the site, if the input gave it one.
    pub id: Option<String>,
}

/// An entry of the queue, ordered by the bits of its distance; then cells come before vertices and
/// sites; then by number.
type QueueEntry = Keyed<(u64, u8, u64), QueueItem>;

#[derive(Debug)]
enum QueueItem {
    Cell(Cell),
    Near(Near),
}

struct EuclideanSearch {
    tiles: Tiles,
    reader: TileReader,
    at: Point,
    wants_sites: bool,
    open: BinaryHeap<Reverse<QueueEntry>>,
}

impl EuclideanSearch {
    fn push_cell(&mut self, cell: Cell) {
        if cell.rect.is_empty() {
            return;
        }
        let key = (distance_to_rect(self.at, cell.rect).to_bits(), 0, cell.number());
        self.open.push(Reverse(QueueEntry {
            key,
            value: QueueItem::Cell(cell),
        }));
    }

    fn push_near(&mut self, near: Near) {
        let vertex = near.vertex.id;
        let number = near
            .site
            .unwrap_or(u64::from(vertex.tile.0) << 32 | u64::from(vertex.index.0));
        self.open.push(Reverse(QueueEntry {
            key: (near.distance.to_bits(), 1, number),
            value: QueueItem::Near(near),
        }));
    }

    fn push_tile(&mut self, tile: &Tile) {
        let far = |point: Point| distance_to_rect(self.at, Rect::around([point]));
        let mut found = Vec::new();
        if self.wants_sites {
            found.extend(tile.sites().map(|site| {
                let vertex = tile.vertex(site.vertex);
                Near {
                    vertex,
                    distance: far(vertex.point),
                    site: Some(site.number),
                    id: site.id.map(str::to_owned),
                }
            }));
        } else {
            found.extend(tile.vertex_indices().map(|vertex| {
                let vertex = tile.vertex(vertex);
                Near {
                    vertex,
                    distance: far(vertex.point),
                    site: None,
                    id: None,
                }
            }));
        }
        found.into_iter().for_each(|near| self.push_near(near));
    }

    async fn next(&mut self) -> Result<Option<Near>, QueryError> {
        while let Some(Reverse(QueueEntry { value, key })) = self.open.pop() {
            let cell = match value {
                QueueItem::Near(near) => return Ok(Some(near)),
                QueueItem::Cell(cell) => cell,
            };
            match self.reader.content_of(cell).await? {
                CellContent::Cut(parts) => parts.into_iter().for_each(|part| self.push_cell(part)),
                CellContent::Tile(tile) => {
                    let lower_bound = f64::from_bits(key.0);
                    let tile = self.tile(tile).await.map_err(|error| error.lower_bound(lower_bound))?;
                    self.push_tile(&tile);
                }
            }
        }
        Ok(None)
    }

    async fn tile(&mut self, tile: TileId) -> Result<std::sync::Arc<Tile>, QueryError> {
        self.tiles.get(tile).await
    }
}

/// Euclidean nearest neighbours.
impl TileReader {
    /// Returns the vertices by Euclidean distance from `at`, nearest first. Vertices with equal
    /// distances are ordered by number. The stream ends, and its limits apply, as for
    /// [`nearest_sites`](Self::nearest_sites), but obstacles do not matter.
    ///
    /// [Examples](crate::query#examples).
    pub fn vertices_by_euclidean_distance(
        &self,
        at: Point,
        options: QueryOptions,
    ) -> impl Stream<Item = Result<Near, QueryError>> + Send + Unpin + 'static + use<> {
        self.by_euclidean_distance(at, options, false)
    }

    /// Returns the sites by Euclidean distance from `at`; otherwise as
    /// [`vertices_by_euclidean_distance`](Self::vertices_by_euclidean_distance).
    ///
    /// [Examples](crate::query#examples).
    pub fn sites_by_euclidean_distance(
        &self,
        at: Point,
        options: QueryOptions,
    ) -> impl Stream<Item = Result<Near, QueryError>> + Send + Unpin + 'static + use<> {
        self.by_euclidean_distance(at, options, true)
    }

    fn by_euclidean_distance(
        &self,
        at: Point,
        options: QueryOptions,
        wants_sites: bool,
    ) -> impl Stream<Item = Result<Near, QueryError>> + Send + Unpin + 'static + use<> {
        let mut search = EuclideanSearch {
            tiles: Tiles::new(self, &options),
            reader: self.clone(),
            at,
            wants_sites,
            open: BinaryHeap::new(),
        };
        if let Some(root) = self.root_cell() {
            search.push_cell(root);
        }
        let is_point = at.x.is_finite() && at.y.is_finite();
        let search = if is_point {
            Ok(search)
        } else {
            Err(QueryError::NotAPoint { point: at })
        };
        Box::pin(stream::unfold(Some(search), |state| async move {
            match state? {
                Err(error) => Some((Err(error), None)),
                Ok(mut search) => match search.next().await {
                    Ok(near) => near.map(|near| (Ok(near), Some(Ok(search)))),
                    Err(error) => Some((Err(error), None)),
                },
            }
        }))
    }
}
