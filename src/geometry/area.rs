//! The exact sign of the area of a closed ring of points.
//!
//! Input: the points of a ring, each once and in order. Output: whether they run counter-clockwise.
//! The sign of the area, unlike the turn at an extreme point, also has an answer for rings with
//! repeated points, spikes and lobes that touch.
//!
//! Twice the area is the sum of x·y' - x'·y over all pairs of neighbours. Each product is two
//! terms without an error. The terms are summed in an expansion that grows as needed (Shewchuk's
//! GROW-EXPANSION, without terms that are zero). Products of valid coordinates
//! ([`Point::is_valid`]) range from 2⁻³⁸⁸ to 2⁴⁰⁰, so nothing overflows or underflows.
//! An expansion has a few terms, and some hundreds in the worst case.

use std::cmp::Ordering;

use crate::geometry::expansion::{two_product, two_sum};
use crate::geometry::point::Point;

/// Returns the sign of the area that a ring of valid points encloses: `Greater` if the ring is
/// counter-clockwise, `Less` if it is clockwise, `Equal` if the area is zero.
#[must_use]
pub fn area_sign(ring: impl IntoIterator<Item = Point>) -> Ordering {
    let mut points = ring.into_iter();
    let Some(first) = points.next() else {
        return Ordering::Equal;
    };
    let (mut sum, mut before) = (Sum::default(), first);
    for point in points.chain([first]) {
        sum.add_product(before.x, point.y);
        sum.add_product(-point.x, before.y);
        before = point;
    }
    sum.sign()
}

/// A sum without rounding error: an expansion of nonzero terms of increasing magnitude.
#[derive(Default)]
struct Sum(Vec<f64>);

impl Sum {
    fn add_product(&mut self, a: f64, b: f64) {
        let (product, error) = two_product(a, b);
        self.add(error);
        self.add(product);
    }

    fn add(&mut self, term: f64) {
        let mut carry = term;
        self.0.retain_mut(|term| {
            let (sum, error) = two_sum(carry, *term);
            carry = sum;
            *term = error;
            error != 0.0
        });
        if carry != 0.0 {
            self.0.push(carry);
        }
    }

    fn sign(&self) -> Ordering {
        match self.0.last() {
            None => Ordering::Equal,
            Some(&largest) if largest > 0.0 => Ordering::Greater,
            Some(_) => Ordering::Less,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::oracle::Exact;
    use proptest::collection::vec;
    use proptest::prelude::*;

    fn exact_sign(ring: &[Point]) -> Ordering {
        let next = ring.iter().cycle().skip(1);
        let area = ring.iter().zip(next).fold(Exact::from(0.0), |area, (a, b)| {
            let cross = &(&Exact::from(a.x) * &Exact::from(b.y)) - &(&Exact::from(b.x) * &Exact::from(a.y));
            &area + &cross
        });
        area.sign()
    }

    /// Generates coordinates of all magnitudes, or of few values, so that areas cancel.
    fn coordinate() -> impl Strategy<Value = f64> {
        prop_oneof![
            3 => (-3..4).prop_map(f64::from),
            1 => (-3..4).prop_map(|n| 0.1 * f64::from(n)),
            1 => (-1.0..1.0, -140..200).prop_map(|(m, e): (f64, i32)| m * 2f64.powi(e)),
        ]
        .prop_filter("valid", |&v| Point::new(v, 0.0).is_valid())
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

        #[test]
        fn the_sign_is_that_of_the_exact_area(coordinates in vec((coordinate(), coordinate()), 0..12), back in any::<bool>()) {
            let mut ring: Vec<Point> = coordinates.into_iter().map(|(x, y)| Point::new(x, y)).collect();
            if back {
                // The path there and back encloses nothing, however crooked it is.
                ring.extend(ring.clone().into_iter().rev());
                prop_assert_eq!(area_sign(ring.iter().copied()), Ordering::Equal);
            }
            prop_assert_eq!(area_sign(ring.iter().copied()), exact_sign(&ring));
            let turned = ring.iter().rev().copied();
            prop_assert_eq!(area_sign(turned), area_sign(ring.iter().copied()).reverse());
        }
    }

    /// Floating point alone gives 0 or the wrong sign for each of these.
    #[test]
    fn the_sign_is_exact_for_slivers_far_from_the_origin() {
        let far = 3e7;
        let least = f64::EPSILON * far;
        for (ring, sign) in [
            (
                [(far, far), (far + 1.0, far + 1.0), (far + 2.0, far + 2.0 + 2.0 * least)],
                Ordering::Greater,
            ),
            (
                [(far, far), (far + 1.0, far + 1.0), (far + 2.0, far + 2.0 - 2.0 * least)],
                Ordering::Less,
            ),
            (
                [(far, far), (far + 1.0, far + 1.0), (far + 2.0, far + 2.0)],
                Ordering::Equal,
            ),
            (
                [(0.0, 0.0), (Point::MAX_MAGNITUDE, 0.0), (0.0, -Point::MIN_MAGNITUDE)],
                Ordering::Less,
            ),
        ] {
            let ring = ring.map(|(x, y)| Point::new(x, y));
            assert_eq!(area_sign(ring), sign, "{ring:?}");
            assert_eq!(exact_sign(&ring), sign, "{ring:?}");
        }
    }
}
