//! Exact arithmetic on floating-point expansions.
//!
//! An expansion is a number stored as an unevaluated sum of `f64` terms that do not overlap, in
//! order of increasing magnitude. Sums, differences and products of expansions have no rounding
//! error, so the sign of the largest term is the sign of the number. The source is Shewchuk,
//! "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", Discrete &
//! Computational Geometry 18 (1997). Departures: zero terms are always dropped, and an expansion is
//! a value on the stack whose capacity is checked at compile time.
//!
//! The arithmetic is exact unless an operation overflows or underflows.
//! [`predicates`](crate::geometry::predicates) shows that its use does neither.

use std::cmp::Ordering;

/// 2²⁷ + 1: multiplying by it splits the 53 bits of a significand into two halves of at most 26
/// bits (Veltkamp, Dekker).
const SPLITTER: f64 = 134_217_729.0;

/// Whether `mul_add` is a single instruction. Otherwise it is a call into the mathematical library,
/// far slower than splitting.
const FUSED: bool = cfg!(any(target_feature = "fma", target_arch = "aarch64"));

/// Returns the rounded sum of `a` and `b`, and its rounding error (Knuth).
#[inline]
pub(super) fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    let a_part = sum - b_part;
    (sum, (a - a_part) + (b - b_part))
}

/// Returns the same as [`two_sum`]. `a` must be zero or not smaller in magnitude than `b` (Dekker).
#[inline]
fn fast_two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    (sum, b - (sum - a))
}

/// Returns the rounded product of `a` and `b`, and its rounding error.
#[inline]
pub(super) fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    if FUSED {
        return (product, a.mul_add(b, -product));
    }
    let (a_high, a_low) = split(a);
    let (b_high, b_low) = split(b);
    let rest = ((product - a_high * b_high) - a_low * b_high) - a_high * b_low;
    (product, a_low * b_low - rest)
}

/// Splits `a` into a sum of two halves. The products of halves are exact.
#[inline]
fn split(a: f64) -> (f64, f64) {
    let scaled = SPLITTER * a;
    let high = scaled - (scaled - a);
    (high, a - high)
}

/// An expansion of at most `N` nonzero terms, strongly nonoverlapping and of increasing magnitude.
#[derive(Clone, Copy, Debug)]
pub(super) struct Expansion<const N: usize> {
    terms: [f64; N],
    len: usize,
}

impl<const N: usize> Expansion<N> {
    const ZERO: Self = Self {
        terms: [0.0; N],
        len: 0,
    };

    /// Returns `a` - `b`.
    #[inline]
    pub(super) fn difference(a: f64, b: f64) -> Self {
        const { assert!(N >= 2) };
        let (high, low) = two_sum(a, -b);
        let mut result = Self::ZERO;
        result.push(low);
        result.push(high);
        result
    }

    /// Returns the number of terms.
    #[inline]
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// Returns the sign of the number, as its order relative to zero.
    #[inline]
    pub(super) fn sign(&self) -> Ordering {
        match self.terms().last() {
            None => Ordering::Equal,
            Some(&largest) if largest > 0.0 => Ordering::Greater,
            Some(_) => Ordering::Less,
        }
    }

    /// Returns the number with a relative error of a few roundings.
    pub(super) fn estimate(&self) -> f64 {
        self.terms().iter().sum()
    }

    /// Returns the same number with capacity `M`. Panics if it has more than `M` terms.
    pub(super) fn shrunk<const M: usize>(&self) -> Expansion<M> {
        let mut result = Expansion::ZERO;
        result.terms[..self.len].copy_from_slice(self.terms());
        result.len = self.len;
        result
    }

    /// Returns the number with the opposite sign.
    #[inline]
    pub(super) fn negated(mut self) -> Self {
        for term in &mut self.terms[..self.len] {
            *term = -*term;
        }
        self
    }

    /// Returns `e` + `f` (Shewchuk, FAST-EXPANSION-SUM).
    pub(super) fn sum<const E: usize, const F: usize>(e: &Expansion<E>, f: &Expansion<F>) -> Self {
        const { assert!(N >= E + F) };
        let mut result = Self::ZERO;
        result.set_sum(e, f);
        result
    }

