//! Shortens a path along edges among the obstacles.
//!
//! The input is the vertices of a path along edges, each in its sector. The output is a path that
//! is not longer, and bends, as a rule, only where an obstacle is in the way. The triangles along
//! the path form a *sleeve*, and the [funnel algorithm](portals) finds the shortest path within the
//! sleeve. Where that path bends round a vertex with no obstacle behind it, the sleeve is moved to
//! the other side of the vertex, and so on for some rounds. Sharp and Crane flip the edges of a
//! path in the same way ("You can find geodesic paths in triangle meshes by just flipping edges",
//! 2020).
//!
//! The sleeve crosses only edges that do not block, within one sector of each vertex, so no path
//! leaks through obstacles. Parts of the path outside the hull, along its edges, are not changed.

mod portals;
mod shorten;
mod sleeve;

pub(crate) use shorten::{length, shorten};
