//! Lines and sites from files: the same options for `build` and for `verify --against`.

mod args;
mod messages;
mod read;
mod rules;

pub use args::{LineArgs, LineFiles};
pub use read::Lines;
pub use rules::{LineRules, MissingZArgs};
