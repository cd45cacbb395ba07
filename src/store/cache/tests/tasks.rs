//! Loads and pins in tasks.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use futures::future::{FutureExt, join_all, pending};
use tokio::runtime::{Builder, Runtime};
use tokio::sync::Notify;

use super::{Sample, Trouble};
use crate::store::cache::shelf::Shelf;

type Samples = Shelf<u32, Sample, Trouble>;

fn runtime() -> Runtime {
    Builder::new_current_thread().enable_all().build().unwrap()
}

fn sample(weight: usize) -> Arc<Sample> {
    Arc::new(Sample { version: 0, weight })
}

async fn load(shelf: &Samples, key: u32, weight: usize) -> Arc<Sample> {
    let value = async move { Ok(sample(weight)) };
    shelf.get_or_load(key, || value).await.unwrap()
}

fn holds(shelf: &Samples, key: u32) -> bool {
    use crate::store::cache::state::Content;
    shelf.with(|inner| matches!(inner.state.peek(&key), Content::Here(_)))
}

#[test]
fn callers_share_a_load_and_its_error_which_is_not_cached() {
    runtime().block_on(async {
        let shelf = Samples::new(100);
        let loads = AtomicU32::new(0);
        let fail = || {
            loads.fetch_add(1, Ordering::Relaxed);
            async {
                tokio::task::yield_now().await;
                Err(Trouble::Disk(7))
            }
        };
        let results = join_all((0..10).map(|_| shelf.get_or_load(1, fail))).await;
        assert!(results.iter().all(|result| *result == Err(Trouble::Disk(7))));
        assert_eq!(loads.into_inner(), 1);
        let statistics = shelf.with(|inner| inner.state.statistics());
        assert_eq!((statistics.misses, statistics.shared_loads), (1, 9));
        assert_eq!(load(&shelf, 1, 5).await.weight, 5);
    });
}

#[test]
fn dropping_one_caller_does_not_cancel_the_others() {
    runtime().block_on(async {
        let shelf = Samples::new(100);
        let go = Arc::new(Notify::new());
        let loads = Arc::new(AtomicU32::new(0));
        let callers: Vec<_> = (0..10)
            .map(|_| {
                let (shelf, go, loads) = (shelf.clone(), Arc::clone(&go), Arc::clone(&loads));
                tokio::spawn(async move {
                    let load = || async move {
                        loads.fetch_add(1, Ordering::Relaxed);
                        go.notified().await;
                        Ok(sample(5))
                    };
                    shelf.get_or_load(1, load).await
                })
            })
            .collect();
        tokio::task::yield_now().await;
        // The first caller began the load.
        for caller in &callers[..5] {
            caller.abort();
        }
        tokio::time::sleep(Duration::from_millis(1)).await;
        go.notify_one();
        for (number, caller) in callers.into_iter().enumerate() {
            match caller.await {
                Ok(value) => assert_eq!(value.unwrap().weight, 5),
                Err(error) => assert!(error.is_cancelled() && number < 5),
            }
        }
        assert_eq!(loads.load(Ordering::Relaxed), 1);
        assert!(holds(&shelf, 1));
        assert_eq!(shelf.with(|inner| inner.state.statistics()).pinned_bytes, 0);
    });
}

#[test]
fn a_load_without_waiting_callers_still_fills_the_cache() {
    runtime().block_on(async {
        let shelf = Samples::new(100);
        assert!(load(&shelf, 1, 5).now_or_never().is_none());
        tokio::time::sleep(Duration::from_millis(1)).await;
        assert!(holds(&shelf, 1));
    });
}

#[test]
fn a_load_without_a_result_is_an_error_only_for_the_caller_that_began_it() {
    runtime().block_on(async {
        let shelf = Samples::new(100);
        let panics = || async { panic!("a load panics, as this test intends") };
        let (began, waited) = tokio::join!(shelf.get_or_load(1, panics), load(&shelf, 1, 5));
        assert_eq!(began, Err(Trouble::Cancelled));
        assert_eq!(waited.weight, 5);
        // The load itself may report that a task below it was cancelled with its runtime.
        let cancelled = || async { Err(Trouble::Cancelled) };
        let (began, waited) = tokio::join!(shelf.get_or_load(2, cancelled), load(&shelf, 2, 5));
        assert_eq!(began, Err(Trouble::Cancelled));
        assert_eq!(waited.weight, 5);
    });
}

