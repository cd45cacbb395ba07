//! Sums that do not depend on their order.
//!
//! In: numbers, in any order and in parts. Out: their exact sum, rounded once. A sum is a fixed-point
//! number with all the bits that an `f64` can have (Kulisch), so that no addition is rounded.

/// The bits of a digit.
const BITS: usize = 32;
/// 2098 bits of `f64`, and room for carries.
const DIGITS: usize = 68;
/// The number of additions after which no digit can have overflowed.
const MANY: u32 = 1 << 30;

/// An exact sum of numbers.
#[derive(Clone, Debug)]
pub(crate) struct ExactSum {
    /// The digits to the base 2³², in units of 2⁻¹⁰⁷⁴, the lowest first. Each has a sign of its own
    /// until carries are [settled](Self::settle).
    digits: [i64; DIGITS],
    additions: u32,
    /// Whether an infinite number, or none, was added.
    is_infinite: bool,
}

impl Default for ExactSum {
    fn default() -> Self {
        Self {
            digits: [0; DIGITS],
            additions: 0,
            is_infinite: false,
        }
    }
}

impl ExactSum {
    /// Adds a number.
    pub(crate) fn add(&mut self, number: f64) {
        if !number.is_finite() {
            self.is_infinite = true;
            return;
        }
        let bits = number.to_bits();
        let (fraction, exponent) = (bits & ((1 << 52) - 1), (bits >> 52) as usize & 0x7ff);
        let (significand, shift) = match exponent {
            0 => (fraction, 0),
            _ => (fraction | 1 << 52, exponent - 1),
        };
        let mut rest = u128::from(significand) << (shift % BITS);
        for digit in &mut self.digits[shift / BITS..shift / BITS + 3] {
            let part = i64::from(rest as u32);
            *digit += if number.is_sign_negative() { -part } else { part };
            rest >>= BITS;
        }
        self.count(1);
    }

    /// Adds another sum.
    pub(crate) fn merge(&mut self, mut other: Self) {
        other.settle();
        for (digit, other) in self.digits.iter_mut().zip(other.digits) {
            *digit += other;
        }
        self.is_infinite |= other.is_infinite;
        self.count(1);
    }

    fn count(&mut self, additions: u32) {
        self.additions += additions;
        if self.additions >= MANY {
            self.settle();
        }
    }

    /// Propagates carries: all digits but the highest one are then at least 0 and below the base.
    fn settle(&mut self) {
        let mut carry = 0;
        for digit in &mut self.digits[..DIGITS - 1] {
            let sum = *digit + carry;
            carry = sum >> BITS;
            *digit = sum & i64::from(u32::MAX);
        }
        self.digits[DIGITS - 1] += carry;
        self.additions = 1;
    }

    /// Returns the sum, rounded to the nearest number; `None` if it is infinite or none.
    pub(crate) fn total(&self) -> Option<f64> {
        let mut sum = self.clone();
        sum.settle();
        let is_negative = sum.digits[DIGITS - 1] < 0;
        if is_negative {
            sum.digits.iter_mut().for_each(|digit| *digit = -*digit);
            sum.settle();
        }
        let Some(highest) = sum.digits.iter().rposition(|&digit| digit != 0) else {
            return (!self.is_infinite).then_some(0.0);
        };
        // At least 97 bits, the lowest of which stands for all below it.
        let lowest = highest.saturating_sub(3);
        let leading = sum.digits[lowest..=highest].iter().rev();
        let leading = leading.fold(0u128, |leading, &digit| leading << BITS | digit.cast_unsigned() as u128);
        let has_more = sum.digits[..lowest].iter().any(|&digit| digit != 0);
        let rounded = (leading | u128::from(has_more)) as f64;
        let exponent = (BITS * lowest) as i32 - 1074;
        // In two steps, because each factor must be a number.
        let half = exponent / 2;
        let total = rounded * 2f64.powi(half) * 2f64.powi(exponent - half);
        let total = if is_negative { -total } else { total };
        (total.is_finite() && !self.is_infinite).then_some(total)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn total(numbers: &[f64]) -> Option<f64> {
        let mut sum = ExactSum::default();
        numbers.iter().for_each(|&number| sum.add(number));
        sum.total()
    }

    #[test]
    fn sums_are_exact_and_rounded_once() {
        for (numbers, expected) in [
            (&[][..], 0.0),
            (&[1.5, -0.25], 1.25),
            (&[1e300, 1.0, -1e300], 1.0),
            (&[f64::MAX, f64::MAX, -f64::MAX], f64::MAX),
            (&[5e-324, 5e-324, -1e-323, -5e-324], -5e-324),
            (&[1.0, f64::EPSILON / 2.0], 1.0),
            (&[1.0, f64::EPSILON / 2.0, 5e-324], 1.0 + f64::EPSILON),
            (&[-1.0, 1e-200], -1.0),
        ] {
            assert_eq!(total(numbers), Some(expected), "{numbers:?}");
        }
        assert_eq!(total(&[f64::MAX, f64::MAX]), None);
        assert_eq!(total(&[f64::INFINITY, 1.0]), None);
        assert_eq!(total(&[f64::NAN]), None);
    }

    proptest! {
        #[test]
        fn the_order_and_the_parts_do_not_matter(
            parts in prop::collection::vec((-1.0..1.0f64, -300..300i32), 0..60),
            at in 0..60usize,
        ) {
            let numbers: Vec<f64> = parts.iter().map(|&(m, e)| m * 2f64.powi(e)).collect();
            let expected = total(&numbers);
            let mut backwards = numbers.clone();
            backwards.reverse();
            prop_assert_eq!(total(&backwards), expected);
            let (left, right) = numbers.split_at(at.min(numbers.len()));
            let mut sums = [left, right].map(|numbers| {
                let mut sum = ExactSum::default();
                numbers.iter().for_each(|&number| sum.add(number));
                sum
            });
            let other = std::mem::take(&mut sums[1]);
            sums[0].merge(other);
            prop_assert_eq!(sums[0].total(), expected);
        }
    }
}
