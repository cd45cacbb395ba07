//! How much long tests do.

/// Returns how many of `all` cases of a long test run: a quarter, or all of them if the environment
/// variable `DELAUNAY_TILES_TESTS` is `all`.
pub fn cases(all: usize) -> usize {
    match std::env::var("DELAUNAY_TILES_TESTS").as_deref() {
        Ok("all") => all,
        _ => all.div_ceil(4),
    }
}
