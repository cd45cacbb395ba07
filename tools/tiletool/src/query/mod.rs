//! `tiletool query`: point location, nearest sites, shortest paths among obstacles, and heights.

mod along;
pub mod args;
pub mod batch;
pub mod command;
mod matrix;
mod picture;
mod print;
mod progress;
mod rows;
mod run;
mod stage;
mod terrain;
mod text;
pub mod turns;

// The Python package and the laboratory use them.
pub use delaunay_tiles_answers::{answer, area, ask, question};
pub use run::{QueryArgs, answer, run};
