//! The points of a file at the centres of pixels, and at places within them.

use std::sync::Arc;

use crate::geometry::Point;
use crate::map_tiles::coord::TileCoord;
use crate::map_tiles::grid::{PIXELS, TileGrid, pixels_of};
use crate::map_tiles::lattice::Lattice;

/// Returns the points at the centres of the pixels of a tile and of a margin around it, row by row
/// from the north. Where the grid has no point of the file, the coordinates are NaN.
pub(super) fn centres(grid: &TileGrid, at: TileCoord, margin: u32) -> Arc<[Point]> {
    let centres = || (0..PIXELS + 2 * margin).map(|i| f64::from(i) - f64::from(margin) + 0.5);
    if let Some(lattice) = Lattice::of(grid, at) {
        let rows = centres().flat_map(|y| centres().map(move |x| [x, y]));
        return rows.map(|pixel| lattice.point(pixel)).collect();
    }
    let fractions = |number: u32| -> Vec<f64> {
        let first = f64::from(number) * f64::from(PIXELS);
        let all = pixels_of(at.z());
        centres().map(|centre| (first + centre) / all).collect()
    };
    grid.points(&fractions(at.x()), &fractions(at.y())).into()
}

/// Returns the points at the samples of some pixels of a tile: `parts` rows of `parts`
/// samples in each.
pub(super) fn within(grid: &TileGrid, at: TileCoord, pixels: &[u32], parts: u32) -> Arc<[Point]> {
    let all = pixels_of(at.z());
    let corner = [at.x(), at.y()].map(|number| f64::from(number) * f64::from(PIXELS));
    let lattice = if pixels.is_empty() { None } else { Lattice::of(grid, at) };
    let point = |[x, y]: [f64; 2]| match &lattice {
        Some(lattice) => lattice.point([x, y]),
        None => grid
            .point_at([(corner[0] + x) / all, (corner[1] + y) / all])
            .unwrap_or(NOWHERE),
    };
    let samples = pixels.iter().flat_map(|&pixel| {
        (0..parts * parts).map(move |sample| {
            let within = move |part: u32| (f64::from(part) + 0.5) / f64::from(parts);
            let (x, y) = (pixel % PIXELS, pixel / PIXELS);
            [
                f64::from(x) + within(sample % parts),
                f64::from(y) + within(sample / parts),
            ]
        })
    });
    samples.map(point).collect()
}

/// What stands for no point. It is outside of everything.
const NOWHERE: Point = Point::new(f64::NAN, f64::NAN);
