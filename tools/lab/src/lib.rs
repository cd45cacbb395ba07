//! What the programs, the bench and the tests of the laboratory share. The program `lab` has the experiments.

pub mod kernels;

/// The number in the middle; of an even count the upper of two, of none 0.
#[must_use]
pub fn median(numbers: &[f64]) -> f64 {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}
