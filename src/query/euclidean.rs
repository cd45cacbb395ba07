//! What is nearest as the crow flies: vertices and sites by Euclidean distance, whatever lies between.
//!
//! Cells of the k-d tree and vertices stand in one queue by their distance (Hjaltason and Samet, "Distance browsing in spatial
//! databases", ACM TODS 24, 1999), so that only tiles are read that can hold the next nearest.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use futures::stream;
use futures::stream::Stream;

use super::request::{QueryError, QueryOptions, Tiles};
use crate::geometry::{Point, Rect};
use crate::store::{KdNode, Tile, TileId, TileReader, Vertex};

/// A vertex or a site, by Euclidean distance.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Near {
    /// The vertex, at which the site lies if it is one.
    pub vertex: Vertex,
    /// How far it is, rounded.
    pub distance: f64,
    /// The site's number, if sites were asked for.
    pub site: Option<u64>,
    /// The site's id, if the input gave it one.
    pub id: Option<String>,
}

/// A thing in the queue: by the bits of its distance, then cells before things in them, then by number.
#[derive(Debug)]
struct Entry {
    key: (u64, u8, u64),
    thing: Thing,
}

#[derive(Debug)]
enum Thing {
    Cell(u32, Rect),
    Near(Near),
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.key == other.key
    }
}

impl Eq for Entry {}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.key.cmp(&other.key)
    }
}

struct Search {
    tiles: Tiles,
    reader: TileReader,
    at: Point,
    wants_sites: bool,
    open: BinaryHeap<Reverse<Entry>>,
}

/// How far a rectangle is, computed so that rounding makes it no farther than any point in it.
fn distance(at: Point, rect: Rect) -> f64 {
    let gap = |v: f64, min: f64, max: f64| (min - v).max(v - max).max(0.0);
    let (dx, dy) = (gap(at.x, rect.min_x, rect.max_x), gap(at.y, rect.min_y, rect.max_y));
    (dx * dx + dy * dy).sqrt()
}

impl Search {
    fn push_cell(&mut self, node: u32, cell: Rect) {
        if cell.is_empty() {
            return;
        }
        let key = (distance(self.at, cell).to_bits(), 0, node.into());
        self.open.push(Reverse(Entry {
            key,
            thing: Thing::Cell(node, cell),
        }));
    }

    fn push_near(&mut self, near: Near) {
        let vertex = near.vertex.id;
        let number = near
            .site
            .unwrap_or(u64::from(vertex.tile.0) << 32 | u64::from(vertex.index));
        self.open.push(Reverse(Entry {
            key: (near.distance.to_bits(), 1, number),
            thing: Thing::Near(near),
        }));
    }

    fn push_tile(&mut self, tile: &Tile) {
        let far = |point: Point| distance(self.at, Rect::around([point]));
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
            found.extend((0..tile.vertex_count()).map(|vertex| {
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
        while let Some(Reverse(Entry { thing, key })) = self.open.pop() {
            let (node, cell) = match thing {
                Thing::Near(near) => return Ok(Some(near)),
                Thing::Cell(node, cell) => (node, cell),
            };
            match self.reader.directory().tree.nodes()[node as usize] {
                KdNode::X { cut, right } => {
                    self.push_cell(node + 1, Rect { max_x: cut, ..cell });
                    self.push_cell(right, Rect { min_x: cut, ..cell });
                }
                KdNode::Y { cut, right } => {
                    self.push_cell(node + 1, Rect { max_y: cut, ..cell });
                    self.push_cell(right, Rect { min_y: cut, ..cell });
                }
                KdNode::Leaf(tile) => {
                    let at_least = f64::from_bits(key.0);
                    let tile = self.tile(tile).await.map_err(|error| error.at_least(at_least))?;
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

impl TileReader {
    /// The vertices by their Euclidean distance from a point, the nearest first; of equally distant ones the first by number.
    /// Ends and limits as [`nearest_sites`](Self::nearest_sites), but obstacles are none.
    pub fn vertices_by_air(
        &self,
        at: Point,
        options: QueryOptions,
    ) -> impl Stream<Item = Result<Near, QueryError>> + Send + Unpin + 'static + use<> {
        self.by_air(at, options, false)
    }

    /// The sites by their Euclidean distance from a point; otherwise as [`vertices_by_air`](Self::vertices_by_air).
    pub fn sites_by_air(
        &self,
        at: Point,
        options: QueryOptions,
    ) -> impl Stream<Item = Result<Near, QueryError>> + Send + Unpin + 'static + use<> {
        self.by_air(at, options, true)
    }

    fn by_air(
        &self,
        at: Point,
        options: QueryOptions,
        wants_sites: bool,
    ) -> impl Stream<Item = Result<Near, QueryError>> + Send + Unpin + 'static + use<> {
        let mut search = Search {
            tiles: Tiles::new(self, &options),
            reader: self.clone(),
            at,
            wants_sites,
            open: BinaryHeap::new(),
        };
        if !self.directory().tree.nodes().is_empty() {
            search.push_cell(0, self.directory().metadata.bounds);
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
