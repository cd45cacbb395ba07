//! Compressed files that are damaged or made to harm.

use super::support::{Random, batches, file_bytes, points_of, runtime};
use super::surgery::Patient;
use super::{Outcome, digest_of, directory_of, mutate, options, use_all};
use delaunay_tiles::geometry::Point;
use distributions::Kind;

/// Offsets in an entry: of the length, of the decoded length and of the codecs.
const LENGTH: usize = 16;
const DECODED: usize = 24;
const CODECS: usize = 44;

/// Builds compressed tiles of 8 vertices, with z.
fn patient() -> Patient {
    let points: Vec<Point> = points_of(Kind::Uniform, 64, 1);
    let z: Vec<f64> = (0..64).map(f64::from).collect();
    let bytes = runtime().block_on(file_bytes(&batches(&points, &z), options().compress(true)));
    Patient::new(bytes)
}

#[test]
fn changed_compressed_bytes_with_right_checksums_never_give_a_wrong_answer() {
    let packed = patient();
    let unpacked = packed.clone().unpacked();
    let right = runtime().block_on(digest_of(packed.bytes.clone())).unwrap();
    assert_eq!(runtime().block_on(digest_of(unpacked.bytes.clone())), Ok(right));
    let runtime = runtime();
    let mut outcomes = [0; 4];
    for seed in 0..1500 {
        let mut random = Random(31_000_000 + seed);
        let patient = if seed % 4 == 0 { &packed } else { &unpacked };
        let mut mutated = patient.clone();
        let part = match random.below(3) {
            0 => patient.borders[random.below(patient.borders.len())],
            _ => patient.cores[random.below(patient.cores.len())],
        };
        mutate(&mut random, &mut mutated.bytes[part.at..part.at + part.length]);
        mutated.sew();
        let outcome = runtime.block_on(use_all(mutated.bytes, &right, &format!("seed {seed}")));
        outcomes[outcome as usize] += 1;
    }
    println!("refused, found, same, other points: {outcomes:?}");
    assert!(
        outcomes[Outcome::Found as usize] > 500 && outcomes[Outcome::Same as usize] > 5,
        "{outcomes:?}"
    );
}

#[test]
fn wrong_decoded_lengths_are_refused() {
    let patient = patient();
    let runtime = runtime();
    for (entry, part) in patient.entries.iter().flat_map(|&entry| [(entry, 0), (entry, 1)]) {
        let at = entry + DECODED + 4 * part;
        let right = super::support::flat::u32_at(&patient.bytes, at);
        for wrong in [
            0,
            1,
            right - 8,
            right - 1,
            right + 1,
            right + 8,
            2 * right,
            1 << 20,
            64 << 20,
            u32::MAX,
        ] {
            let mut mutated = patient.clone();
            mutated.put(at, &wrong.to_le_bytes());
            mutated.sew();
            let found = runtime.block_on(digest_of(mutated.bytes));
            assert!(found.is_err(), "{wrong} in place of {right}");
        }
    }
}

#[test]
fn unknown_codecs_and_lengths_beyond_the_limits_are_refused() {
    let patient = patient();
    let runtime = runtime();
    let entry = patient.entries[1];
    let length = super::support::flat::u32_at(&patient.bytes, entry + LENGTH);
    let faults: [(usize, u32, &str); 6] = [
        (CODECS, 2, "codec 2, which this program does not know"),
        (CODECS, 0x0901, "codec 9, which this program does not know"),
        (CODECS, 0x0001_0101, "codecs are 0x10101"),
        (CODECS, 0x0100, "cannot decode to"),
        (DECODED, 256 * length + 1, "cannot decode to"),
        (DECODED, (64 << 20) + 1, "cannot decode to"),
    ];
    for (field, value, reason) in faults {
        let mut mutated = patient.clone();
        mutated.put(entry + field, &value.to_le_bytes());
        mutated.sew();
        let error = runtime.block_on(directory_of(mutated.bytes)).err().unwrap().to_string();
        assert!(error.contains(reason), "{error}");
    }
}

/// A frame of blocks, each of four bytes, that decompress to 128 KiB of zeros each.
fn bomb(blocks: u32) -> Vec<u8> {
    let mut frame = vec![0x28, 0xb5, 0x2f, 0xfd, 0x00, 0x50];
    for block in 0..blocks {
        let is_last = u32::from(block + 1 == blocks);
        frame.extend(&((128 << 10) << 3 | 1 << 1 | is_last).to_le_bytes()[..3]);
        frame.push(0);
    }
    frame
}

/// Frames that decompress to more than the plan, and plans that say to be longer than the buffer.
#[test]
fn bombs_are_refused() {
    let patient = patient();
    let runtime = runtime();
    for core in &patient.cores {
        let mut mutated = patient.clone();
        for plan in [500u32, 100_000, 64 << 20, u32::MAX] {
            let mut bytes = plan.to_le_bytes().to_vec();
            bytes.extend(bomb((core.length as u32 - 10) / 4));
            bytes.resize(core.length, 0);
            mutated.put(core.at, &bytes);
            mutated.sew();
            let found = runtime.block_on(digest_of(mutated.bytes.clone()));
            assert!(found.is_err(), "a plan of {plan} bytes");
        }
    }
}
