//! Tests of the cache under a checker of interleavings (crate `shuttle`). The checker runs tasks
//! one at a time and chooses, at each lock and each await, which task continues. It runs some
//! thousand random schedules and some hundred PCT schedules (Burckhardt and others, "A randomized
//! scheduler with probabilistic guarantees of finding bugs", ASPLOS 2010), from fixed seeds.
//!
//! The files of the cache are compiled a second time here, with the checker's lock and tasks in
//! place of `sync.rs`.

#[allow(dead_code, reason = "the library has more uses for it")]
#[path = "../../src/store/cache/edit.rs"]
mod edit;
#[allow(dead_code, reason = "the library has more uses for it")]
#[path = "../../src/store/cache/shelf.rs"]
mod shelf;
#[allow(dead_code, reason = "the library has more uses for it")]
#[path = "../../src/store/cache/state.rs"]
mod state;
#[path = "../../src/store/cache/statistics.rs"]
mod statistics;

/// Has the same items as `src/store/cache/sync.rs`.
mod sync {
    use std::future::Future;
    use std::mem;

    use shuttle::sync::MutexGuard;

    pub(super) struct Mutex<T>(shuttle::sync::Mutex<T>);

    impl<T> Mutex<T> {
        pub(super) fn new(value: T) -> Self {
            Self(shuttle::sync::Mutex::new(value))
        }

        pub(super) fn lock(&self) -> MutexGuard<'_, T> {
            self.0.lock().unwrap()
        }
    }

    pub(super) fn spawn(task: impl Future<Output = ()> + Send + 'static) {
        // The checker ends a detached task at the end of the test. A forgotten handle makes it
        // await the task.
        mem::forget(shuttle::future::spawn(task));
    }
}

use std::collections::HashMap;
use std::future::Future;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};

use futures::future::{BoxFuture, FutureExt};
use shuttle::future::{JoinHandle, block_on, spawn, yield_now};
use shuttle::scheduler::{PctScheduler, RandomScheduler};
use shuttle::{Config, Runner};

use self::edit::EditCache;
use self::shelf::{Failure, Shelf};
use self::state::{Content, Weight};

/// A value that an editor changes in two steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Sample {
    one: u32,
    other: u32,
}

const WEIGHT: usize = 10;

