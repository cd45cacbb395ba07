//! Changes of points: insertion, deletion, moves, and new z.
//!
//! In: calls, in order. Out: the points of the file are what the calls ask for.
//!
//! ```text
//!   calls, by tile ──▶ the point at each position, before and after (net)
//!                           │        │
//!   new and changed points (insert)  └──▶ points that go, at the end (delete, removal)
//! ```
//!
//! Points come before lines, and go after them. So the triangulation never becomes smaller than it
//! will be, and what lines hold stays. A vertex goes if nothing holds it: no point, no site, and no
//! end of a segment.

mod call;
mod delete;
mod insert;
mod net;
mod removal;

pub(crate) use call::{CallInTile, PointCall, PointCalls};
pub(crate) use delete::delete;
pub(crate) use insert::{Inserted, insert};
pub(crate) use net::{Attributes, Missing, Positions, tile_at};
