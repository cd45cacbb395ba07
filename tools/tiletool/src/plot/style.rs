//! Colours that have the same meaning in all pictures, and styles of shapes and lines.

use super::svg::UNITS;

pub const INK: &str = "#23313d";
pub const GREY: &str = "#66727c";
pub const PAPER: &str = "#fcfbf8";
pub const EDGE: &str = "#5f7f99";
/// Edges that are less important than what is drawn over them.
pub const FAINT_EDGE: &str = "#93abbd";
pub const HULL: &str = "#1f4e6f";
pub const CONSTRAINT: &str = "#2f7d4f";
pub const WALL: &str = "#4a2c1d";
pub const HOLE: &str = "#cfd3d6";
pub const SITE: &str = "#a8327a";

/// The style of lines, and of groups of lines whose shapes name their own fill.
pub const LINES: &str = "fill=\"none\" stroke-linejoin=\"round\"";

/// Returns the red, green and blue of a colour such as `#23313d`.
pub fn rgb(colour: &str) -> [u8; 3] {
    let number = u32::from_str_radix(colour.trim_start_matches('#'), 16).unwrap_or(0);
    [16, 8, 0].map(|shift| (number >> shift) as u8)
}

/// Returns the style of filled shapes.
pub fn fill(colour: &str) -> String {
    format!("fill=\"{colour}\"")
}

/// Returns the style of lines of `width` pixels, in a group of
/// [`Svg::in_units`](super::svg::Svg::in_units).
pub fn stroke(colour: &str, width: f64) -> String {
    format!("stroke=\"{colour}\" stroke-width=\"{:.1}\"", width * UNITS)
}