impl Weight for Sample {
    fn weight(&self) -> usize {
        WEIGHT
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Trouble {
    Disk,
    Cancelled,
}

impl Failure for Trouble {
    const CANCELLED: Self = Self::Cancelled;

    fn is_cancelled(&self) -> bool {
        *self == Self::CANCELLED
    }
}

type Samples = Shelf<u32, Sample, Trouble>;
type Loaded = Result<Arc<Sample>, Trouble>;

/// Runs `test` under `schedules` random schedules and a quarter as many PCT schedules.
pub fn explore<F: Future<Output = ()>>(schedules: usize, test: impl Fn() -> F + Send + Sync + 'static) {
    let test = Arc::new(move || block_on(test()));
    let random = Arc::clone(&test);
    Runner::new(RandomScheduler::new_from_seed(1, schedules), Config::new()).run(move || random());
    Runner::new(PctScheduler::new_from_seed(1, 3, schedules / 4), Config::new()).run(move || test());
}

/// Returns a load function that counts its calls in `loads`; the first `fails` calls return an
/// error.
fn counted(loads: &Arc<AtomicU32>, fails: u32) -> impl Fn() -> BoxFuture<'static, Loaded> + Send + use<> {
    let loads = Arc::clone(loads);
    move || {
        let number = loads.fetch_add(1, Ordering::SeqCst);
        async move {
            yield_now().await;
            if number < fails {
                return Err(Trouble::Disk);
            }
            Ok(Arc::new(Sample::default()))
        }
        .boxed()
    }
}

fn bytes(shelf: &Samples) -> (usize, usize) {
    let statistics = shelf.with(|inner| inner.state.statistics());
    (statistics.bytes, statistics.pinned_bytes)
}

#[test]
fn concurrent_callers_share_one_load_when_some_are_cancelled() {
    explore(1500, || async {
        let (shelf, loads) = (Samples::new(100), Arc::default());
        let callers: Vec<JoinHandle<_>> = (0..4)
            .map(|_| {
                let (shelf, load) = (shelf.clone(), counted(&loads, 0));
                spawn(async move { shelf.get_or_load(1, load).await })
            })
            .collect();
        callers[0].abort();
        callers[1].abort();
        let mut came = 0;
        for (caller, number) in callers.into_iter().zip(0..) {
            match caller.await {
                Ok(value) => assert_eq!(*value.unwrap(), Sample::default()),
                Err(_) => assert!(number < 2, "nobody else is cancelled"),
            }
            came += 1;
        }
        assert_eq!((came, loads.load(Ordering::SeqCst)), (4, 1));
        assert_eq!(bytes(&shelf), (WEIGHT, 0));
    });
}

#[test]
fn a_load_error_reaches_all_waiters_and_no_later_caller() {
    explore(1500, || async {
        let (shelf, loads) = (Samples::new(100), Arc::default());
        let callers: Vec<JoinHandle<_>> = (0..3)
            .map(|_| {
                let (shelf, load) = (shelf.clone(), counted(&loads, 1));
                spawn(async move { shelf.get_or_load(1, load).await.err() })
            })
            .collect();
        let mut errors = 0;
        for caller in callers {
            let error = caller.await.unwrap();
            assert!(error.is_none_or(|error| error == Trouble::Disk));
            errors += u64::from(error.is_some());
        }
        let statistics = shelf.with(|inner| inner.state.statistics());
        // The callers that shared the first load get its error; a caller that came after it does
        // not.
        assert_eq!(statistics.hits + statistics.misses + statistics.shared_loads, 3);
        assert!((1..=2).contains(&statistics.misses) && errors >= 1);
        assert_eq!(u64::from(loads.load(Ordering::SeqCst)), statistics.misses);
        assert_eq!((statistics.misses == 1), (errors == 3));
        assert!(shelf.get_or_load(1, counted(&loads, 1)).await.is_ok());
        assert_eq!(bytes(&shelf), (WEIGHT, 0));
    });
}

#[test]
fn pinned_values_are_not_evicted() {
    explore(800, || async {
        let (shelf, loads) = (Samples::new(2 * WEIGHT), Arc::default());
        let tasks: Vec<JoinHandle<()>> = (0..3)
            .map(|task| {
                let (shelf, load) = (shelf.clone(), counted(&loads, 0));
                spawn(async move {
                    let pinned = shelf.pin_or_load(task, &load).await.unwrap();
                    for other in 10..12 {
                        shelf.get_or_load(other + task, &load).await.unwrap();
                        let found = shelf.with(|inner| inner.state.peek(&task));
                        assert!(matches!(found, Content::Here(value) if Arc::ptr_eq(&value, &pinned)));
                    }
                })
            })
            .collect();
        for task in tasks {
            task.await.unwrap();
        }
        let (bytes, pinned) = bytes(&shelf);
        assert!(bytes <= 2 * WEIGHT && pinned == 0);
    });
}

/// The saved values. A read and a write take a while, and some writes fail.
#[derive(Default)]
struct Disk {
    /// Locked only where no other task can run, so the checker need not know of the lock.
    saved: Mutex<HashMap<u32, Sample>>,
    writes: AtomicU32,
    /// Every `fails`-th write fails; 0 means that none fails.
    fails: u32,
}

impl Disk {
    fn cache(self: &Arc<Self>, capacity: usize) -> EditCache<u32, Sample, Trouble> {
        let disk = Arc::clone(self);
        EditCache::new(capacity, move |key, value: Arc<Sample>| {
            let disk = Arc::clone(&disk);
            async move {
                yield_now().await;
                let number = disk.writes.fetch_add(1, Ordering::SeqCst) + 1;
                if disk.fails > 0 && number.is_multiple_of(disk.fails) {
                    return Err(Trouble::Disk);
                }
                assert_eq!(value.one, value.other, "no edit is written by half");
                let before = disk.saved.lock().unwrap().insert(key, *value);
                assert!(
                    before.is_none_or(|before| before.one < value.one),
                    "{before:?} {value:?}"
                );
                yield_now().await;
                Ok(())
            }
            .boxed()
        })
    }

