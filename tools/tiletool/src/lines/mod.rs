//! Lines and sites from files, with the same options for `build` and `verify --against`.

mod args;
mod messages;
mod read;
mod rules;

pub use args::{LineArgs, LineFiles};
pub use read::{LineInput, LineSet};
pub use rules::{LineRules, MissingZArgs};
