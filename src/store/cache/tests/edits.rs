//! Edits and write-backs, on a simulated disk that may be slow or full.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use futures::future::{BoxFuture, FutureExt};
use parking_lot::Mutex;
use tokio::runtime::Builder;

use super::{Sample, Trouble};
use crate::store::cache::edit::EditCache;

/// A simulated disk: the saved values, and whether writes fail.
#[derive(Clone, Default)]
struct Disk(Arc<Mutex<DiskState>>);

#[derive(Default)]
struct DiskState {
    saved: BTreeMap<u32, Sample>,
    writes: Vec<u32>,
    fails: bool,
    panics: bool,
}

type Samples = EditCache<u32, Sample, Trouble>;

impl Disk {
    fn cache(&self, capacity: usize) -> Samples {
        let disk = self.clone();
        EditCache::new(capacity, move |key, value| disk.clone().write(key, value))
    }

    fn write(self, key: u32, value: Arc<Sample>) -> BoxFuture<'static, Result<(), Trouble>> {
        async move {
            tokio::time::sleep(Duration::from_micros(100)).await;
            let mut inner = self.0.lock();
            assert!(!inner.panics, "a write panics, as this test intends");
            if inner.fails {
                return Err(Trouble::Disk(key));
            }
            inner.saved.insert(key, *value);
            inner.writes.push(key);
            Ok(())
        }
        .boxed()
    }

    fn load(&self, key: u32) -> impl Fn() -> BoxFuture<'static, Result<Arc<Sample>, Trouble>> + use<> {
        let disk = self.clone();
        move || {
            let disk = disk.clone();
            async move {
                let found = disk.0.lock().saved.get(&key).copied();
                Ok(Arc::new(found.unwrap_or(Sample { version: 0, weight: 10 })))
            }
            .boxed()
        }
    }

    fn version(&self, key: u32) -> u64 {
        self.0.lock().saved.get(&key).map_or(0, |sample| sample.version)
    }
}

async fn change(cache: &Samples, disk: &Disk, key: u32) -> Result<(), Trouble> {
    cache.edit(key, disk.load(key)).await?.version += 1;
    Ok(())
}

fn run(test: impl Future<Output = ()>) {
    Builder::new_current_thread()
        .enable_all()
        .build()
        .unwrap()
        .block_on(test);
}

#[test]
fn only_changed_values_are_written_when_there_is_no_room() {
    run(async {
        let disk = Disk::default();
        let mut cache = disk.cache(50);
        for key in 0..20 {
            change(&cache, &disk, key).await.unwrap();
            let only_read = cache.edit(100 + key, disk.load(100 + key)).await.unwrap();
            assert_eq!(only_read.version, 0);
        }
        let statistics = cache.statistics();
        assert!(statistics.bytes <= 50, "{statistics}");
        assert_eq!(
            statistics.most_bytes, 60,
            "one value more than fits is held while it makes room"
        );
        assert!(
            disk.0
                .lock()
                .writes
                .iter()
                .copied()
                .eq(0..statistics.write_backs as u32)
        );
        cache.flush(2).await.unwrap();
        assert!(disk.0.lock().writes.iter().copied().eq(0..20));
        cache.flush(2).await.unwrap();
        assert_eq!(cache.statistics().write_backs, 20, "once each");
        // The values are loaded as they were saved.
        for key in 0..20 {
            assert_eq!(cache.edit(key, disk.load(key)).await.unwrap().version, 1);
        }
    });
}

#[test]
fn an_edit_becomes_visible_at_once_and_a_reader_keeps_its_value() {
    run(async {
        let disk = Disk::default();
        let cache = disk.cache(50);
        let reader = cache.reader();
        let before = reader.read(1, disk.load(1)).await.unwrap();
        let mut edit = cache.edit(1, disk.load(1)).await.unwrap();
        edit.version = 1;
        edit.weight = 25;
        assert_eq!(before.version, 0);
        let mut waiting = Box::pin(reader.read(1, disk.load(1)));
        assert!(waiting.as_mut().now_or_never().is_none());
        edit.version = 2;
        drop(edit);
        assert_eq!(waiting.await.unwrap().version, 2);
        assert_eq!(before.version, 0);
        assert_eq!(cache.statistics().bytes, 25);
    });
}

