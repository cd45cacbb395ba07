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
//! Calls that do not fit into memory are on disk, in parts that do (spilled).
//!
//! Points come before lines, and go after them. So the triangulation never becomes smaller than it
//! will be, and what lines hold stays. A vertex goes if nothing holds it: no point, no site, and no
//! end of a segment.

mod bytes;
mod call;
mod calls;
mod delete;
mod insert;
mod net;
mod removal;
mod spilled;

pub(crate) use bytes::{MAX_CALL_BYTES, decode_call, encode_call};
pub(crate) use call::{CallInTile, PointCall};
pub(crate) use calls::PointCalls;
pub(crate) use delete::{Gone, delete};
pub(crate) use insert::{Inserted, insert};
pub(crate) use net::{Attributes, Missing, Positions, tile_at};
pub(crate) use spilled::SpilledCalls;
