//! Queries for walking distances: sites, vertices and paths, exact or with bounds.

mod fast;
mod paths;
mod progressive;
mod sites;

pub use progressive::{Cost, Progress};
