//! Paths as they are told: their points, and what they bend around.

use super::distance::Distance;
use crate::geometry::Point;
use crate::store::{EdgeSource, Vertex, VertexId};

/// A shortest path.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Path {
    /// How long it is.
    pub distance: Distance,
    /// From its start by way of its bends to its end.
    pub points: Vec<Point>,
    /// Where it bends, in order: one for each point between start and end.
    pub bends: Vec<Bend>,
    /// Whether it was proved by a walk through the triangles that it passes.
    pub is_certified: bool,
}

/// A bend of a path.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Bend {
    /// The vertex at which it is.
    pub vertex: Vertex,
    /// Whether the path turns left there, with an obstacle on its left; otherwise right.
    pub turns_left: bool,
    /// The other end of the edge, from the vertex, that it bends around. None if nothing is in the way: the path is not a shortest one.
    pub edge_to: Option<Vertex>,
    /// The lines along that edge, as seen from the vertex; none if it only separates a hole that nothing drew.
    pub sources: Vec<EdgeSource>,
}

/// A point of a way: where it is, and the vertex if it is one.
pub(crate) type WayPoint = (Point, Option<VertexId>);

/// How a question for a path ends.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum PathOutcome {
    /// With a shortest path.
    Found(Path),
    /// Both ends are free, but no way leads from one to the other.
    Unreachable,
    /// An end lies in an obstacle.
    InsideObstacle {
        /// The end.
        point: Point,
        /// The nearest point where one may be, rounded; none if there is none.
        nearest_free: Option<Point>,
    },
}

#[cfg(all(test, feature = "serde"))]
mod tests {
    use super::*;
    use crate::geometry::VertexIndex;
    use crate::store::{LineKind, TileId};

    #[test]
    fn a_path_serialises_with_what_it_bends_around() {
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
