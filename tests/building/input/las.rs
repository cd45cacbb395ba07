//! LAS, LAZ and COPC.

use crate::input::{Read, assert_says, data, drain, file, shared, stream, with_format};
use delaunay_tiles::input::{Format, InputError, InputOptions, PointBatch, PointSource, Returns};
use std::path::Path;

fn open(path: &Path, options: &InputOptions) -> Result<Read, InputError> {
    PointSource::open(&[path.to_owned()], options).and_then(drain)
}

/// Returns all points as the crate `las` itself reads them.
fn expected(path: &Path) -> Vec<las::Point> {
    let mut reader = las::Reader::from_path(path).unwrap();
    reader.read_all().unwrap().points().map(Result::unwrap).collect()
}

const FILES: [&str; 5] = [
    "las/32-1-472-150-76.laz",
    "las/autzen.copc.laz",
    "las/autzen.las",
    "las/autzen.laz",
    "las/extrabytes.laz",
];

#[test]
fn points_equal_those_of_the_las_crate() {
    for name in FILES {
        let path = data(name);
        let read = open(&path, &InputOptions::default()).unwrap();
        let all = expected(&path);
        let kept: Vec<_> = all.iter().enumerate().filter(|(_, p)| !p.is_withheld).collect();
        assert!(!kept.is_empty());
        assert_eq!(read.points.len(), kept.len(), "{name}");
        for (n, (record, point)) in kept.iter().enumerate() {
            assert_eq!(
                (read.points[n], read.z[n]),
                ((point.x, point.y), point.z),
                "{name}: {n}"
            );
            assert_eq!(read.records[n], *record as u64);
        }
        assert_eq!(read.source.counts().records, all.len() as u64);
        assert_eq!(read.source.counts().withheld, (all.len() - kept.len()) as u64);
        println!("{name}: {} points, crs {:?}", all.len(), read.source.crs_of_files());
    }
}

#[test]
fn classes_and_returns_filter_the_points() {
    for name in FILES {
        let path = data(name);
        let all = expected(&path);
        let count = |keep: &dyn Fn(&las::Point) -> bool| all.iter().filter(|p| !p.is_withheld && keep(p)).count();
        for returns in [Returns::First, Returns::Last] {
            let options = InputOptions::default().returns(returns);
            let read = open(&path, &options).unwrap();
            let kept = count(&|p| match returns {
                Returns::First => p.return_number == 1,
                _ => p.return_number == p.number_of_returns,
            });
            assert_eq!(read.points.len(), kept, "{name} {returns}");
        }
        let options = InputOptions::default().classes(vec![1, 2]);
        let read = open(&path, &options).unwrap();
        let kept = count(&|p| matches!(u8::from(p.classification), 1 | 2));
        assert_eq!(read.points.len(), kept, "{name}");
        let counts = read.source.counts();
        assert_eq!(counts.filtered + counts.withheld, (all.len() - kept) as u64);
    }
}

