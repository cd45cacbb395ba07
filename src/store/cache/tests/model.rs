//! The state machine compared with a naive model: a list that is searched and summed up on each
//! use.

use std::sync::Arc;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::Sample;
use crate::store::cache::state::{CacheState, Content};
use crate::store::cache::statistics::CacheStatistics;

const KEYS: u8 = 7;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Location {
    Absent,
    Loading,
    Here,
    Lent,
}

/// Everything known about a key, including while it is absent.
#[derive(Clone, Copy, Debug)]
struct ModelEntry {
    location: Location,
    /// The value in the cache or with its editor.
    held: Sample,
    pins: usize,
    dirty: bool,
    writing: Option<u64>,
    leaving: bool,
    used_again: bool,
    /// The eviction order: the entry with the lowest number is evicted first.
    turn: i64,
    /// The version on disk, and the latest version.
    saved: u64,
    latest: u64,
}

impl ModelEntry {
    fn is_free(&self) -> bool {
        self.location == Location::Here && self.pins == 0 && self.writing.is_none()
    }

    fn weight(&self) -> usize {
        match self.location {
            Location::Here | Location::Lent => self.held.weight,
            Location::Absent | Location::Loading => 0,
        }
    }
}

impl ModelEntry {
    /// Returns whether the action is possible now.
    fn allows(&self, action: Action) -> bool {
        match action {
            Action::Get | Action::PinAndLoad | Action::WriteForRoom | Action::DropClean => true,
            Action::Loaded | Action::LoadFailed => self.location == Location::Loading,
            Action::Unpin => self.pins > usize::from(self.location == Location::Lent),
            Action::Edit => self.location == Location::Here && self.pins > 0,
            Action::GiveBack { .. } => self.location == Location::Lent,
            Action::Flush => self.dirty && self.writing.is_none() && self.location == Location::Here,
            Action::Written | Action::WriteFailed => self.writing.is_some(),
        }
    }
}

struct Model {
    capacity: usize,
    items: Vec<ModelEntry>,
    /// Keys and weights of evicted values, in order.
    left: Vec<(u8, usize)>,
    statistics: CacheStatistics,
    clock: i64,
    requests: u64,
}

impl Model {
    fn new(capacity: usize) -> Self {
        let item = ModelEntry {
            location: Location::Absent,
            held: Sample { version: 0, weight: 0 },
            pins: 0,
            dirty: false,
            writing: None,
            leaving: false,
            used_again: false,
            turn: 0,
            saved: 0,
            latest: 0,
        };
        Self {
            capacity,
            items: vec![item; usize::from(KEYS)],
            left: Vec::new(),
            statistics: CacheStatistics::default(),
            clock: 0,
            requests: 0,
        }
    }

    fn sum(&self, counts: impl Fn(&ModelEntry) -> bool) -> usize {
        self.items
            .iter()
            .filter(|item| counts(item))
            .map(ModelEntry::weight)
            .sum()
    }

    fn bytes(&self) -> usize {
        self.sum(|_| true)
    }

    fn pinned(&self) -> usize {
        self.sum(|item| !item.is_free())
    }

    /// Updates the model after an action on a key.
    fn transition_done(&mut self, key: u8, next: bool) {
        self.clock += 1;
        let item = &mut self.items[usize::from(key)];
        item.turn = self.clock;
        if item.is_free() && (next || item.held.weight > self.capacity) {
            item.turn = -self.clock;
            item.used_again = false;
        }
        if item.location == Location::Absent && item.pins == 0 {
            item.used_again = false;
        }
        self.statistics.most_bytes = self.statistics.most_bytes.max(self.bytes());
        while self.sum(|item| item.is_free() && item.used_again) > self.capacity / 5 * 4 {
            let protected = self.items.iter_mut().filter(|item| item.is_free() && item.used_again);
            let oldest = protected.min_by_key(|item| item.turn).unwrap();
            self.clock += 1;
            (oldest.used_again, oldest.turn) = (false, self.clock);
        }
    }

    fn used(&mut self, key: u8) {
        let item = &mut self.items[usize::from(key)];
        (item.used_again, item.leaving) = (true, false);
    }

    fn make_room(&mut self) -> Option<u8> {
        loop {
            let outside = self.sum(|item| !item.is_free() && (item.leaving || item.weight() > self.capacity));
            if self.bytes() - outside <= self.capacity {
                return None;
            }
            let free = (0..KEYS).filter(|&key| self.items[usize::from(key)].is_free());
            let next = free.min_by_key(|&key| {
                let item = &self.items[usize::from(key)];
                (item.used_again, item.turn)
            })?;
            if self.items[usize::from(next)].dirty {
                return Some(next);
            }
            self.evict(next);
        }
    }

