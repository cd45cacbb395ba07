//! A pseudo-random order of 0..n that needs no memory.
//!
//! The input is n, a seed and a position. The output is the number at that position; each number of
//! 0..n is at exactly one position. A Feistel network permutes the numbers of b bits, 2^(b-1) < n
//! <= 2^b. Results of n or more pass through it again until one is below n ("cycle walking", J.
//! Black and P. Rogaway, Ciphers with Arbitrary Finite Domains, 2002), less than twice on average.
//!
//! ```text
//!      left   right            left and right have b/2 bits, one of them a bit more if b is odd;
//!        |      |              every round is undone by the same round, so the network is one-to-one
//!        ^ <- f(right, key)    whatever f is
//!         \    /
//!          \  /
//!           \/
//!           /\
//!      right' left'
//! ```

use crate::random::{Purpose, Stream, mix};

const ROUNDS: usize = 6;

/// A permutation of 0..n.
#[derive(Clone, Debug)]
pub(crate) struct Shuffle {
    n: u64,
    /// The bits of the left and of the right half, before the first round and after every other
    /// one.
    widths: [u32; 2],
    keys: [u64; ROUNDS],
}

impl Shuffle {
    /// Creates the permutation of 0..n for a seed. n may be at most 2^63.
    pub(crate) fn new(n: u64, seed: u64) -> Self {
        assert!(n <= 1 << 63, "cannot shuffle more than 2^63 numbers");
        let bits = n.next_power_of_two().trailing_zeros().max(2);
        let mut stream = Stream::new(seed, Purpose::Shuffle);
        Shuffle {
            n,
            widths: [bits / 2, bits - bits / 2],
            keys: std::array::from_fn(|_| stream.bits()),
        }
    }

    /// Returns the number at position `i` < n.
    #[inline]
    pub(crate) fn at(&self, i: u64) -> u64 {
        debug_assert!(i < self.n);
        let mut x = self.permute(i);
        while x >= self.n {
            x = self.permute(x);
        }
        x
    }

    #[inline]
    fn permute(&self, x: u64) -> u64 {
        let [left_width, right_width] = self.widths;
        let (mut left, mut right) = (x >> right_width, x & ((1 << right_width) - 1));
        for pair in self.keys.chunks_exact(2) {
            left ^= mix(right ^ pair[0]) >> (64 - left_width);
            right ^= mix(left ^ pair[1]) >> (64 - right_width);
        }
        left << right_width | right
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_at_exactly_one_position() {
        for n in (0..130).chain([1000, 1023, 1024, 1025, 65_536, 100_003]) {
            for seed in 0..3 {
                let shuffle = Shuffle::new(n, seed);
                let mut seen = vec![false; n as usize];
                for i in 0..n {
                    let x = shuffle.at(i) as usize;
                    assert!(!std::mem::replace(&mut seen[x], true), "n {n}, seed {seed}: {x} twice");
                }
            }
        }
    }

    #[test]
    fn positions_and_numbers_are_uncorrelated() {
        let n = 10_000u64;
        let shuffle = Shuffle::new(n, 1);
        let ascents = (1..n).filter(|&i| shuffle.at(i) > shuffle.at(i - 1)).count();
        assert!((4800..5200).contains(&ascents), "{ascents}");
        let displacement: u64 = (0..n).map(|i| shuffle.at(i).abs_diff(i)).sum::<u64>() / n;
        assert!((3200..3470).contains(&displacement), "{displacement} instead of n/3");
        assert_ne!(shuffle.at(0), Shuffle::new(n, 2).at(0));
    }

    #[test]
    fn ranges_far_larger_than_memory_are_shuffled() {
        let shuffle = Shuffle::new((1 << 62) + 12_345, 9);
        assert!((0..1000).all(|i| shuffle.at(i) < (1 << 62) + 12_345));
    }
}