#[test]
fn reference_systems_are_read_from_the_header() {
    let crs = |name: &str| {
        let source = PointSource::open(&[data(name)], &InputOptions::default()).unwrap();
        source.crs_of_files().first().map(|(_, crs)| crs.clone())
    };
    assert_eq!(crs("las/32-1-472-150-76.laz").as_deref(), Some("EPSG:25832"));
    assert!(
        crs("las/autzen.copc.laz")
            .unwrap()
            .contains(r#"AUTHORITY["EPSG","2992"]"#)
    );
}

#[test]
fn all_110_000_points_of_a_larger_file_are_read() {
    let Some(path) = shared("lidar/autzen_trim.laz") else {
        return;
    };
    let read = open(&path, &InputOptions::default()).unwrap();
    assert_eq!(read.points.len(), 110_000);
    let ground = InputOptions::default().classes(vec![2]);
    let read = open(&path, &ground).unwrap();
    assert_eq!(read.points.len(), 26_107);
    assert_eq!(read.source.counts().filtered, 110_000 - 26_107);
}

#[test]
fn files_and_streams_that_are_no_las_file_are_refused() {
    let bytes = std::fs::read(data("las/autzen.las")).unwrap();
    assert_says(
        stream(&bytes, &with_format(Format::Las)),
        &["stream: LAS is not read from a stream; give the name of a file"],
    );
    assert_says(
        stream(&bytes, &InputOptions::default()),
        &["LAS is not read from a stream"],
    );
    for no_las in [&b""[..], b"LAS", b"x,y\n1,2\n"] {
        assert_says(
            file("a.las", no_las, &InputOptions::default()),
            &["a.las: the file does not begin with `LASF`; this is not a LAS or LAZ file"],
        );
    }
}

/// Returns the bytes of a file, with each change written at its offset. (`autzen.las` has version
/// 1.2 and format 1.)
fn changed(name: &str, changes: &[(usize, &[u8])]) -> Vec<u8> {
    let mut bytes = std::fs::read(data(name)).unwrap();
    for (at, change) in changes {
        bytes[*at..at + change.len()].copy_from_slice(change);
    }
    bytes
}

#[test]
fn headers_with_false_values_are_refused() {
    let las = |changes: &[(usize, &[u8])]| file("a.las", changed("las/autzen.las", changes), &InputOptions::default());
    assert_says(
        las(&[(107, &[0xff; 4])]),
        &["4294967295 points of 28 bytes from byte", "do not fit into 4962 bytes"],
    );
    assert_says(las(&[(105, &[0xff; 2])]), &["point records of 65535 bytes"]);
    assert_says(
        las(&[(105, &[2, 0])]),
        &["point records of 2 bytes; format 1 needs at least 28"],
    );
    assert_says(las(&[(104, &[11])]), &["point format 11; 10 is the highest"]);
    assert_says(
        las(&[(25, &[7])]),
        &["this is LAS version 1.7", "versions 1.0 to 1.4 are read"],
    );
    assert_says(
        las(&[(100, &[0xff; 4])]),
        &["variable length record", "is not before the points"],
    );
    assert_says(las(&[(96, &[0xff; 4])]), &["do not fit into 4962 bytes"]);
    assert_says(las(&[(94, &[9, 0])]), &["a header of 9 bytes; it needs at least 227"]);
    assert_says(
        las(&[(131, &f64::NAN.to_le_bytes())]),
        &["the scale or the offset", "not finite"],
    );
    // A scale that makes all coordinates too large is an error of the records.
    assert_says(
        las(&[(131, &1e300f64.to_le_bytes())]),
        &["record 0 (point 0): x is", "2^200"],
    );
    // The file is compressed according to the header only.
    assert_says(
        las(&[(104, &[0x81])]),
        &["compressed points, but no record that describes the compression"],
    );
}

#[test]
fn a_file_cut_short_is_refused() {
    let bytes = std::fs::read(data("las/autzen.las")).unwrap();
    assert_says(
        file("a.las", &bytes[..bytes.len() - 1], &InputOptions::default()),
        &["do not fit into 4961 bytes; the file is cut short"],
    );
}

/// The crate `laz` trusts the number of chunks and the sizes of layers: it allocates 16 bytes for
/// each chunk, and the claimed size of a layer.
#[test]
fn claims_within_compressed_points_that_exceed_the_file_are_refused() {
    let name = "las/autzen.copc.laz";
    let bytes = std::fs::read(data(name)).unwrap();
    let u32_at = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let (start, length) = (u32_at(96), usize::from(bytes[105]));
    let table = u32_at(start);
    assert_says(
        file(
            "a.laz",
            changed(name, &[(table + 4, &[0xff; 4])]),
            &InputOptions::default(),
        ),
        &["a table of 4294967295 chunks in a file of 4368 bytes"],
    );
    let layers = start + 8 + length + 4;
    assert_says(
        file(
            "a.laz",
            changed(name, &[(layers + 4, &[0xff; 4])]),
            &InputOptions::default(),
        ),
        &["a chunk of", "bytes are left in the file"],
    );
}

/// The crate `laz` panicked at the chunk size of such files, which have no chunks, and printed the
/// panic.
#[test]
fn a_file_of_the_old_compressor_without_chunks_is_read() {
    let path = data("las/pointwise-1.2.laz");
    let read = open(&path, &InputOptions::default()).unwrap();
    assert_eq!(read.points.len(), 1065);
    let header = std::fs::read(path).unwrap();
    let number = |at: usize| f64::from_le_bytes(header[at..at + 8].try_into().unwrap());
    let range = |values: &mut dyn Iterator<Item = f64>| {
        values.fold([f64::NEG_INFINITY, f64::INFINITY], |[max, min], v| {
            [max.max(v), min.min(v)]
        })
    };
    let found = [
        range(&mut read.points.iter().map(|p| p.0)),
        range(&mut read.points.iter().map(|p| p.1)),
        range(&mut read.z.iter().copied()),
    ];
    for (n, found) in found.as_flattened().iter().enumerate() {
        assert!((found - number(179 + 8 * n)).abs() < 1e-6, "{n}: {found}");
    }
}

#[test]
fn panic_is_caught_is_true_during_each_panic_of_the_decoder() {
    let path = data("las/autzen.laz");
    let whole = std::fs::read(&path).unwrap();
    let start = u32::from_le_bytes(whole[96..100].try_into().unwrap()) as usize;
    let before = std::panic::take_hook();
    static UNCAUGHT: std::sync::atomic::AtomicUsize = std::sync::atomic::AtomicUsize::new(0);
    static CAUGHT: std::sync::atomic::AtomicUsize = std::sync::atomic::AtomicUsize::new(0);
    let here = std::thread::current().id();
    std::panic::set_hook(Box::new(move |panic| {
        if std::thread::current().id() != here {
            return before(panic);
        }
        let count = if delaunay_tiles::input::panic_is_caught() {
            &CAUGHT
        } else {
            &UNCAUGHT
        };
        count.fetch_add(1, std::sync::atomic::Ordering::SeqCst);
    }));
    let mut random = crate::input::hostile::Random(7);
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("damaged.laz");
    for _ in 0..3000 {
        let mut bytes = whole.clone();
        for _ in 0..20 {
            let at = start + 8 + random.below(whole.len() - start - 8);
            bytes[at] = random.next() as u8;
        }
        std::fs::write(&path, bytes).unwrap();
        drop(open(&path, &InputOptions::default()));
        if CAUGHT.load(std::sync::atomic::Ordering::SeqCst) > 0 {
            break;
        }
    }
    assert!(!delaunay_tiles::input::panic_is_caught());
    drop(std::panic::take_hook());
    let counts = [&CAUGHT, &UNCAUGHT].map(|count| count.load(std::sync::atomic::Ordering::SeqCst));
    assert_eq!(counts[1], 0);
    println!("{} panics were caught", counts[0]);
}

#[test]
fn a_scale_of_zero_is_an_error() {
    let whole = std::fs::read(data("las/autzen.las")).unwrap();
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        for zero in [0.0f64, -0.0] {
            let mut bytes = whole.clone();
            bytes[131 + 8 * axis..139 + 8 * axis].copy_from_slice(&zero.to_le_bytes());
            let says = format!("the scale of {name} is 0");
            assert_says(file("a.las", bytes, &InputOptions::default()), &["a.las", &says]);
        }
    }
}

