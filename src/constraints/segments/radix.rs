//! Radix sort of numbers by some of their bits, lowest first: without comparisons, a pass for every
//! few bits.

/// Largest number of bits of a pass. The write positions of all digits then stay in the processor's
/// cache.
const DIGIT: u32 = 11;

/// Sorts by the bits from `low` up to but excluding `high`. Numbers with equal bits there keep
/// their order.
pub(crate) fn sort_by_bits(numbers: &mut Vec<u64>, low: u32, high: u32) {
    let bits = high.saturating_sub(low);
    if bits == 0 || numbers.len() < 2 {
        return;
    }
    let passes = bits.div_ceil(DIGIT);
    let width = bits.div_ceil(passes);
    let mask = (1usize << width) - 1;
    let mut sorted = vec![0; numbers.len()];
    let mut offsets = vec![0usize; mask + 1];
    for pass in 0..passes {
        // Bits from `high` on must not affect the last pass, whose digit may reach beyond `high`.
        let from = low + pass * width;
        let mask = mask.min((1usize << (high - from).min(width)) - 1);
        let digit = |number: u64| (number >> from) as usize & mask;
        offsets.fill(0);
        for &number in numbers.iter() {
            offsets[digit(number)] += 1;
        }
        let mut next = 0;
        for offset in &mut offsets {
            next += std::mem::replace(offset, next);
        }
        for &number in numbers.iter() {
            let offset = &mut offsets[digit(number)];
            sorted[*offset] = number;
            *offset += 1;
        }
        std::mem::swap(numbers, &mut sorted);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

        #[test]
        fn numbers_are_sorted_by_their_bits(
            numbers in prop::collection::vec(any::<u64>(), 0..300),
            low in 0u32..64,
            bits in 0u32..65,
            few in 0u32..60,
        ) {
            let numbers: Vec<u64> = numbers.iter().map(|number| number >> few).collect();
            let high = (low + bits).min(64);
            let key = |number: &u64| (*number >> low) & (((1u128 << (high - low)) - 1) as u64);
            let mut expected = numbers.clone();
            expected.sort_by_key(key);
            let mut sorted = numbers;
            sort_by_bits(&mut sorted, low, high);
            prop_assert_eq!(sorted, expected);
        }
    }
}
