//! `tiletool query`: point location, nearest sites, and shortest paths among obstacles.

mod along;
pub mod answer;
mod area;
pub mod args;
pub mod ask;
pub mod batch;
pub mod command;
mod matrix;
mod picture;
mod print;
mod progress;
mod run;
mod stage;
mod values;

pub use run::{QueryArgs, answer, run};
