//! Shared code of the programs, the bench and the tests of the laboratory. The program `lab` has
//! the experiments.

pub mod kernels;

/// Returns the median; the upper one of an even count, and 0 of no numbers.
#[must_use]
pub fn median(numbers: &[f64]) -> f64 {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}
