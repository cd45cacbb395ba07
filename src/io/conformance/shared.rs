//! Files are shared by many threads and runtimes, which start and end.

use std::fs;

use futures::future::{FutureExt, try_join_all};
use tokio::runtime::Builder;

use crate::io::conformance::{Subject, pattern, wait};
use crate::io::file::ReadAt;
use crate::io::range_lock::is_locked_below;

pub(super) fn thousands_of_reads_run_at_once(subject: &impl Subject) {
    let bytes = pattern(1 << 20);
    let file = subject.holding(&bytes);
    let ranges = || (0..5000u64).map(|i| i * 181..i * 181 + i % 97 * 50 + 1);
    let read = wait(try_join_all(ranges().map(|range| file.read_at(range)))).unwrap();
    for (read, range) in read.iter().zip(ranges()) {
        assert!(read == &bytes[range.start as usize..range.end as usize], "{range:?}");
    }
}

pub(super) fn dropped_reads_disturb_no_others(subject: &impl Subject) {
    let bytes = pattern(4 << 20);
    let file = subject.holding(&bytes);
    for round in 0..20 {
        for i in 0..50u64 {
            let read = file.read_at(i * 1000..i * 1000 + (1 << 20));
            match i % 3 {
                // Never polled, polled once, and awaited.
                0 => drop(read),
                1 => drop(read.now_or_never()),
                _ => assert_eq!(wait(read).unwrap()[0], bytes[i as usize * 1000], "{round}"),
            }
        }
    }
    assert!(wait(file.read_at(0..4 << 20)).unwrap() == bytes);
}

pub(super) fn numbers_are_unlocked_when_nobody_awaits_a_read(subject: &impl Subject) {
    for round in 0..100 {
        let file = subject.holding(&pattern(1 << 20));
        let (Some(path), Ok(())) = (subject.path(), file.lock_shared(4)) else {
            // It is not on disk, or the system cannot lock numbers.
            return;
        };
        let editor = fs::File::options().write(true).open(path).unwrap();
        let is_locked = || is_locked_below(&editor, 5).unwrap();
        let (abandoned, awaited) = (file.clone().read_at(0..1 << 20), file.read_at(0..1 << 20));
        drop(file);
        drop(abandoned);
        assert!(is_locked(), "{round}");
        wait(awaited).unwrap();
        assert!(!is_locked(), "{round}");
    }
}

pub(super) fn reads_work_in_any_runtime(subject: &impl Subject) {
    let bytes = pattern(2 << 20);
    let file = subject.holding(&bytes);
    for workers in 1..4 {
        let runtime = Builder::new_multi_thread().worker_threads(workers).build().unwrap();
        let reads = (0..40u64).map(|i| {
            let file = file.clone();
            runtime.spawn(async move { file.read_at(i * 500..i * 500 + (1 << 20)).await })
        });
        let reads: Vec<_> = reads.collect();
        let first = runtime.block_on(async { reads.into_iter().next().unwrap().await });
        assert!(first.unwrap().unwrap() == bytes[..1 << 20]);
        // The other reads end with their runtime, finished or not.
        runtime.shutdown_background();
    }
    let runtimes = [(); 2].map(|()| Builder::new_current_thread().build().unwrap());
    let read = || file.read_at(5..2 << 20);
    // A future that one runtime started is awaited in another.
    let started = {
        let _within = runtimes[0].enter();
        read()
    };
    assert!(runtimes[1].block_on(started).unwrap() == bytes[5..]);
    assert!(wait(read()).unwrap() == bytes[5..]);
}

pub(super) fn bytes_outlive_their_file(subject: &impl Subject) {
    let bytes = pattern(1 << 20);
    let file = subject.holding(&bytes);
    let (read, started) = (wait(file.read_at(100..1 << 20)).unwrap(), file.read_at(3..1 << 20));
    let part = read.slice(50..500_000);
    drop((file, read));
    assert!(part == bytes[150..500_100]);
    assert!(
        wait(started).unwrap() == bytes[3..],
        "the file stays open until the answer is there"
    );
}

pub(super) fn an_open_file_keeps_its_bytes_when_its_name_is_replaced(subject: &impl Subject) {
    let old = pattern(300_000);
    let file = subject.holding(&old);
    let Some(path) = subject.path() else {
        return;
    };
    let next = path.with_extension("next");
    fs::write(&next, b"another").unwrap();
    fs::rename(&next, &path).unwrap();
    assert!(wait(file.read_at(0..300_000)).unwrap() == old);
    fs::remove_file(&path).unwrap();
    assert!(wait(file.clone().read_at(1..299_999)).unwrap() == old[1..299_999]);
}
