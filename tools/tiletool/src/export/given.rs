//! Which options a command line gives.

/// Returns the name of the first option that is given.
pub fn first_given<const COUNT: usize>(options: [(&'static str, bool); COUNT]) -> Option<&'static str> {
    options
        .into_iter()
        .find_map(|(name, is_given)| is_given.then_some(name))
}
