//! The state from which an interrupted build continues: its plan, its segments, and the journal of
//! its finished blocks.

pub(super) mod checked_file;
pub(super) mod codec;
pub(super) mod journal;
pub(super) mod plan;
mod values;
