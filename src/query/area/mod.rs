//! The area within a walking distance.
//!
//! The wavefront reports the regions that each of its roots sees
//! ([`wavefront`](crate::query::wavefront)). The part of a region within the remaining distance of
//! its root belongs to the area, and nothing else does. Pieces of one root touch along edges, where
//! their outlines have the same points to the last bit. Pieces of different roots may overlap, for
//! example behind an obstacle that paths pass on both sides.
//!
//! Most triangles of a large area lie in it as a whole. Each of them can replace all of its pieces,
//! and two that share an edge need no union: the edge is not part of the outline. The union of the
//! rings around them and of the other pieces gives the area as polygons.

mod cover;
mod piece;
mod polygon;
mod rings;
mod union;
mod within;

pub use cover::AreaCover;
pub use piece::AreaPiece;
pub use polygon::AreaPolygon;
