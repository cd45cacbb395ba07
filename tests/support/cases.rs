//! How much long tests do.

/// Returns how many of `all` cases of a long test run: a quarter, or all of them if the environment
/// variable `DELAUNAY_TILES_TESTS` is `all`.
pub fn cases(all: usize) -> usize {
    match std::env::var("DELAUNAY_TILES_TESTS").as_deref() {
        Ok("all") => all,
        _ => all.div_ceil(4),
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
