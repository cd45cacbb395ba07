//! Walking distance along the edges of the triangulation: the CDT distance.
//!
//! In: a source, and tiles as they are asked for. Out: vertices in their sectors, nearest first, each with the one before it: the source
//! tree. It is Dijkstra's search over the edges that one may walk along: those of free triangles, and those of the hull where the
//! outside is free. A wall is walked along on one of its sides, and a vertex is passed within one sector ([`ground`](crate::query::free_space::ground)),
//! so a node is a vertex in a sector: unlike in the wave, where only one sector of a vertex matters, a way may pass it in each.
//!
//! ```text
//!     a ─────── b         the wall w v parts what is round v into one sector only, but round w, where it goes on, into two. From a
//!     │ ╲  v  ╱ │         to c the edges lead round v, over a v and v c, or across w only on either side of the wall:
//!     │  ╲ ║ ╱  │         (w, left) has an edge to a, and (w, right) one to c
//!     │   ╲║╱   │
//!     a'───w────c
//!          ║
//! ```
//!
//! It is at most 4π√3/9 < 2.42 times the shortest way among obstacles if all constraints are walls (Bose and Keil, "On the stretch factor of
//! the constrained Delaunay triangulation", ISVD 2006): what sees each other is joined by edges no longer than that. Break lines are
//! no obstacles, but hold edges in place that the bound needs elsewhere; so there is no such bound where a file has them.
//!
//! A source or target that is no vertex is put in for the one query ([`overlay`]).
//!
//! It has no I/O: [`EdgeSearch::step`] is given a tile, and tells when it needs another; [`run`] feeds it.

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