/// The crate `las` writes the points of the COPC file as LAS and LAZ.
#[test]
fn one_cloud_has_the_same_records_in_las_laz_and_copc() {
    let folder = tempfile::tempdir().unwrap();
    let copc = data("las/autzen.copc.laz");
    let header = las::Reader::from_path(&copc).unwrap().header().clone();
    let read = open(&copc, &InputOptions::default()).unwrap();
    for name in ["cloud.las", "cloud.laz"] {
        let mut builder = las::Builder::from((1, 4));
        builder.point_format = *header.point_format();
        builder.point_format.is_compressed = name.ends_with("laz");
        builder.transforms = *header.transforms();
        let path = folder.path().join(name);
        let mut writer = las::Writer::from_path(&path, builder.into_header().unwrap()).unwrap();
        for point in expected(&copc) {
            writer.write_point(point).unwrap();
        }
        drop(writer);
        let written = open(&path, &InputOptions::default()).unwrap();
        assert!(!written.points.is_empty());
        assert_eq!(written.points, read.points, "{name}");
        assert_eq!(written.z, read.z, "{name}");
        assert_eq!(written.records, read.records, "{name}");
    }
}

/// Writes points in chunks of 50,000, the last one smaller.
fn write_chunks(path: &Path, format: u8, count: i32) {
    let mut builder = las::Builder::from((1, if format < 6 { 2 } else { 4 }));
    builder.point_format = las::point::Format::new(format).unwrap();
    builder.point_format.is_compressed = true;
    let mut writer = las::Writer::from_path(path, builder.into_header().unwrap()).unwrap();
    for n in 0..count {
        let [x, y, z] = [n % 1013, n / 1013, n * 7919 % 1009].map(f64::from);
        writer
            .write_point(las::Point {
                x,
                y,
                z,
                gps_time: Some(z),
                ..las::Point::default()
            })
            .unwrap();
    }
}

