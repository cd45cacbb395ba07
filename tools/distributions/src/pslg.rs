//! Planar straight-line graphs of the thesis: many short segments that do not cross.
//!
//! The input is a kind, n, α and a seed. The output is n points and, independently of them, about
//! α·n segments between them.
//!
//! The plane is divided into about n/3 cells of equal mass. Each cell has three random points,
//! which are connected by all three segments with probability α, or by none. Cells are disjoint,
//! and the triangle of a cell's points stays within it, so no segments cross:
//!
//! - uniform: cells are the rectangles of a square grid; they are convex.
//! - line singularity: the same points, mapped. The map moves x only, and monotonically, so cells
//!   remain disjoint rectangles. The points are mapped, not the segments, and points in a rectangle
//!   have their segments in it.
//! - Kuzmin: cells are between two of √(n/3) radii and two of √(n/3) angles, at least three. A
//!   sector of at most 120° is convex except for its inner arc, the only boundary through which a
//!   chord can leave:
//!
//! ```text
//!        __---__                  __---__
//!      /         \              /         \
//!     a --------- b  leaves    /  a-----b  \   stays
//!      \   ___   /              \   ___   /
//!       \_/   \_/                \_/   \_/
//! ```
//!
//!   So three points are drawn again until all three segments avoid the inner circle. This depends
//!   on neither α nor the segments, and makes the mass of a cell slightly smaller at its inner arc.
//!   With the thousands of cells of a measurement it is rare: chords sag by the square of a
//!   sector's angle.
//!
//! Points keep 2^-20 of a cell's width away from its boundary, far more than any rounding, so all
//! of this holds for the rounded coordinates. Cells are visited in pseudo-random order; the three
//! points of a cell have consecutive record numbers.

use std::fmt;
use std::iter::FusedIterator;

use crate::Kind;
use crate::degenerate::{Shuffled, ceil_sqrt};
use crate::points::hint;
use crate::random::{Purpose, Stream};
use crate::scattered::{kuzmin, kuzmin_radius, line_singularity};

/// A PSLG of the thesis: `n` points in about n/3 cells. The points of a cell are connected by all
/// three segments with probability α, so there are about α·n segments in all, which do not cross.
///
/// If 3 does not divide n, the last one or two points are alone in their cell, without segments.
#[derive(Clone, Debug)]
pub struct Pslg {
    kind: Kind,
    n: u64,
    alpha: f64,
    seed: u64,
}

impl Pslg {
    /// Creates a PSLG of a kind with [`Kind::has_pslg`], with `n` <= 2^32 points and 0 <= `alpha`
    /// <= 1.
    pub fn new(kind: Kind, n: u64, alpha: f64, seed: u64) -> Result<Self, Unsupported> {
        if !kind.has_pslg() {
            return Err(Unsupported::Kind(kind));
        }
        if !(0.0..=1.0).contains(&alpha) {
            return Err(Unsupported::Alpha(alpha));
        }
        if n > MAX_RECORDS {
            return Err(Unsupported::Records(n));
        }
        Ok(Pslg { kind, n, alpha, seed })
    }

    /// Returns the number of points: n.
    pub fn records(&self) -> u64 {
        self.n
    }

    /// Returns the points, exactly `n`. They do not depend on α.
    pub fn points(&self) -> PslgPoints {
        let cells = self.n.div_ceil(3);
        let rows = ceil_sqrt(cells).max(1);
        let columns = match self.kind {
            Kind::Kuzmin => rows.max(3),
            _ => rows,
        };
        let rows = cells.div_ceil(columns).max(1);
        PslgPoints {
            kind: self.kind,
            cells: Shuffled::new(rows * columns, self.seed),
            rows,
            columns,
            stream: Stream::new(self.seed, Purpose::Points),
            cell: [[0.0; 2]; 3],
            next: 3,
            left: self.n,
        }
    }

