//! Formatting of numbers and comments.

use std::io::Write;

use super::numbering::Numbering;
use crate::geometry::VertexIndex;
use crate::store::Tile;

/// Appends formatted text.
pub(super) fn put(out: &mut Vec<u8>, text: std::fmt::Arguments<'_>) {
    out.write_fmt(text).expect("a vector takes everything");
}

/// Appends the shortest text that parses to the same number: digits and a point, or an exponent as
/// in `1e-30` where that is shorter. C's `strtod`, JSON and other parsers accept it.
pub(super) fn put_number(out: &mut Vec<u8>, number: f64) {
    put(out, format_args!("{number:?}"));
}

/// Appends the coordinates of a corner, separated by `separator`, and its z, or `no_z` if it has
/// none.
pub(super) fn put_vertex(tile: &Tile, corner: VertexIndex, separator: u8, no_z: Option<f64>, out: &mut Vec<u8>) {
    let p = tile.point(corner);
    put_number(out, p.x);
    out.push(separator);
    put_number(out, p.y);
    if let Some(z) = tile.z(corner).or(no_z) {
        out.push(separator);
        put_number(out, z);
    }
}

/// Returns the lines of a header that describe the origin of an export.
///
/// The lines are short, since readers of PLY and of Triangle's files have lines of at most 1024
/// characters. A coordinate reference system that needs more (WKT rather than a name) is left out.
pub(super) fn comments(numbering: &Numbering) -> Vec<String> {
    const LONGEST: usize = 200;
    let mut lines = vec![concat!("delaunay-tiles ", env!("CARGO_PKG_VERSION")).to_owned()];
    if let Some(crs) = &numbering.reader().directory().lists.crs {
        let crs: String = crs.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        if crs.len() <= LONGEST {
            lines.push(format!("crs {crs}"));
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_parse_to_the_same_bits() {
        for (number, text) in [
            (0.0, "0.0"),
            (-1.5, "-1.5"),
            (0.1 + 0.2, "0.30000000000000004"),
            (1e-30, "1e-30"),
            (-2.5e-43, "-2.5e-43"),
            (1.6069380442589903e60, "1.6069380442589903e60"),
        ] {
            let mut out = Vec::new();
            put_number(&mut out, number);
            assert_eq!(String::from_utf8(out).unwrap(), text);
            assert_eq!(text.parse::<f64>().unwrap().to_bits(), number.to_bits());
        }
    }
}