#[test]
fn a_waiting_caller_loads_itself_when_the_runtime_of_the_load_is_dropped() {
    let alive = runtime();
    // The load is polled before its runtime ends, or never.
    for polls in [true, false] {
        let dying = runtime();
        let shelf = Samples::new(100);
        let began = {
            let shelf = shelf.clone();
            async move { shelf.get_or_load(1, pending).now_or_never() }
        };
        assert!(dying.block_on(began).is_none());
        if polls {
            dying.block_on(tokio::task::yield_now());
        }
        let mut waiting = Box::pin(load(&shelf, 1, 5));
        let first = alive.block_on(async { waiting.as_mut().now_or_never() });
        assert!(first.is_none(), "it waits for the other's load");
        drop(dying);
        let value = alive.block_on(waiting);
        assert_eq!(value.weight, 5);
        let statistics = shelf.with(|inner| inner.state.statistics());
        assert_eq!((statistics.bytes, statistics.pinned_bytes), (5, 0));
    }
}

#[test]
fn pinned_values_stay_and_a_value_larger_than_the_cache_evicts_no_others() {
    runtime().block_on(async {
        let shelf = Samples::new(100);
        let pinned = shelf.pin_or_load(0, || async { Ok(sample(30)) }).await.unwrap();
        for key in 1..50 {
            load(&shelf, key, 10).await;
        }
        assert!(holds(&shelf, 0));
        let statistics = shelf.with(|inner| inner.state.statistics());
        assert_eq!(
            (statistics.bytes, statistics.pinned_bytes, statistics.evictions),
            (100, 30, 42)
        );
        // A value larger than the cache stays while it is pinned.
        let large = shelf.pin_or_load(50, || async { Ok(sample(101)) }).await.unwrap();
        let statistics = shelf.with(|inner| inner.state.statistics());
        assert_eq!(
            (statistics.bytes, statistics.pinned_bytes, statistics.evictions),
            (201, 131, 42)
        );
        assert_eq!(load(&shelf, 50, 0).await.weight, 101);
        drop(large);
        assert!(!holds(&shelf, 50));
        // Pins alone may exceed the capacity.
        let others = join_all((60..64).map(|key| shelf.pin_or_load(key, || async { Ok(sample(40)) }))).await;
        let statistics = shelf.with(|inner| inner.state.statistics());
        assert_eq!((statistics.bytes, statistics.pinned_bytes), (190, 190));
        drop(others);
        assert!(holds(&shelf, 0));
        drop(pinned);
        let statistics = shelf.with(|inner| inner.state.statistics());
        assert!(statistics.bytes <= 100 && statistics.pinned_bytes == 0);
        assert_eq!(statistics.most_bytes, 201);
    });
}

#[test]
fn a_cache_of_capacity_0_still_shares_loads() {
    runtime().block_on(async {
        let shelf = Samples::new(0);
        let values = join_all((0..4).map(|_| load(&shelf, 1, 5))).await;
        assert!(values.iter().all(|value| value.weight == 5));
        let statistics = shelf.with(|inner| inner.state.statistics());
        assert_eq!(
            (statistics.misses, statistics.shared_loads, statistics.bytes),
            (1, 3, 0)
        );
    });
}

/// With a plain LRU there are no hits after the scan.
#[test]
fn a_scan_does_not_evict_values_that_are_used_repeatedly() {
    runtime().block_on(async {
        let shelf = Samples::new(1000);
        let hits = || shelf.with(|inner| inner.state.statistics()).hits;
        for _ in 0..2 {
            for key in 0..70 {
                load(&shelf, key, 10).await;
            }
        }
        for key in 1000..3000 {
            load(&shelf, key, 10).await;
        }
        let before = hits();
        for key in 0..70 {
            load(&shelf, key, 10).await;
        }
        assert_eq!(hits() - before, 70);
        // The new hot values replace the old ones.
        for _ in 0..3 {
            for key in 5000..5070 {
                load(&shelf, key, 10).await;
            }
        }
        for key in 1000..3000 {
            load(&shelf, key, 10).await;
        }
        let before = hits();
        for key in 5000..5070 {
            load(&shelf, key, 10).await;
        }
        assert_eq!(hits() - before, 70);
    });
}
