//! How much long tests do.

fn are_all_wanted() -> bool {
    std::env::var("DELAUNAY_TILES_TESTS").is_ok_and(|wanted| wanted == "all")
}

/// Returns how many of `all` cases of a long test run: an eighth, or all of them if the environment
/// variable `DELAUNAY_TILES_TESTS` is `all`.
pub fn cases(all: usize) -> usize {
    if are_all_wanted() { all } else { all.div_ceil(8) }
}

/// Returns the ways in which a long test does its work in round `round`: every second one, by turns, or
/// all of them if the environment variable `DELAUNAY_TILES_TESTS` is `all`.
pub fn by_turns<T: Copy>(ways: &[T], round: usize) -> Vec<T> {
    match are_all_wanted() {
        true => ways.to_vec(),
        false => ways.iter().copied().skip(round % 2).step_by(2).collect(),
    }
}

/// Returns the seeds of the cases that run, of `all` that there are: the first ones, as [`cases`] tells
/// how many; or those that the environment variable `DELAUNAY_TILES_SEEDS` names, as `FIRST..END`.
pub fn seeds(all: usize) -> Vec<u64> {
    let Ok(named) = std::env::var("DELAUNAY_TILES_SEEDS") else {
        return (0..cases(all) as u64).collect();
    };
    let ends = named.split_once("..").map(|(first, end)| [first, end].map(str::parse));
    match ends {
        Some([Ok(first), Ok(end)]) => (first..end).collect(),
        _ => panic!("DELAUNAY_TILES_SEEDS is `{named}`, not FIRST..END"),
    }
}
