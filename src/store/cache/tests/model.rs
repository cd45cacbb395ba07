//! The state beside a naive model: a list that is searched and summed up anew each time.

use std::sync::Arc;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::Sample;
use crate::store::cache::state::{Content, State};
use crate::store::cache::statistics::CacheStatistics;

const KEYS: u8 = 7;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Where {
    Absent,
    Loading,
    Here,
    Lent,
}

/// All there is to know of a key, also while it is absent.
#[derive(Clone, Copy, Debug)]
struct Item {
    place: Where,
    /// What the cache has, or its editor.
    held: Sample,
    pins: usize,
    dirty: bool,
    writing: Option<u64>,
    leaving: bool,
    again: bool,
    /// The lower, the sooner it goes.
    turn: i64,
    /// The version on disk, and the last one made.
    saved: u64,
    latest: u64,
}

impl Item {
    fn is_free(&self) -> bool {
        self.place == Where::Here && self.pins == 0 && self.writing.is_none()
    }

    fn weight(&self) -> usize {
        match self.place {
            Where::Here | Where::Lent => self.held.weight,
            Where::Absent | Where::Loading => 0,
        }
    }
}

impl Item {
    /// Whether this can happen to it now.
    fn allows(&self, act: Act) -> bool {
        match act {
            Act::Get | Act::PinAndLoad | Act::WriteForRoom | Act::DropClean => true,
            Act::Loaded | Act::LoadFailed => self.place == Where::Loading,
            Act::Unpin => self.pins > usize::from(self.place == Where::Lent),
            Act::Edit => self.place == Where::Here && self.pins > 0,
            Act::GiveBack { .. } => self.place == Where::Lent,
            Act::Flush => self.dirty && self.writing.is_none() && self.place == Where::Here,
            Act::Written | Act::WriteFailed => self.writing.is_some(),
        }
    }
}

struct Model {
    capacity: usize,
    items: Vec<Item>,
    /// Keys and weights of what left, in order.
    left: Vec<(u8, usize)>,
    statistics: CacheStatistics,
    clock: i64,
    requests: u64,
}

