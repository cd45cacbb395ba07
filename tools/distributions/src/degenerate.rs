//! Points that are collinear or cocircular, exactly or up to rounding.

use crate::random::{Purpose, Stream, cos_sin};
use crate::shuffle::Shuffle;
use crate::source::Source;

/// The numbers 0..n in pseudo-random order.
#[derive(Clone, Debug)]
pub(crate) struct Shuffled {
    order: Shuffle,
    position: u64,
}

impl Shuffled {
    pub(crate) fn new(n: u64, seed: u64) -> Self {
        Shuffled {
            order: Shuffle::new(n, seed),
            position: 0,
        }
    }

    #[inline]
    pub(crate) fn next(&mut self) -> u64 {
        self.position += 1;
        self.order.at(self.position - 1)
    }
}

/// [`Kind::Grid`](crate::Kind::Grid) and [`Kind::Offset`](crate::Kind::Offset).
#[derive(Clone, Debug)]
pub(crate) struct Grid {
    cells: Shuffled,
    columns: u64,
    offset: f64,
    step: f64,
}

impl Grid {
    pub(crate) fn new(n: u64, seed: u64, offset: f64, step: f64) -> Self {
        Grid {
            cells: Shuffled::new(n, seed),
            columns: ceil_sqrt(n).max(1),
            offset,
            step,
        }
    }
}

impl Source for Grid {
    #[inline]
    fn next(&mut self) -> [f64; 2] {
        let cell = self.cells.next();
        [cell % self.columns, cell / self.columns].map(|i| self.offset + i as f64 * self.step)
    }
}

/// Returns the smallest integer whose square is at least n.
pub(crate) fn ceil_sqrt(n: u64) -> u64 {
    let root = n.isqrt();
    root + u64::from(root * root < n)
}

/// [`Kind::Parabola`](crate::Kind::Parabola).
#[derive(Clone, Debug)]
pub(crate) struct Parabola(Shuffled);

impl Parabola {
    pub(crate) fn new(n: u64, seed: u64) -> Self {
        Parabola(Shuffled::new(n, seed))
    }
}

impl Source for Parabola {
    fn next(&mut self) -> [f64; 2] {
        let x = self.0.next() as f64;
        [x, x * x]
    }
}

/// [`Kind::Line`](crate::Kind::Line).
#[derive(Clone, Debug)]
pub(crate) struct Line(Shuffled);

impl Line {
    pub(crate) fn new(n: u64, seed: u64) -> Self {
        Line(Shuffled::new(n, seed))
    }
}

impl Source for Line {
    fn next(&mut self) -> [f64; 2] {
        let i = self.0.next() as f64;
        [3.0 * i, i]
    }
}

/// [`Kind::FourLines`](crate::Kind::FourLines).
#[derive(Clone, Debug)]
pub(crate) struct FourLines {
    numbers: Shuffled,
    /// Half the number of points on a line: s runs from 1 - 2 half to about 2 half.
    half: u64,
}

impl FourLines {
    pub(crate) fn new(n: u64, seed: u64) -> Self {
        FourLines {
            numbers: Shuffled::new(n, seed),
            half: n / 8,
        }
    }
}

impl Source for FourLines {
    fn next(&mut self) -> [f64; 2] {
        let i = self.numbers.next();
        // s is odd, so no point is at the origin, which would be on all four lines.
        let s = (2 * (i / 4) + 1) as f64 - (2 * self.half) as f64;
        match i % 4 {
            0 => [s, 0.0],
            1 => [0.0, s],
            2 => [s, s],
            _ => [s, -s],
        }
    }
}

/// [`Kind::NearlyCollinear`](crate::Kind::NearlyCollinear).
#[derive(Clone, Debug)]
pub(crate) struct NearlyCollinear {
    stream: Stream,
    start: [f64; 2],
    /// The vector from the run's start to its end.
    vector: [f64; 2],
    number: u64,
}

impl NearlyCollinear {
    pub(crate) fn new(seed: u64) -> Self {
        NearlyCollinear {
            stream: Stream::new(seed, Purpose::Points),
            start: [0.0; 2],
            vector: [0.0; 2],
            number: 0,
        }
    }
}

impl Source for NearlyCollinear {
    fn next(&mut self) -> [f64; 2] {
        const RUN: u64 = 1000;
        if self.number.is_multiple_of(RUN) {
            // Points around (1.5, 1.5), so that no coordinate is near 0: the ulp is the same nearly
            // everywhere.
            let [x, y] = [self.stream.unit(), self.stream.unit()];
            self.start = [1.25 + x / 2.0, 1.25 + y / 2.0];
            self.vector = cos_sin(self.stream.unit()).map(|d| d / 8.0);
        }
        self.number += 1;
        let t = self.stream.unit();
        let [x, y] = [self.start[0] + t * self.vector[0], self.start[1] + t * self.vector[1]];
        [x, if self.number.is_multiple_of(4) { y.next_up() } else { y }]
    }
}
