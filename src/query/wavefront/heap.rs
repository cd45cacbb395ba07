//! A heap of numbers by lengths.

/// A place in `items`, with the bits of a length that is not negative, which are ordered as it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) length: u64,
    pub(super) place: u32,
}

/// The least entry first. Each has up to four below it, which lie together, so that there are half as many steps as in a binary heap.
#[derive(Debug)]
pub(super) struct Heap(Vec<Entry>);

impl Heap {
    pub(super) fn new() -> Self {
        Self(Vec::new())
    }

    pub(super) fn with_capacity(entries: usize) -> Self {
        Self(Vec::with_capacity(entries))
    }

    /// The least entry.
    #[inline]
    pub(super) fn first(&self) -> Option<&Entry> {
        self.0.first()
    }

    /// The least entries of all, in no order, and some others.
    pub(super) fn top(&self, entries: usize) -> impl Iterator<Item = &Entry> {
        self.0.iter().take(entries)
    }

    /// The least length; infinite if there is none.
    #[inline]
    pub(super) fn front(&self) -> f64 {
        self.0
            .first()
            .map_or(f64::INFINITY, |entry| f64::from_bits(entry.length))
    }

    pub(super) fn push(&mut self, entry: Entry) {
        self.0.push(entry);
        self.rise(self.0.len() - 1, entry);
    }

    pub(super) fn pop(&mut self) -> Option<Entry> {
        let last = self.0.pop()?;
        let Some(&least) = self.0.first() else {
            return Some(last);
        };
        // The gap goes down to where nothing is below it, for the last one most likely belongs there.
        let mut at = 0;
        loop {
            let first = 4 * at + 1;
            let below = match self.0.get(first..) {
                Some(&[a, b, c, d, ..]) => first + least_of([a, b, c, d]),
                Some(rest) if !rest.is_empty() => {
                    let lengths = rest.iter().map(|entry| entry.length);
                    lengths.zip(first..).min().map_or(first, |(_, place)| place)
                }
                _ => break,
            };
            self.0[at] = self.0[below];
            at = below;
        }
        self.rise(at, last);
        Some(least)
    }

    /// Puts an entry in a gap, or above it.
    #[inline]
    fn rise(&mut self, gap: usize, entry: Entry) {
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

/// The place of the least of four, without branches that nobody can foresee.
#[inline]
fn least_of(entries: [Entry; 4]) -> usize {
    let [a, b, c, d] = entries.map(|entry| entry.length);
    let (one, other) = (usize::from(b < a), 2 + usize::from(d < c));
    let is_other = usize::from(c.min(d) < a.min(b));
    one + (other - one) * is_other
}
