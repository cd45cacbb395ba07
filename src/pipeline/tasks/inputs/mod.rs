//! The inputs of a build as tasks, each of which distributes the points of one input to the cells of the
//! plan.
//!
//! ```text
//! Builder ─▶ inputs ─┬▶ distribute ─▶ input-0, run-… ─┐
//!                    ├▶ distribute ─▶ input-1, run-… ─┼▶ taken by a resumed build ─▶ blocks
//!                    └▶ …                             ┘
//! ```
//!
//! The plan has the cells, and the number of the first record of each input, which its beginning
//! announces. So a task depends on the plan and on its own input alone, and its output gets its name when
//! it is complete.

mod input_task;
mod input_tasks;
mod saved;

pub use input_task::{DistributedInput, InputTask};
pub(crate) use input_tasks::TakenInputs;
pub use input_tasks::{InputPlan, InputTasks};
pub(crate) use saved::SavedInputs;
