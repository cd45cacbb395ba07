//! The local visibility graph: what sees what among a few obstacle edges, and shortest paths over it.
//!
//! In come the edges of obstacles that someone thinks matter, points that lie in the open, and a source; out come the shortest paths
//! among these edges. Its nodes are the ends of the edges and the points. Which nodes a node sees is found by a sweep round it
//! (D. T. Lee, "Proximity and reachability in the plane", 1978), in O(n log n) with a balanced tree. However:
//!
//! - A node is swept when the search settles it, and only as far as the search may still go: most nodes never are.
//! - Only tangents are looked for: where a path turns, the obstacle is on the inside of the turn. A node turns in one of its
//!   sectors or in none (see [`ground`](crate::query::free_space::ground)), so a node of the search is a vertex and the side that paths turn to there.
//! - What a ray passes is told by the edges at the nodes on it, to the left and to the right of the ray: nothing leaks through
//!   where edges meet, and one walks along an edge on a side of it.
//!
//! It has no I/O, and all turns are exact.

pub(crate) mod edges;
mod search;
mod status;
mod sweep;
#[cfg(test)]
mod tests;

pub(super) use edges::LocalGraph;
pub(super) use search::Search;
