//! Coverage of pixels by lines and areas, added one by one in any order.
//!
//! In: lines and triangles in pixels of an image, some perhaps outside. Out: how much of each pixel
//! they cover. All sums are of whole numbers, so that the order of what is drawn does not matter.

/// A point in pixels, y downwards.
pub type Pixel = (f64, f64);

/// The total length of lines in each pixel.
pub struct Lengths {
    columns: usize,
    /// In units of [`Lengths::UNIT`].
    sums: Vec<u16>,
}

/// How much of each pixel is under the widest of some strokes.
pub struct Strokes {
    columns: usize,
    covered: Vec<u8>,
}

/// The area of each pixel that lies in triangles that do not overlap.
pub struct Areas {
    columns: usize,
    /// The change of the covered area from each pixel to its right neighbour, in units of
    /// [`Areas::UNIT`]; one column more than the image has. Sides of two triangles cancel out.
    changes: Vec<i32>,
}

impl Lengths {
    /// Parts of a pixel's width. More than 256 pixels of length count as 256.
    const UNIT: f64 = 256.0;

    /// Creates an image without lines.
    pub fn new((columns, rows): (usize, usize)) -> Self {
        Self {
            columns,
            sums: vec![0; columns * rows],
        }
    }

    /// Adds a line. Each piece of it is shared by the four pixels around its middle. Shares are rounded
    /// up, so that many tiny ones do not vanish.
    pub fn line(&mut self, a: Pixel, b: Pixel) {
        let Some((a, b)) = clipped(a, b, self.size(), 0.0) else {
            return;
        };
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let pieces = dx.abs().max(dy.abs()).ceil().max(1.0);
        let length = Self::UNIT * dx.hypot(dy) / pieces;
        for piece in 0..pieces as u32 {
            let at = (f64::from(piece) + 0.5) / pieces;
            let (x, y) = (a.0 + dx * at - 0.5, a.1 + dy * at - 0.5);
            let (right, below) = (x - x.floor(), y - y.floor());
            for (column, row, share) in [
                (0.0, 0.0, (1.0 - right) * (1.0 - below)),
                (1.0, 0.0, right * (1.0 - below)),
                (0.0, 1.0, (1.0 - right) * below),
                (1.0, 1.0, right * below),
            ] {
                self.add(x.floor() + column, y.floor() + row, (length * share).ceil() as u16);
            }
        }
    }

    fn size(&self) -> (usize, usize) {
        (self.columns, self.sums.len() / self.columns)
    }

    fn add(&mut self, x: f64, y: f64, length: u16) {
        let (columns, rows) = self.size();
        if (0.0..columns as f64).contains(&x) && (0.0..rows as f64).contains(&y) {
            let sum = &mut self.sums[y as usize * columns + x as usize];
            *sum = sum.saturating_add(length);
        }
    }

    /// Returns the length of lines in each pixel, in pixels.
    pub fn all(&self) -> impl Iterator<Item = f64> {
        self.sums.iter().map(|&sum| f64::from(sum) / Self::UNIT)
    }
}

impl Strokes {
    /// Creates an image without strokes.
    pub fn new((columns, rows): (usize, usize)) -> Self {
        Self {
            columns,
            covered: vec![0; columns * rows],
        }
    }

    /// Adds a line of some width with round ends; a disc if both ends are the same.
    pub fn line(&mut self, a: Pixel, b: Pixel, width: f64) {
        let (columns, rows) = (self.columns, self.covered.len() / self.columns);
        // Up to this distance, the middle of a pixel is at least touched.
        let reach = width / 2.0 + 0.5;
        let Some((a, b)) = clipped(a, b, (columns, rows), reach) else {
            return;
        };
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let square = dx * dx + dy * dy;
        let position = |x: f64, y: f64| match square > 0.0 {
            true => (((x - a.0) * dx + (y - a.1) * dy) / square).clamp(0.0, 1.0),
            false => 0.0,
        };
        for row in range(a.1.min(b.1) - reach, a.1.max(b.1) + reach, rows) {
            let y = row as f64 + 0.5;
            // The part of the line from which this row is within reach.
            let [from, to] = match dy == 0.0 {
                true => [0.0, 1.0],
                false => [-reach, reach].map(|far| ((y + far - a.1) / dy).clamp(0.0, 1.0)),
            };
            let [from, to] = [from, to].map(|at| a.0 + dx * at);
            for column in range(from.min(to) - reach, from.max(to) + reach, columns) {
                let x = column as f64 + 0.5;
                let at = position(x, y);
                let distance = (x - a.0 - dx * at).hypot(y - a.1 - dy * at);
                let covered = (255.0 * (reach - distance).clamp(0.0, 1.0)).round() as u8;
                let pixel = &mut self.covered[row * columns + column];
                *pixel = covered.max(*pixel);
            }
        }
    }

