//! Writes are visible to the reads after them.

use bytes::Bytes;
use futures::future::{FutureExt, try_join_all};

use crate::io::conformance::{Writing, pattern, wait};
use crate::io::file::{ReadAt, WriteAt};

pub(super) fn files_grow_as_they_are_written(subject: &impl Writing) {
    let file = subject.create();
    assert!(wait(file.read_at(0..1)).is_err());
    let bytes = pattern(3_000_000);
    let mut end = 0;
    for length in [1, 10, 4096, 5000, 1 << 20, (1 << 20) + 1, 7] {
        wait(file.write_at(end as u64, Bytes::copy_from_slice(&bytes[end..end + length]))).unwrap();
        end += length;
        let from = end.saturating_sub(length + 13);
        assert!(
            wait(file.read_at(from as u64..end as u64)).unwrap() == bytes[from..end],
            "{end}"
        );
        assert!(wait(file.read_at(0..end as u64 + 1)).is_err());
    }
    wait(file.sync()).unwrap();
    // The old bytes are overwritten, and those around them stay.
    wait(file.write_at(100, Bytes::from_static(&[0; 50]))).unwrap();
    let read = wait(file.read_at(0..end as u64)).unwrap();
    assert!(read[..100] == bytes[..100] && read[100..150] == [0; 50] && read[150..] == bytes[150..end]);
}

pub(super) fn gaps_read_as_zeros(subject: &impl Writing) {
    let file = subject.create();
    wait(file.write_at(10_000, Bytes::from_static(b"end"))).unwrap();
    wait(file.write_at(20_000, Bytes::new())).unwrap();
    wait(file.sync()).unwrap();
    let read = wait(file.read_at(0..10_003)).unwrap();
    assert!(read[..10_000].iter().all(|&byte| byte == 0) && &read[10_000..] == b"end");
    assert!(wait(file.read_at(0..10_004)).is_err(), "no bytes make no file longer");
}

pub(super) fn impossible_offsets_are_errors(subject: &impl Writing) {
    let file = subject.create();
    wait(file.write_at(0, Bytes::from_static(b"abc"))).unwrap();
    for offset in [(1 << 63) - 2, (1 << 63) - 1, 1 << 63, u64::MAX - 1, u64::MAX] {
        assert!(
            wait(file.write_at(offset, Bytes::from_static(b"abc"))).is_err(),
            "{offset}"
        );
    }
    assert_eq!(wait(file.read_at(0..3)).unwrap(), &b"abc"[..]);
    assert!(wait(file.read_at(0..4)).is_err());
}

pub(super) fn many_writes_run_at_once(subject: &impl Writing) {
    const PIECE: usize = 3001;
    let file = subject.create();
    let bytes = Bytes::from(pattern(400 * PIECE));
    let write = |i: usize| file.write_at((i * PIECE) as u64, bytes.slice(i * PIECE..(i + 1) * PIECE));
    wait(try_join_all((0..400).rev().map(write))).unwrap();
    wait(try_join_all((0..5).map(|_| file.sync()))).unwrap();
    assert!(wait(file.read_at(0..bytes.len() as u64)).unwrap() == bytes);
}

pub(super) fn a_dropped_write_is_still_performed(subject: &impl Writing) {
    let file = subject.create();
    let bytes = Bytes::from(pattern(1 << 20));
    // One future is polled once, the other never.
    let _ = file.write_at(0, bytes.clone()).now_or_never();
    drop(file.write_at(bytes.len() as u64, bytes.clone()));
    let end = 2 * bytes.len() as u64;
    let both = [&bytes[..], &bytes[..]].concat();
    // Nothing reports when the writes are done.
    while !wait(file.read_at(0..end)).is_ok_and(|read| read == both) {
        std::thread::yield_now();
    }
}
