//! Data structures and sorts that do not depend on triangulations.

pub(crate) mod bucket_sort;
pub(crate) mod keyed;
pub(crate) mod mix;
pub(crate) mod prefetch;
pub(crate) mod union_find;
