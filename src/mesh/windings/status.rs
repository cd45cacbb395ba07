//! The edges that a sweep line meets, in order from below.
//!
//! They are a list of short lists: a search bisects both, and a change moves only the entries of
//! one short list.

use crate::geometry::Point;

/// Largest number of entries of a short list before it is divided.
const MOST: usize = 256;

/// An edge on the sweep line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StatusEntry {
    /// The number of the edge.
    pub(crate) edge: u32,
    /// The last point on the edge that the sweep passed.
    pub(crate) from: Point,
    /// The windings below and above the edge and all edges that overlap it.
    pub(crate) windings: [i32; 2],
    /// The face above the edge, if its winding is negative.
    pub(crate) face: u32,
    /// Whether it is the first of the edges that overlap each other.
    pub(crate) is_first: bool,
}

/// The position of an entry, or where one would be inserted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct StatusPosition {
    list: usize,
    index: usize,
}

/// The entries on the sweep line.
#[derive(Debug)]
pub(crate) struct Status {
    /// No list is empty, unless it is the only one.
    lists: Vec<Vec<StatusEntry>>,
}

impl Status {
    pub(crate) fn new() -> Self {
        Self {
            lists: vec![Vec::new()],
        }
    }

    /// Returns the position after all entries for which `below` is true. These must come before all
    /// others.
    pub(crate) fn search(&self, mut below: impl FnMut(&StatusEntry) -> bool) -> StatusPosition {
        let list = self.lists.partition_point(|list| list.last().is_some_and(&mut below));
        match self.lists.get(list) {
            Some(its) => StatusPosition {
                list,
                index: its.partition_point(below),
            },
            None => StatusPosition {
                list: list - 1,
                index: self.lists[list - 1].len(),
            },
        }
    }

    /// Returns the entry below a position.
    pub(crate) fn below(&self, at: StatusPosition) -> Option<&StatusEntry> {
        match at.index.checked_sub(1) {
            Some(index) => self.lists[at.list].get(index),
            None => self.lists[..at.list].last()?.last(),
        }
    }

    /// Returns the entry at a position.
    pub(crate) fn above(&self, at: StatusPosition) -> Option<&StatusEntry> {
        self.lists[at.list]
            .get(at.index)
            .or_else(|| self.lists.get(at.list + 1)?.first())
    }

    /// Removes the entries from a position on for which `is_taken` is true, and inserts the entries
    /// that `make` makes of them. Returns the position after the inserted entries.
    pub(crate) fn replace(
        &mut self,
        at: StatusPosition,
        mut is_taken: impl FnMut(&StatusEntry) -> bool,
        [taken, made]: [&mut Vec<StatusEntry>; 2],
        make: impl FnOnce(&[StatusEntry], &mut Vec<StatusEntry>),
    ) -> StatusPosition {
        taken.clear();
        made.clear();
        let (mut list, mut from) = (at.list, at.index);
        // The last list that changes, and the position after the entries that are removed from it.
        let end = loop {
            let its = &self.lists[list];
            let count = its[from..].iter().take_while(|entry| is_taken(entry)).count();
            taken.extend_from_slice(&its[from..from + count]);
            if from + count < its.len() || list + 1 == self.lists.len() {
                break from + count;
            }
            (list, from) = (list + 1, 0);
        };
        make(taken, made);
        let behind = StatusPosition {
            list: at.list,
            index: at.index + made.len(),
        };
        if list == at.list {
            self.lists[list].splice(at.index..end, made.iter().copied());
        } else {
            self.lists[list].drain(..end);
            self.lists[at.list].truncate(at.index);
            self.lists[at.list].extend_from_slice(made);
            let is_empty = self.lists[list].is_empty();
            self.lists.drain(at.list + 1..list + usize::from(is_empty));
        }
        self.tidy(behind)
    }

    /// Divides or removes the list of a position. Returns the new position.
    fn tidy(&mut self, at: StatusPosition) -> StatusPosition {
        let its = &self.lists[at.list];
        if its.is_empty() && self.lists.len() > 1 {
            self.lists.remove(at.list);
            return match at.list.checked_sub(1) {
                Some(list) => StatusPosition {
                    list,
                    index: self.lists[list].len(),
                },
                None => StatusPosition { list: 0, index: 0 },
            };
        }
        if its.len() <= MOST {
            return at;
        }
        let parts: Vec<Vec<StatusEntry>> = its.chunks(MOST / 2).map(<[StatusEntry]>::to_vec).collect();
        let added = parts.len();
        self.lists.splice(at.list..=at.list, parts);
        let (mut list, mut index) = (at.list, at.index);
        while index > self.lists[list].len() && list + 1 < at.list + added {
            index -= self.lists[list].len();
            list += 1;
        }
        StatusPosition { list, index }
    }

    /// Returns all entries, from below.
    pub(crate) fn entries_mut(&mut self) -> impl Iterator<Item = &mut StatusEntry> {
        self.lists.iter_mut().flatten()
    }
}
