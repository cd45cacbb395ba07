//! A sort by a small number in linear time, and by a key within each bucket.

/// Sorts items by bucket, then by key. `bucket` returns a number below `buckets`.
pub(crate) fn bucket_sort<T: Copy, K: Ord>(
    items: &[T],
    buckets: usize,
    bucket: impl Fn(&T) -> u32,
    key: impl Fn(&T) -> K + Copy,
) -> Vec<T> {
    let Some(&first) = items.first() else { return Vec::new() };
    if items.len() < buckets / 8 {
        // A pass over the buckets would take longer than a sort.
        let mut sorted = items.to_vec();
        sorted.sort_unstable_by_key(|item| (bucket(item), key(item)));
        return sorted;
    }
    let mut ends = vec![0u32; buckets];
    for item in items {
        ends[bucket(item) as usize] += 1;
    }
    let mut before = 0;
    for end in &mut ends {
        before += *end;
        *end = before - *end;
    }
    let mut sorted = vec![first; items.len()];
    for item in items {
        let slot = &mut ends[bucket(item) as usize];
        sorted[*slot as usize] = *item;
        *slot += 1;
    }
    let mut start = 0;
    for end in ends {
        sorted[start..end as usize].sort_unstable_by_key(key);
        start = end as usize;
    }
    sorted
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

        #[test]
        fn bucket_sort_agrees_with_a_comparison_sort(items in prop::collection::vec((0u32..20, 0u32..9), 0..200)) {
            let mut expected = items.clone();
            expected.sort_unstable();
            prop_assert_eq!(bucket_sort(&items, 20, |item| item.0, |item| *item), expected);
        }
    }
}
