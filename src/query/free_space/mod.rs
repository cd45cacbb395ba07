//! Where one may walk: what blocks, the sectors round vertices, and the places where queries begin and end.

mod footing;
mod ground;
mod marks;
mod nearest_free;
mod passages;
mod place;
mod sight;
mod spot;
mod wedges;

pub use footing::Footing;
pub(crate) use ground::{Beyond, Ground};
pub(crate) use marks::Mark;
#[cfg(feature = "baselines")]
pub(crate) use nearest_free::nearest_on;
pub(crate) use passages::{Passage, Passages};
pub(crate) use place::Place;
pub(crate) use spot::Spot;
pub(crate) use wedges::Wedge;
