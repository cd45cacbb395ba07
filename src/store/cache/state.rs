//! What a cache holds, and what has to go: a state machine without locks, tasks or I/O.
//!
//! Comes in: what was asked for, loaded, pinned, edited and written back, in the order in which it happened. Goes out: values,
//! and the dirty value that must be written before there is room. Whoever calls does the loading and writing.
//!
//! ```text
//!              begin_load           end_load(value)               begin_write
//!     absent ─────────────▶ loading ──────────────▶ clean   dirty ───────────▶ writing
//!      ▲  ▲                    │                    │ ▲ ▲     ▲ ▲                │  │
//!      │  └── end_load(none) ──┘                    │ │ │     │ └── not saved ───┘  │
//!      │                                            │ │ └─────┼────── saved ────────┘
//!      │                                       lend ▼ │       │
//!      │                                            lent ─────┘  give_back: clean if it did not change
//!      └── make_room ── clean, and not pinned
//! ```
//!
//! A dirty value may be lent too, and so may one that is being written: the write-back has a copy then, and the value is dirty
//! again if it comes back changed. Only clean values that nobody pins go, so nothing is lost that was not saved.
//!
//! **Which one goes.** A segmented LRU (Karedla, Love and Wherry, "Caching strategies to improve disk system performance",
//! IEEE Computer 27(3), 1994): what is loaded comes on *probation*, what is used again is *protected*, up to 4/5 of the
//! capacity; beyond that the least recently used of the protected goes back on probation. Values leave from probation first.
//! So tiles that are used once, by however long a scan, push out each other, and not those that queries come back to.
//! However, what queries turn to next, if it is larger than what is left for probation, would never be there when it is used
//! again. So the keys of what left are remembered, for as many bytes as the capacity (A1out of 2Q: Johnson and Shasha, VLDB
//! 1994): what comes back that soon is protected.
//!
//! Pinned values, and those being written, stand in neither list. They count in bytes, and others have to go for them; if
//! pins alone exceed the capacity, so does the cache. A value that is larger than the cache pushes out no others: it is there
//! while it is pinned, and then it is the next to go.

use std::collections::HashMap;
use std::hash::Hash;
use std::mem;
use std::sync::Arc;

use lru::LruCache;

use super::statistics::CacheStatistics;

/// What a cache can hold.
pub(crate) trait Weight {
    /// Bytes that it takes in memory.
    fn weight(&self) -> usize;
}

/// Where the value of a key is.
#[derive(Debug)]
pub(crate) enum Content<V> {
    /// Not here, and not on its way.
    Absent,
    /// On its way.
    Loading,
    /// Here.
    Here(Arc<V>),
    /// With its editor.
    Lent,
}

impl<V> Clone for Content<V> {
    fn clone(&self) -> Self {
        match self {
            Self::Absent => Self::Absent,
            Self::Loading => Self::Loading,
            Self::Here(value) => Self::Here(Arc::clone(value)),
            Self::Lent => Self::Lent,
        }
    }
}

struct Entry<V> {
    content: Content<V>,
    /// Bytes; 0 until it is loaded.
    weight: usize,
    pins: usize,
    /// It differs from what was written last.
    dirty: bool,
    writing: bool,
    /// It is written to make room, and nobody has used it since.
    leaving: bool,
    /// It was used again since it came.
    again: bool,
}

impl<V> Entry<V> {
    const ABSENT: Self = Self {
        content: Content::Absent,
        weight: 0,
        pins: 0,
        dirty: false,
        writing: false,
        leaving: false,
        again: false,
    };

    fn is_held(&self) -> bool {
        self.pins > 0 || self.writing || matches!(self.content, Content::Loading | Content::Lent)
    }

    fn is_used(&mut self) {
        self.again = true;
        self.leaving = false;
    }
}

/// When a value goes, among those of its list.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Turn {
    Last,
    Next,
}

/// The state of a cache.
pub(crate) struct State<K, V> {
    capacity: usize,
    /// What can go: each list by last use.
    probation: LruCache<K, Entry<V>>,
    protected: LruCache<K, Entry<V>>,
    /// What cannot.
    held: HashMap<K, Entry<V>>,
    /// Sums of weights: of all, …
    bytes: usize,
    protected_bytes: usize,
    held_bytes: usize,
    /// … and of what is held, but will go by itself or is too large to push out others.
    outside_bytes: usize,
    counts: CacheStatistics,
    /// The weights of what left, and their sum.
    left: LruCache<K, usize>,
    left_bytes: usize,
    /// What went, for the caller to drop when the lock is released.
    gone: Vec<Arc<V>>,
}

