//! From points to a tile file: divide, conquer, merge, borders.
//!
//! ```text
//! push ─┬─▶ point_store ──────────────────────────┐ all points in memory: one block
//!       └─▶ spill ──▶ runs ──▶ plan ──▶ prefetch ─┤ or many on disk, read one ahead of those in work
//! push_lines ─▶ segments ─────────────────────────┤ those that meet a block go with it
//!                                                 ▼
//!              conquest: divide ──▶ leaf ──▶ merge ──▶ border_log ──▶ border ──▶ output ──▶ OUT
//!                        k-d tree   cores    late      spilled        the rest   writes,
//!                        and cells  seams    triangles by groups      of tiles   journal
//!                                    └─ node ─┘
//!                                    constrain and components, where there are segments; regions before borders
//! ```
//!
//! [`Builder`] takes batches; `assembly` makes the file of them and starts `pipeline` on computing threads, which share a board of tasks (`schedule`). What
//! they finish comes in the order of the file (`ordered`) through a channel to the task that writes (`output`).

mod assembly;
mod builder;
pub(crate) mod conquer;
mod disk;
pub(crate) mod error;
pub(crate) mod finish;
pub(crate) mod ingest;
pub(crate) mod options;
mod output;
mod plan;
pub(crate) mod records;
mod resume;
mod run;
pub(crate) mod summary;
mod terms;
mod threads;
pub(crate) mod work_folder;

pub use builder::Builder;
pub use error::BuildError;
pub use options::{BuildOptions, Crossings, Duplicates, Phase, Progress, Steiner, UnknownDuplicates};
pub use records::Description;
pub use summary::{BuildSummary, LevelSummary, PhaseSummary, Waits};
