//! Walking distance along the edges of the triangulation: the CDT distance.
//!
//! The input is a source, and tiles on request. The output is vertices in their sectors, nearest
//! first, each with its predecessor: the source tree. The search is Dijkstra's algorithm over the
//! walkable edges: those of free triangles, and those of the hull if the outside is free. A path
//! runs along a wall on one of its sides, and passes a vertex within one sector
//! ([`free_space`](crate::query::free_space)). So a node is a vertex in a sector. In the wavefront
//! only one sector of a vertex matters; here a path may pass a vertex in each.
//!
//! ```text
//!     a ─────── b    The wall w v divides the plane round v into one sector only, but the plane
//!     │ ╲  v  ╱ │    round w, where the wall continues, into two. From a to c the edges lead round
//!     │  ╲ ║ ╱  │    v, over a v and v c, or across w only on either side of the wall: the node
//!     │   ╲║╱   │    (w, left) has an edge to a, and the node (w, right) has one to c.
//!     a'───w────c
//!          ║
//! ```
//!
//! If all constraints are walls, the CDT distance is at most 4π√3/9 < 2.42 times the shortest path
//! among the obstacles (Bose and Keil, "On the stretch factor of the constrained Delaunay
//! triangulation", ISVD 2006): a path along edges connects points that see each other, and is at
//! most that much longer. Break lines are not obstacles, but keep edges that the bound needs
//! elsewhere. So a file with break lines has no such bound.
//!
//! A source or target that is not a vertex is inserted for the one query ([`overlay`]).
//!
//! The search does no I/O: [`EdgeSearch::step`](search::EdgeSearch::step) takes a tile, and returns
//! when it needs another; [`run`] supplies the tiles.

mod cavity;
mod corner;
mod distances;
mod node;
mod overlay;
mod run;
mod search;
mod sector;
mod stretch;

#[cfg(feature = "baselines")]
pub(crate) use corner::Corner;
pub(crate) use corner::Within;
pub(crate) use distances::SitesAlongEdges;
pub use distances::{CdtPath, CdtVertex};
pub(crate) use node::Node;
pub(crate) use run::{BreakLines, EdgeRun};
pub(crate) use sector::{sector, wedge};
pub(crate) use stretch::STRETCH;
