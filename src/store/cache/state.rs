//! The contents of a cache and its eviction policy: a state machine without locks, tasks or I/O.
//!
//! Its inputs are requests, loads, pins, edits and write-backs, in the order in which they happen.
//! Its outputs are values, and the dirty value that must be written before there is room. The
//! caller loads and writes.
//!
//! ```text
//!              begin_load           end_load(value)               begin_write
//!     absent ─────────────▶ loading ──────────────▶ clean   dirty ───────────▶ writing
//!      ▲  ▲                    │                    │ ▲ ▲     ▲ ▲                │  │
//!      │  └── end_load(none) ──┘                    │ │ │     │ └── not saved ───┘  │
//!      │                                            │ │ └─────┼────── saved ────────┘
//!      │                                       lend ▼ │       │
//!      │                                            lent ─────┘  give_back (clean if unchanged)
//!      └── make_room ── clean, and not pinned
//! ```
//!
//! A dirty value may be lent too, and so may a value that is being written: the write-back then has
//! a copy, and the value becomes dirty again if it comes back changed. Only clean values that are
//! not pinned are evicted, so no unsaved change is lost.
//!
//! **Which value is evicted.** The policy is a segmented LRU (Karedla, Love and Wherry, "Caching
//! strategies to improve disk system performance", IEEE Computer 27(3), 1994). A loaded value
//! starts on *probation*. A value that is used again becomes *protected*. Protected values take up
//! to 4/5 of the capacity; beyond that, the least recently used protected value goes back on
//! probation. Values on probation are evicted first. Tiles that a scan uses once therefore evict
//! each other, however long the scan is, and not the tiles that queries use again.
//!
//! This alone would fail when queries turn to a new set of tiles that is larger than the space left
//! for probation: each of its tiles would be evicted before it is used again. Therefore the keys of
//! evicted values are remembered, for as many bytes as the capacity (A1out of 2Q: Johnson and
//! Shasha, VLDB 1994). A value that is loaded again while its key is remembered becomes protected.
//!
//! Pinned values and values that are being written are in neither list. Their bytes count, and
//! other values are evicted for them; if pinned values alone exceed the capacity, so does the
//! cache. A value larger than the capacity evicts no others: it stays while it is pinned, and is
//! the next to be evicted after that.

use std::collections::HashMap;
use std::hash::Hash;
use std::mem;
use std::sync::Arc;

use lru::LruCache;

use super::statistics::CacheStatistics;

/// A value that a cache can hold.
pub(crate) trait Weight {
    /// Returns the bytes that the value takes in memory.
    fn weight(&self) -> usize;
}

/// The location of the value of a key.
#[derive(Debug)]
pub(crate) enum Content<V> {
    /// Not in the cache, and not being loaded.
    Absent,
    /// Being loaded.
    Loading,
    /// In the cache.
    Here(Arc<V>),
    /// Lent to its editor.
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

struct CacheEntry<V> {
    content: Content<V>,
    /// Bytes; 0 until the value is loaded.
    weight: usize,
    pins: usize,
    /// Whether the value differs from what was written last.
    dirty: bool,
    writing: bool,
    /// Whether the value is being written to make room, and was not used since the write began.
    leaving: bool,
    /// Whether the value was used again after it was loaded.
    used_again: bool,
}

impl<V> CacheEntry<V> {
    const ABSENT: Self = Self {
        content: Content::Absent,
        weight: 0,
        pins: 0,
        dirty: false,
        writing: false,
        leaving: false,
        used_again: false,
    };

    fn is_held(&self) -> bool {
        self.pins > 0 || self.writing || matches!(self.content, Content::Loading | Content::Lent)
    }

