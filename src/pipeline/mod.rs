//! Turns points into a tile file: divide, conquer, merge, borders.
//!
//! ```text
//! push ─┬─▶ point_store ──────────────────────────┐ all points in memory: one block
//!       └─▶ spill ──▶ runs ──▶ plan ──▶ prefetch ─┤ or many on disk, read ahead of the computing
//! push_lines ─▶ segments ─────────────────────────┤ a block gets the segments that meet it
//!                                                 ▼
//!              conquest: divide ──▶ leaf ──▶ merge ──▶ border_log ──▶ border ──▶ output ──▶ OUT
//!                        k-d tree   cores    late      spilled        the rest   writes,
//!                        and cells  seams    triangles by groups      of tiles   journal
//!                                    └─ node ─┘
//!                                    constrain and components, where there are segments;
//!                                    regions before borders
//! ```
//!
//! Where lines or sites lack z and points have it, `draping` first takes all points through this
//! once, alone, and `ingest::drape` gives vertices the z of that surface.
//!
//! [`Builder`] takes batches (`ingest`). `assembly` makes the file from them: it starts `run` on
//! computing threads, which share a board of tasks (`conquer::schedule`). Their results pass in the
//! order of the file (`output::ordered`) through a channel to the task that writes
//! (`output::writer`). After the root, `finish` assembles the borders. `resume` holds the state
//! from which an interrupted build continues. `tasks` distributes inputs and conquers blocks one by
//! one, in any process, for a build that is then resumed; `task_store` is where they find their points
//! and leave their tiles if they share no folder. `records` holds the values that phases pass to each
//! other.

mod assembly;
mod builder;
pub(crate) mod conquer;
mod context;
mod disk;
pub(crate) mod draping;
pub(crate) mod error;
pub(crate) mod finish;
pub(crate) mod ingest;
pub(crate) mod next_state;
pub(crate) mod options;
mod output;
mod plan;
pub(crate) mod records;
mod resume;
mod run;
pub(crate) mod summary;
mod task_store;
mod tasks;
mod threads;
pub(crate) mod work_folder;

pub use builder::{Builder, Planned};
pub use error::BuildError;
pub use options::{BuildOptions, Crossings, Duplicates, Phase, Progress, Steiner, UnknownDuplicates};
pub use records::Description;
pub use summary::{BuildSummary, LevelSummary, PhaseSummary, Waits};
pub use task_store::TaskStore;
pub use tasks::{BlockTasks, ConqueredBlock, DistributedInput, InputPlan, InputTask, InputTasks, TaskOptions};