    /// Returns the segments as pairs of record numbers, that is of indices into
    /// [`points`](Self::points), in ascending order of cells.
    pub fn segments(&self) -> impl Iterator<Item = [u32; 2]> + use<> {
        let mut stream = Stream::new(self.seed, Purpose::Segments);
        let alpha = self.alpha;
        // Below 2^32: n is at most that, and a record number is less than n.
        (0..self.n / 3).filter(move |_| stream.unit() < alpha).flat_map(|cell| {
            let [a, b, c] = [0, 1, 2].map(|i| (3 * cell + i) as u32);
            [[a, b], [b, c], [c, a]]
        })
    }
}

/// Record numbers are u32.
pub(crate) const MAX_RECORDS: u64 = 1 << 32;

/// Iterator of [`Pslg::points`].
#[derive(Clone, Debug)]
pub struct PslgPoints {
    kind: Kind,
    cells: Shuffled,
    rows: u64,
    columns: u64,
    stream: Stream,
    /// The points of the current cell, and the index of the next one to return.
    cell: [[f64; 2]; 3],
    next: usize,
    left: u64,
}

impl PslgPoints {
    fn draw_cell(&mut self) {
        let number = self.cells.next();
        let (row, column) = (number / self.columns, number % self.columns);
        let inner = kuzmin_radius(row as f64 / self.rows as f64);
        loop {
            for i in 0..3 {
                let u = self.draw(column, self.columns);
                let v = self.draw(row, self.rows);
                self.cell[i] = match self.kind {
                    Kind::Kuzmin => kuzmin(v, u),
                    Kind::LineSingularity => line_singularity([u, v]),
                    _ => [u, v],
                };
            }
            let [a, b, c] = self.cell;
            if self.kind != Kind::Kuzmin || [[a, b], [b, c], [c, a]].into_iter().all(|s| keeps_away(s, inner)) {
                return;
            }
        }
    }

    /// Returns a number in the `i`-th of `parts` equal parts of [0, 1], not too near to its ends.
    fn draw(&mut self, i: u64, parts: u64) -> f64 {
        const MARGIN: f64 = 1.0 / (1 << 20) as f64;
        (i as f64 + MARGIN + self.stream.unit() * (1.0 - 2.0 * MARGIN)) / parts as f64
    }
}

/// Returns whether a whole segment is more than `radius` away from the origin, as its ends are.
///
/// The nearest point is an end or the foot of the perpendicular, whose distance is |a × (b - a)| /
/// |b - a|. The error of this form is a few ulp of the distance, while cells are 2^-20 of their
/// width apart.
fn keeps_away([a, b]: [[f64; 2]; 2], radius: f64) -> bool {
    let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    let foot_within = a[0] * dx + a[1] * dy < 0.0 && b[0] * dx + b[1] * dy > 0.0;
    let cross = a[0] * dy - a[1] * dx;
    !foot_within || cross.abs() > radius * (dx * dx + dy * dy).sqrt()
}

impl Iterator for PslgPoints {
    type Item = [f64; 2];

    fn next(&mut self) -> Option<[f64; 2]> {
        self.left = self.left.checked_sub(1)?;
        if self.next == 3 {
            self.draw_cell();
            self.next = 0;
        }
        self.next += 1;
        Some(self.cell[self.next - 1])
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        hint(self.left)
    }
}

impl FusedIterator for PslgPoints {}

/// The reason why there is no such PSLG.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unsupported {
    /// The kind has no PSLG: see [`Kind::has_pslg`].
    Kind(Kind),
    /// α is not a probability.
    Alpha(f64),
    /// Too many points: segments refer to them by u32.
    Records(u64),
}

impl fmt::Display for Unsupported {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Unsupported::Kind(kind) => {
                let mut kinds = Kind::ALL.to_vec();
                kinds.retain(|kind| kind.has_pslg());
                write!(
                    f,
                    "there is no PSLG of kind {kind}, only of {}",
                    kinds.iter().map(|k| k.name()).collect::<Vec<_>>().join(", ")
                )
            }
            Unsupported::Alpha(alpha) => write!(f, "the probability of segments is {alpha}, but must be from 0 to 1"),
            Unsupported::Records(n) => {
                write!(f, "segments refer to at most 2^32 points, but there would be {n}")
            }
        }
    }
}

impl std::error::Error for Unsupported {}