    fn mark_used(&mut self) {
        self.used_again = true;
        self.leaving = false;
    }
}

/// The position of a value in the eviction order of its list.
#[derive(Clone, Copy, PartialEq, Eq)]
enum EvictionTurn {
    Last,
    Next,
}

/// The state of a cache.
pub(crate) struct CacheState<K, V> {
    capacity: usize,
    /// Values that can be evicted, each list in the order of their last use.
    probation: LruCache<K, CacheEntry<V>>,
    protected: LruCache<K, CacheEntry<V>>,
    /// Values that cannot be evicted.
    held: HashMap<K, CacheEntry<V>>,
    /// Sums of the weights of all values, of protected values and of held values.
    bytes: usize,
    protected_bytes: usize,
    held_bytes: usize,
    /// Sum of the weights of held values that are about to be evicted, or that are larger than the
    /// capacity. No other values are evicted for them.
    outside_bytes: usize,
    statistics: CacheStatistics,
    /// The weights of recently evicted values, by key, and their sum.
    left: LruCache<K, usize>,
    left_bytes: usize,
    /// Evicted values, which the caller drops after it has released the lock.
    gone: Vec<Arc<V>>,
}

impl<K: Copy + Eq + Hash, V: Weight> CacheState<K, V> {
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
            statistics: CacheStatistics::default(),
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
            ..self.statistics
        }
    }

    /// Returns the location of a value. This does not count as a use.
    pub(super) fn peek(&self, key: &K) -> Content<V> {
        self.entry(key).map_or(Content::Absent, |entry| entry.content.clone())
    }

    /// Returns the value and counts a hit if the value is in the cache. Otherwise nothing changes.
    pub(super) fn get(&mut self, key: &K) -> Option<Arc<V>> {
        if let Some(entry) = self.protected.get(key)
            && let Content::Here(value) = &entry.content
        {
            self.statistics.hits += 1;
            return Some(Arc::clone(value));
        }
        let Content::Here(value) = self.peek(key) else {
            return None;
        };
        self.statistics.hits += 1;
        self.change(*key, EvictionTurn::Last, CacheEntry::mark_used);
        Some(value)
    }

    /// Pins a value, which may be in the cache, being loaded or absent, and returns its location.
    ///
    /// The value is not evicted until [`unpin`](Self::unpin) was called as often as `pin`. This
    /// counts as a hit if the value is in the cache or lent, and as a shared load if it is being
    /// loaded.
    pub(super) fn pin(&mut self, key: K) -> Content<V> {
        let found = self.peek(&key);
        self.change(key, EvictionTurn::Last, |entry| {
            entry.pins += 1;
            if matches!(found, Content::Here(_) | Content::Lent) {
                entry.mark_used();
            }
        });
        match found {
            Content::Here(_) | Content::Lent => self.statistics.hits += 1,
            Content::Loading => self.statistics.shared_loads += 1,
            Content::Absent => {}
        }
        found
    }

    pub(super) fn unpin(&mut self, key: K) {
        self.change(key, EvictionTurn::Last, |entry| entry.pins -= 1);
        let _dirty = self.make_room();
    }

    /// Begins a load, which counts as a miss.
    pub(super) fn begin_load(&mut self, key: K) {
        debug_assert!(matches!(self.peek(&key), Content::Absent));
        self.statistics.misses += 1;
        self.change(key, EvictionTurn::Last, |entry| entry.content = Content::Loading);
    }

    /// Ends a load. `value` is `None` if the load failed.
    pub(super) fn end_load(&mut self, key: K, value: Option<Arc<V>>) {
        debug_assert!(matches!(self.peek(&key), Content::Loading));
        let used_again = value.is_some() && self.is_back(&key);
        self.change(key, EvictionTurn::Last, |entry| {
            entry.used_again |= used_again;
            entry.weight = value.as_ref().map_or(0, |value| value.weight());
            entry.content = value.map_or(Content::Absent, Content::Here);
        });
        let _dirty = self.make_room();
    }

    /// Lends the value to its editor, if it is in the cache. The value must be pinned.
    pub(super) fn lend(&mut self, key: K) -> Option<Arc<V>> {
        let Content::Here(value) = self.peek(&key) else {
            return None;
        };
        self.change(key, EvictionTurn::Last, |entry| entry.content = Content::Lent);
        Some(value)
    }

    /// Takes a lent value back from its editor.
    pub(super) fn give_back(&mut self, key: K, value: Arc<V>, changed: bool) {
        debug_assert!(matches!(self.peek(&key), Content::Lent));
        self.change(key, EvictionTurn::Last, |entry| {
            entry.dirty |= changed;
            entry.weight = value.weight();
            entry.content = Content::Here(value);
        });
    }

    /// Evicts clean values, least recently used first, until the rest fits into the capacity. Stops
    /// at a dirty value whose turn it is, and returns its key.
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

    /// Evicts clean values until the rest fits into the capacity, skipping dirty ones. For use when
    /// the dirty values cannot be written.
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

    /// Begins to write a value that is dirty, in the cache and not yet being written, and returns
    /// it. `leaving` is true if it is written to make room.
    pub(super) fn begin_write(&mut self, key: K, leaving: bool) -> Option<Arc<V>> {
        if !self.is_dirty(&key) || self.is_writing(&key) {
            return None;
        }
        let Content::Here(value) = self.peek(&key) else {
            return None;
        };
        self.change(key, EvictionTurn::Last, |entry| {
            (entry.dirty, entry.writing, entry.leaving) = (false, true, leaving);
        });
        Some(value)
    }

    /// Ends a write. `saved` says whether it succeeded.
    pub(super) fn end_write(&mut self, key: K, saved: bool) {
        debug_assert!(self.is_writing(&key));
        self.statistics.write_backs += u64::from(saved);
        let leaving = self.held.get(&key).is_some_and(|entry| entry.leaving);
        // A failed write is retried next, and not only after all others have failed too.
        let turn = if leaving {
            EvictionTurn::Next
        } else {
            EvictionTurn::Last
        };
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

    /// Returns the keys of all values that are not saved, including those being written.
    pub(super) fn unsaved(&self) -> Vec<K> {
        let all = self.held.iter().chain(&self.protected).chain(&self.probation);
        all.filter(|(_, entry)| entry.dirty || entry.writing)
            .map(|(key, _)| *key)
            .collect()
    }

    /// Returns the values that were evicted since the last call.
    pub(super) fn take_gone(&mut self) -> Vec<Arc<V>> {
        mem::take(&mut self.gone)
    }

    fn entry(&self, key: &K) -> Option<&CacheEntry<V>> {
        let held = self.held.get(key);
        held.or_else(|| self.protected.peek(key))
            .or_else(|| self.probation.peek(key))
    }

    /// Changes an entry. Every transition takes the entry out of its list, changes it, and inserts
    /// it into the list where it then belongs.
    fn change(&mut self, key: K, turn: EvictionTurn, change: impl FnOnce(&mut CacheEntry<V>)) {
        let mut entry = self.take_out(&key).unwrap_or(CacheEntry::ABSENT);
        change(&mut entry);
        self.put_in(key, entry, turn);
    }

    fn take_out(&mut self, key: &K) -> Option<CacheEntry<V>> {
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

    fn put_in(&mut self, key: K, mut entry: CacheEntry<V>, turn: EvictionTurn) {
        self.bytes += entry.weight;
        self.statistics.most_bytes = self.statistics.most_bytes.max(self.bytes);
        if entry.is_held() {
            self.held_bytes += entry.weight;
            self.outside_bytes += self.outside(&entry);
            self.held.insert(key, entry);
        } else if matches!(entry.content, Content::Absent) {
            // The value is neither pinned nor being loaded: drop the entry.
        } else if turn == EvictionTurn::Next || entry.weight > self.capacity {
            entry.used_again = false;
            self.probation.push(key, entry);
            self.probation.demote(&key);
        } else if entry.used_again {
            self.protected_bytes += entry.weight;
            self.protected.push(key, entry);
            self.demote_protected();
        } else {
            self.probation.push(key, entry);
        }
    }

    /// Returns the bytes of a held entry for which no other value has to be evicted.
    fn outside(&self, entry: &CacheEntry<V>) -> usize {
        match entry.leaving || entry.weight > self.capacity {
            true => entry.weight,
            false => 0,
        }
    }

    fn evict(&mut self, key: K) {
        if let Some(CacheEntry {
            content: Content::Here(value),
            weight,
            ..
        }) = self.take_out(&key)
        {
            self.remember(key, weight);
            self.gone.push(value);
            self.statistics.evictions += 1;
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

    /// Returns whether a value that was just loaded was evicted recently.
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
            entry.used_again = false;
            self.probation.push(key, entry);
        }
    }
}
