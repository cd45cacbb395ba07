//! What a point source reports before it is read.

use crate::input::{bits, drain};
use delaunay_tiles::geometry::{Point, Rect};
use delaunay_tiles::input::{Format, InputOptions, MissingZ, PointBatch, PointSource};
use std::io::Cursor;
use std::num::NonZeroU64;
use std::path::{Path, PathBuf};
use std::time::{Duration, UNIX_EPOCH};

fn doubles(numbers: impl IntoIterator<Item = f64>) -> Vec<u8> {
    numbers.into_iter().flat_map(f64::to_le_bytes).collect()
}

/// Returns `n` points whose x counts up from `first`.
fn counted(first: u32, n: u32) -> Vec<u8> {
    doubles((first..first + n).flat_map(|n| [f64::from(n), 1.0]))
}

fn write(dir: &Path, files: &[(&str, &[u8])]) -> Vec<PathBuf> {
    let write = |(name, bytes): &(&str, &[u8])| {
        let path = dir.join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    };
    files.iter().map(write).collect()
}

/// Opens a source of these files; returns it with their folder.
fn source(files: &[(&str, &[u8])], options: &InputOptions) -> (PointSource, tempfile::TempDir) {
    let dir = tempfile::tempdir().unwrap();
    let source = PointSource::open(&write(dir.path(), files), options).unwrap();
    (source, dir)
}

fn of_bytes(bytes: &[u8], format: Format) -> PointSource {
    let options = InputOptions::default().format(format);
    PointSource::from_reader("stream", Box::new(Cursor::new(bytes.to_vec())), &options).unwrap()
}

fn xs(points: &[Point]) -> Vec<f64> {
    points.iter().map(|p| p.x).collect()
}

#[test]
fn a_source_reports_the_number_of_points_left() {
    let raw = counted(0, 10_000);
    let node: &[u8] = b"2 2 0 0\n0 1 2\n1 3 4\n";
    let (mut all, _dir) = source(
        &[("a.f64", &raw), ("b.node", node), ("c.f64", &raw)],
        &InputOptions::default(),
    );
    assert_eq!(all.expected_points(), Some(20_002));
    let mut batch = PointBatch::default();
    let mut left = 20_002;
    while all.next_batch(&mut batch).unwrap() {
        left -= batch.len() as u64;
        assert_eq!(all.expected_points(), Some(left));
    }
    assert_eq!(left, 0);
    let of_none = PointSource::open(&[], &InputOptions::default()).unwrap();
    assert_eq!(of_none.expected_points(), Some(0));

    let options = InputOptions::default().dims(3).skip_invalid(true);
    let (triples, _dir) = source(&[("a.f64", &raw[..24 * 7 + 5])], &options);
    assert_eq!(triples.expected_points(), Some(7));

    let much: &[u8] = b"18446744073709551615 2 0 0\n";
    let (claims, _dir) = source(&[("a.node", much), ("b.node", much)], &InputOptions::default());
    assert_eq!(claims.expected_points(), Some(u64::MAX));
}

#[test]
fn streams_text_and_gzip_have_no_expected_points_and_no_sample() {
    let raw = counted(0, 100);
    let source_of = |files: &[(&str, &[u8])]| source(files, &InputOptions::default());
    let stream = of_bytes(&raw, Format::F64);
    assert_eq!((stream.expected_points(), stream.identity()), (None, None));
    assert_eq!(stream.sample(10).unwrap(), []);
    let (node, _dir) = source_of(&[("a.f64", &raw), ("b.node", b"1 2 0 0\n1 1 1\n")]);
    assert_eq!(node.sample(10).unwrap(), []);
    {
        let (text, _dir) = source_of(&[("a.f64", &raw), ("b.csv", b"1,2\n")]);
        assert_eq!(text.expected_points(), None);
        assert_eq!(text.sample(10).unwrap(), []);
        let (gzip, _dir) = source_of(&[("a.f64.gz", &crate::input::gzip(&raw))]);
        assert_eq!(gzip.expected_points(), None);
        assert_eq!(gzip.sample(10).unwrap(), []);
        assert!(gzip.identity().is_some());
    }
}

/// If a source has no more points than wanted, the sample is all of them.
#[test]
fn a_sample_of_few_points_has_all_of_them_or_about_the_wanted_number() {
    let files: [(&str, &[u8]); 4] = [
        ("a.f64", &counted(0, 37)),
        ("b.f64", &[]),
        ("c.f64", &counted(37, 1)),
        ("d.f64", &counted(38, 62)),
    ];
    let (all, _dir) = source(&files, &InputOptions::default());
    let numbers: Vec<f64> = (0..100).map(f64::from).collect();
    for count in [100, 101, 160, 5000, usize::MAX] {
        assert_eq!(xs(&all.sample(count).unwrap()), numbers);
    }
    for count in [0, 1, 17, 99] {
        let sample = xs(&all.sample(count).unwrap());
        assert!(sample.len().abs_diff(count) <= 1 && sample.is_sorted_by(|a, b| a < b));
    }
    let of_none = PointSource::open(&[], &InputOptions::default()).unwrap();
    assert_eq!(of_none.sample(10).unwrap(), []);
}