    fn load(self: &Arc<Self>, key: u32) -> impl FnOnce() -> BoxFuture<'static, Loaded> + Send + use<> {
        let disk = Arc::clone(self);
        move || {
            async move {
                yield_now().await;
                let found = disk.saved.lock().unwrap().get(&key).copied();
                yield_now().await;
                Ok(Arc::new(found.unwrap_or_default()))
            }
            .boxed()
        }
    }

    fn saved(&self, key: u32) -> u32 {
        self.saved.lock().unwrap().get(&key).map_or(0, |value| value.one)
    }
}

/// Changes the value of `key`, and retries until the edit succeeds.
async fn change(cache: &EditCache<u32, Sample, Trouble>, disk: &Arc<Disk>, key: u32) {
    loop {
        match cache.edit(key, disk.load(key)).await {
            Ok(mut edit) => {
                edit.one += 1;
                yield_now().await;
                edit.other += 1;
                return;
            }
            Err(error) => assert_eq!(error, Trouble::Disk),
        }
    }
}

/// Edits each of three values three times while others read; one reader is aborted in between.
fn edit_and_read(capacity: usize, fails: u32) {
    explore(500, move || async move {
        let disk = Arc::new(Disk {
            fails,
            ..Disk::default()
        });
        let mut cache = disk.cache(capacity);
        let readers: Vec<JoinHandle<()>> = (0..2)
            .map(|_| {
                let (reader, disk) = (cache.reader(), Arc::clone(&disk));
                spawn(async move {
                    let mut seen = [0; 3];
                    for key in [0, 1, 2, 0, 1, 2] {
                        match reader.read(key, disk.load(key)).await {
                            Ok(value) => {
                                assert_eq!(value.one, value.other, "an edit is seen as a whole");
                                let seen = &mut seen[key as usize];
                                assert!(value.one >= *seen, "what was changed is not lost");
                                *seen = value.one;
                            }
                            Err(error) => assert!(error == Trouble::Disk && fails > 0),
                        }
                    }
                })
            })
            .collect();
        for key in [0, 1, 0, 2, 1, 2] {
            change(&cache, &disk, key).await;
        }
        readers[0].abort();
        for key in [0, 1, 2] {
            change(&cache, &disk, key).await;
        }
        while let Err(error) = cache.flush(1).await {
            assert!(error == Trouble::Disk && fails > 0);
        }
        assert!((0..3).all(|key| disk.saved(key) == 3));
        for reader in readers {
            // The first reader may have been aborted.
            let _ = reader.await;
        }
        let statistics = cache.statistics();
        assert!(
            statistics.bytes <= capacity && statistics.pinned_bytes == 0,
            "{statistics}"
        );
    });
}

#[test]
fn edits_are_seen_and_saved_with_room_for_one_value() {
    edit_and_read(WEIGHT, 0);
}

#[test]
fn edits_are_seen_and_saved_with_capacity_zero() {
    edit_and_read(0, 0);
}

#[test]
fn edits_are_seen_and_saved_when_writes_fail() {
    edit_and_read(WEIGHT, 3);
}

#[test]
fn concurrent_edits_of_one_value_are_serialized() {
    explore(800, || async {
        let disk = Arc::new(Disk::default());
        let cache = Arc::new(disk.cache(WEIGHT));
        let tasks: Vec<JoinHandle<()>> = (0..3)
            .map(|task| {
                let (cache, disk) = (Arc::clone(&cache), Arc::clone(&disk));
                spawn(async move {
                    change(&cache, &disk, 0).await;
                    change(&cache, &disk, task).await;
                })
            })
            .collect();
        for task in tasks {
            task.await.unwrap();
        }
        let mut cache = Arc::into_inner(cache).unwrap();
        cache.flush(1).await.unwrap();
        assert_eq!([0, 1, 2].map(|key| disk.saved(key)), [4, 1, 1]);
    });
}
