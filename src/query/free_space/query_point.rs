//! The points where queries start or end: their vertex, edge or triangle, whether they are free,
//! and the nearest free point if not.

use super::nearest_free::nearest_free;
use super::position::Position;
use super::space::FreeSpace;
use super::wedges::Wedge;
use crate::geometry::{Point, TriangleId};
use crate::query::locating::{Location, TriangleRef, Walked};
use crate::query::request::{QueryError, Tiles};
use crate::store::{TileId, Vertex, VertexId};

/// A point of a query, with its position in the triangulation.
#[derive(Clone, Debug)]
pub(crate) struct QueryPoint {
    pub(crate) point: Point,
    pub(crate) position: Position,
    /// Whether the point is free.
    pub(crate) is_free: bool,
    /// Whether the point is outside the hull or on its edge, and the outside is free.
    pub(crate) is_outside: bool,
    /// The corners of the free triangles that contain the point, inside or on an edge; empty for a
    /// vertex.
    pub(crate) triangles: Vec<[Point; 3]>,
    /// The free triangles at the point's vertex or edge, as far as they are known.
    pub(crate) around: Vec<(TileId, TriangleId)>,
}

impl QueryPoint {
    /// Finds the position of a point. A coordinate counts as 0 if it is closer to 0 than any
    /// coordinate of a triangulation can be.
    pub(crate) async fn find(tiles: &mut Tiles, point: Point) -> Result<Self, QueryError> {
        let point = point.representable();
        if !point.is_valid() {
            return Err(QueryError::NotAPoint { point });
        }
        let Walked { location, exit } = tiles.walk(point).await?;
        let position = match (location, exit) {
            (Location::InTriangle(triangle), _) => Position::Triangle(triangle),
            (Location::OnEdge { ends, .. }, _) => Position::Edge { ends },
            (Location::OnVertex(vertex), _) => Position::Vertex(vertex),
            (Location::Outside, Some(edge)) => Position::Outside(edge),
            (Location::Outside, None) => return Err(tiles.no_triangles()),
        };
        let mut this = Self {
            point,
            position,
            is_free: false,
            is_outside: false,
            triangles: Vec::new(),
            around: Vec::new(),
        };
        this.determine_freedom(tiles).await?;
        Ok(this)
    }

    /// Finds the position of a point, and fails with [`QueryError::InsideObstacle`] if it is not
    /// free.
    pub(crate) async fn find_free(tiles: &mut Tiles, point: Point) -> Result<Self, QueryError> {
        let query_point = Self::find(tiles, point).await?;
        if query_point.is_free {
            return Ok(query_point);
        }
        let nearest_free = query_point.nearest_free(tiles).await?;
        Err(QueryError::InsideObstacle { point, nearest_free })
    }

    /// Returns the free point nearest to this one, which is not free; `None` if no point is free.
    pub(crate) async fn nearest_free(&self, tiles: &mut Tiles) -> Result<Option<Point>, QueryError> {
        nearest_free(tiles, self.point, self.position).await
    }

    /// Finds out whether a vertex is free.
    pub(crate) async fn at_vertex(tiles: &mut Tiles, vertex: Vertex) -> Result<Self, QueryError> {
        let mut this = Self::at(vertex);
        this.is_free = false;
        this.determine_freedom(tiles).await?;
        Ok(this)
    }

    /// Returns the query point of a vertex that is known to be free.
    pub(crate) fn at(vertex: Vertex) -> Self {
        Self {
            point: vertex.point,
            position: Position::Vertex(vertex),
            is_free: true,
            is_outside: false,
            triangles: Vec::new(),
            around: Vec::new(),
        }
    }

    /// Returns the vertex at the point, if there is one.
    pub(crate) fn vertex(&self) -> Option<VertexId> {
        match self.position {
            Position::Vertex(vertex) => Some(vertex.id),
            _ => None,
        }
    }

    /// Returns the tile that a search from here needs first.
    pub(crate) fn tile(&self) -> TileId {
        match self.position {
            Position::Triangle(triangle) => triangle.tile,
            Position::Edge { ends: [_, end] } => end.id.tile,
            Position::Vertex(vertex) => vertex.id.tile,
            Position::Outside([from, _]) => from.tile,
        }
    }

    /// Determines whether the point is free.
    async fn determine_freedom(&mut self, tiles: &mut Tiles) -> Result<(), QueryError> {
        let outside_is_free = tiles.outside_is_free();
        match self.position {
            Position::Outside(_) => self.is_outside = outside_is_free,
            Position::Triangle(TriangleRef { tile, triangle, .. }) => {
                let tile = tiles.get(tile).await?;
                if !tile.is_hole(triangle) {
                    self.triangles.push(tile.triangle_points(triangle));
                }
            }
            Position::Vertex(vertex) => {
                let tile = tiles.get(vertex.id.tile).await?;
                if tile.leaving(vertex.id.index).is_none() {
                    return Err(tiles.no_triangles());
                }
                let wedges = FreeSpace::of(tiles, &tile).free_wedges(vertex.id.index);
                let wedges = tiles.checked(tile.id(), wedges)?;
                self.is_free = !wedges.is_empty();
                for wedge in wedges {
                    if let Wedge::Triangle(half_edge) = wedge {
                        self.around.push((tile.id(), half_edge.triangle()));
                    }
                }
            }
            Position::Edge { ends: [a, b] } => {
                for [from, to] in [[a, b], [b, a]] {
                    match tiles.half_edge_between(from.id, to.id).await? {
                        Some((tile, half_edge)) if tile.is_hole(half_edge.triangle()) => {}
                        Some((tile, half_edge)) => {
                            self.triangles.push(tile.triangle_points(half_edge.triangle()));
                            self.around.push((tile.id(), half_edge.triangle()));
                        }
                        None => self.is_outside |= outside_is_free,
                    }
                }
            }
        }
        self.is_free |= self.is_outside || !self.triangles.is_empty();
        Ok(())
    }
}
