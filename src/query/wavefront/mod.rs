//! The wave: from a source over free triangles, to sites, vertices or places, nearest first; exact.
//!
//! After Cui, Harabor and Grastien, "Compromise-free pathfinding on a navigation mesh" (IJCAI 2017), which looks for one goal,
//! and Zhao, Taniar and Harabor, "Fast k-nearest neighbor on a navigation mesh" (SoCS 2018), which has many: a root sees
//! intervals of sides; an interval is pushed through the triangle behind it and falls into what is seen of the two other sides.
//! Where a corner is in the way, it becomes a root in its turn. However:
//!
//! - The end of an interval is kept as the vertex that bounds the ray there, so every turn is one of three input points, and exact.
//! - A vertex becomes a root when it is the nearest thing to do, not where it is seen, and by way of its star, which knows its
//!   sectors ([`ground`](crate::query::free_space::ground)): nothing leaks where obstacles touch.
//! - The outside of the hull is no triangle. A shortest way between two points of the closed hull stays in it, for the way to
//!   the nearest point of a convex set lengthens nothing; so the outside is walked through along hull edges only, and besides
//!   from a source and to places that lie there.
//!
//! ```text
//!        c               the cone of root r between the rays through R and L enters the triangle a b c by side b a;
//!       ╱ ╲              c is in it, so it falls into the cone from R to c, over side b c, and that from c to L, over side c a
//!    a ╱───╲ b
//!     L│   ╱R            side s of the triangle runs from a, seen on the left, to b, seen on the right
//!       ╲ ╱
//!        r
//! ```
//!
//! It has no I/O: [`Wave::step`] is given a tile, and tells when it needs another.

mod bend;
mod cone;
mod found;
mod goal;
mod heap;
mod join;
mod parts;
mod queue;
mod reached;
mod roots;
mod run;
mod see;
mod spread;
mod start;
mod step;
mod task;
mod waiting;
mod wave;

pub(crate) use found::What;
pub(crate) use goal::{Goal, Places};
pub(crate) use parts::{Part, Shape, Side};
pub(crate) use run::{Approach, Run};
