//! The wavefront: an exact search from a source through free triangles to sites, vertices or query
//! points, nearest first.
//!
//! The method follows Cui, Harabor and Grastien, "Compromise-free pathfinding on a navigation mesh"
//! (IJCAI 2017), for one goal, and Zhao, Taniar and Harabor, "Fast k-nearest neighbor on a
//! navigation mesh" (SoCS 2018), for many. A root sees an interval of an edge through a *window*.
//! The window is pushed through the triangle behind the edge, and splits into what the root sees of
//! the two other edges. A corner that is in the way becomes a root itself. The differences are:
//!
//! - The end of an interval is kept as the vertex that bounds the ray there. So every turn is a
//!   turn of three input points, and exact.
//! - A vertex becomes a root when it is next in the queue, not when it is seen, and by way of its
//!   star, which knows the sectors ([`free_space`](crate::query::free_space)). So no path leaks
//!   through where obstacles touch.
//! - The outside of the hull has no triangles. A shortest path between two points of the closed
//!   hull stays in it, because projection to the nearest point of a convex set lengthens nothing.
//!   So paths outside run along hull edges only, except from a source and to query points outside.
//!
//! ```text
//!        c         The window of root r between the rays through R and L enters the triangle a b c
//!       ╱ ╲        over the edge a b. It contains c, so it splits into the window from R to c,
//!    a ╱───╲ b     over the edge b c, and the window from c to L, over the edge c a.
//!     L│   ╱R
//!       ╲ ╱        The half-edge of the entered triangle runs from a, seen on the left, to b,
//!        r         seen on the right.
//! ```
//!
//! The wavefront does no I/O: [`Wavefront::step`](state::Wavefront::step) takes a tile, and returns
//! when it needs another.

mod aims;
mod bend;
mod found;
mod goal;
mod heap;
mod join;
mod queue;
mod reached;
mod regions;
mod roots;
mod run;
mod see;
mod spread;
mod start;
mod state;
mod step;
mod task;
mod waiting;
mod whole;
mod window;

pub(crate) use found::{FoundTarget, Target};
pub(crate) use goal::{Goal, QueryPoints};
pub(crate) use regions::{HalfPlane, RegionShape, VisibleRegion, WholeTriangle};
pub(crate) use run::{Approach, WavefrontRun};