impl<K: Copy + Eq + Hash, V: Weight> State<K, V> {
    pub(super) fn new(capacity: usize) -> Self {
        Self {
            capacity,
            probation: LruCache::unbounded(),
            protected: LruCache::unbounded(),
            held: HashMap::new(),
            bytes: 0,
            protected_bytes: 0,
            held_bytes: 0,
            outside_bytes: 0,
            counts: CacheStatistics::default(),
            left: LruCache::unbounded(),
            left_bytes: 0,
            gone: Vec::new(),
        }
    }

    pub(super) fn capacity(&self) -> usize {
        self.capacity
    }

    pub(super) fn statistics(&self) -> CacheStatistics {
        CacheStatistics {
            bytes: self.bytes,
            pinned_bytes: self.held_bytes,
            ..self.counts
        }
    }

    /// Where a value is; this is no use of it.
    pub(super) fn peek(&self, key: &K) -> Content<V> {
        self.entry(key).map_or(Content::Absent, |entry| entry.content.clone())
    }

    /// The value, if it is here: a hit then, and else nothing.
    pub(super) fn get(&mut self, key: &K) -> Option<Arc<V>> {
        if let Some(entry) = self.protected.get(key)
            && let Content::Here(value) = &entry.content
        {
            self.counts.hits += 1;
            return Some(Arc::clone(value));
        }
        let Content::Here(value) = self.peek(key) else {
            return None;
        };
        self.counts.hits += 1;
        self.change(*key, Turn::Last, Entry::is_used);
        Some(value)
    }

    /// Keeps a value from leaving until it is [unpinned](Self::unpin) as often, whether it is here or still to come. Says where
    /// it is: a hit if it is here or lent, and a shared load if it is on its way.
    pub(super) fn pin(&mut self, key: K) -> Content<V> {
        let found = self.peek(&key);
        self.change(key, Turn::Last, |entry| {
            entry.pins += 1;
            if matches!(found, Content::Here(_) | Content::Lent) {
                entry.is_used();
            }
        });
        match found {
            Content::Here(_) | Content::Lent => self.counts.hits += 1,
            Content::Loading => self.counts.shared_loads += 1,
            Content::Absent => {}
        }
        found
    }

    pub(super) fn unpin(&mut self, key: K) {
        self.change(key, Turn::Last, |entry| entry.pins -= 1);
        let _dirty = self.make_room();
    }

    /// The value is on its way: a miss.
    pub(super) fn begin_load(&mut self, key: K) {
        debug_assert!(matches!(self.peek(&key), Content::Absent));
        self.counts.misses += 1;
        self.change(key, Turn::Last, |entry| entry.content = Content::Loading);
    }

    /// The value has come, or will not come.
    pub(super) fn end_load(&mut self, key: K, value: Option<Arc<V>>) {
        debug_assert!(matches!(self.peek(&key), Content::Loading));
        let again = value.is_some() && self.is_back(&key);
        self.change(key, Turn::Last, |entry| {
            entry.again |= again;
            entry.weight = value.as_ref().map_or(0, |value| value.weight());
            entry.content = value.map_or(Content::Absent, Content::Here);
        });
        let _dirty = self.make_room();
    }

    /// Hands the value to its editor, if it is here. It must be pinned.
    pub(super) fn lend(&mut self, key: K) -> Option<Arc<V>> {
        let Content::Here(value) = self.peek(&key) else {
            return None;
        };
        self.change(key, Turn::Last, |entry| entry.content = Content::Lent);
        Some(value)
    }

    /// Takes the value back from its editor.
    pub(super) fn give_back(&mut self, key: K, value: Arc<V>, changed: bool) {
        debug_assert!(matches!(self.peek(&key), Content::Lent));
        self.change(key, Turn::Last, |entry| {
            entry.dirty |= changed;
            entry.weight = value.weight();
            entry.content = Content::Here(value);
        });
    }

    /// Lets clean values go, the least recently used first, until the others fit or a dirty one's turn has come, which it
    /// returns.
    pub(super) fn make_room(&mut self) -> Option<K> {
        while self.bytes - self.outside_bytes > self.capacity {
            let next = self.probation.peek_lru().or_else(|| self.protected.peek_lru());
            let (&key, entry) = next?;
            if entry.dirty {
                return Some(key);
            }
            self.evict(key);
        }
        None
    }

    /// Lets clean values go, also those whose turn comes after dirty ones, until the others fit: for when those cannot be
    /// written.
    pub(super) fn drop_clean(&mut self) {
        let free = self.probation.iter().rev().chain(self.protected.iter().rev());
        let clean: Vec<K> = free.filter(|(_, entry)| !entry.dirty).map(|(key, _)| *key).collect();
        for key in clean {
            if self.bytes - self.outside_bytes <= self.capacity {
                break;
            }
            self.evict(key);
        }
    }

    /// The value of a dirty entry that is here and not being written, which is now; `leaving`: because there is no room for it.
    pub(super) fn begin_write(&mut self, key: K, leaving: bool) -> Option<Arc<V>> {
        if !self.is_dirty(&key) || self.is_writing(&key) {
            return None;
        }
        let Content::Here(value) = self.peek(&key) else {
            return None;
        };
        self.change(key, Turn::Last, |entry| {
            (entry.dirty, entry.writing, entry.leaving) = (false, true, leaving);
        });
        Some(value)
    }

