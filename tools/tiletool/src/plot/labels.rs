//! Texts on a map, as many as fit beside each other.

use delaunay_tiles::geometry::Rect;

use super::axis::text_width;
use super::page::Page;
use super::style::{INK, fill};
use super::svg::{Anchor, Svg};

/// Font size of the texts.
const TEXT: f64 = 14.0;
/// The side in pixels of the squares in which what is taken is noted.
const SQUARE: f64 = 3.0;
/// Maximum number of characters of a text.
const MAX_CHARACTERS: usize = 32;

/// The parts of a frame that texts and marks take.
pub struct Labels {
    frame: Rect,
    columns: usize,
    taken: Vec<bool>,
    style: String,
}

impl Labels {
    pub fn new(page: &Page) -> Self {
        let [columns, rows] = <[f64; 2]>::from(page.frame.size()).map(|side| (side / SQUARE).ceil().max(1.0) as usize);
        let style = format!(
            "{} stroke=\"#fff\" stroke-opacity=\"0.9\" stroke-width=\"4\" stroke-linejoin=\"round\" paint-order=\"stroke\"",
            fill(INK)
        );
        Self {
            frame: page.frame,
            columns,
            taken: vec![false; columns * rows],
            style,
        }
    }

    /// Keeps texts off a mark.
    pub fn mark(&mut self, (x, y): (f64, f64), radius: f64) {
        self.take(Rect::new(x - radius, y - radius, x + radius, y + radius));
    }

    /// Writes a text beside a mark, where there is room for it. Returns whether there is.
    pub fn beside(&mut self, svg: &mut Svg, (x, y): (f64, f64), radius: f64, text: &str) -> bool {
        let (right, left) = (x + radius + 2.0, x - radius - 2.0);
        let (above, middle, below) = (y - radius - 4.0, y + 0.36 * TEXT, y + radius + TEXT);
        let near = 0.6 * radius;
        [
            (x + near, above, Anchor::Start),
            (right, middle, Anchor::Start),
            (left, middle, Anchor::End),
            (x - near, above, Anchor::End),
            (x + near, below, Anchor::Start),
            (x - near, below, Anchor::End),
            (x, above, Anchor::Middle),
            (x, below, Anchor::Middle),
        ]
        .into_iter()
        .any(|(x, y, anchor)| self.write(svg, (x, y), anchor, text))
    }

    /// Writes a text with its middle at a pixel, if there is room for it. Returns whether there is.
    pub fn over(&mut self, svg: &mut Svg, (x, y): (f64, f64), text: &str) -> bool {
        self.write(svg, (x, y + 0.36 * TEXT), Anchor::Middle, text)
    }

    fn write(&mut self, svg: &mut Svg, (x, y): (f64, f64), anchor: Anchor, text: &str) -> bool {
        let text = cut(text);
        let width = text_width(&text, TEXT);
        let start = match anchor {
            Anchor::Start => x,
            Anchor::Middle => x - width / 2.0,
            Anchor::End => x - width,
        };
        let around = Rect::new(start - 2.0, y - 0.8 * TEXT, start + width + 2.0, y + 0.28 * TEXT);
        let fits = !text.is_empty() && self.is_free(around);
        if fits {
            self.take(around);
            svg.text((x, y), TEXT, anchor, &self.style, &text);
        }
        fits
    }

    fn is_free(&self, around: Rect) -> bool {
        let f = self.frame;
        let inside =
            around.min_x >= f.min_x && around.max_x <= f.max_x && around.min_y >= f.min_y && around.max_y <= f.max_y;
        inside && self.squares(around).all(|square| !self.taken[square])
    }

    fn take(&mut self, around: Rect) {
        for square in self.squares(around) {
            self.taken[square] = true;
        }
    }

    /// Returns the squares that a rectangle in pixels meets.
    fn squares(&self, around: Rect) -> impl Iterator<Item = usize> + use<> {
        let (columns, rows) = (self.columns, self.taken.len() / self.columns);
        // Conversions saturate, so what is outside meets no square.
        let range = |min: f64, max: f64, start: f64, count: usize| {
            let [from, to] = [min, max].map(|side| (side - start) / SQUARE);
            from.floor() as usize..(to.ceil() as usize).min(count)
        };
        let x = range(around.min_x, around.max_x, self.frame.min_x, columns);
        let y = range(around.min_y, around.max_y, self.frame.min_y, rows);
        y.flat_map(move |row| x.clone().map(move |column| row * columns + column))
    }
}

/// Shortens a text that is too long for a map.
pub fn cut(text: &str) -> String {
    match text.char_indices().nth(MAX_CHARACTERS) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_do_not_overlap_and_stay_inside() {
        let page = Page::new(Rect::new(0.0, 0.0, 100.0, 50.0)).unwrap();
        let (mut labels, mut svg) = (Labels::new(&page), Svg::new(page.width, page.height, ""));
        let (x, y) = (page.frame.min_x + 300.0, page.frame.min_y + 200.0);
        labels.mark((x, y), 5.0);
        assert!(!labels.over(&mut svg, (x, y), "under a mark"));
        let written = (0..20).filter(|_| labels.beside(&mut svg, (x, y), 5.0, "name")).count();
        assert!((2..=8).contains(&written), "{written}");
        assert!(!labels.over(&mut svg, (page.frame.min_x, y), "half outside"));
        assert!(!labels.over(&mut svg, (x + 200.0, y), ""));
        assert!(!labels.over(&mut svg, (f64::NAN, f64::INFINITY), "nowhere"));
        assert_eq!(svg.finish().matches("<text").count(), written);
    }

    #[test]
    fn long_texts_are_cut() {
        assert_eq!(cut(&"ä".repeat(32)), "ä".repeat(32));
        assert_eq!(cut(&"ä".repeat(33)), format!("{}…", "ä".repeat(32)));
    }
}