    /// Returns how much of each pixel is covered, up to 1.
    pub fn all(&self) -> impl Iterator<Item = f64> {
        self.covered.iter().map(|&covered| f64::from(covered) / 255.0)
    }
}

impl Areas {
    /// Parts of a pixel's area.
    const UNIT: f64 = 65536.0;
    /// Parts of a pixel's height to which corners are rounded, so that heights are exact.
    const STEPS: f64 = 256.0;

    /// Creates an image without triangles.
    pub fn new((columns, rows): (usize, usize)) -> Self {
        Self {
            columns,
            changes: vec![0; (columns + 1) * rows],
        }
    }

    /// Adds a triangle. All triangles have the same orientation.
    pub fn triangle(&mut self, corners: [Pixel; 3]) {
        let corners = corners.map(|(x, y)| (x, (y * Self::STEPS).round() / Self::STEPS));
        if corners.iter().all(|(x, y)| x.is_finite() && y.is_finite()) {
            (0..3).for_each(|i| self.side(corners[i], corners[(i + 1) % 3]));
        }
    }

    fn side(&mut self, a: Pixel, b: Pixel) {
        let (sign, a, b) = if a.1 < b.1 { (1, a, b) } else { (-1, b, a) };
        let rows = self.changes.len() / (self.columns + 1);
        // The same side gives the same numbers in both directions.
        let x_at = |y: f64| a.0 + (b.0 - a.0) * ((y - a.1) / (b.1 - a.1));
        for row in range(a.1, b.1, rows) {
            let (top, bottom) = (a.1.max(row as f64), b.1.min(row as f64 + 1.0));
            if top < bottom {
                self.piece(row, x_at(top), x_at(bottom), bottom - top, sign);
            }
        }
    }

    /// Adds a piece of a side within a row: all to the right of it changes by its height.
    fn piece(&mut self, row: usize, x0: f64, x1: f64, height: f64, sign: i32) {
        let last = self.columns as f64;
        let (x0, x1) = (x0.min(x1).clamp(0.0, last), x0.max(x1).clamp(0.0, last));
        let changes = &mut self.changes[row * (self.columns + 1)..][..self.columns + 1];
        let total = (height * Self::UNIT) as i32;
        // The area to the right of the piece and to the left of `x`, for each unit of height.
        let area = |x: f64| match x {
            _ if x <= x0 => 0.0,
            _ if x >= x1 => x - (x0 + x1) / 2.0,
            _ => (x - x0) * (x - x0) / (2.0 * (x1 - x0)),
        };
        let (mut column, mut before) = (x0 as usize, 0);
        while column < self.columns && before != total {
            let x = column as f64;
            let share = if x >= x1 { 1.0 } else { area(x + 1.0) - area(x) };
            let covered = if share >= 1.0 {
                total
            } else {
                (share * f64::from(total)).round() as i32
            };
            changes[column] = changes[column].wrapping_add(sign * (covered - before));
            (column, before) = (column + 1, covered);
        }
    }

    /// Returns how much of each pixel is covered, up to 1.
    pub fn all(&self) -> impl Iterator<Item = f64> {
        self.changes.chunks(self.columns + 1).flat_map(|row| {
            let mut sum = 0i32;
            row[..self.columns].iter().map(move |&change| {
                sum = sum.wrapping_add(change);
                (f64::from(sum.unsigned_abs()) / Self::UNIT).min(1.0)
            })
        })
    }
}

/// Returns the whole numbers below `count` whose pixels meet an interval.
fn range(min: f64, max: f64, count: usize) -> std::ops::Range<usize> {
    // Conversions saturate.
    min.floor() as usize..(max.ceil() as usize).min(count)
}

