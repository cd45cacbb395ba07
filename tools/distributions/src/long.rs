//! Long segments: a case that segments inserted cell by cell cannot have.
//!
//! The input is n, m and a seed. The output is n uniform points, the 2m ends of m segments, and the
//! segments. Each segment crosses nearly all of the unit square, from x in [0, 0.01) to x in (0.99,
//! 1], and no two of them meet.
//!
//! ```text
//!   1 +-------------+
//!     | -----_______|
//!     | ---________ |
//!     |  _____------|
//!     |_____--------|
//!   0 +-------------+
//! ```
//!
//! Segment i is on the line from (0, F(s)) to (1, G(t)) with s and t random in the i-th of m parts
//! of [0, 1]. F and G increase, so two lines have the same order on the left as on the right, and
//! do not cross between. F(t) = t + a·t·(1 - t) with a in ±[0.4, 0.9], and G has the other sign:
//! segments are bundled at the top on one side and at the bottom on the other, and their slopes are
//! up to ±0.45, different for every one.
//!
//! s and t keep 1/16 of their part's width away from its ends, and F' >= 0.1. So even for 2^31
//! segments the gap is 5e-12, far more than the rounding of the ends.

use crate::pslg::{MAX_RECORDS, Unsupported};
use crate::random::{Purpose, Stream};
use crate::shuffle::Shuffle;
use crate::{Kind, points};

/// `n` uniform points and `m` long segments that do not cross.
///
/// Records 0..n are the points of [`Kind::Uniform`]; the ends follow. Record n + 2k is the left end
/// and n + 2k + 1 the right end of segment k. Segments are in pseudo-random order of height.
#[derive(Clone, Debug)]
pub struct LongSegments {
    n: u64,
    m: u64,
    seed: u64,
}

impl LongSegments {
    /// Creates a set of `n` points and `m` segments, with n + 2m <= 2^32.
    pub fn new(n: u64, m: u64, seed: u64) -> Result<Self, Unsupported> {
        let records = n.saturating_add(m.saturating_mul(2));
        if records > MAX_RECORDS {
            return Err(Unsupported::Records(records));
        }
        Ok(LongSegments { n, m, seed })
    }

    /// Returns the number of points, ends included: n + 2m.
    pub fn records(&self) -> u64 {
        self.n + 2 * self.m
    }

    /// Returns the n points, then the 2m ends.
    pub fn points(&self) -> impl Iterator<Item = [f64; 2]> + use<> {
        let mut ends = Ends::new(self.m, self.seed);
        points(Kind::Uniform, self.n, self.seed).chain((0..self.m).flat_map(move |k| ends.draw(k)))
    }

    /// Returns the segments as pairs of record numbers.
    pub fn segments(&self) -> impl Iterator<Item = [u32; 2]> + use<> {
        let n = self.n;
        // Below 2^32, as `new` has checked.
        (0..self.m).map(move |k| [(n + 2 * k) as u32, (n + 2 * k + 1) as u32])
    }
}

/// Draws the ends of one segment after the other.
struct Ends {
    heights: Shuffle,
    m: u64,
    stream: Stream,
    /// The a of F and of G.
    bends: [f64; 2],
}

impl Ends {
    fn new(m: u64, seed: u64) -> Self {
        let mut stream = Stream::new(seed, Purpose::Ends);
        let [a, b] = [stream.unit(), stream.unit()].map(|u| 0.4 + 0.5 * u);
        let bends = if stream.unit() < 0.5 { [a, -b] } else { [-a, b] };
        Ends {
            heights: Shuffle::new(m, seed),
            m,
            stream,
            bends,
        }
    }

    /// Returns the left and the right end of segment `k`; must be called for 0, 1, 2 … in order.
    fn draw(&mut self, k: u64) -> [[f64; 2]; 2] {
        let part = self.heights.at(k) as f64;
        let [left, right] = self.bends.map(|bend| {
            let t = (part + (1.0 + 14.0 * self.stream.unit()) / 16.0) / self.m as f64;
            t + bend * t * (1.0 - t)
        });
        let at = |x: f64| [x, left + (right - left) * x];
        let x = 0.01 * self.stream.unit();
        [at(x), at(1.0 - 0.01 * self.stream.unit())]
    }
}
