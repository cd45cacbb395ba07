//! Questions by walking distance and by Euclidean distance.
//!
//! A function takes a reader, points as arrays and [`Options`](batch::Options), and answers in
//! columns. Where answers have several lengths, a column of offsets says where each begins: the
//! Python part gives them their shapes and names.
//!
//! ```text
//!   sites   paths   distances   along   area   euclidean   footing     one kind of question each
//!     │       │         │         │       │        │          │
//!     ├───────┴── ways  │         │       │        │          │       columns of many paths
//!     └─────────────────┴──── ends, names, batch ──┴──────────┘       how each question ended; ids
//! ```

pub mod along;
pub mod area;
mod batch;
pub mod distances;
mod ends;
pub mod euclidean;
pub mod footing;
mod names;
pub mod paths;
pub mod sites;
mod ways;
