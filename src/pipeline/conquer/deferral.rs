//! Which segments a node defers: those that hold too many triangles. An edit inserts them once the
//! file is complete.
//!
//! A subsegment can be inserted at any time, so deferring it does not change the result. A node
//! decides by its own content and by what its children deferred: so the tasks of a build do not
//! depend on each other's timing, and a task that runs again gives the same bytes.

/// Chooses which segments to defer, given the number of triangles that each holds. Those that hold
/// most are deferred, so that the others together hold at most `limit`.
pub(crate) fn choose_deferred(held: &[usize], limit: usize) -> Vec<bool> {
    let mut order: Vec<usize> = (0..held.len()).collect();
    order.sort_by_key(|&index| held[index]);
    let mut sum = 0;
    let mut is_deferred = vec![false; held.len()];
    for index in order {
        sum += held[index];
        is_deferred[index] = sum > limit && held[index] > 0;
    }
    is_deferred
}
