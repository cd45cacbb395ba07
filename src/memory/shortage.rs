//! Too little memory: for what, and how much it takes.

use std::fmt;

use crate::geometry::Point;

/// Work takes more memory than it is allowed.
///
/// # Example
///
/// ```
/// use delaunay_tiles::{MemoryShortage, MemoryUse};
///
/// let shortage = MemoryShortage { of: MemoryUse::Split, needed: 300 << 20, budget: 256 << 20 };
/// assert!(shortage.to_string().contains("about 300 MiB of memory, and 256 MiB are allowed"));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MemoryShortage {
    /// The work.
    pub of: MemoryUse,
    /// Bytes that it takes, about.
    pub needed: u64,
    /// Bytes that it is allowed.
    pub budget: u64,
}

/// What memory is used for.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum MemoryUse {
    /// A single tile and its block.
    Tile,
    /// Seams that do not shrink as they should, so that the root would not fit: points on a curve, say.
    Seams,
    /// Triangles that are held by segments which go through many tiles.
    Held,
    /// Sources of edges, where many lines run along each other.
    Overlaps {
        /// A vertex that they run through.
        point: Point,
    },
    /// Sites and hole points, which are kept in memory.
    Sites,
    /// Segments that are split where they cross.
    Split,
    /// A polygon that is checked.
    Polygon {
        /// The number of the polygon's record.
        obstacle: u64,
    },
    /// Regions that are told apart.
    Regions,
    /// An edit of a file.
    Edit,
}

impl fmt::Display for MemoryShortage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (needed, budget) = (self.needed.div_ceil(1 << 20), self.budget >> 20);
        match self.of {
            MemoryUse::Tile => write!(
                f,
                "{budget} MiB of memory are allowed, and the work on one tile and its block takes {needed} MiB; allow more, or \
                 use smaller tiles"
            ),
            MemoryUse::Seams => write!(
                f,
                "these points have so many neighbours across cells that merging takes about {needed} MiB of memory, and {budget} \
                 MiB are allowed; allow that much"
            ),
            MemoryUse::Held => write!(
                f,
                "segments cross so many tiles that the triangles on their way take about {needed} MiB of memory, and {budget} MiB \
                 are allowed; allow that much"
            ),
            MemoryUse::Overlaps { point: Point { x, y } } => write!(
                f,
                "so many lines run along each other at ({x}, {y}) that edges take {needed} MiB of memory or more to know all of \
                 theirs, and {budget} MiB are allowed; leave out those that are there more than once, or allow more"
            ),
            MemoryUse::Sites => write!(
                f,
                "sites and hole points take a quarter of {needed} MiB of memory, and {budget} MiB are allowed in all; allow that \
                 much"
            ),
            MemoryUse::Split => write!(
                f,
                "splitting segments where they cross takes about {needed} MiB of memory, and {budget} MiB are allowed; allow that \
                 much"
            ),
            MemoryUse::Polygon { obstacle } => write!(
                f,
                "so much of obstacle {obstacle} lies side by side that checking it takes about {needed} MiB of memory, and \
                 {budget} MiB are allowed for that; allow {factor} times as much in all",
                factor = self.needed.div_ceil(self.budget.max(1))
            ),
            MemoryUse::Regions => write!(
                f,
                "telling the regions between segments apart takes about {needed} MiB of memory, and {budget} MiB are allowed; \
                 allow that much"
            ),
            MemoryUse::Edit => write!(
                f,
                "this takes {needed} MiB of memory at least, and {budget} MiB are allowed; allow more"
            ),
        }
    }
}

impl std::error::Error for MemoryShortage {}
