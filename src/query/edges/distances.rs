//! Queries for CDT distances.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use futures::future::FutureExt;
use futures::stream::Stream;

use foldhash::HashSet;

use super::corner::GraphVertex;
use super::run::EdgeRun;
use crate::collections::keyed::Keyed;
use crate::geometry::Point;
use crate::query::answer::{Distance, SiteFound};
use crate::query::free_space::QueryPoint;
use crate::query::request::{QueryError, QueryOptions, Tiles, unfold};
use crate::store::{TileReader, Vertex, VertexId};

/// A shortest path along edges.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CdtPath {
    /// The length of the path, with bounds of the CDT distance.
    pub distance: Distance,
    /// The start, the vertices on the path, and the end.
    pub points: Vec<Point>,
    /// The vertices at these points; `None` for an end that is not a vertex.
    pub vertices: Vec<Option<VertexId>>,
}

/// A vertex in one of its sectors, found by CDT distance.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CdtVertex {
    /// The vertex.
    pub vertex: Vertex,
    /// The neighbour at the right end of the sector, seen from the vertex; `None` if the vertex has
    /// one free sector only.
    pub sector: Option<VertexId>,
    /// The distance along edges, with bounds of the CDT distance.
    pub distance: Distance,
    /// The previous vertex on the path, as the index of an item of the stream, from 0: the parent
    /// in the source tree. `None` if the previous vertex is the source and not an item, or the
    /// vertex is itself the source.
    pub parent: Option<u64>,
}

/// A stream of vertices in their sectors.
pub(crate) struct VertexStream {
    pub(crate) run: EdgeRun,
    /// For each node, the number of edges on the path to it.
    legs: Vec<u32>,
    /// The number of nodes that are inserted points; they come first.
    inserted: u32,
}

impl VertexStream {
    async fn next(&mut self) -> Result<Option<(CdtVertex, u32)>, QueryError> {
        while let Some(number) = self.run.next().await? {
            let node = *self.run.node(number);
            let before = node.parent.and_then(|parent| self.legs.get(parent as usize));
            self.legs.push(before.map_or(0, |legs| legs + 1));
            let Some(id) = node.vertex.vertex() else {
                self.inserted += 1;
                continue;
            };
            let parent = node.parent.and_then(|parent| parent.checked_sub(self.inserted));
            let found = CdtVertex {
                vertex: Vertex { id, point: node.point },
                sector: Some(node.sector)
                    .filter(|&sector| sector != node.vertex)
                    .and_then(GraphVertex::vertex),
                distance: Distance::of_legs(node.length, self.legs[number as usize] as usize),
                parent: parent.map(u64::from),
            };
            return Ok(Some((found, number)));
        }
        Ok(None)
    }
}

/// A site with its node, ordered by length and number.
type Ready = Keyed<(u64, u64), (SiteFound, u32)>;

/// A stream of sites.
pub(crate) struct SitesAlongEdges {
    pub(crate) vertices: VertexStream,
    met: HashSet<VertexId>,
    /// The sites that were reached, with their nodes, until no other site can be nearer.
    ready: BinaryHeap<Reverse<Ready>>,
}

impl SitesAlongEdges {
    /// Starts at `at`.
    pub(crate) async fn start(reader: &TileReader, at: Point, options: &QueryOptions) -> Result<Self, QueryError> {
        Ok(Self {
            vertices: VertexStream::start(reader, at, options).await?,
            met: HashSet::default(),
            ready: BinaryHeap::new(),
        })
    }

    /// Returns the next site, and its node.
    pub(crate) async fn next(&mut self) -> Result<Option<(SiteFound, u32)>, QueryError> {
        loop {
            let front = self.vertices.run.search.front();
            let nearest = self.ready.peek().map(|ready| f64::from_bits(ready.0.key.0));
            if nearest.is_some_and(|nearest| nearest < front) {
                return Ok(self.ready.pop().map(|Reverse(ready)| ready.value));
            }
            let found = self.vertices.next().await;
            let lower_bound = nearest.unwrap_or(front);
            let Some((found, node)) = found.map_err(|error| error.lower_bound(lower_bound))? else {
                return Ok(self.ready.pop().map(|Reverse(ready)| ready.value));
            };
            if !self.met.insert(found.vertex.id) {
                continue;
            }
            for site in self.vertices.run.tile().sites_at(found.vertex.id.index) {
                let found = SiteFound {
                    number: site.number,
                    id: site.id.map(str::to_owned),
                    vertex: found.vertex,
                    distance: found.distance,
                    path: None,
                };
                self.ready.push(Reverse(Keyed {
                    key: (found.distance.value.to_bits(), site.number),
                    value: (found, node),
                }));
            }
        }
    }
}

