//! Changes of sites: points with an id that queries search for.
//!
//! In: calls, in order. Out: the sites of each tile are what the calls ask for. A site that comes
//! where no vertex is makes one. Where a site goes, its vertex may go, too, if nothing else holds
//! it.

mod call;
mod change;

pub(crate) use call::{SiteCall, SiteCalls};
pub(crate) use change::change;
