//! The texts on paths, where paths are apart from each other.

use std::collections::HashMap;

use super::axis::text_width;
use super::ink::Pixel;
use super::labels::Labels;
use super::overlay::Way;
use super::page::Page;
use super::svg::Svg;

/// The side in pixels of the squares in which paths are counted.
const SQUARE: f64 = 8.0;
/// Where on a path its text may be: in its middle first.
const PLACES: [f64; 7] = [0.5, 0.42, 0.58, 0.34, 0.66, 0.26, 0.74];
/// The number of paths above which they are not counted, because no text would be readable.
const MAX_COUNTED: usize = 2000;

/// A path as pixels.
struct Line {
    pixels: Vec<Pixel>,
    length: f64,
}

impl Line {
    fn new(way: &Way, page: &Page) -> Self {
        let pixels: Vec<_> = way.points.iter().map(|&point| page.pixel(point)).collect();
        let length = pixels.windows(2).map(|ends| distance(ends[0], ends[1])).sum();
        Self { pixels, length }
    }

    /// Returns the pixel at a share of the length.
    fn at(&self, share: f64) -> Pixel {
        let mut left = share * self.length;
        for ends in self.pixels.windows(2) {
            let [a, b] = [ends[0], ends[1]];
            let length = distance(a, b);
            if left <= length && length > 0.0 {
                return (a.0 + (b.0 - a.0) * left / length, a.1 + (b.1 - a.1) * left / length);
            }
            left -= length;
        }
        self.pixels.last().copied().unwrap_or_default()
    }
}

fn distance(a: Pixel, b: Pixel) -> f64 {
    (b.0 - a.0).hypot(b.1 - a.1)
}

fn square((x, y): Pixel) -> (i64, i64) {
    ((x / SQUARE).floor() as i64, (y / SQUARE).floor() as i64)
}

/// Writes the texts of paths on them, as many as fit. A text is where the fewest paths are.
pub fn write(svg: &mut Svg, labels: &mut Labels, ways: &[Way], page: &Page) {
    if ways.len() > MAX_COUNTED || ways.iter().all(|way| way.text.is_empty()) {
        return;
    }
    let lines: Vec<_> = ways.iter().map(|way| Line::new(way, page)).collect();
    // Each square: the number of paths in it, and the last of them.
    let mut paths: HashMap<(i64, i64), (u32, usize)> = HashMap::new();
    for (number, line) in lines.iter().enumerate() {
        let steps = (line.length / (SQUARE / 2.0)).ceil().max(1.0) as u32;
        for step in 0..=steps {
            let place = square(line.at(f64::from(step) / f64::from(steps)));
            let (count, last) = paths.entry(place).or_insert((0, usize::MAX));
            if *last != number {
                (*count, *last) = (*count + 1, number);
            }
        }
    }
    for (way, line) in ways.iter().zip(&lines) {
        // A text longer than its path would hide it.
        if line.length < 1.2 * text_width(&way.text, SQUARE) {
            continue;
        }
        let mut places = PLACES.map(|share| line.at(share));
        places.sort_by_key(|&place| paths.get(&square(place)).map_or(0, |&(count, _)| count));
        for place in places {
            if labels.over(svg, place, &way.text) {
                break;
            }
        }
    }
}