#[test]
fn chunks_give_the_same_points_whatever_the_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    for format in [1, 6] {
        let path = folder.path().join(format!("{format}.laz"));
        write_chunks(&path, format, 170_001);
        let read = |threads: usize| open(&path, &InputOptions::default().threads(threads)).unwrap();
        let expected = read(1);
        assert_eq!(expected.points.len(), 170_001);
        for threads in [0, 2, 9] {
            let read = read(threads);
            assert!(
                read.points == expected.points && read.z == expected.z,
                "{threads} threads"
            );
            assert_eq!(read.records, expected.records);
            assert_eq!(read.source.bytes_read(), expected.source.bytes_read());
        }
    }
}

/// The points before the damage come first, then the error, although later chunks are decoded at the
/// same time.
#[test]
fn a_damaged_chunk_is_an_error_behind_the_points_before_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.laz");
    write_chunks(&path, 6, 170_001);
    let mut bytes = std::fs::read(&path).unwrap();
    // The sizes of the layers of the third chunk, behind its first point and its number of points.
    let start = u32::from_le_bytes(bytes[96..100].try_into().unwrap()) as usize + 8;
    let layers = |bytes: &[u8], chunk: usize| -> usize {
        let sizes = &bytes[chunk + 34..chunk + 34 + 9 * 4];
        let size = |n: usize| u32::from_le_bytes(sizes[4 * n..4 * n + 4].try_into().unwrap()) as usize;
        chunk + 34 + 9 * 4 + (0..9).map(size).sum::<usize>()
    };
    let third = layers(&bytes, layers(&bytes, start));
    bytes[third + 34..third + 38].fill(0xff);
    std::fs::write(&path, &bytes).unwrap();
    for threads in [1, 2, 9] {
        let mut source =
            PointSource::open(std::slice::from_ref(&path), &InputOptions::default().threads(threads)).unwrap();
        let (mut batch, mut count) = (PointBatch::default(), 0);
        let error = loop {
            match source.next_batch(&mut batch) {
                Ok(true) => count += batch.len(),
                Ok(false) => panic!("no error"),
                Err(error) => break error,
            }
        };
        assert!(
            count > 91_000 && count <= 100_000,
            "{count} points with {threads} threads"
        );
        assert!(error.to_string().contains("a chunk of"), "{error}");
    }
}
