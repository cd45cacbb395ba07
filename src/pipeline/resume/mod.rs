//! What a build that was interrupted goes on from.

mod codec;
pub(super) mod journal;