    /// Returns `e` × `factor` (Shewchuk, SCALE-EXPANSION).
    pub(super) fn scaled<const E: usize>(e: &Expansion<E>, factor: f64) -> Self {
        const { assert!(N >= 2 * E) };
        let mut result = Self::ZERO;
        let mut carry = 0.0;
        for &term in e.terms() {
            let (high, low) = two_product(term, factor);
            let (sum, error) = two_sum(carry, low);
            result.push(error);
            let (sum, error) = fast_two_sum(high, sum);
            result.push(error);
            carry = sum;
        }
        result.push(carry);
        result
    }

    /// Returns `e` × `f`, as the sum of `e` scaled by each term of `f`.
    pub(super) fn product<const E: usize, const F: usize, const S: usize>(e: &Expansion<E>, f: &Expansion<F>) -> Self {
        const { assert!(N >= 2 * E * F && S >= 2 * E) };
        let mut result = Self::ZERO;
        let mut next = Self::ZERO;
        for &factor in f.terms() {
            next.set_sum(&result, &Expansion::<S>::scaled(e, factor));
            std::mem::swap(&mut result, &mut next);
        }
        result
    }

    fn terms(&self) -> &[f64] {
        &self.terms[..self.len]
    }

    #[inline]
    fn push(&mut self, term: f64) {
        if term != 0.0 {
            self.terms[self.len] = term;
            self.len += 1;
        }
    }

    fn set_sum<const E: usize, const F: usize>(&mut self, e: &Expansion<E>, f: &Expansion<F>) {
        self.len = 0;
        let (mut e, mut f) = (e.terms().iter(), f.terms().iter());
        let (mut next_e, mut next_f) = (e.next(), f.next());
        let mut carry = 0.0;
        loop {
            // Takes the smaller of the two next terms, as in a merge.
            let term = match (next_e, next_f) {
                (Some(&x), Some(&y)) if x.abs() < y.abs() => {
                    next_e = e.next();
                    x
                }
                (Some(&x), None) => {
                    next_e = e.next();
                    x
                }
                (_, Some(&y)) => {
                    next_f = f.next();
                    y
                }
                (None, None) => break,
            };
            let (sum, error) = two_sum(carry, term);
            self.push(error);
            carry = sum;
        }
        self.push(carry);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::oracle::Exact;
    use proptest::prelude::*;

    fn value<const N: usize>(e: &Expansion<N>) -> Exact {
        e.terms()
            .iter()
            .fold(Exact::from(0.0), |sum, &term| &sum + &Exact::from(term))
    }

    fn number() -> impl Strategy<Value = f64> {
        (-1.0..1.0, -90..90).prop_map(|(m, e): (f64, i32)| m * 2f64.powi(e))
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

        #[test]
        fn operations_are_exact(a in number(), b in number(), c in number(), d in number(), f in number()) {
            let [xa, xb, xc, xd, xf] = [a, b, c, d, f].map(Exact::from);
            let left = Expansion::<2>::difference(a, b);
            let right = Expansion::<2>::difference(c, d);
            let product = Expansion::<8>::product::<2, 2, 4>(&left, &right);
            let scaled = Expansion::<16>::scaled(&product, f);
            let total = Expansion::<18>::sum(&scaled, &left.negated());
            let exact = &(&xa - &xb) * &(&xc - &xd);
            prop_assert_eq!(value(&product).sign_of_difference(&exact), Ordering::Equal);
            let exact = &(&exact * &xf) - &(&xa - &xb);
            prop_assert_eq!(value(&total).sign_of_difference(&exact), Ordering::Equal);
            prop_assert_eq!(total.sign(), exact.sign());
            let error = (&Exact::from(total.estimate()) - &exact).sign_of_difference(&Exact::from(total.estimate().abs() * 1e-15));
            prop_assert_ne!(error, Ordering::Greater);
            prop_assert!(total.terms().is_sorted_by(|x, y| x.abs() < y.abs()));
            prop_assert!(total.terms().iter().all(|&term| term != 0.0));
        }
    }

    #[test]
    fn a_number_minus_itself_has_no_terms() {
        let e = Expansion::<2>::difference(1.0, 1e-30);
        assert_eq!(e.len(), 2);
        let zero = Expansion::<4>::sum(&e, &e.negated());
        assert_eq!((zero.len(), zero.sign()), (0, Ordering::Equal));
    }
}
