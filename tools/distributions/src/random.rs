//! Randomness and trigonometry that give the same bits on every platform, today and in ten years.
//!
//! The input is a seed, the output numbers. The stream of 32-bit words is ChaCha8, which its
//! algorithm defines. Everything made from those words (64-bit integers, fractions, noise) is
//! computed here and not by `rand`, whose conversions may change between versions. Sine and cosine
//! are polynomials computed here, because those of the C library differ between platforms. IEEE 754
//! defines the remaining operations, `+ - * /`, `sqrt` and `round`, to the last bit.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// The purpose of a stream of numbers: streams of one seed with different purposes are independent.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Purpose {
    /// Coordinates x and y.
    Points = 0,
    /// Keys of a [`crate::shuffle::Shuffle`].
    Shuffle = 1,
    /// The third coordinate.
    Heights = 2,
    /// The choice of segments.
    Segments = 3,
    /// Ends of long segments.
    Ends = 4,
}

/// A seeded stream of random numbers.
#[derive(Clone, Debug)]
pub(crate) struct Stream(ChaCha8Rng);

impl Stream {
    /// Creates the stream of `seed` for a purpose: the key is the seed, little-endian, then zeros;
    /// the stream number is the purpose.
    pub(crate) fn new(seed: u64, purpose: Purpose) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        let mut rng = ChaCha8Rng::from_seed(key);
        rng.set_stream(purpose as u64);
        Stream(rng)
    }

    /// Returns 64 random bits: two words of the stream, the low one first.
    #[inline]
    pub(crate) fn bits(&mut self) -> u64 {
        let low = u64::from(self.0.next_u32());
        u64::from(self.0.next_u32()) << 32 | low
    }

    /// Returns a multiple of 2^-53 in [0, 1).
    #[inline]
    pub(crate) fn unit(&mut self) -> f64 {
        unit_of(self.bits())
    }

    /// Returns an integer in [0, n), or 0 if n is 0. Biased by less than n / 2^64.
    #[inline]
    pub(crate) fn below(&mut self, n: u64) -> u64 {
        ((u128::from(self.bits()) * u128::from(n)) >> 64) as u64
    }

    /// Returns bell-shaped noise in (-2, 2) with standard deviation 0.58: the sum of four uniform
    /// numbers, centred.
    #[inline]
    pub(crate) fn noise(&mut self) -> f64 {
        let (a, b, c, d) = (self.unit(), self.unit(), self.unit(), self.unit());
        (a + b) + (c + d) - 2.0
    }
}

/// Returns the upper 53 of 64 bits as a fraction in [0, 1).
#[inline]
pub(crate) fn unit_of(bits: u64) -> f64 {
    const ULP: f64 = 1.0 / (1u64 << 53) as f64;
    (bits >> 11) as f64 * ULP
}

/// Scrambles 64 bits one to one (the finalizer of `SplitMix64`: Steele, Lea and Flood 2014).
#[inline]
pub fn mix(x: u64) -> u64 {
    let x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}

/// Returns the point of the unit square that belongs to `key`: always the same one.
#[inline]
pub(crate) fn point_of(key: u64) -> [f64; 2] {
    let x = mix(key.wrapping_add(0x9e37_79b9_7f4a_7c15));
    [unit_of(x), unit_of(mix(x ^ 0xd1b5_4a32_d192_ed03))]
}

/// Returns cosine and sine of an angle in turns (1 = 360°), to about 1e-16 plus the rounding of the
/// argument.
///
/// The angle is reduced to at most an eighth of a turn on either side of a quadrant's axis, which
/// is exact. Taylor's series up to the 18th power then leaves an error below 1e-18.
pub(crate) fn cos_sin(turns: f64) -> [f64; 2] {
    let fraction = turns - turns.round();
    let quadrant = (fraction * 4.0).round();
    let a = (fraction - quadrant / 4.0) * std::f64::consts::TAU;
    let a2 = a * a;
    let (mut cos, mut sin) = (1.0, 1.0);
    // Horner: cos = 1 - a²/(1·2) (1 - a²/(3·4) (1 - …)),
    // sin/a = 1 - a²/(2·3) (1 - a²/(4·5) (1 - …))
    let mut k = 17.0;
    while k > 0.0 {
        cos = 1.0 - a2 * cos * (1.0 / (k * (k + 1.0)));
        sin = 1.0 - a2 * sin * (1.0 / ((k + 1.0) * (k + 2.0)));
        k -= 2.0;
    }
    let sin = sin * a;
    match quadrant as i32 {
        0 => [cos, sin],
        1 => [-sin, cos],
        -1 => [sin, -cos],
        _ => [-cos, -sin],
    }
}

/// Returns the sine of an angle in turns.
pub(crate) fn sin(turns: f64) -> f64 {
    cos_sin(turns)[1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_those_of_chacha8() {
        // The eSTREAM test vector of ChaCha8 with a key and a nonce of zeros begins 3e 00 ef 2f 89
        // 5f 40 d6.
        assert_eq!(Stream::new(0, Purpose::Points).bits(), 0xd640_5f89_2fef_003e);
    }

    #[test]
    fn fractions_stay_below_one() {
        assert_eq!(unit_of(0), 0.0);
        assert_eq!(unit_of(u64::MAX), 1.0 - f64::EPSILON / 2.0);
    }

    #[test]
    fn cosine_and_sine_agree_with_the_platform() {
        for i in -4000..4000 {
            let turns = f64::from(i) / 997.0;
            let [c, s] = cos_sin(turns);
            let (s0, c0) = (turns * std::f64::consts::TAU).sin_cos();
            assert!(
                (c - c0).abs() < 1e-14 && (s - s0).abs() < 1e-14,
                "{turns}: {c} {c0}, {s} {s0}"
            );
            assert!((c * c + s * s - 1.0).abs() < 1e-15);
        }
        assert_eq!(cos_sin(0.25), [0.0, 1.0]);
        assert_eq!(cos_sin(0.5)[0], -1.0);
    }

    #[test]
    fn integers_below_n_are_uniform() {
        let mut stream = Stream::new(3, Purpose::Points);
        let mut seen = [0; 6];
        (0..6000).for_each(|_| seen[stream.below(6) as usize] += 1);
        assert!(seen.iter().all(|&count| (850..1150).contains(&count)), "{seen:?}");
        assert_eq!(stream.below(0), 0);
    }
}
