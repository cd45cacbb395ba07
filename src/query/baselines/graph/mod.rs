//! The local visibility graph: visibility among a few obstacle edges, and shortest paths over it.
//!
//! The input is the obstacle edges that the caller considers relevant, points in free space, and a
//! source. The output is the shortest paths among these edges. The nodes are the ends of the edges
//! and the points. A sweep round a node finds the nodes that it sees (D. T. Lee, "Proximity and
//! reachability in the plane", 1978), in O(n log n) with a balanced tree. The differences are:
//!
//! - A node is swept when the search settles it, and only as far as the search may still go. Most
//!   nodes are never swept.
//! - Only tangents are found: where a path turns, the obstacle is on the inside of the turn. A node
//!   turns in one of its sectors or in none (see [`free_space`](crate::query::free_space)), so a
//!   node of the search is a vertex with the side to which paths turn there.
//! - The edges at the nodes on a ray, to its left and to its right, decide what the ray passes. So
//!   no path leaks through where edges meet, and a path runs along an edge on one of its sides.
//!
//! The graph does no I/O, and all turns are exact.

pub(crate) mod edges;
mod search;
mod status;
mod sweep;
#[cfg(test)]
mod tests;

pub(super) use edges::LocalGraph;
pub(super) use search::VisibilitySearch;