    fn drop_clean(&mut self) {
        loop {
            let outside = self.sum(|item| !item.is_free() && (item.leaving || item.weight() > self.capacity));
            let clean = (0..KEYS).filter(|&key| {
                let item = &self.items[usize::from(key)];
                item.is_free() && !item.dirty
            });
            let next = clean.min_by_key(|&key| {
                let item = &self.items[usize::from(key)];
                (item.used_again, item.turn)
            });
            match next {
                Some(next) if self.bytes() - outside > self.capacity => self.evict(next),
                _ => return,
            }
        }
    }

    fn evict(&mut self, key: u8) {
        let item = &mut self.items[usize::from(key)];
        (item.location, item.used_again) = (Location::Absent, false);
        self.statistics.evictions += 1;
        if item.held.weight <= self.capacity {
            self.left.push((key, item.held.weight));
            while self.left.iter().map(|&(_, weight)| weight).sum::<usize>() > self.capacity {
                self.left.remove(0);
            }
        }
    }
}

#[derive(Clone, Copy, Debug)]
enum Action {
    Get,
    PinAndLoad,
    Loaded,
    LoadFailed,
    Unpin,
    Edit,
    GiveBack { changed: bool },
    WriteForRoom,
    DropClean,
    Flush,
    Written,
    WriteFailed,
}

/// The state machine and its model. Every action is applied to both.
struct StateAndModel {
    state: CacheState<u8, Sample>,
    model: Model,
}

impl StateAndModel {
    fn new(capacity: usize) -> Self {
        Self {
            state: CacheState::new(capacity),
            model: Model::new(capacity),
        }
    }

    fn item(&mut self, key: u8) -> &mut ModelEntry {
        &mut self.model.items[usize::from(key)]
    }

    /// Applies the action to the first key, from `key` on, for which it is possible now.
    fn apply_from(&mut self, action: Action, key: u8, weight: usize) {
        let mut keys = (key..KEYS).chain(0..key);
        if let Some(key) = keys.find(|&key| self.item(key).allows(action)) {
            self.apply(action, key, weight);
        }
    }

    fn apply(&mut self, action: Action, key: u8, weight: usize) {
        let item = *self.item(key);
        match action {
            Action::Get => {
                let found = self.state.get(&key);
                assert_eq!(
                    found.as_deref(),
                    (item.location == Location::Here).then_some(&item.held)
                );
                if found.is_some() {
                    self.model.requests += 1;
                    self.model.statistics.hits += 1;
                    self.model.used(key);
                    self.model.transition_done(key, false);
                }
            }
            Action::PinAndLoad => self.pin_and_load(key),
            Action::Loaded | Action::LoadFailed => {
                let loaded = Sample {
                    version: item.saved,
                    weight,
                };
                let came = matches!(action, Action::Loaded);
                self.state.end_load(key, came.then(|| Arc::new(loaded)));
                let before = self.model.left.len();
                self.model.left.retain(|&(left, _)| !came || left != key);
                let again = self.model.left.len() < before;
                let item = self.item(key);
                item.location = if came { Location::Here } else { Location::Absent };
                item.held = loaded;
                item.used_again |= again;
                self.model.transition_done(key, false);
                self.model.make_room();
            }
            Action::Unpin => {
                self.state.unpin(key);
                self.item(key).pins -= 1;
                self.model.transition_done(key, false);
                self.model.make_room();
            }
            Action::Edit => {
                assert_eq!(self.state.lend(key).as_deref(), Some(&item.held));
                self.item(key).location = Location::Lent;
                self.model.transition_done(key, false);
            }
            Action::GiveBack { changed } => {
                let item = self.item(key);
                if changed {
                    item.latest += 1;
                    item.held = Sample {
                        version: item.latest,
                        weight,
                    };
                }
                item.dirty |= changed;
                item.location = Location::Here;
                let held = item.held;
                self.state.give_back(key, Arc::new(held), changed);
                self.model.transition_done(key, false);
            }
            Action::WriteForRoom => {
                let next = self.state.make_room();
                assert_eq!(next, self.model.make_room());
                match next {
                    Some(key) => self.begin_write(key, true),
                    None => assert!(self.model.bytes() <= self.model.capacity + self.model.pinned()),
                }
            }
            Action::DropClean => {
                self.state.drop_clean();
                self.model.drop_clean();
            }
            Action::Flush => self.begin_write(key, false),
            Action::Written | Action::WriteFailed => {
                let saved = matches!(action, Action::Written);
                self.state.end_write(key, saved);
                let item = self.item(key);
                let version = item.writing.take().unwrap();
                let leaving = std::mem::take(&mut item.leaving);
                if saved {
                    item.saved = version;
                }
                item.dirty |= !saved;
                self.model.statistics.write_backs += u64::from(saved);
                self.model.transition_done(key, leaving);
                self.model.make_room();
            }
        }
        self.check();
    }