impl Model {
    fn new(capacity: usize) -> Self {
        let item = Item {
            place: Where::Absent,
            held: Sample { version: 0, weight: 0 },
            pins: 0,
            dirty: false,
            writing: None,
            leaving: false,
            again: false,
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

    fn sum(&self, counts: impl Fn(&Item) -> bool) -> usize {
        self.items.iter().filter(|item| counts(item)).map(Item::weight).sum()
    }

    fn bytes(&self) -> usize {
        self.sum(|_| true)
    }

    fn pinned(&self) -> usize {
        self.sum(|item| !item.is_free())
    }

    /// After something happened to a key.
    fn moved(&mut self, key: u8, next: bool) {
        self.clock += 1;
        let item = &mut self.items[usize::from(key)];
        item.turn = self.clock;
        if item.is_free() && (next || item.held.weight > self.capacity) {
            item.turn = -self.clock;
            item.again = false;
        }
        if item.place == Where::Absent && item.pins == 0 {
            item.again = false;
        }
        self.statistics.most_bytes = self.statistics.most_bytes.max(self.bytes());
        while self.sum(|item| item.is_free() && item.again) > self.capacity / 5 * 4 {
            let protected = self.items.iter_mut().filter(|item| item.is_free() && item.again);
            let oldest = protected.min_by_key(|item| item.turn).unwrap();
            self.clock += 1;
            (oldest.again, oldest.turn) = (false, self.clock);
        }
    }

    fn used(&mut self, key: u8) {
        let item = &mut self.items[usize::from(key)];
        (item.again, item.leaving) = (true, false);
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
                (item.again, item.turn)
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
                (item.again, item.turn)
            });
            match next {
                Some(next) if self.bytes() - outside > self.capacity => self.evict(next),
                _ => return,
            }
        }
    }

    fn evict(&mut self, key: u8) {
        let item = &mut self.items[usize::from(key)];
        (item.place, item.again) = (Where::Absent, false);
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
enum Act {
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

/// The state and its model, to which the same happens.
struct Both {
    state: State<u8, Sample>,
    model: Model,
}

impl Both {
    fn new(capacity: usize) -> Self {
        Self {
            state: State::new(capacity),
            model: Model::new(capacity),
        }
    }

    fn item(&mut self, key: u8) -> &mut Item {
        &mut self.model.items[usize::from(key)]
    }

    /// Does something to the first key, from this one on, to which it can happen now.
    fn act_from(&mut self, act: Act, key: u8, weight: usize) {
        let mut keys = (key..KEYS).chain(0..key);
        if let Some(key) = keys.find(|&key| self.item(key).allows(act)) {
            self.act(act, key, weight);
        }
    }

    fn act(&mut self, act: Act, key: u8, weight: usize) {
        let item = *self.item(key);
        match act {
            Act::Get => {
                let found = self.state.get(&key);
                assert_eq!(found.as_deref(), (item.place == Where::Here).then_some(&item.held));
                if found.is_some() {
                    self.model.requests += 1;
                    self.model.statistics.hits += 1;
                    self.model.used(key);
                    self.model.moved(key, false);
                }
            }
            Act::PinAndLoad => self.pin_and_load(key),
            Act::Loaded | Act::LoadFailed => {
                let loaded = Sample {
                    version: item.saved,
                    weight,
                };
                let came = matches!(act, Act::Loaded);
                self.state.end_load(key, came.then(|| Arc::new(loaded)));
                let before = self.model.left.len();
                self.model.left.retain(|&(left, _)| !came || left != key);
                let again = self.model.left.len() < before;
                let item = self.item(key);
                item.place = if came { Where::Here } else { Where::Absent };
                item.held = loaded;
                item.again |= again;
                self.model.moved(key, false);
                self.model.make_room();
            }
            Act::Unpin => {
                self.state.unpin(key);
                self.item(key).pins -= 1;
                self.model.moved(key, false);
                self.model.make_room();
            }
            Act::Edit => {
                assert_eq!(self.state.lend(key).as_deref(), Some(&item.held));
                self.item(key).place = Where::Lent;
                self.model.moved(key, false);
            }
            Act::GiveBack { changed } => {
                let item = self.item(key);
                if changed {
                    item.latest += 1;
                    item.held = Sample {
                        version: item.latest,
                        weight,
                    };
                }
                item.dirty |= changed;
                item.place = Where::Here;
                let held = item.held;
                self.state.give_back(key, Arc::new(held), changed);
                self.model.moved(key, false);
            }
            Act::WriteForRoom => {
                let next = self.state.make_room();
                assert_eq!(next, self.model.make_room());
                match next {
                    Some(key) => self.begin_write(key, true),
                    None => assert!(self.model.bytes() <= self.model.capacity + self.model.pinned()),
                }
            }
            Act::DropClean => {
                self.state.drop_clean();
                self.model.drop_clean();
            }
            Act::Flush => self.begin_write(key, false),
            Act::Written | Act::WriteFailed => {
                let saved = matches!(act, Act::Written);
                self.state.end_write(key, saved);
                let item = self.item(key);
                let version = item.writing.take().unwrap();
                let leaving = std::mem::take(&mut item.leaving);
                if saved {
                    item.saved = version;
                }
                item.dirty |= !saved;
                self.model.statistics.write_backs += u64::from(saved);
                self.model.moved(key, leaving);
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
        match item.place {
            Where::Here | Where::Lent => {
                self.model.used(key);
                self.model.statistics.hits += 1;
            }
            Where::Loading => self.model.statistics.shared_loads += 1,
            Where::Absent => {
                assert!(matches!(found, Content::Absent));
                assert_eq!(item.saved, item.latest, "what was changed is lost");
                self.state.begin_load(key);
                self.item(key).place = Where::Loading;
                self.model.statistics.misses += 1;
            }
        }
        self.model.moved(key, false);
    }

    fn begin_write(&mut self, key: u8, leaving: bool) {
        let item = *self.item(key);
        let can = item.dirty && item.writing.is_none() && item.place == Where::Here;
        let value = self.state.begin_write(key, leaving);
        assert_eq!(value.as_deref(), can.then_some(&item.held));
        if can {
            let item = self.item(key);
            (item.dirty, item.writing, item.leaving) = (false, Some(item.held.version), leaving);
            self.model.moved(key, false);
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
                Content::Absent => assert_eq!(item.place, Where::Absent),
                Content::Loading => assert_eq!(item.place, Where::Loading),
                Content::Lent => assert_eq!(item.place, Where::Lent),
                Content::Here(value) => assert_eq!((item.place, *value), (Where::Here, item.held)),
            }
            assert_eq!(self.state.is_dirty(&key), item.dirty);
            assert_eq!(self.state.is_writing(&key), item.writing.is_some());
            let last = if item.place == Where::Absent {
                item.saved
            } else {
                item.held.version
            };
            assert_eq!(last, item.latest, "key {key} went back");
        }
    }

    /// Lets all that is under way come to its end.
    fn settle(&mut self) {
        let ends = [
            Act::Written,
            Act::Loaded,
            Act::GiveBack { changed: false },
            Act::Unpin,
            Act::Flush,
            Act::Written,
        ];
        for act in ends {
            for key in 0..KEYS {
                while self.item(key).allows(act) {
                    let weight = self.item(key).held.weight;
                    self.act(act, key, weight);
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

fn acts() -> impl Strategy<Value = (Act, u8, usize)> {
    let act = prop_oneof![
        4 => Just(Act::Get),
        6 => Just(Act::PinAndLoad),
        6 => Just(Act::Loaded),
        1 => Just(Act::LoadFailed),
        9 => Just(Act::Unpin),
        8 => Just(Act::Edit),
        6 => prop::bool::weighted(0.8).prop_map(|changed| Act::GiveBack { changed }),
        6 => Just(Act::WriteForRoom),
        1 => Just(Act::DropClean),
        1 => Just(Act::Flush),
        3 => Just(Act::Written),
        1 => Just(Act::WriteFailed),
    ];
    // One in ten is larger than any cache.
    let weight = prop_oneof![9 => 0..40usize, 1 => Just(500)];
    (act, 0..KEYS, weight)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 800,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(1),
        ..ProptestConfig::default()
    })]

    #[test]
    fn the_state_does_what_the_model_does(
        capacity in prop_oneof![1 => Just(0), 6 => 1..60usize],
        acts in prop::collection::vec(acts(), 0..250),
    ) {
        let mut both = Both::new(capacity);
        for (act, key, weight) in acts {
            both.act_from(act, key, weight);
        }
        both.settle();
    }
}
