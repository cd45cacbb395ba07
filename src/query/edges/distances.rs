//! Questions for the CDT distance.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use futures::stream::Stream;

use foldhash::HashSet;

use super::corner::End;
use super::run::EdgeRun;
use crate::collections::keyed::Keyed;
use crate::geometry::Point;
use crate::query::answer::{Distance, SiteFound};
use crate::query::free_space::Place;
use crate::query::request::{QueryError, QueryOptions, Tiles, unfold};
use crate::store::{TileReader, Vertex, VertexId};

/// A shortest way along edges.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CdtPath {
    /// How long it is; the bounds are those of the CDT distance.
    pub distance: Distance,
    /// From its start by way of vertices to its end.
    pub points: Vec<Point>,
    /// The vertices that these points are; ends may be none.
    pub vertices: Vec<Option<VertexId>>,
}

/// A vertex in one of its sectors, by CDT distance.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CdtVertex {
    /// The vertex.
    pub vertex: Vertex,
    /// The neighbour at the right end of the sector, as seen from the vertex; none if the vertex has one free sector only.
    pub sector: Option<VertexId>,
    /// How far it is along edges; the bounds are those of the CDT distance.
    pub distance: Distance,
    /// Which item of the stream, from 0, the way comes from: the parent in the source tree. None: from the source, if that is not
    /// the vertex itself.
    pub parent: Option<u64>,
}

/// A stream of vertices in their sectors.
pub(crate) struct Vertices {
    pub(crate) run: EdgeRun,
    /// For each node, how many edges lead there.
    legs: Vec<u32>,
    /// Nodes that are no vertices of the file; they come first.
    put_in: u32,
}

impl Vertices {
    async fn next(&mut self) -> Result<Option<(CdtVertex, u32)>, QueryError> {
        while let Some(number) = self.run.next().await? {
            let node = *self.run.node(number);
            let before = node.parent.and_then(|parent| self.legs.get(parent as usize));
            self.legs.push(before.map_or(0, |legs| legs + 1));
            let Some(id) = node.vertex.vertex() else {
                self.put_in += 1;
                continue;
            };
            let parent = node.parent.and_then(|parent| parent.checked_sub(self.put_in));
            let found = CdtVertex {
                vertex: Vertex { id, point: node.point },
                sector: Some(node.sector)
                    .filter(|&sector| sector != node.vertex)
                    .and_then(End::vertex),
                distance: Distance::of_legs(node.length, self.legs[number as usize] as usize),
                parent: parent.map(u64::from),
            };
            return Ok(Some((found, number)));
        }
        Ok(None)
    }
}

/// A site, with its node, by length and number.
type Ready = Keyed<(u64, u64), (SiteFound, u32)>;

/// A stream of sites.
pub(crate) struct SitesAlongEdges {
    pub(crate) vertices: Vertices,
    met: HashSet<VertexId>,
    /// Those that were met, with their nodes, by length and number, until no other can be as near.
    ready: BinaryHeap<Reverse<Ready>>,
}

impl SitesAlongEdges {
    /// Starts at a point, for sites that are not farther away than `limit`.
    pub(crate) async fn start(
        reader: &TileReader,
        at: Point,
        limit: f64,
        options: &QueryOptions,
    ) -> Result<Self, QueryError> {
        Ok(Self {
            vertices: Vertices::start(reader, at, limit, options).await?,
            met: HashSet::default(),
            ready: BinaryHeap::new(),
        })
    }

    /// The next site, and its node.
    pub(crate) async fn next(&mut self) -> Result<Option<(SiteFound, u32)>, QueryError> {
        loop {
            let front = self.vertices.run.search.front();
            let nearest = self.ready.peek().map(|ready| f64::from_bits(ready.0.key.0));
            if nearest.is_some_and(|nearest| nearest < front) {
                return Ok(self.ready.pop().map(|Reverse(ready)| ready.value));
            }
            let found = self.vertices.next().await;
            let at_least = nearest.unwrap_or(front);
            let Some((found, node)) = found.map_err(|error| error.at_least(at_least))? else {
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

impl Vertices {
    async fn start(reader: &TileReader, at: Point, limit: f64, options: &QueryOptions) -> Result<Self, QueryError> {
        Ok(Self {
            run: EdgeRun::from_point(reader, at, limit, options).await?,
            legs: Vec::new(),
            put_in: 0,
        })
    }
}

/// Distances along edges of the triangulation.
impl TileReader {
    /// The CDT distance between two points: the length of a shortest way along edges of the triangulation that one may walk along, with
    /// both points among the vertices, and that way. None if no way leads from one to the other.
    ///
    /// It is at least the walking distance, and less than 2.42 times that (Bose and Keil 2006). An end that is no vertex is put in
    /// for this query; nothing is written. A point outside the hull is joined to the vertices of the hull that it sees.
    ///
    /// [Examples](crate::query#examples).
    ///
    /// # Errors
    /// [`BreakLines`](QueryError::BreakLines) if the file has any, [`InsideObstacle`](QueryError::InsideObstacle) if an end lies
    /// in one; otherwise as [`shortest_path`](Self::shortest_path).
    pub async fn cdt_distance(
        &self,
        from: Point,
        to: Point,
        options: QueryOptions,
    ) -> Result<Option<CdtPath>, QueryError> {
        let mut tiles = Tiles::new(self, &options);
        let to = Place::find_free(&mut tiles, to).await?;
        let from = Place::find_free(&mut tiles, from).await?;
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

    /// All vertices that can be reached from a point, in each of their sectors, by [CDT distance](Self::cdt_distance): the source
    /// tree. Vertices that are equally far away come by their coordinates.
    ///
    /// Ends and limits as [`nearest_sites`](Self::nearest_sites); and it ends with an error if the file has break lines.
    ///
    /// [Examples](crate::query#examples).
    pub fn vertices_by_cdt_distance(
        &self,
        from: Point,
        options: QueryOptions,
    ) -> impl Stream<Item = Result<CdtVertex, QueryError>> + Send + Unpin + 'static + use<> {
        let reader = self.clone();
        let start = async move {
            let mut vertices = Vertices::start(&reader, from, f64::INFINITY, &options).await?;
            vertices.run.refuse_break_lines()?;
            Ok(vertices)
        };
        unfold(start, |mut vertices: Vertices| async move {
            Ok(vertices.next().await?.map(|(vertex, _)| (vertex, vertices)))
        })
    }

    /// The sites by [CDT distance](Self::cdt_distance) from a point; equally far ones by number. Their paths are none, and their
    /// distances those along edges, with the bounds of these. Ends and limits as
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
            let mut sites = SitesAlongEdges::start(&reader, from, f64::INFINITY, &options).await?;
            sites.vertices.run.refuse_break_lines()?;
            Ok(sites)
        };
        unfold(start, |mut sites: SitesAlongEdges| async move {
            Ok(sites.next().await?.map(|(site, _)| (site, sites)))
        })
    }
}
