//! `tiletool query`: point location, nearest sites, and shortest paths among obstacles.

mod along;
pub mod answer;
mod area;
pub mod args;
pub mod ask;
mod asked;
pub mod batch;
pub mod command;
mod matrix;
mod objects;
mod picture;
mod print;
mod progress;
mod rows;
mod run;
mod stage;
mod text;
mod values;

pub use run::{QueryArgs, answer, run};
