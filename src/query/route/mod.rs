//! A path as it bends, and its proof.

mod bends;
mod certify;

pub(crate) use bends::{path, path_with};
