//! Points exactly on a circle: integer points with x² + y² = R².
//!
//! A prime p = 1 (mod 4) is a sum of two squares a² + b², that is p = π·π̄ with the Gaussian
//! integer π = a + bi. If R = p₁^e₁ · p₂^e₂ · …, then z = i^u · ∏ πⱼ^kⱼ · π̄ⱼ^(2eⱼ - kⱼ) with u in
//! 0..4 and kⱼ in 0..=2eⱼ are all the Gaussian integers with |z| = R, each once: 4 · ∏ (2eⱼ + 1)
//! points (Hardy and Wright, An Introduction to the Theory of Numbers, chapter XVI). u and the kⱼ
//! are the digits of a number, so no table of points is needed.
//!
//! R must stay below 2^53 for coordinates to be exact. The best product is 5² · 13 · 17 · 29 · 37 ·
//! 41 · 53 · 61 · 73 · 89 = 5.1e15 with 4 · 5 · 3⁹ = 393660 points. Few points get a small circle:
//! the smallest number of these factors that suffices.

use crate::degenerate::Shuffled;
use crate::random::{Purpose, Stream, cos_sin};
use crate::source::Source;

/// a, b with a² + b² = 5, 13, 17, 29, 37, 41, 53, 61, 73, 89.
const FACTORS: [[i64; 2]; 10] = [
    [2, 1],
    [3, 2],
    [4, 1],
    [5, 2],
    [6, 1],
    [5, 4],
    [7, 2],
    [6, 5],
    [8, 3],
    [8, 5],
];

/// [`Kind::Circle`](crate::Kind::Circle).
#[derive(Clone, Debug)]
pub(crate) enum Circle {
    /// Integer points: the shuffled numbers of points, and the exponent of each factor in R.
    Exact(Shuffled, [u8; FACTORS.len()]),
    /// Random angles on the unit circle, rounded.
    Rounded(Box<Stream>),
}

impl Circle {
    pub(crate) fn new(n: u64, seed: u64) -> Self {
        let mut exponents = [0; FACTORS.len()];
        for i in (0..FACTORS.len()).chain([0]) {
            exponents[i] += 1;
            let count = exponents.iter().map(|&e| 2 * u64::from(e) + 1).product::<u64>() * 4;
            if n <= count {
                return Circle::Exact(Shuffled::new(count, seed), exponents);
            }
        }
        Circle::Rounded(Box::new(Stream::new(seed, Purpose::Points)))
    }
}

impl Source for Circle {
    fn next(&mut self) -> [f64; 2] {
        match self {
            Circle::Exact(numbers, exponents) => integer_point(numbers.next(), exponents).map(|x| x as f64),
            Circle::Rounded(stream) => cos_sin(stream.unit()),
        }
    }
}

/// Returns the `number`-th Gaussian integer with modulus R = ∏ factor^exponent.
fn integer_point(mut number: u64, exponents: &[u8; FACTORS.len()]) -> [i64; 2] {
    let mut digit = |base: u64| {
        let digit = number % base;
        number /= base;
        digit
    };
    let mut z = [[1, 0], [0, 1], [-1, 0], [0, -1]][digit(4) as usize];
    for ([a, b], &e) in FACTORS.into_iter().zip(exponents) {
        let e = 2 * u64::from(e);
        let k = digit(e + 1);
        // No overflow: |z| only grows, up to R < 2^53, and each product below is at most the new
        // |z|.
        (0..k).for_each(|_| z = times(z, [a, b]));
        (k..e).for_each(|_| z = times(z, [a, -b]));
    }
    z
}

fn times([a, b]: [i64; 2], [c, d]: [i64; 2]) -> [i64; 2] {
    [a * c - b * d, a * d + b * c]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn integer_points_are_distinct_and_on_the_circle() {
        for (n, radius) in [
            (3, 5),
            (12, 5),
            (13, 65),
            (1000, 48_612_265),
            (100_000, 1_021_090_952_484_265),
            (393_660, 5_105_454_762_421_325),
        ] {
            let mut circle = Circle::new(n, 5);
            let points: HashSet<[i64; 2]> = (0..n).map(|_| circle.next().map(|x| x as i64)).collect();
            assert_eq!(points.len() as u64, n);
            for p in points {
                let [x, y] = p.map(i128::from);
                assert_eq!(x * x + y * y, radius * radius, "{x}, {y}");
            }
        }
        assert!(matches!(Circle::new(393_661, 5), Circle::Rounded(_)));
    }
}