/// Each part of the inputs contributes to the sample in proportion to its length, and sampling does
/// not disturb the stream.
#[test]
fn a_sample_is_spread_evenly_over_many_points() {
    let files: [(&str, &[u8]); 3] = [
        ("a.f64", &counted(0, 300_000)),
        ("b.f64", &counted(300_000, 10)),
        ("c.f64", &counted(300_010, 99_990)),
    ];
    let (mut many, dir) = source(&files, &InputOptions::default());
    let sample = many.sample(3200).unwrap();
    let numbers = xs(&sample);
    assert_eq!(numbers.len(), 3200);
    assert!(numbers.is_sorted_by(|a, b| a < b));
    for part in 0..40 {
        let (from, to) = (f64::from(part) * 10_000.0, f64::from(part + 1) * 10_000.0);
        assert_eq!(numbers.iter().filter(|x| (from..to).contains(*x)).count(), 80);
    }
    let positions: std::collections::BTreeSet<u64> = numbers.iter().map(|x| *x as u64 % 2000).collect();
    assert!(positions.len() > 1000, "always the same positions in the parts");

    let most = many.sample(usize::MAX).unwrap();
    assert_eq!(most.len(), 4 << 20 >> 4);

    let mut batch = PointBatch::default();
    assert!(many.next_batch(&mut batch).unwrap());
    assert_eq!((batch.points[0].x, batch.points[8191].x), (0.0, 8191.0));
    assert_eq!(many.sample(3200).unwrap(), sample);
    while many.next_batch(&mut batch).unwrap() {}
    assert_eq!(many.counts().points, 400_000);
    assert_eq!(many.sample(3200).unwrap(), sample);

    std::fs::write(dir.path().join("c.f64"), counted(0, 1)).unwrap();
    assert_eq!(many.sample(3200).unwrap(), sample[..2400]);
    std::fs::remove_file(dir.path().join("c.f64")).unwrap();
    let error = many.sample(3200).unwrap_err().to_string();
    assert!(error.contains("c.f64: cannot be opened"), "{error}");
}

#[test]
fn invalid_points_are_not_in_a_sample() {
    let raw = doubles([
        1.0,
        f64::NAN,
        2.0,
        -0.0,
        f64::INFINITY,
        1.0,
        3.0,
        1e300,
        4.0,
        5.0,
        6.0,
        7.0,
    ]);
    let (pairs, _dir) = source(&[("a.f64", &raw)], &InputOptions::default());
    let found: Vec<_> = pairs.sample(100).unwrap().into_iter().map(bits).collect();
    let expected = [(2.0, 0.0), (4.0, 5.0), (6.0, 7.0)];
    assert_eq!(found, expected.map(|(x, y): (f64, f64)| (x.to_bits(), y.to_bits())));
    let options = InputOptions::default().dims(3);
    let raw = doubles([1.0, 2.0, f64::NAN, 3.0, 4.0, 5.0]);
    let (triples, _dir) = source(&[("a.f64", &raw)], &options);
    assert_eq!(triples.sample(100).unwrap(), [Point::new(3.0, 4.0)]);
}

#[test]
fn any_change_of_files_order_options_or_times_changes_the_identity() {
    let dir = tempfile::tempdir().unwrap();
    let paths = write(dir.path(), &[("a.f64", &counted(0, 5)), ("b.f64", &counted(0, 5))]);
    let identity = |paths: &[PathBuf], options: &InputOptions| {
        let source = PointSource::open(paths, options).unwrap();
        let identity = source.identity().unwrap();
        assert_eq!(drain(source).unwrap().source.identity().unwrap(), identity);
        identity
    };
    let default = InputOptions::default();
    let both = identity(&paths, &default);
    assert_eq!(identity(&paths, &default), both);
    // They change nothing of what is read, and the machine that goes on may have others.
    assert_eq!(identity(&paths, &InputOptions::default().threads(3)), both);
    let skipping = InputOptions::default().skip_invalid(true);
    let swapped = [paths[1].clone(), paths[0].clone()];
    let mut all = vec![
        identity(&paths, &skipping),
        identity(&swapped, &default),
        identity(&paths[..1], &default),
        identity(&paths[1..], &default),
        identity(&[], &default),
    ];
    // Also times before 1970.
    for microseconds in [1, 1_000_001] {
        for time in [
            UNIX_EPOCH + Duration::from_micros(microseconds),
            UNIX_EPOCH - Duration::from_micros(microseconds),
        ] {
            let file = std::fs::File::options().write(true).open(&paths[1]).unwrap();
            file.set_modified(time).unwrap();
            all.push(identity(&paths, &default));
        }
    }
    std::fs::write(&paths[1], counted(0, 6)).unwrap();
    all.push(identity(&paths, &default));
    all.push(both);
    for (n, one) in all.iter().enumerate() {
        assert!(!all[..n].contains(one), "{one}");
    }
}

