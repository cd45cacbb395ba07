//! Rows of delimited text: comma, semicolon, tab or blanks.

mod ahead;
mod columns;
mod points;
mod rows;
mod segments;
mod sites;

pub use points::Points;
pub use segments::Segments;
pub use sites::Sites;
