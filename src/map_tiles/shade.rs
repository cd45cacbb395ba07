//! Shaded relief, or the plane without heights, with holes.
//!
//! In: samples of the triangulation. Out: the colour and the opacity of each pixel. A pixel depends
//! on the samples at its place and at those of its eight neighbours alone, so that tiles agree
//! where they meet. The gradient is Horn's, 1981.

use crate::map_tiles::colours::{FREE, HOLE, LIGHT};
use crate::map_tiles::grid::PIXELS;
use crate::query::Ground;
use crate::terrain::shading::{brightness, lit, tint};

/// The width of samples with a margin of one pixel.
const WIDTH: usize = PIXELS as usize + 2;
/// The opacity of holes over heights.
const HOLE_OPACITY: f64 = 0.85;

/// What is known of a tile. Samples at centres have a margin of one pixel.
pub(super) struct Samples {
    /// The heights at the centres of pixels, NaN where there is no surface.
    pub(super) heights: Option<Relief>,
    /// What is at the centres of pixels. Without it, there are no holes.
    pub(super) ground: Option<Vec<Ground>>,
    /// The pixels that have more samples, in order.
    pub(super) pixels: Vec<u32>,
    /// The number of samples in each of them.
    pub(super) parts: usize,
    /// The heights at these samples, if there are heights.
    pub(super) heights_within: Vec<f64>,
    /// What is at these samples, if it is known of centres.
    pub(super) ground_within: Vec<Ground>,
}

/// Heights, and how they become colours.
pub(super) struct Relief {
    /// By row and column, with a margin of one pixel.
    pub(super) z: Vec<f64>,
    /// The heights of the first and the last colour.
    pub(super) coloured: [f64; 2],
    /// The height of a unit of z, in pixels to the east and to the north, for each row of the tile.
    pub(super) steepness: Vec<[f64; 2]>,
}

/// The colour of a pixel, and its opacity from 0 to 1.
pub(super) type Shade = ([f64; 3], f64);

/// Returns the colours of all pixels.
pub(super) fn shade(samples: &Samples) -> Vec<Shade> {
    let mut within = samples.pixels.iter().zip(0..).peekable();
    let pixels = (0..PIXELS * PIXELS).map(|pixel| {
        let more = within.next_if(|(marked, _)| **marked == pixel);
        let at = (pixel / PIXELS) as usize + 1;
        let at = at * WIDTH + (pixel % PIXELS) as usize + 1;
        let range = more.map(|(_, index)| index * samples.parts..(index + 1) * samples.parts);
        pixel_of(samples, at, (pixel / PIXELS) as usize, range)
    });
    pixels.collect()
}

fn pixel_of(samples: &Samples, at: usize, row: usize, within: Option<std::ops::Range<usize>>) -> Shade {
    let (hole, ground) = match (&samples.ground, &within) {
        (Some(_), Some(range)) => shares(&samples.ground_within[range.clone()]),
        (Some(ground), None) => shares(&ground[at..=at]),
        (None, _) => (0.0, 1.0),
    };
    let Some(relief) = &samples.heights else {
        // The colour of what is there, whatever else is in the pixel.
        let holes = if ground > 0.0 { hole / ground } else { 0.0 };
        return (mixed(FREE.map(f64::from), holes), ground);
    };
    let heights = within.map(|range| &samples.heights_within[range]);
    let known = || heights.into_iter().flatten().filter(|z| !z.is_nan());
    let share = heights.map(|heights| known().count() as f64 / heights.len() as f64);
    let centre = relief.z[at];
    let z = match centre.is_nan() {
        false => centre,
        true => known().sum::<f64>() / known().count() as f64,
    };
    if z.is_nan() {
        return ([0.0; 3], 0.0);
    }
    let colour = lit(relief.colour(z), brightness(relief.slope(at, z, row), LIGHT));
    (mixed(colour, HOLE_OPACITY * hole), share.unwrap_or(1.0))
}

/// Returns the shares of samples in holes, and on the ground or in holes.
fn shares(samples: &[Ground]) -> (f64, f64) {
    let share = |is_it: fn(&&Ground) -> bool| samples.iter().filter(is_it).count() as f64 / samples.len() as f64;
    (
        share(|ground| **ground == Ground::Hole),
        share(|ground| **ground != Ground::Outside),
    )
}

/// Returns a colour with a share of that of holes.
fn mixed(colour: [f64; 3], holes: f64) -> [f64; 3] {
    [0, 1, 2].map(|i| colour[i] + (f64::from(HOLE[i]) - colour[i]) * holes)
}

impl Relief {
    fn colour(&self, z: f64) -> [f64; 3] {
        let [low, high] = self.coloured;
        tint(if high > low { (z - low) / (high - low) } else { 0.5 })
    }

    /// Returns the change of height to the east and to the north, for each unit of length. A
    /// neighbour without a height counts as high as the pixel.
    fn slope(&self, at: usize, z: f64, row: usize) -> [f64; 2] {
        let height = |at: usize| if self.z[at].is_nan() { z } else { self.z[at] };
        let sum = |a: usize, b: usize, c: usize| height(a) + 2.0 * height(b) + height(c);
        let (north, south) = (at - WIDTH, at + WIDTH);
        let east = sum(north + 1, at + 1, south + 1) - sum(north - 1, at - 1, south - 1);
        let up = sum(north - 1, north, north + 1) - sum(south - 1, south, south + 1);
        let [along, across] = self.steepness[row];
        [east / 8.0 * along, up / 8.0 * across]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(east: f64, north: f64) -> Relief {
        let z = |at: usize| 100.0 + east * (at % WIDTH) as f64 - north * (at / WIDTH) as f64;
        Relief {
            z: (0..WIDTH * WIDTH).map(z).collect(),
            coloured: [0.0, 500.0],
            steepness: vec![[1.0; 2]; PIXELS as usize],
        }
    }

    #[test]
    fn the_gradient_of_a_plane_is_that_of_the_plane() {
        let relief = plane(0.25, -0.75);
        let at = 40 * WIDTH + 17;
        assert_eq!(relief.slope(at, relief.z[at], 39), [0.25, -0.75]);
    }

    #[test]
    fn a_pixel_that_is_half_a_hole_has_half_its_colour() {
        let samples = Samples {
            heights: None,
            ground: Some(vec![Ground::Free; WIDTH * WIDTH]),
            pixels: vec![5, 9],
            parts: 2,
            heights_within: Vec::new(),
            ground_within: vec![Ground::Free, Ground::Hole, Ground::Outside, Ground::Hole],
        };
        let pixels = shade(&samples);
        let half = [0, 1, 2].map(|i| (f64::from(FREE[i]) + f64::from(HOLE[i])) / 2.0);
        assert_eq!(pixels[5], (half, 1.0));
        assert_eq!(pixels[9], (HOLE.map(f64::from), 0.5));
        assert_eq!(pixels[6], (FREE.map(f64::from), 1.0));
    }
}
