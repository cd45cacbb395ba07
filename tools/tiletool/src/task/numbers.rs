//! Numbers of tasks, for lists.

/// Returns the numbers of the tasks that are not done.
pub fn left(are_done: impl Iterator<Item = bool>) -> Vec<usize> {
    let numbered = are_done.enumerate();
    numbered.filter(|(_, is_done)| !is_done).map(|(task, _)| task).collect()
}

/// Returns ascending numbers as ranges.
pub fn ranges(numbers: &[usize]) -> String {
    let runs = numbers.chunk_by(|a, b| a + 1 == *b).map(|run| match run {
        [first, .., last] => format!("{first}-{last}"),
        _ => run[0].to_string(),
    });
    runs.collect::<Vec<_>>().join(", ")
}
