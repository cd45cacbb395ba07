//! Vertices without z.

use std::fmt;

use crate::geometry::Point;
use crate::store::EdgeSource;

/// The value that stands for a missing z. The z of the input are finite.
pub(crate) const NO_Z: f64 = f64::NAN;

/// A vertex without z.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct VertexWithoutZ {
    /// The kind of vertex.
    pub what: WithoutZ,
    /// The position of the vertex.
    pub point: Point,
    /// The line with the smallest number that ends there or was cut there, if any.
    pub line: Option<EdgeSource>,
}

/// The kind of a vertex without z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum WithoutZ {
    /// The point with this record number.
    Point(u64),
    /// An end of a line.
    End,
    /// A point where lines cross each other or borders.
    Crossing,
    /// The site with this number.
    Site(u64),
}

impl fmt::Display for VertexWithoutZ {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.what, self.line) {
            (WithoutZ::Point(record), _) => write!(f, "record {record}")?,
            (WithoutZ::Site(site), _) => write!(f, "site {site}")?,
            (WithoutZ::End, Some(line)) => write!(f, "an end of {} {}", line.kind(), line.number())?,
            (WithoutZ::End, None) => write!(f, "an end of a line")?,
            (WithoutZ::Crossing, _) => write!(f, "a point where lines cross")?,
        }
        write!(f, " at ({}, {})", self.point.x, self.point.y)
    }
}
