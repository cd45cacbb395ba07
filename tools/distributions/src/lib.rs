//! Seeded point sets and PSLGs to test and measure triangulations with.
//!
//! The input is a [`Kind`], a number of points and a seed. The output is an iterator of coordinates
//! that are computed on the fly: it needs the same few hundred bytes for ten points and for ten
//! billion. The same arguments give the same bits on every platform and in every later version;
//! `tests/golden.rs` checks this.
//!
//! ```
//! use distributions::{Kind, Pslg, points};
//!
//! let cloud: Vec<[f64; 2]> = points(Kind::Kuzmin, 1000, 42).collect();
//! assert_eq!(cloud.len(), 1000);
//!
//! let pslg = Pslg::new(Kind::Uniform, 3000, 0.5, 42)?;
//! assert_eq!(pslg.points().count(), 3000);
//! assert!(pslg.segments().all(|[a, b]| a < 3000 && b < 3000)); // about 1500 of them
//! # Ok::<(), distributions::Unsupported>(())
//! ```
//!
//! X. Wu measured with the uniform and Kuzmin distributions, the line singularity and the PSLGs on
//! them in *I/O-Efficient Algorithm for Constrained Delaunay Triangulation with Applications to
//! Proximity Search* (thesis, National University of Singapore, 2004). The shuffled grid and the
//! long segments are harder cases; the other kinds resemble real data or are degenerate.

mod circle;
mod degenerate;
mod kind;
mod long;
mod map;
mod points;
mod pslg;
mod random;
mod scattered;
mod shuffle;
mod source;
mod surveyed;

pub use kind::{Kind, UnknownKind};
pub use long::LongSegments;
pub use map::{Map, MapKind};
pub use points::{Points, Points3, points, points3};
pub use pslg::{Pslg, PslgPoints, Unsupported};
pub use random::mix;