impl VertexStream {
    async fn start(reader: &TileReader, at: Point, options: &QueryOptions) -> Result<Self, QueryError> {
        Ok(Self {
            run: EdgeRun::from_point(reader, at, options).await?,
            legs: Vec::new(),
            inserted: 0,
        })
    }
}

/// Distances along edges of the triangulation.
impl TileReader {
    /// Returns the CDT distance between two points, with its path: the length of a shortest path
    /// along walkable edges of the constrained Delaunay triangulation that has both points as
    /// vertices. Returns `None` if no path connects them.
    ///
    /// It is at least the walking distance, and less than 2.42 times the walking distance (Bose and
    /// Keil 2006). An end that is not a vertex is inserted for this query only; nothing is written.
    /// A point outside the hull is connected to the vertices of the hull that it sees.
    ///
    /// [Examples](crate::query#examples).
    ///
    /// # Errors
    /// [`BreakLines`](QueryError::BreakLines) if the file has break lines, and
    /// [`InsideObstacle`](QueryError::InsideObstacle) if an end is in an obstacle; otherwise as
    /// [`shortest_path`](Self::shortest_path).
    pub fn cdt_distance(
        &self,
        from: Point,
        to: Point,
        options: QueryOptions,
    ) -> impl Future<Output = Result<Option<CdtPath>, QueryError>> + Send {
        async move {
            let mut tiles = Tiles::new(self, &options);
            let to = QueryPoint::find_free(&mut tiles, to).await?;
            let from = QueryPoint::find_free(&mut tiles, from).await?;
            let (mut run, end) = EdgeRun::towards(tiles, from, &to, 1.0).await?;
            run.refuse_break_lines()?;
            let Some(node) = run.find(end).await? else {
                return Ok(None);
            };
            let mut way = run.search.way(node);
            if let [only] = way[..] {
                way.push(only);
            }
            Ok(Some(CdtPath {
                distance: Distance::of_legs(run.node(node).length, way.len() - 1),
                points: way.iter().map(|node| node.point).collect(),
                vertices: way.iter().map(|node| node.vertex.vertex()).collect(),
            }))
        }
        .boxed()
    }

    /// Returns all vertices that can be reached from `from`, in each of their sectors, by [CDT
    /// distance](Self::cdt_distance): the source tree. Vertices with equal distances are ordered by
    /// their coordinates.
    ///
    /// The stream ends, and its limits apply, as for [`nearest_sites`](Self::nearest_sites). It
    /// also ends with an error if the file has break lines.
    ///
    /// [Examples](crate::query#examples).
    pub fn vertices_by_cdt_distance(
        &self,
        from: Point,
        options: QueryOptions,
    ) -> impl Stream<Item = Result<CdtVertex, QueryError>> + Send + Unpin + 'static + use<> {
        let reader = self.clone();
        let start = async move {
            let mut vertices = VertexStream::start(&reader, from, &options).await?;
            vertices.run.refuse_break_lines()?;
            Ok(vertices)
        };
        unfold(start, |mut vertices: VertexStream| async move {
            Ok(vertices.next().await?.map(|(vertex, _)| (vertex, vertices)))
        })
    }

    /// Returns the sites by [CDT distance](Self::cdt_distance) from `from`; sites with equal
    /// distances are ordered by number. They have no paths, and their distances are those along
    /// edges, with their bounds. The stream ends, and its limits apply, as for
    /// [`vertices_by_cdt_distance`](Self::vertices_by_cdt_distance).
    ///
    /// [Examples](crate::query#examples).
    pub fn sites_by_cdt_distance(
        &self,
        from: Point,
        options: QueryOptions,
    ) -> impl Stream<Item = Result<SiteFound, QueryError>> + Send + Unpin + 'static + use<> {
        let reader = self.clone();
        let start = async move {
            let mut sites = SitesAlongEdges::start(&reader, from, &options).await?;
            sites.vertices.run.refuse_break_lines()?;
            Ok(sites)
        };
        unfold(start, |mut sites: SitesAlongEdges| async move {
            Ok(sites.next().await?.map(|(site, _)| (site, sites)))
        })
    }
}
