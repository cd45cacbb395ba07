//! Queries for walking distances: sites, vertices and paths, exact or with bounds.

mod candidates;
mod fast;
mod nearest;
mod paths;
mod progressive;
mod sites;

pub use progressive::{Cost, Progress};
