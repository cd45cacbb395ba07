//! Reads return exactly the bytes of the file.

use std::io::ErrorKind;

use crate::io::conformance::{Subject, pattern, wait};
use crate::io::file::ReadAt;

/// Compares a range, read from the file, with the bytes that the file was made of.
fn check(file: &impl ReadAt, bytes: &[u8], from: usize, to: usize) {
    let read = wait(file.read_at(from as u64..to as u64)).unwrap();
    assert!(read == bytes[from..to], "{from}..{to}");
}

pub(super) fn ranges_are_read_exactly(subject: &impl Subject) {
    let bytes = pattern(100_001);
    let file = subject.holding(&bytes);
    assert_eq!(file.length(), 100_001);
    // Offsets around the boundaries of disk blocks, aligned and not, and at the end of the file.
    let offsets = [
        0, 1, 511, 512, 4095, 4096, 4097, 8191, 8192, 12_345, 98_304, 100_000, 100_001,
    ];
    for (number, &from) in offsets.iter().enumerate() {
        for &to in &offsets[number..] {
            check(&file, &bytes, from, to);
        }
    }
}

pub(super) fn an_empty_range_reads_nothing_at_any_offset(subject: &impl Subject) {
    for file in [subject.holding(&pattern(10)), subject.holding(&[])] {
        for offset in [0, 5, 10, 11, 1 << 40, u64::MAX] {
            assert!(wait(file.read_at(offset..offset)).unwrap().is_empty(), "{offset}");
        }
    }
}

pub(super) fn ranges_beyond_the_end_fail_without_allocation(subject: &impl Subject) {
    let file = subject.holding(&pattern(10_000));
    let beyond = [
        9_999..10_001,
        10_000..10_001,
        0..10_001,
        4096..20_000,
        // This is more than any machine has.
        0..1 << 60,
        5..u64::MAX,
        1 << 40..(1 << 40) + 1,
        (1 << 63) - 2..(1 << 63) + 2,
        u64::MAX - 1..u64::MAX,
    ];
    for range in beyond {
        let error = wait(file.read_at(range.clone())).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::UnexpectedEof, "{range:?}");
    }
    #[expect(clippy::reversed_empty_ranges, reason = "that is what is tested")]
    let backwards = wait(file.read_at(7..3)).unwrap_err();
    assert_eq!(backwards.kind(), ErrorKind::InvalidInput);
    check(&file, &pattern(10_000), 3, 10_000);
}

pub(super) fn long_ranges_are_read_whole(subject: &impl Subject) {
    let bytes = pattern((20 << 20) + 123);
    let file = subject.holding(&bytes);
    // Buffers are reused for ranges that are somewhat longer or shorter.
    for length in [
        (1 << 20) + 1,
        1 << 20,
        (1 << 20) - 1,
        9 << 20,
        300_000,
        290_000,
        19 << 20,
        1 << 19,
    ] {
        for from in [0, 1, 4096, 1_000_003] {
            check(&file, &bytes, from, from + length);
        }
    }
    check(&file, &bytes, 0, bytes.len());
    file.rest();
    check(&file, &bytes, 77, bytes.len());
}

pub(super) fn answers_come_in_the_order_of_the_ranges(subject: &impl Subject) {
    let bytes = pattern(1 << 20);
    let file = subject.holding(&bytes);
    // Long ranges before short ones, backwards, overlapping, and repeated.
    let mut ranges: Vec<_> = (0..60u64).rev().map(|i| i * 1000..i * 1000 + (i + 1) * 7000).collect();
    ranges.extend([5..5, 0..1 << 20, 17..18, 17..18]);
    let answers = wait(file.read_many(&ranges)).unwrap();
    assert_eq!(answers.len(), ranges.len());
    for (answer, range) in answers.iter().zip(&ranges) {
        assert!(answer == &bytes[range.start as usize..range.end as usize], "{range:?}");
    }
    assert!(wait(file.read_many(&[])).unwrap().is_empty());
    let error = wait(file.read_many(&[0..10, 0..2 << 20])).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::UnexpectedEof);
}

pub(super) fn a_short_file_is_read_to_its_last_byte(subject: &impl Subject) {
    for length in [1, 7, 4095, 4096, 4097] {
        let bytes = pattern(length);
        let file = subject.holding(&bytes);
        check(&file, &bytes, 0, length);
        check(&file, &bytes, length - 1, length);
        let beyond = wait(file.read_at(0..length as u64 + 1)).unwrap_err();
        assert_eq!(beyond.kind(), ErrorKind::UnexpectedEof);
    }
}
