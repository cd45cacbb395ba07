//! Vertices and sites by Euclidean distance, regardless of obstacles.
//!
//! Cells of the k-d tree and vertices are in one queue, ordered by distance (Hjaltason and Samet,
//! "Distance browsing in spatial databases", ACM TODS 24, 1999). So only tiles that can contain the
//! next nearest are read.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use futures::stream::Stream;

use super::request::{QueryError, QueryOptions, Tiles, unfold};
use crate::collections::keyed::Keyed;
use crate::geometry::{Point, Rect, VertexIndex};
use crate::query::answer::distance::distance_to_rect;
use crate::store::{Cell, CellContent, Tile, TileReader, Vertex, VertexId};

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

/// A cell that was not searched yet, ordered by the bits of its distance, then by number.
type OpenCell = Keyed<(u64, u64), Cell>;
/// A vertex or site that was not returned yet, ordered by the bits of its distance, then by number.
type Waiting = Keyed<(u64, u64), VertexId>;

/// A search for vertices or sites, nearest first.
pub(super) struct EuclideanSearch {
    reader: TileReader,
    at: Point,
    wants_sites: bool,
    cells: BinaryHeap<Reverse<OpenCell>>,
    waiting: BinaryHeap<Reverse<Waiting>>,
}

impl EuclideanSearch {
    pub(super) fn new(reader: &TileReader, at: Point, wants_sites: bool) -> Self {
        let mut this = Self {
            reader: reader.clone(),
            at,
            wants_sites,
            cells: BinaryHeap::new(),
            waiting: BinaryHeap::new(),
        };
        if let Some(root) = reader.root_cell() {
            this.push_cell(root);
        }
        this
    }

    fn push_cell(&mut self, cell: Cell) {
        if cell.rect.is_empty() {
            return;
        }
        let key = (distance_to_rect(self.at, cell.rect).to_bits(), cell.number());
        self.cells.push(Reverse(Keyed { key, value: cell }));
    }

    fn push_tile(&mut self, tile: &Tile) {
        let entry = |index: VertexIndex, site: Option<u64>| {
            let distance = distance_to_rect(self.at, Rect::around([tile.point(index)]));
            let vertex = VertexId { tile: tile.id(), index };
            let number = site.unwrap_or(u64::from(vertex.tile.0) << 32 | u64::from(index.0));
            let key = (distance.to_bits(), number);
            Reverse(Keyed { key, value: vertex })
        };
        // Many entries at once are cheaper than one after the other.
        if self.wants_sites {
            let sites = tile.sites().map(|site| entry(site.vertex, Some(site.number)));
            self.waiting.extend(sites.collect::<Vec<_>>());
        } else {
            let vertices = tile.vertex_indices().map(|index| entry(index, None));
            self.waiting.extend(vertices);
        }
    }

    /// Returns a lower bound of the distances of all that were not returned yet; infinite at the
    /// end.
    pub(super) fn bound(&self) -> f64 {
        let cell = self.cells.peek().map_or(u64::MAX, |cell| cell.0.key.0);
        let waiting = self.waiting.peek().map_or(u64::MAX, |waiting| waiting.0.key.0);
        match cell.min(waiting) {
            u64::MAX => f64::INFINITY,
            bits => f64::from_bits(bits),
        }
    }

    /// Returns the next nearest. A failed search can be continued.
    pub(super) async fn next(&mut self, tiles: &mut Tiles) -> Result<Option<Near>, QueryError> {
        loop {
            let waiting = self.waiting.peek().map(|waiting| waiting.0.key.0);
            let cell = self.cells.peek().map(|cell| (cell.0.key.0, cell.0.value));
            if let Some((bits, cell)) = cell
                && waiting.is_none_or(|waiting| bits <= waiting)
            {
                let parts = match self.reader.content_of(cell).await? {
                    CellContent::Cut(parts) => Some(parts),
                    CellContent::Tile(tile) => {
                        let tile = tiles.get(tile).await;
                        let tile = tile.map_err(|error| error.lower_bound(f64::from_bits(bits)))?;
                        self.push_tile(&tile);
                        None
                    }
                };
                self.cells.pop();
                parts.into_iter().flatten().for_each(|part| self.push_cell(part));
                continue;
            }
            let Some(Reverse(Keyed { key, value })) = self.waiting.peek() else {
                return Ok(None);
            };
            let near = self.near(tiles, *value, *key).await;
            let near = near.map_err(|error| error.lower_bound(f64::from_bits(key.0)))?;
            self.waiting.pop();
            return Ok(Some(near));
        }
    }

    async fn near(&self, tiles: &mut Tiles, id: VertexId, key: (u64, u64)) -> Result<Near, QueryError> {
        let tile = tiles.get(id.tile).await?;
        let (distance, number) = (f64::from_bits(key.0), key.1);
        let site = if self.wants_sites {
            tile.sites_at(id.index).find(|site| site.number == number)
        } else {
            None
        };
        Ok(Near {
            vertex: tile.vertex(id.index),
            distance,
            site: self.wants_sites.then_some(number),
            id: site.and_then(|site| site.id).map(str::to_owned),
        })
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
        let search = EuclideanSearch::new(self, at, wants_sites);
        let tiles = Tiles::new(self, &options);
        let start = async move {
            match at.x.is_finite() && at.y.is_finite() {
                true => Ok((search, tiles)),
                false => Err(QueryError::NotAPoint { point: at }),
            }
        };
        unfold(start, |(mut search, mut tiles): (EuclideanSearch, Tiles)| async move {
            let near = search.next(&mut tiles).await?;
            Ok(near.map(|near| (near, (search, tiles))))
        })
    }
}