#[test]
fn las_files_report_expected_points_and_samples() {
    use crate::input::data;
    let open = |name: &str, options: &InputOptions| PointSource::open(&[data(name)], options).unwrap();
    let chosen = InputOptions::default().classes(vec![1, 2]);
    for options in [&InputOptions::default(), &chosen] {
        let plain = open("las/autzen.las", options);
        let sample = plain.sample(100_000).unwrap();
        let some = plain.sample(64).unwrap().len();
        let expected = plain.expected_points().unwrap();
        let read = drain(plain).unwrap();
        assert!(!sample.is_empty() && some <= 64);
        assert_eq!(sample.iter().map(|p| (p.x, p.y)).collect::<Vec<_>>(), read.points);
        assert_eq!(expected, read.source.counts().records);
    }
    let compressed = open("las/autzen.laz", &chosen);
    assert_eq!(compressed.sample(100).unwrap(), []);
    let expected = compressed.expected_points().unwrap();
    assert_eq!(expected, drain(compressed).unwrap().source.counts().records);
}

/// They stand in for a sample where there is none.
#[test]
fn positions_are_spread_over_the_extents_that_inputs_announce() {
    use crate::input::data;
    let las = [data("las/autzen.laz"), data("las/autzen.las")];
    let source = PointSource::open(&las, &InputOptions::default()).unwrap();
    let points = drain(PointSource::open(&las[..1], &InputOptions::default()).unwrap())
        .unwrap()
        .points;
    let around = |points: &[(f64, f64)]| Rect::around(points.iter().map(|&(x, y)| Point::new(x, y)));
    let extent = around(&points);
    let positions = source.expected_positions(1000);
    assert!((1000..1003).contains(&positions.len()), "{}", positions.len());
    let (width, height) = extent.size();
    let mut quarters = [0; 4];
    for p in positions {
        // Headers are rounded.
        assert!(
            (p.x - extent.min_x) / width > -0.01 && (p.x - extent.max_x) / width < 0.01,
            "{p:?}"
        );
        assert!(
            (p.y - extent.min_y) / height > -0.01 && (p.y - extent.max_y) / height < 0.01,
            "{p:?}"
        );
        let is_high = |at: f64, low: f64, size: f64| usize::from(at > low + size / 2.0);
        quarters[2 * is_high(p.x, extent.min_x, width) + is_high(p.y, extent.min_y, height)] += 1;
    }
    assert!(
        quarters.iter().all(|&count| (240..260).contains(&count)),
        "{quarters:?}"
    );
    let within = Rect::new(extent.min_x, extent.min_y, extent.min_x + width / 2.0, extent.max_y);
    let half = PointSource::open(&las, &InputOptions::default().bounds(within)).unwrap();
    assert!(half.expected_positions(1000).iter().all(|&p| within.contains(p)));
    // Only where all inputs announce them.
    let dir = tempfile::tempdir().unwrap();
    let raw = write(dir.path(), &[("a.f64", &counted(0, 9))]);
    let both = PointSource::open(&[las[0].clone(), raw[0].clone()], &InputOptions::default()).unwrap();
    assert_eq!(both.expected_positions(10), []);
    assert_eq!(
        PointSource::open(&[], &InputOptions::default())
            .unwrap()
            .expected_positions(10),
        []
    );
}

#[test]
fn one_of_the_inputs_gives_the_points_that_it_gives_among_all() {
    let dir = tempfile::tempdir().unwrap();
    let files = [
        ("a.f64", counted(0, 9000)),
        ("b.f64", counted(9000, 30)),
        ("c.f64", counted(9030, 8200)),
    ];
    let files = files.each_ref().map(|(name, bytes)| (*name, &bytes[..]));
    let paths = write(dir.path(), &files);
    let every = InputOptions::default().every(NonZeroU64::new(7).unwrap());
    for options in [InputOptions::default(), every] {
        let all = drain(PointSource::open(&paths, &options).unwrap()).unwrap();
        let (mut points, mut sources) = (Vec::new(), Vec::new());
        let mut first = 0;
        for input in 0..3 {
            let source = PointSource::open(&paths[input..=input], &options).unwrap();
            let announced = source.expected_records()[0].unwrap();
            let read = drain(source.as_part(first, false)).unwrap();
            let counts = read.source.counts();
            assert_eq!(counts.records, announced);
            assert_eq!(counts.points + counts.filtered, counts.records);
            points.extend(read.points);
            sources.extend(read.source.sources().to_vec());
            first += announced;
        }
        assert!(points == all.points);
        assert_eq!(sources, all.source.sources());
    }
    // Others have z.
    let paths = write(dir.path(), &[("d.csv", b"x,y\n1,2\n"), ("e.csv", b"x,y,z\n3,4,5\n")]);
    let zero = InputOptions::default().missing_z(MissingZ::Zero);
    let all = PointSource::open(&paths, &zero).unwrap();
    let part = PointSource::open(&paths[..1], &zero).unwrap().as_part(0, all.has_z());
    let [all, part] = [all, part].map(|source| drain(source).unwrap());
    assert_eq!((&part.z[..], part.z.len()), (&all.z[..1], 1));
}
