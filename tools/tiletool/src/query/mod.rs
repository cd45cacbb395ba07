//! `tiletool query`: point location, nearest sites, shortest paths among obstacles, and heights.

mod along;
pub mod answer;
pub mod area;
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
mod terrain;
mod text;
pub mod turns;
mod values;

pub use run::{QueryArgs, answer, run};
