//! The blocks of a build as tasks, each of which any process may do that shares the work folder.
//!
//! ```text
//! Builder ─▶ plan, tasks, runs, ─┬▶ conquer ─▶ block-0, cores-0 ─┐
//!            segments-…          ├▶ conquer ─▶ block-1, cores-1 ─┼▶ gather: tiles, borders, journal ─▶ resumed build
//!                                └▶ …                            ┘
//! ```
//!
//! A task depends on the plan and on its own block alone, and its output gets its name when it is
//! complete. So it may be done twice, anywhere and in any order, and it may be killed. Each block has
//! a range of tile numbers from the plan; numbers that it does not use stay unused in the file.
//! The [`inputs`] may be tasks too, before there are blocks.

mod block_file;
mod block_tasks;
mod conquer;
mod gather;
pub(crate) mod inputs;
pub(crate) mod left;
pub(crate) mod saved;
pub(crate) mod stored;

pub use block_tasks::BlockTasks;
pub use conquer::{ConqueredBlock, TaskOptions};
pub use inputs::{DistributedInput, InputPlan, InputTask, InputTasks};
