//! Encodes columns, and finds out which are decimals.

use crate::store::format::codec::column::{Coding, Column, DECIMALS, Decimals, FLOATS, INTEGERS};
use crate::store::format::codec::planes::{PlanData, zigzag};

/// The divisors that are tried, in order.
const DIVISORS: [f64; 14] = [
    1.0,
    10.0,
    1e2,
    1e3,
    1e4,
    1e5,
    1e6,
    1e7,
    1e8,
    1e9,
    256.0,
    65_536.0,
    16_777_216.0,
    4_294_967_296.0,
];
/// Integers up to this magnitude are exact as floating-point numbers.
const EXACT: f64 = 9_007_199_254_740_992.0;

impl Column {
    /// Appends the header of the column.
    pub(super) fn write(self, out: &mut Vec<u8>) {
        match self.coding {
            Coding::Integers { width } => out.extend([INTEGERS, width, self.planes, 0]),
            Coding::Floats => out.extend([FLOATS, 8, self.planes, 0]),
            Coding::Decimals(decimals) => {
                out.extend([DECIMALS, 8, self.planes, decimals.has_corrections.into()]);
                out.extend(decimals.base.to_le_bytes());
                out.extend(decimals.step.to_le_bytes());
                out.extend(decimals.divisor.to_le_bytes());
            }
        }
    }
}

/// Encodes unsigned integers of `width` bytes.
pub(super) fn encode_integers(out: &mut PlanData, values: impl Iterator<Item = u64>, width: u8) -> Column {
    let unused = 64 - 8 * u32::from(width);
    let mut before = 0u64;
    let deltas = values.map(|value| {
        let delta = (value.wrapping_sub(before) << unused) as i64 >> unused;
        before = value;
        zigzag(delta)
    });
    let deltas: Vec<u64> = deltas.collect();
    Column {
        coding: Coding::Integers { width },
        planes: out.all_planes(&deltas),
    }
}

/// Encodes floating-point numbers.
pub(super) fn encode_floats(out: &mut PlanData, values: &[f64]) -> Column {
    if let Some((decimals, deltas, corrections)) = decimals(values) {
        let planes = out.all_planes(&deltas);
        if decimals.has_corrections {
            out.planes(&corrections, 1);
        }
        return Column {
            coding: Coding::Decimals(decimals),
            planes,
        };
    }
    let column = encode_integers(out, values.iter().map(|value| value.to_bits()), 8);
    Column {
        coding: Coding::Floats,
        ..column
    }
}

/// Returns the integer of a value and the correction of its bits, if the value is close to a
/// multiple of 1 / `divisor`.
fn integer(value: f64, divisor: f64) -> Option<(i64, u64)> {
    let integer = (value * divisor).round();
    if integer.abs() >= EXACT {
        return None;
    }
    // Integers have no negative zero.
    let quotient = integer as i64 as f64 / divisor;
    let correction = value.to_bits().wrapping_sub(quotient.to_bits()) as i64;
    (-128..128)
        .contains(&correction)
        .then_some((integer as i64, zigzag(correction)))
}

/// Returns the coding of values as decimals, and their differences and corrections, if there is
/// one that is shorter than their bits.
fn decimals(values: &[f64]) -> Option<(Decimals, Vec<u64>, Vec<u64>)> {
    // Most divisors are refuted by a few values.
    let some = values.iter().step_by(values.len() / 32 + 1);
    let suits = |divisor: &f64| some.clone().all(|&value| integer(value, *divisor).is_some());
    DIVISORS.into_iter().filter(suits).find_map(|divisor| {
        let pairs = values.iter().map(|&value| integer(value, divisor));
        let (integers, corrections): (Vec<i64>, Vec<u64>) = pairs.collect::<Option<Vec<_>>>()?.into_iter().unzip();
        let base = *integers.first()?;
        let step = integers
            .iter()
            .fold(0, |step, integer| gcd(step, integer.abs_diff(base)));
        let step = step.max(1) as i64;
        let mut before = base;
        let deltas = integers.iter().map(|&integer| {
            let delta = (integer - before) / step;
            before = integer;
            zigzag(delta)
        });
        let decimals = Decimals {
            base,
            step,
            divisor,
            has_corrections: corrections.iter().any(|&correction| correction != 0),
        };
        Some((decimals, deltas.collect(), corrections))
    })
}

fn gcd(mut a: u64, mut b: u64) -> u64 {
    // Almost always one of them is 1 soon.
    while b != 0 && a != 1 {
        (a, b) = (b, a % b);
    }
    a
}