    fn pin_and_load(&mut self, key: u8) {
        self.model.requests += 1;
        let found = self.state.pin(key);
        let item = *self.item(key);
        self.item(key).pins += 1;
        match item.location {
            Location::Here | Location::Lent => {
                self.model.used(key);
                self.model.statistics.hits += 1;
            }
            Location::Loading => self.model.statistics.shared_loads += 1,
            Location::Absent => {
                assert!(matches!(found, Content::Absent));
                assert_eq!(item.saved, item.latest, "a change was lost");
                self.state.begin_load(key);
                self.item(key).location = Location::Loading;
                self.model.statistics.misses += 1;
            }
        }
        self.model.transition_done(key, false);
    }

    fn begin_write(&mut self, key: u8, leaving: bool) {
        let item = *self.item(key);
        let can = item.dirty && item.writing.is_none() && item.location == Location::Here;
        let value = self.state.begin_write(key, leaving);
        assert_eq!(value.as_deref(), can.then_some(&item.held));
        if can {
            let item = self.item(key);
            (item.dirty, item.writing, item.leaving) = (false, Some(item.held.version), leaving);
            self.model.transition_done(key, false);
        }
    }

    fn check(&self) {
        let statistics = self.state.statistics();
        let expected = CacheStatistics {
            bytes: self.model.bytes(),
            pinned_bytes: self.model.pinned(),
            ..self.model.statistics
        };
        assert_eq!(statistics, expected);
        let asked = statistics.hits + statistics.misses + statistics.shared_loads;
        assert_eq!(asked, self.model.requests);
        let mut unsaved = self.state.unsaved();
        unsaved.sort_unstable();
        let expected = (0..KEYS).filter(|&key| {
            let item = &self.model.items[usize::from(key)];
            item.dirty || item.writing.is_some()
        });
        assert!(unsaved.into_iter().eq(expected));
        for (key, item) in (0..KEYS).zip(&self.model.items) {
            match self.state.peek(&key) {
                Content::Absent => assert_eq!(item.location, Location::Absent),
                Content::Loading => assert_eq!(item.location, Location::Loading),
                Content::Lent => assert_eq!(item.location, Location::Lent),
                Content::Here(value) => assert_eq!((item.location, *value), (Location::Here, item.held)),
            }
            assert_eq!(self.state.is_dirty(&key), item.dirty);
            assert_eq!(self.state.is_writing(&key), item.writing.is_some());
            let last = if item.location == Location::Absent {
                item.saved
            } else {
                item.held.version
            };
            assert_eq!(last, item.latest, "key {key} went back");
        }
    }

    /// Ends everything that is in progress.
    fn settle(&mut self) {
        let ends = [
            Action::Written,
            Action::Loaded,
            Action::GiveBack { changed: false },
            Action::Unpin,
            Action::Flush,
            Action::Written,
        ];
        for action in ends {
            for key in 0..KEYS {
                while self.item(key).allows(action) {
                    let weight = self.item(key).held.weight;
                    self.apply(action, key, weight);
                }
            }
        }
        let statistics = self.state.statistics();
        assert_eq!(statistics.pinned_bytes, 0);
        assert!(statistics.bytes <= self.model.capacity);
        assert!(self.model.items.iter().all(|item| item.saved == item.latest));
        assert!(self.state.unsaved().is_empty());
    }
}

fn actions() -> impl Strategy<Value = (Action, u8, usize)> {
    let action = prop_oneof![
        4 => Just(Action::Get),
        6 => Just(Action::PinAndLoad),
        6 => Just(Action::Loaded),
        1 => Just(Action::LoadFailed),
        9 => Just(Action::Unpin),
        8 => Just(Action::Edit),
        6 => prop::bool::weighted(0.8).prop_map(|changed| Action::GiveBack { changed }),
        6 => Just(Action::WriteForRoom),
        1 => Just(Action::DropClean),
        1 => Just(Action::Flush),
        3 => Just(Action::Written),
        1 => Just(Action::WriteFailed),
    ];
    // One value in ten is larger than any cache.
    let weight = prop_oneof![9 => 0..40usize, 1 => Just(500)];
    (action, 0..KEYS, weight)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 800,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(1),
        ..ProptestConfig::default()
    })]

    #[test]
    fn the_state_machine_agrees_with_the_naive_model(
        capacity in prop_oneof![1 => Just(0), 6 => 1..60usize],
        actions in prop::collection::vec(actions(), 0..250),
    ) {
        let mut both = StateAndModel::new(capacity);
        for (action, key, weight) in actions {
            both.apply_from(action, key, weight);
        }
        both.settle();
    }
}