/// Returns the part of a line within `margin` of an image; `None` if there is none.
fn clipped(a: Pixel, b: Pixel, (columns, rows): (usize, usize), margin: f64) -> Option<(Pixel, Pixel)> {
    let (mut from, mut to) = (0.0f64, 1.0f64);
    for (start, end, most) in [(a.0, b.0, columns as f64), (a.1, b.1, rows as f64)] {
        let [low, high] = [-margin, most + margin].map(|side| (side - start) / (end - start));
        if start == end {
            if !(-margin..=most + margin).contains(&start) {
                return None;
            }
        } else {
            (from, to) = (from.max(low.min(high)), to.min(low.max(high)));
        }
    }
    // Not so if a number is infinite or none.
    let inside = from <= to && [a.0, a.1, b.0, b.1].iter().all(|v| v.is_finite());
    let at = |share: f64| match share {
        0.0 => a,
        1.0 => b,
        // Rounding must not lead far away from the image.
        _ => (
            (a.0 + (b.0 - a.0) * share).clamp(-margin, columns as f64 + margin),
            (a.1 + (b.1 - a.1) * share).clamp(-margin, rows as f64 + margin),
        ),
    };
    inside.then(|| (at(from), at(to)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (usize, usize) = (20, 10);

    fn total(all: impl Iterator<Item = f64>) -> f64 {
        all.sum()
    }

    #[test]
    fn lengths_add_up_in_any_order() {
        let lines = [
            ((2.0, 2.0), (17.0, 8.0)),
            ((5.0, 8.5), (5.01, 8.5)),
            ((3.0, 7.0), (3.0, 2.0)),
        ];
        let draw = |order: [usize; 3]| {
            let mut lengths = Lengths::new(SIZE);
            order.into_iter().for_each(|i| lengths.line(lines[i].0, lines[i].1));
            lengths
        };
        let (one, other) = (draw([0, 1, 2]), draw([2, 0, 1]));
        assert_eq!(one.sums, other.sums);
        let expected = 15f64.hypot(6.0) + 0.01 + 5.0;
        assert!((total(one.all()) - expected).abs() < 0.4);
    }

    #[test]
    fn strokes_are_as_wide_as_they_should_be() {
        for end in [(15.0, 5.0), (13.0, 8.0), (4.0, 7.5)] {
            let mut strokes = Strokes::new(SIZE);
            strokes.line((4.0, 4.0), end, 2.0);
            let length = (end.0 - 4.0).hypot(end.1 - 4.0);
            let area = 2.0 * length + std::f64::consts::PI;
            assert!((total(strokes.all()) - area).abs() < 0.1 * area, "{end:?}");
            let mut back = Strokes::new(SIZE);
            back.line(end, (4.0, 4.0), 2.0);
            assert!(total(back.all()) > 0.0);
        }
    }

    #[test]
    fn areas_are_exact_and_inner_sides_leave_no_trace() {
        let corners = [(1.0, 1.0), (18.5, 2.25), (7.25, 9.5)];
        let inner = (9.0, 4.5);
        let mut whole = Areas::new(SIZE);
        whole.triangle(corners);
        let mut parts = Areas::new(SIZE);
        (0..3).for_each(|i| parts.triangle([corners[i], corners[(i + 1) % 3], inner]));
        assert!(whole.changes == parts.changes);
        let [(ax, ay), (bx, by), (cx, cy)] = corners;
        let area = ((bx - ax) * (cy - ay) - (by - ay) * (cx - ax)) / 2.0;
        assert!((total(whole.all()) - area).abs() < 0.01);
        assert_eq!(whole.all().nth(4 * 20 + 9), Some(1.0));
        let mut small = Areas::new(SIZE);
        small.triangle([(3.25, 3.25), (3.75, 3.25), (3.25, 3.75)]);
        assert_eq!(
            small.all().filter(|&covered| covered > 0.0).collect::<Vec<_>>(),
            [0.125]
        );
    }

    #[test]
    fn what_is_outside_takes_no_time_and_no_memory() {
        let far = [-1e300, -1e18, -3.0, 5.0, 25.0, 1e18, 1e300, f64::NAN, f64::INFINITY];
        let points: Vec<_> = far.iter().flat_map(|&x| far.map(|y| (x, y))).collect();
        let (mut lengths, mut strokes, mut areas) = (Lengths::new(SIZE), Strokes::new(SIZE), Areas::new(SIZE));
        for &a in &points {
            for &b in &points {
                lengths.line(a, b);
                strokes.line(a, b, 3.0);
                areas.triangle([a, b, (5.0, 5.0)]);
            }
        }
        let mut outside = Strokes::new(SIZE);
        outside.line((-3.0, -9.0), (30.0, -9.0), 3.0);
        assert_eq!(total(outside.all()), 0.0);
        outside.line((-1e9, 5.0), (1e9, 5.0), 1.0);
        assert!((total(outside.all()) - 20.0).abs() < 0.1);
    }
}
