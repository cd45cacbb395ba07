//! The shaded relief of a surface: heights as colours, lit from the north-west.
//!
//! In: a tile file with z, and a page. Out: an image of the frame, and the heights that its colours
//! mean. The height of a pixel is that of the triangle at its centre; the light falls on the slope
//! between neighbouring pixels. So triangles that are smaller than pixels do not flicker, and one pass
//! over the tiles suffices.

use delaunay_tiles::store::TileReader;
use delaunay_tiles::terrain::shading::{brightness, lit, tint};
use delaunay_tiles::terrain::{Grid, RasterOptions};
use resvg::tiny_skia::{Pixmap, PremultipliedColorU8};

use super::image::blank;
use super::page::Page;

/// Maximum number of cells whose heights are computed at once, with 16 bytes for each.
const BAND: usize = 1 << 18;
/// Number of pixels from which quantiles are taken.
const SAMPLE: usize = 1 << 17;
/// The share of pixels at each end that may lie outside of the colours.
const TAIL: f64 = 0.005;
/// If all heights span more than this multiple of the heights without the tails, the tails are cut.
const LONG_TAILS: f64 = 1.5;
/// The slope at which the steepest tenth of the pixels is drawn.
const STEEP: f64 = 0.8;
/// How much of the light on slopes is seen.
const LIGHT: f64 = 0.5;

/// The heights of the pixels of a frame.
pub struct Relief {
    columns: usize,
    /// Row by row from the north, above `base`; NaN where there is no surface.
    heights: Vec<f32>,
    /// The height of the first pixel that has one. Differences from it are precise where all heights
    /// are large.
    base: f64,
}

/// The heights that the first and the last colour mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heights {
    /// The height of the first colour.
    pub min: f64,
    /// The height of the last colour.
    pub max: f64,
    /// Whether there are lower ones.
    pub has_lower: bool,
    /// Whether there are higher ones.
    pub has_higher: bool,
}

impl Relief {
    /// Computes the heights in the frame of a page. `None` if the file has none, or if its coordinates
    /// are too large for their extent to be drawn as pixels.
    ///
    /// # Errors
    /// Fails if a tile cannot be read, or if the memory does not suffice.
    pub async fn gather(reader: &TileReader, page: &Page) -> anyhow::Result<Option<Self>> {
        let m = reader.metadata();
        if !m.has_z || m.triangles == 0 {
            return Ok(None);
        }
        let Ok(grid) = Grid::starting_at(page.view(), 1.0 / page.length(1.0)) else {
            return Ok(None);
        };
        let options = RasterOptions::new(grid);
        let (columns, rows) = page.pixels();
        let mut this = Self::new(columns, rows);
        // The number of cells may differ by rounding.
        let (columns, rows) = (grid.columns().min(columns as u32), grid.rows().min(rows as u32));
        let band = (BAND / this.columns).max(1);
        for top in (0..rows).step_by(band) {
            let bottom = rows.min(top + band as u32);
            let values = reader.raster(&options, 0..columns, top..bottom).await?;
            for (row, values) in (top as usize..).zip(values.chunks(columns as usize)) {
                this.set_row(row, values);
            }
        }
        Ok(Some(this))
    }

    fn new(columns: usize, rows: usize) -> Self {
        Self {
            columns,
            heights: vec![f32::NAN; columns * rows],
            base: f64::NAN,
        }
    }

    fn set_row(&mut self, row: usize, values: &[f64]) {
        let row = &mut self.heights[row * self.columns..][..self.columns];
        for (height, &value) in row.iter_mut().zip(values) {
            if self.base.is_nan() && value.is_finite() {
                self.base = value;
            }
            let above = (value - self.base) as f32;
            *height = if above.is_finite() { above } else { f32::NAN };
        }
    }

    /// Returns the heights that the colours mean. `None` if no pixel has one.
    pub fn heights(&self) -> Option<Heights> {
        let known = || self.heights.iter().filter(|height| !height.is_nan()).copied();
        let (min, max) = known().fold((f32::MAX, f32::MIN), |(min, max), z| (min.min(z), max.max(z)));
        if min > max {
            return None;
        }
        let [low, high] = quantiles(known(), [TAIL, 1.0 - TAIL]);
        let [min, max, low, high] = [min, max, low, high].map(f64::from);
        let cut = max - min > LONG_TAILS * (high - low) && low < high;
        let (first, last) = if cut { (low, high) } else { (min, max) };
        Some(Heights {
            min: self.base + first,
            max: self.base + last,
            has_lower: min < first,
            has_higher: max > last,
        })
    }

    /// Draws the heights, on a background of this colour.
    pub fn image(&self, heights: Heights, background: [u8; 3]) -> anyhow::Result<Pixmap> {
        let rows = self.heights.len() / self.columns;
        let mut image = blank((self.columns, rows), background)?;
        let factor = self.factor();
        let span = heights.max - heights.min;
        for (cell, pixel) in image.pixels_mut().iter_mut().enumerate() {
            if let Some(slope) = self.slope(cell) {
                let z = self.base + f64::from(self.heights[cell]);
                let share = if span > 0.0 { (z - heights.min) / span } else { 0.5 };
                let bright = brightness(slope.map(|change| change * factor), LIGHT);
                let [r, g, b] = lit(tint(share), bright).map(|c| c.round() as u8);
                *pixel = PremultipliedColorU8::from_rgba(r, g, b, 255).unwrap_or(*pixel);
            }
        }
        Ok(image)
    }

