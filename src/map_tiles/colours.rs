//! The colours of pictures. They are those of the tool's plots, but for the ground: a map has no frame,
//! so free ground must differ from the page, and holes from free ground.

/// Red, green and blue.
pub(super) type Colour = [u8; 3];

/// Free ground without heights.
pub(super) const FREE: Colour = [242, 240, 234];
/// Holes.
pub(super) const HOLE: Colour = [193, 201, 207];
/// Break lines.
pub(super) const BREAK: Colour = [47, 125, 79];
/// Walls.
pub(super) const WALL: Colour = [74, 44, 29];
/// Outlines of holes.
pub(super) const OUTLINE: Colour = [122, 133, 141];
/// Sites.
pub(super) const SITE: Colour = [168, 50, 122];
/// Vertices, where there is nothing else.
pub(super) const VERTEX: Colour = [35, 49, 61];

/// How much of the light on slopes is seen.
pub(super) const LIGHT: f64 = 0.55;
