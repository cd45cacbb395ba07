//! Paths: their points, and what they bend around.

use super::distance::Distance;
use crate::geometry::Point;
use crate::store::{EdgeSource, Vertex, VertexId};

/// A shortest path.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Path {
    /// The length of the path.
    pub distance: Distance,
    /// The start, the bends and the end.
    pub points: Vec<Point>,
    /// The bends, in order: one for each point between start and end.
    pub bends: Vec<Bend>,
    /// Whether the path was proved by a walk through the triangles that it passes.
    pub is_certified: bool,
}

/// A bend of a path.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Bend {
    /// The vertex of the bend.
    pub vertex: Vertex,
    /// Whether the path turns left, with an obstacle on its left. Otherwise it turns right, with an
    /// obstacle on its right.
    pub turns_left: bool,
    /// The other end of the edge at the vertex that the path bends around. `None` if nothing is in
    /// the way, because the path is not a shortest one.
    pub edge_to: Option<Vertex>,
    /// The lines along that edge, in the direction from the vertex. Empty if the edge only
    /// separates a hole that was not drawn.
    pub sources: Vec<EdgeSource>,
}

/// A point of a path, and its vertex if it is one.
pub(crate) type WayPoint = (Point, Option<VertexId>);

/// The outcome of a query for a path.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum PathOutcome {
    /// A shortest path.
    Found(Path),
    /// Both ends are free, but no path connects them.
    Unreachable,
    /// An end is in an obstacle.
    InsideObstacle {
        /// The end.
        point: Point,
        /// The nearest free point, rounded; `None` if no point is free.
        nearest_free: Option<Point>,
    },
}

#[cfg(all(test, feature = "serde"))]
mod tests {
    use super::*;
    use crate::geometry::VertexIndex;
    use crate::store::{LineKind, TileId};

    #[test]
    fn a_path_serialises_with_its_bends() {
        let id = VertexId {
            tile: TileId(2),
            index: VertexIndex(3),
        };
        let vertex = Vertex {
            id,
            point: Point::new(3.0, 4.0),
        };
        let path = Path {
            distance: Distance::of_legs(5.0, 1),
            points: vec![Point::new(0.0, 0.0), vertex.point],
            bends: vec![Bend {
                vertex,
                turns_left: true,
                edge_to: None,
                sources: vec![EdgeSource::new(LineKind::Obstacle, 7)],
            }],
            is_certified: false,
        };
        let json = serde_json::to_value(PathOutcome::Found(path)).unwrap();
        let bend = &json["Found"]["bends"][0];
        assert_eq!(json["Found"]["points"][1]["y"], 4.0);
        assert_eq!(bend["vertex"]["id"]["tile"], 2);
        assert_eq!(bend["sources"][0]["kind"], "obstacle");
        assert_eq!(
            (&bend["sources"][0]["number"], &bend["sources"][0]["depth_change"]),
            (&7.into(), &1.into())
        );
    }
}
