//! The state from which an interrupted build continues.

mod codec;
pub(super) mod journal;
