//! What may be done and held at once.

mod outgoing;
mod slots;

pub use outgoing::Outgoing;
pub use slots::Slots;
