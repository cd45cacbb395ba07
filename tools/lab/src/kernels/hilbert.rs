//! Hilbert curve keys, four bits of each coordinate at a time.
//!
//! The input is points and their bounding box. The output is 64-bit keys whose order is that of a
//! Hilbert curve of 32 levels over the square around the box. It has 32 levels because a skewed
//! distribution puts most of its points in very few of the 2¹⁶ columns that a 32-bit key could
//! distinguish.

use delaunay_tiles::geometry::{Point, Rect};

/// The curve over 16 by 16 cells in each of its four states: `TABLE[state][x << 4 | y]` is
/// `position << 2 | next state`. A state is `flipped << 1 | swapped`: how the following bits are
/// transformed.
const TABLE: [[u16; 256]; 4] = table();

const fn table() -> [[u16; 256]; 4] {
    let mut table = [[0; 256]; 4];
    let mut state = 0;
    while state < 4 {
        let mut cell = 0;
        while cell < 256 {
            let (mut swapped, mut flipped) = (state & 1, state >> 1);
            let (mut position, mut level) = (0, 4);
            while level > 0 {
                level -= 1;
                let (mut x, mut y) = (cell >> (4 + level) & 1, cell >> level & 1);
                if swapped == 1 {
                    (x, y) = (y, x);
                }
                (x, y) = (x ^ flipped, y ^ flipped);
                position = position << 2 | (3 * x) ^ y;
                if y == 0 {
                    flipped ^= x;
                    swapped ^= 1;
                }
            }
            table[state][cell] = (position << 2 | flipped << 1 | swapped) as u16;
            cell += 1;
        }
        state += 1;
    }
    table
}

/// The curve over the square around a box.
pub(crate) struct Curve {
    origin: Point,
    scale: f64,
}

impl Curve {
    pub(crate) fn over(bounds: Rect) -> Self {
        let (width, height) = bounds.size();
        Self {
            origin: Point::new(bounds.min_x, bounds.min_y),
            scale: f64::from(u32::MAX) / width.max(height),
        }
    }

    /// Returns the key of a point in the box.
    pub(crate) fn key(&self, p: Point) -> u64 {
        // Casts saturate, and give 0 for the NaN of a box without an inside.
        let x = ((p.x - self.origin.x) * self.scale) as u32;
        let y = ((p.y - self.origin.y) * self.scale) as u32;
        let (mut key, mut state) = (0, 0);
        for shift in (0..32).step_by(4).rev() {
            let cell = (x >> shift & 15) << 4 | y >> shift & 15;
            let entry = TABLE[state][cell as usize];
            key = key << 8 | u64::from(entry >> 2);
            state = usize::from(entry & 3);
        }
        key
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_on_the_curve_are_neighbours_in_the_plane() {
        let curve = Curve::over(Rect::new(0.0, 0.0, f64::from(u32::MAX), f64::from(u32::MAX)));
        // 64 by 64 cells in the middle: two aligned squares of 2^6 cells are at most 2^12 steps
        // each.
        let base = 1u32 << 31;
        let mut keyed: Vec<_> = (0..64 * 64)
            .map(|i| (base + i % 64, base + i / 64))
            .map(|(x, y)| (curve.key(Point::new(x.into(), y.into())), x, y))
            .collect();
        keyed.sort_unstable();
        for pair in keyed.windows(2) {
            assert_eq!(pair[0].0 + 1, pair[1].0);
            assert_eq!(pair[0].1.abs_diff(pair[1].1) + pair[0].2.abs_diff(pair[1].2), 1);
        }
    }
}
