//! The bends of a path, and its proof.

mod bends;
mod certify;

pub(crate) use bends::{path, path_with};
