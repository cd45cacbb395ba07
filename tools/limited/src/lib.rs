//! Runs programs under a hard limit of memory, and measures them from outside.
//!
//! [`Limit`] is the limit: a cgroup where one may be made, otherwise a thread that watches the
//! process. [`measure`] runs a command to its end. [`cases`] has the commands of `tiletool` that
//! take `--memory`, with inputs made for them.

pub mod cases;
mod cgroup;
mod limit;
mod measure;

pub use limit::Limit;
pub use measure::{Ended, Took, measure};

/// Returns the text after the first line's name `name` and a colon, in a text of the kernel.
#[must_use]
pub fn after_colon<'a>(text: &'a str, name: &str) -> Option<&'a str> {
    let mut lines = text.lines().filter_map(|line| line.split_once(':'));
    lines.find_map(|(key, value)| (key.trim() == name).then(|| value.trim()))
}