    /// What was to be written is saved, or is not.
    pub(super) fn end_write(&mut self, key: K, saved: bool) {
        debug_assert!(self.is_writing(&key));
        self.counts.write_backs += u64::from(saved);
        let leaving = self.held.get(&key).is_some_and(|entry| entry.leaving);
        // A write that failed is tried again next, and not after all others have failed too.
        let turn = if leaving { Turn::Next } else { Turn::Last };
        self.change(key, turn, |entry| {
            entry.dirty |= !saved;
            (entry.writing, entry.leaving) = (false, false);
        });
        let _dirty = self.make_room();
    }

    pub(super) fn is_dirty(&self, key: &K) -> bool {
        self.entry(key).is_some_and(|entry| entry.dirty)
    }

    pub(super) fn is_writing(&self, key: &K) -> bool {
        self.held.get(key).is_some_and(|entry| entry.writing)
    }

    /// The keys of all values that are not saved, those being written included.
    pub(super) fn unsaved(&self) -> Vec<K> {
        let all = self.held.iter().chain(&self.protected).chain(&self.probation);
        all.filter(|(_, entry)| entry.dirty || entry.writing)
            .map(|(key, _)| *key)
            .collect()
    }

    /// What went since this was asked last.
    pub(super) fn take_gone(&mut self) -> Vec<Arc<V>> {
        mem::take(&mut self.gone)
    }

    fn entry(&self, key: &K) -> Option<&Entry<V>> {
        let held = self.held.get(key);
        held.or_else(|| self.protected.peek(key))
            .or_else(|| self.probation.peek(key))
    }

    /// All transitions: an entry is taken out, changed, and put where it belongs now.
    fn change(&mut self, key: K, turn: Turn, change: impl FnOnce(&mut Entry<V>)) {
        let mut entry = self.take_out(&key).unwrap_or(Entry::ABSENT);
        change(&mut entry);
        self.put_in(key, entry, turn);
    }

    fn take_out(&mut self, key: &K) -> Option<Entry<V>> {
        let entry = if let Some(entry) = self.held.remove(key) {
            self.held_bytes -= entry.weight;
            self.outside_bytes -= self.outside(&entry);
            entry
        } else if let Some(entry) = self.protected.pop(key) {
            self.protected_bytes -= entry.weight;
            entry
        } else {
            self.probation.pop(key)?
        };
        self.bytes -= entry.weight;
        Some(entry)
    }

    fn put_in(&mut self, key: K, mut entry: Entry<V>, turn: Turn) {
        self.bytes += entry.weight;
        self.counts.most_bytes = self.counts.most_bytes.max(self.bytes);
        if entry.is_held() {
            self.held_bytes += entry.weight;
            self.outside_bytes += self.outside(&entry);
            self.held.insert(key, entry);
        } else if matches!(entry.content, Content::Absent) {
            // Nobody waits for it any more.
        } else if turn == Turn::Next || entry.weight > self.capacity {
            entry.again = false;
            self.probation.push(key, entry);
            self.probation.demote(&key);
        } else if entry.again {
            self.protected_bytes += entry.weight;
            self.protected.push(key, entry);
            self.demote_protected();
        } else {
            self.probation.push(key, entry);
        }
    }

    /// Bytes of a held entry that no other has to go for.
    fn outside(&self, entry: &Entry<V>) -> usize {
        match entry.leaving || entry.weight > self.capacity {
            true => entry.weight,
            false => 0,
        }
    }

    fn evict(&mut self, key: K) {
        if let Some(Entry {
            content: Content::Here(value),
            weight,
            ..
        }) = self.take_out(&key)
        {
            self.remember(key, weight);
            self.gone.push(value);
            self.counts.evictions += 1;
        }
    }

    fn remember(&mut self, key: K, weight: usize) {
        if weight > self.capacity {
            return;
        }
        self.left.push(key, weight);
        self.left_bytes += weight;
        while self.left_bytes > self.capacity {
            let Some((_, weight)) = self.left.pop_lru() else {
                break;
            };
            self.left_bytes -= weight;
        }
    }

    /// Whether what came left a short while ago.
    fn is_back(&mut self, key: &K) -> bool {
        let weight = self.left.pop(key);
        self.left_bytes -= weight.unwrap_or(0);
        weight.is_some()
    }

    fn demote_protected(&mut self) {
        while self.protected_bytes > self.capacity / 5 * 4 {
            let Some((key, mut entry)) = self.protected.pop_lru() else {
                break;
            };
            self.protected_bytes -= entry.weight;
            entry.again = false;
            self.probation.push(key, entry);
        }
    }
}
