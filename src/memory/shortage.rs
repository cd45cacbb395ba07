//! The error of work that needs more memory than it is allowed.

use std::fmt;

use crate::geometry::Point;

/// The error of work that needs more memory than it is allowed.
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
    /// The work that needs the memory.
    pub of: MemoryUse,
    /// The bytes that the work needs, approximately.
    pub needed: u64,
    /// The bytes that the work is allowed.
    pub budget: u64,
}

/// A use of memory.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum MemoryUse {
    /// A single tile and its block.
    Tile,
    /// Seams that do not shrink as they should, so that the root would not fit. This happens with
    /// points on a curve, for example.
    Seams,
    /// Triangles held by segments that cross many tiles.
    Held,
    /// Sources of edges, where many lines overlap.
    Overlaps {
        /// A vertex on these lines.
        point: Point,
    },
    /// Sites, ponds and hole points, which stay in memory.
    Sites,
    /// Segments that are split where they cross.
    Split,
    /// A polygon that is checked.
    Polygon {
        /// The number of the polygon's record.
        obstacle: u64,
    },
    /// Regions between segments.
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
                "the work on one tile and its block needs {needed} MiB of memory, and {budget} MiB are allowed; allow more, or use \
                 smaller tiles"
            ),
            MemoryUse::Seams => write!(
                f,
                "too many points have neighbours in other cells: merging needs about {needed} MiB of memory, and {budget} MiB are \
                 allowed; allow at least {needed} MiB"
            ),
            MemoryUse::Held => write!(
                f,
                "the triangles on segments that cross many tiles need about {needed} MiB of memory, and {budget} MiB are allowed; \
                 allow at least {needed} MiB"
            ),
            MemoryUse::Overlaps { point: Point { x, y } } => write!(
                f,
                "too many lines overlap at ({x}, {y}): edges need at least {needed} MiB of memory to store their lines, and \
                 {budget} MiB are allowed; remove duplicate lines, or allow more"
            ),
            MemoryUse::Sites => write!(
                f,
                "sites, ponds and hole points take a quarter of {needed} MiB of memory, and {budget} MiB are allowed in all; allow at \
                 least {needed} MiB"
            ),
            MemoryUse::Split => write!(
                f,
                "splitting segments where they cross needs about {needed} MiB of memory, and {budget} MiB are allowed; allow at \
                 least {needed} MiB"
            ),
            MemoryUse::Polygon { obstacle } => write!(
                f,
                "too many edges of obstacle {obstacle} lie side by side: checking them needs about {needed} MiB of memory, and \
                 {budget} MiB are allowed for that; allow {factor} times as much in all",
                factor = self.needed.div_ceil(self.budget.max(1))
            ),
            MemoryUse::Regions => write!(
                f,
                "finding the regions between segments needs about {needed} MiB of memory, and {budget} MiB are allowed; allow at \
                 least {needed} MiB"
            ),
            MemoryUse::Edit => write!(
                f,
                "the edit needs at least {needed} MiB of memory, and {budget} MiB are allowed; allow more"
            ),
        }
    }
}

impl std::error::Error for MemoryShortage {}
