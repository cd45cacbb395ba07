//! A heap of numbers, ordered by lengths.

/// A number with the bits of a length. The length is not negative, so its bits have the same order.
#[derive(Clone, Copy, Debug)]
pub(super) struct HeapEntry {
    pub(super) length: u64,
    pub(super) slot: u32,
    /// The root of the task.
    pub(super) root: u32,
}

/// A heap with the least entry first. Each entry has up to four children, which are adjacent, so it
/// has half as many levels as a binary heap.
#[derive(Debug)]
pub(super) struct Heap(Vec<HeapEntry>);

impl Heap {
    pub(super) fn new() -> Self {
        Self(Vec::new())
    }

    pub(super) fn with_capacity(entries: usize) -> Self {
        Self(Vec::with_capacity(entries))
    }

    /// Returns the least entry.
    #[inline]
    pub(super) fn first(&self) -> Option<&HeapEntry> {
        self.0.first()
    }

    /// Returns the first `entries` entries of the heap, in no order: the least ones, and some
    /// others.
    pub(super) fn top(&self, entries: usize) -> impl Iterator<Item = &HeapEntry> {
        self.0.iter().take(entries)
    }

    /// Returns the least length; infinite if the heap is empty.
    #[inline]
    pub(super) fn front(&self) -> f64 {
        self.0
            .first()
            .map_or(f64::INFINITY, |entry| f64::from_bits(entry.length))
    }

    pub(super) fn push(&mut self, entry: HeapEntry) {
        self.0.push(entry);
        self.rise(self.0.len() - 1, entry);
    }

    pub(super) fn pop(&mut self) -> Option<HeapEntry> {
        let last = self.0.pop()?;
        let Some(&least) = self.0.first() else {
            return Some(last);
        };
        // The gap sinks to a leaf first, because the last entry most likely belongs there.
        let mut at = 0;
        loop {
            let first = 4 * at + 1;
            let below = match self.0.get(first..) {
                Some(&[a, b, c, d, ..]) => first + least_of([a, b, c, d]),
                Some(rest) if !rest.is_empty() => {
                    let lengths = rest.iter().map(|entry| entry.length);
                    lengths.zip(first..).min().map_or(first, |(_, slot)| slot)
                }
                _ => break,
            };
            self.0[at] = self.0[below];
            at = below;
        }
        self.rise(at, last);
        Some(least)
    }

    /// Moves an entry up from a gap to its position.
    #[inline]
    fn rise(&mut self, gap: usize, entry: HeapEntry) {
        let mut at = gap;
        while at > 0 {
            let above = (at - 1) / 4;
            if self.0[above].length <= entry.length {
                break;
            }
            self.0[at] = self.0[above];
            at = above;
        }
        self.0[at] = entry;
    }
}

/// Returns the index of the least of four entries. Branch-free: the comparisons are unpredictable.
#[inline]
fn least_of(entries: [HeapEntry; 4]) -> usize {
    let [a, b, c, d] = entries.map(|entry| entry.length);
    let (one, other) = (usize::from(b < a), 2 + usize::from(d < c));
    let is_other = usize::from(c.min(d) < a.min(b));
    one + (other - one) * is_other
}