    /// Returns the factor of all slopes. Most terrain is flat compared with its extent, and in
    /// geographic coordinates z has another unit, so the slopes themselves decide: the steepest tenth
    /// of them is drawn as [`STEEP`] or steeper, whatever they are.
    fn factor(&self) -> f64 {
        let slopes = (0..self.heights.len()).filter_map(|cell| self.slope(cell));
        let [steep] = quantiles(slopes.map(|[x, y]| x.hypot(y) as f32), [0.9]);
        if steep > 0.0 { STEEP / f64::from(steep) } else { 0.0 }
    }

    /// Returns the change of the height for each pixel to the east and to the north. `None` if a cell
    /// has no height.
    fn slope(&self, cell: usize) -> Option<[f64; 2]> {
        let here = self.heights[cell];
        let (row, column) = (cell / self.columns, cell % self.columns);
        let height = |at: Option<usize>| at.map(|at| self.heights[at]).filter(|z| !z.is_nan());
        let between = |before: Option<usize>, after: Option<usize>| match (height(before), height(after)) {
            (Some(before), Some(after)) => (f64::from(after) - f64::from(before)) / 2.0,
            (Some(before), None) => f64::from(here) - f64::from(before),
            (None, Some(after)) => f64::from(after) - f64::from(here),
            (None, None) => 0.0,
        };
        let west = (column > 0).then(|| cell - 1);
        let east = (column + 1 < self.columns).then(|| cell + 1);
        let north = (row > 0).then(|| cell - self.columns);
        let south = (cell + self.columns < self.heights.len()).then(|| cell + self.columns);
        (!here.is_nan()).then(|| [between(west, east), between(south, north)])
    }
}

/// Returns quantiles of some of the numbers, evenly chosen; 0 if there is no number.
fn quantiles<const N: usize>(numbers: impl Iterator<Item = f32>, shares: [f64; N]) -> [f32; N] {
    // Keeps every number, then every second one, and so on.
    let (mut kept, mut step) = (Vec::with_capacity(SAMPLE), 1);
    for (index, number) in numbers.enumerate() {
        if index % step == 0 {
            if kept.len() == SAMPLE {
                let mut position = 0;
                kept.retain(|_| {
                    position += 1;
                    position % 2 == 1
                });
                step *= 2;
                if index % step != 0 {
                    continue;
                }
            }
            kept.push(number);
        }
    }
    kept.sort_unstable_by(f32::total_cmp);
    shares.map(|share| match kept.len() {
        0 => 0.0,
        count => kept[((count - 1) as f64 * share).round() as usize],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn relief(columns: usize, z: impl Fn(usize, usize) -> f64) -> Relief {
        let mut relief = Relief::new(columns, 40);
        for row in 0..40 {
            let values: Vec<_> = (0..columns).map(|column| z(column, row)).collect();
            relief.set_row(row, &values);
        }
        relief
    }

    #[test]
    fn slopes_are_exaggerated_by_their_steepness_alone() {
        for scale in [1e-6, 1.0, 1e6] {
            let relief = relief(50, |column, row| 4e6 + scale * (column as f64 - 2.0 * row as f64));
            let factor = relief.factor();
            assert!((factor * scale * 5f64.sqrt() - STEEP).abs() < 1e-2, "{scale}: {factor}");
        }
        assert_eq!(relief(50, |_, _| 7.0).factor(), 0.0);
    }

    #[test]
    fn a_few_outliers_do_not_take_the_colours() {
        let plain = |column: usize, row: usize| (column + row) as f64;
        let heights = relief(100, plain).heights().unwrap();
        assert_eq!((heights.min, heights.max), (0.0, 138.0));
        assert!(!heights.has_lower && !heights.has_higher);
        let spike = |column, row| {
            if (column, row) == (3, 3) {
                9e9
            } else {
                plain(column, row)
            }
        };
        let heights = relief(100, spike).heights().unwrap();
        assert!(heights.min < 20.0 && heights.max > 110.0 && heights.max <= 138.0);
        assert!(heights.has_lower && heights.has_higher);
        assert!(relief(100, |_, _| f64::NAN).heights().is_none());
        let flat = relief(100, |_, _| 7.5).heights().unwrap();
        assert_eq!((flat.min, flat.max), (7.5, 7.5));
    }

    #[test]
    fn quantiles_of_many_numbers_are_those_of_some() {
        let numbers = (0..3_000_000).map(|i| (i % 1000) as f32);
        let [low, middle, high] = quantiles(numbers, [0.0, 0.5, 1.0]);
        assert!(low < 10.0 && (middle - 500.0).abs() < 10.0 && high > 990.0);
    }
}
