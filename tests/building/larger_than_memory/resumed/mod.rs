//! The promise: a build that is stopped at any moment goes on, and gives the file of a build that was
//! not stopped, byte for byte.

mod lines;
mod points;
