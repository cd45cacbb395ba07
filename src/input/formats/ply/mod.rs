//! PLY (Turk, "The PLY Polygon File Format", 1994): ASCII and binary, of either byte order.
//!
//! In: a stream. Out: the points of the element `vertex`, from its properties x, y and, if there is
//! one, z, of any type of number; or the edges of the faces. All other elements and properties are
//! passed over, lists too.
//!
//! ```text
//! ply
//! format binary_little_endian 1.0      or ascii, binary_big_endian
//! comment …
//! element vertex 4                     an element, and its number of rows
//! property double x                    a number in each row
//! element face 2
//! property list uchar int vertex_indices        a count of the first type, then so many numbers
//! end_header
//! …                                    the rows of all elements, without anything in between
//! ```
//!
//! The reader is the library's own. The crate `ply-rs-bw` 4 reads an element into a list, or, row
//! by row, a list of a row as long as it claims to be and a line of any length; it sets each
//! property by its name. Here a row has at most [`MOST_ITEMS`](rows::MOST_ITEMS) numbers to keep,
//! and no count is trusted: what the header claims must be in the file.

mod body;
mod edges;
mod header;
mod points;
mod rows;

pub use edges::{Edges, vertices};
pub use points::Points;
