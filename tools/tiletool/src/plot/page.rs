//! The layout of the page, which maps coordinates to pixels.

use anyhow::ensure;
use delaunay_tiles::geometry::{Point, Rect};

use super::axis::{Axis, TICK_TEXT, text_width};

/// Width of the page in pixels.
const WIDTH: f64 = 1600.0;
/// Pixels above the frame, for title and subtitle.
const HEADER: f64 = 84.0;
/// Pixels below the frame, for coordinates, legend, scales and caption.
const FOOTER: f64 = 134.0;
/// Pixels beside the frame.
const SIDE_MARGIN: f64 = 30.0;
/// Pixels between the frame and the bounds of the points.
const MARGIN: f64 = 24.0;
/// Minimum and maximum height of the frame in pixels.
const FRAME_HEIGHTS: (f64, f64) = (420.0, 1500.0);

/// A page with a frame, and the map from the plane to it: one scale for both axes, y upwards.
pub struct Page {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The frame of the map in pixels, y downwards.
    pub frame: Rect,
    /// The coordinates below the frame.
    pub x_axis: Axis,
    /// The coordinates beside the frame.
    pub y_axis: Axis,
    center: Point,
    scale: f64,
}

impl Page {
    /// Creates a page for points within `bounds`, which may be empty, a point, or a line.
    ///
    /// # Errors
    /// Fails if `bounds` are not valid coordinates.
    pub fn new(bounds: Rect) -> anyhow::Result<Self> {
        if bounds.is_empty() {
            return Ok(Self::layout(Point::default(), 0.0, 0.0, None));
        }
        let corners = [
            Point::new(bounds.min_x, bounds.min_y),
            Point::new(bounds.max_x, bounds.max_y),
        ];
        let valid = corners
            .into_iter()
            .all(|corner| corner.x.abs().max(corner.y.abs()) <= Point::MAX_MAGNITUDE);
        ensure!(
            valid,
            "the bounds in the directory are not valid coordinates: {bounds:?}"
        );
        let (width, height) = bounds.size();
        let center = Point::new(bounds.min_x + width / 2.0, bounds.min_y + height / 2.0);
        let size = if width.max(height) > 0.0 {
            (width, height)
        } else {
            // A single point is shown with enough room around it for round coordinates.
            let magnitude = center.x.abs().max(center.y.abs());
            (if magnitude > 0.0 { magnitude / 10.0 } else { 1.0 }, 0.0)
        };
        // The room for the coordinates beside the frame depends on their labels, which depend
        // slightly on that room. So the layout is computed twice.
        let first = Self::layout(center, size.0, size.1, Some(120.0));
        let room = first.y_axis.widest();
        Ok(Self::layout(center, size.0, size.1, Some(room)))
    }

    fn layout(center: Point, width: f64, height: f64, label_room: Option<f64>) -> Self {
        let left = label_room.map_or(SIDE_MARGIN, |room| (room + SIDE_MARGIN + 12.0).max(70.0));
        let frame_width = WIDTH - left - SIDE_MARGIN;
        let (least, most) = FRAME_HEIGHTS;
        // If the width or the height is 0, the other one determines the scale.
        let scale = ((frame_width - 2.0 * MARGIN) / width).min((most - 2.0 * MARGIN) / height);
        let frame_height = if label_room.is_some() {
            height * scale + 2.0 * MARGIN
        } else {
            0.0
        };
        let frame_height = frame_height.clamp(least, most).round();
        let frame = Rect::new(left.round(), HEADER, WIDTH - SIDE_MARGIN, HEADER + frame_height);
        let axis = |middle: f64, pixels: f64, room: fn(&str) -> f64| match label_room {
            Some(_) => Axis::new(middle, scale, pixels, room),
            None => Axis::default(),
        };
        Self {
            width: WIDTH as u32,
            height: (HEADER + frame_height + FOOTER) as u32,
            frame,
            x_axis: axis(center.x, frame.size().0, |label| text_width(label, TICK_TEXT) + 40.0),
            y_axis: axis(center.y, frame.size().1, |_| 3.0 * TICK_TEXT),
            center,
            scale,
        }
    }

    /// Returns the pixel of a point. For a point far outside the page, this may be any far pixel.
    pub fn pixel(&self, p: Point) -> (f64, f64) {
        let (x, y) = (
            (self.frame.min_x + self.frame.max_x) / 2.0,
            (self.frame.min_y + self.frame.max_y) / 2.0,
        );
        (
            x + (p.x - self.center.x) * self.scale,
            y - (p.y - self.center.y) * self.scale,
        )
    }

    /// Returns the baselines of the legend, the scales and the caption.
    pub fn footer(&self) -> [f64; 3] {
        [58.0, 88.0, 118.0].map(|below| self.frame.max_y + below)
    }

    /// Returns the number of columns and rows of pixels of the frame.
    pub fn pixels(&self) -> (usize, usize) {
        let (width, height) = self.frame.size();
        (width as usize, height as usize)
    }

    /// Returns the part of the plane that the frame shows.
    pub fn view(&self) -> Rect {
        let (width, height) = self.frame.size();
        let (dx, dy) = (width / 2.0 / self.scale, height / 2.0 / self.scale);
        let Point { x, y } = self.center;
        Rect::new(x - dx, y - dy, x + dx, y + dy)
    }

    /// Returns the part of a cell within the frame, in pixels. The sides of the cell may be at
    /// infinity.
    pub fn cell(&self, cell: Rect) -> Rect {
        let (left, top) = self.pixel(Point::new(cell.min_x, cell.max_y));
        let (right, bottom) = self.pixel(Point::new(cell.max_x, cell.min_y));
        let f = self.frame;
        Rect::new(
            left.max(f.min_x),
            top.max(f.min_y),
            right.min(f.max_x),
            bottom.min(f.max_y),
        )
    }

    /// Converts a length in the plane to pixels.
    pub fn length(&self, length: f64) -> f64 {
        length * self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_of_any_size_and_shape_fill_the_frame() {
        for (x, y, w, h) in [
            (0.0, 0.0, 1.0, 1.0),
            (3.0, 4.0, 0.0, 0.0),
            (0.0, 0.0, 0.0, 0.0),
            (5e5, 4e6, 1000.0, 0.0),
            (5e5, 4e6, 0.0, 1e-3),
            (-1e30, -1e30, 2e30, 2e30),
            (1e-30, 1e-30, 1e-31, 1e-32),
            (1e15, 1e15, 0.25, 0.25),
        ] {
            let page = Page::new(Rect::new(x, y, x + w, y + h)).unwrap();
            for p in [Point::new(x, y), Point::new(x + w, y + h)] {
                let (px, py) = page.pixel(p);
                assert!(page.frame.contains(Point::new(px, py)), "{p:?} at {px}, {py}");
            }
            let (a, b) = (page.pixel(Point::new(x, y)), page.pixel(Point::new(x + w, y + h)));
            assert!(a.0 <= b.0 && a.1 >= b.1);
            assert!(page.cell(Rect::PLANE) == page.frame);
            assert!((500..=2000).contains(&page.height));
        }
        assert!(Page::new(Rect::EMPTY).unwrap().x_axis.ticks.is_empty());
        assert!(Page::new(Rect::PLANE).is_err());
    }
}
