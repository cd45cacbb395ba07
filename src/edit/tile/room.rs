//! Lists that will grow a little: a cache is full of them.

/// Collects a list, with room for a few more entries: most edits add few, for which a list should not be
/// moved.
pub(crate) fn with_room<T>(entries: impl ExactSizeIterator<Item = T>) -> Vec<T> {
    let mut list = Vec::with_capacity(entries.len() + room(entries.len()));
    list.extend(entries);
    list
}

/// Returns the number of entries that a list of this length has room for when it is loaded.
pub(crate) fn room(length: usize) -> usize {
    length / 64 + 2
}

/// Makes room in a list for `more` entries, or for an eighth of its length if that is more.
pub(crate) fn make_room<T>(list: &mut Vec<T>, more: usize) {
    if list.capacity() - list.len() < more {
        list.reserve_exact(more.max(list.len() / 8));
    }
}

/// Returns the bytes of a list, including its spare capacity.
pub(crate) fn bytes_of<T>(list: &Vec<T>) -> usize {
    list.capacity() * size_of::<T>()
}