#[test]
fn a_value_can_be_read_and_changed_while_it_is_written() {
    run(async {
        let disk = Disk::default();
        let mut cache = disk.cache(10);
        change(&cache, &disk, 1).await.unwrap();
        let reader = cache.reader();
        // Its write-back begins, and the caller that needed the room is dropped.
        assert!(reader.read(2, disk.load(2)).now_or_never().is_none());
        tokio::task::yield_now().await;
        assert!(reader.read(2, disk.load(2)).now_or_never().is_none());
        assert_eq!((disk.version(1), cache.statistics().pinned_bytes), (0, 10));
        let read = reader.read(1, disk.load(1)).now_or_never().unwrap().unwrap();
        assert_eq!(read.version, 1);
        change(&cache, &disk, 1).await.unwrap();
        drop(read);
        while cache.statistics().write_backs == 0 {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
        assert_eq!(disk.version(1), 1);
        cache.flush(2).await.unwrap();
        assert_eq!((disk.version(1), cache.statistics().write_backs), (2, 2));
    });
}

#[test]
fn a_value_that_cannot_be_written_stays_and_the_caller_that_needed_room_gets_the_error() {
    run(async {
        let disk = Disk::default();
        let mut cache = disk.cache(30);
        for key in 0..3 {
            change(&cache, &disk, key).await.unwrap();
        }
        disk.0.lock().fails = true;
        for _ in 0..3 {
            // The same write is tried again, and no other value is evicted instead.
            assert_eq!(change(&cache, &disk, 7).await, Err(Trouble::Disk(0)));
            assert_eq!(cache.statistics().bytes, 30, "the value loaded in vain was evicted");
        }
        assert_eq!(cache.flush(2).await, Err(Trouble::Disk(0)));
        disk.0.lock().fails = false;
        disk.0.lock().panics = true;
        assert_eq!(change(&cache, &disk, 7).await, Err(Trouble::Cancelled));
        disk.0.lock().panics = false;
        for key in 0..3 {
            assert_eq!(cache.edit(key, disk.load(key)).await.unwrap().version, 1);
        }
        assert_eq!(cache.statistics().write_backs, 0);
        cache.flush(2).await.unwrap();
        assert!((0..3).all(|key| disk.version(key) == 1));
        assert!(cache.statistics().bytes <= 30 && cache.statistics().pinned_bytes == 0);
    });
}

#[test]
fn a_write_that_dies_with_its_runtime_leaves_the_value_dirty() {
    let disk = Disk::default();
    let mut cache = disk.cache(10);
    let dying = Builder::new_current_thread().enable_all().build().unwrap();
    dying.block_on(async {
        change(&cache, &disk, 1).await.unwrap();
        assert!(cache.flush(1).now_or_never().is_none());
        tokio::task::yield_now().await;
    });
    assert_eq!(cache.statistics().pinned_bytes, 10);
    drop(dying);
    assert_eq!((disk.version(1), cache.statistics().pinned_bytes), (0, 0));
    run(async {
        cache.flush(2).await.unwrap();
        assert_eq!(disk.version(1), 1);
    });
}

#[test]
fn the_next_request_makes_room_for_values_that_grew() {
    run(async {
        let disk = Disk::default();
        let mut cache = disk.cache(40);
        for key in 0..4 {
            change(&cache, &disk, key).await.unwrap();
        }
        cache.edit(3, disk.load(3)).await.unwrap().weight = 35;
        assert_eq!(cache.statistics().bytes, 65);
        // A value larger than the cache is written as soon as it may be evicted.
        cache.edit(4, disk.load(4)).await.unwrap().weight = 1000;
        drop(cache.edit(5, disk.load(5)).await.unwrap());
        let statistics = cache.statistics();
        assert!(statistics.bytes <= 40, "{statistics}");
        assert_eq!(disk.0.lock().saved[&4].weight, 1000);
        assert_eq!(cache.edit(4, disk.load(4)).await.unwrap().weight, 1000);
        cache.flush(2).await.unwrap();
        assert_eq!(disk.0.lock().saved.len(), 5);
    });
}
