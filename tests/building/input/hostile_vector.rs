//! Damaged files of vector data give records or an error that names the file, never a panic, and
//! within bounds of time.

use crate::input::hostile::Random;
use crate::input::{drain, segments, sites};
use crate::support::test_data::data;
use delaunay_tiles::input::{InputError, InputOptions, PointSource, SegmentSource, SiteSource, panic_is_caught};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Once;
use std::time::{Duration, Instant};

/// The files that are damaged, and the number of bytes between two places where each is cut.
fn samples() -> [(&'static str, usize); 7] {
    [
        ("lines.fgb", 7),
        ("mixed.fgb", 31),
        ("lines_indexed.fgb", 31),
        ("lines.shp", 5),
        ("polygons.shp", 7),
        ("clusters.shp", 1),
        ("lines.gpkg", 1021),
    ]
}

/// Fails the test if a panic is printed that no reader catches.
fn watch_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if !panic_is_caught() {
                before(panic);
            }
        }));
    });
}

/// Reads the file as each kind of records. Returns the error of reading it as lines.
fn read_all(path: &Path) -> Option<InputError> {
    let paths: [PathBuf; 1] = [path.to_owned()];
    let as_lines = SegmentSource::open(&paths).and_then(segments::drain).err();
    let others = [
        SegmentSource::open_obstacles(&paths).and_then(segments::drain).err(),
        SiteSource::open(&paths, Some("name")).and_then(sites::drain).err(),
        PointSource::open(&paths, &InputOptions::default())
            .and_then(drain)
            .err(),
    ];
    for error in others.iter().flatten().chain(&as_lines) {
        let message = error.to_string();
        assert!(message.contains("hostile") && message.len() < 1200, "{message}");
    }
    as_lines
}

/// Runs `damage` on the samples until the time is over.
fn for_samples(seconds: u64, mut damage: impl FnMut(&Path, &[u8], usize, Instant)) {
    watch_panics();
    let folder = tempfile::tempdir().unwrap();
    let samples = samples();
    for (name, step) in &samples {
        let bytes = fs::read(data("formats").join(name)).unwrap();
        let suffix = name.rsplit_once('.').unwrap().1;
        let path = folder.path().join(format!("hostile.{suffix}"));
        let until = Instant::now() + Duration::from_secs(seconds) / samples.len() as u32;
        damage(&path, &bytes, *step, until);
    }
}

#[test]
fn a_file_that_is_cut_short_is_an_error() {
    for_samples(20, |path, bytes, step, until| {
        fs::write(path, bytes).unwrap();
        assert!(read_all(path).is_none());
        for length in (0..bytes.len()).step_by(step) {
            fs::write(path, &bytes[..length]).unwrap();
            let error = read_all(path);
            assert!(error.is_some(), "{}: {length} of {} bytes", path.display(), bytes.len());
            if Instant::now() > until {
                break;
            }
        }
    });
}

#[test]
fn flipped_bits_give_records_or_an_error() {
    let mut random = Random(23);
    let mut failed = 0;
    for_samples(12, |path, bytes, _, until| {
        for _ in 0..400 {
            let mut bytes = bytes.to_vec();
            for _ in 0..=random.below(4) {
                let at = random.below(bytes.len());
                bytes[at] ^= 1 << random.below(8);
            }
            fs::write(path, &bytes).unwrap();
            failed += u32::from(read_all(path).is_some());
            if Instant::now() > until {
                break;
            }
        }
    });
    assert!(failed > 0 || samples().is_empty());
}

/// Counts and lengths, which mostly stand in the first bytes, become as large as they can be.
#[test]
fn large_numbers_are_not_trusted() {
    for_samples(12, |path, bytes, _, until| {
        for at in (0..bytes.len().min(600)).step_by(2) {
            for value in [[0xff; 4], [0xff, 0xff, 0xff, 0x7f], [0x7f, 0xff, 0xff, 0xff]] {
                let mut bytes = bytes.to_vec();
                bytes[at..at + 4].copy_from_slice(&value);
                fs::write(path, &bytes).unwrap();
                read_all(path);
            }
            if Instant::now() > until {
                break;
            }
        }
    });
}
