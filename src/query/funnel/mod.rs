//! A way over edges, pulled taut among the obstacles.
//!
//! In: the vertices of a way along edges, each in its sector. Out: a way that is not longer, and bends, as a rule, only where it is in
//! the way of something. The triangles along the way make a *sleeve*, through which the [funnel](funnel) finds the shortest way. Where that bends round a
//! vertex with nothing behind it, the sleeve is led round the vertex on the other side (as edges of a path are flipped by Sharp
//! and Crane, "You can find geodesic paths in triangle meshes by just flipping edges", 2020), and so on, for some rounds.
//!
//! The sleeve only goes over edges that nothing blocks, within one sector of each vertex, so nothing leaks. What is walked outside the
//! hull, along its edges, stays as it is.

mod pull;
mod sleeve;
mod taut;

pub(crate) use taut::{length, taut};
