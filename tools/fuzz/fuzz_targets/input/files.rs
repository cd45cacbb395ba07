//! Hostile input files: good files of every format with changes that the fuzzer chooses, or bytes
//! that it makes up, read as every kind of record. Any records and any error are accepted.

use delaunay_tiles::geometry::Rect;
use delaunay_tiles::input::{
    Format, InputOptions, MissingZ, PointBatch, PointSource, PolySource, SegmentBatch, SegmentSource, SiteBatch,
    SiteSource, panic_is_caught,
};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// A good file, as a suffix and bytes, with those beside it.
type Sample = &'static [(&'static str, &'static [u8])];

macro_rules! data {
    ($name:literal) => {
        include_bytes!(concat!("../../../../tests/data/", $name))
    };
}

const SAMPLES: [Sample; 33] = [
    &[("csv", data!("formats/points.csv"))],
    &[("csv", b"0,0,5,5\n1.5,2e3,\"3\",4\n# c\n5,5,0,1\n")],
    &[("csv", b"x,y,name\n1,2,a\n3,4,\"b, c\"\n5,6,7\n")],
    &[(
        "f64",
        b"\0\0\0\0\0\0\xf0\x3f\0\0\0\0\0\0\xf0\x3f\0\0\0\0\0\0\xf0\x3f\0\0\0\0\0\0\xf0\x3f",
    )],
    &[("u32", b"\0\0\0\0\x01\0\0\0\x01\0\0\0\x02\0\0\0")],
    &[("geojson", data!("formats/lines.geojson"))],
    &[("geojson", data!("formats/mixed.geojson"))],
    &[("fgb", data!("formats/lines.fgb"))],
    &[("fgb", data!("formats/lines_indexed.fgb"))],
    &[("fgb", data!("formats/mixed.fgb"))],
    &[("fgb", data!("formats/sites.fgb"))],
    &[("shp", data!("formats/lines.shp")), ("prj", data!("formats/lines.prj"))],
    &[("shp", data!("formats/polygons.shp"))],
    &[("shp", data!("formats/clusters.shp"))],
    &[
        ("shp", data!("formats/sites.shp")),
        ("dbf", data!("formats/sites.dbf")),
        ("prj", data!("formats/sites.prj")),
    ],
    &[("gpkg", data!("formats/lines.gpkg"))],
    &[("gpkg", data!("formats/all.gpkg"))],
    &[("las", data!("las/autzen.las"))],
    &[("laz", data!("las/autzen.laz"))],
    &[("laz", data!("las/autzen.copc.laz"))],
    &[("laz", data!("las/pointwise-1.2.laz"))],
    &[("laz", data!("las/extrabytes.laz"))],
    &[("parquet", data!("formats/columns.parquet"))],
    &[("parquet", data!("formats/columns_decimal.parquet"))],
    &[("parquet", data!("formats/columns_f32.parquet"))],
    &[("parquet", data!("formats/geo_wkb.parquet"))],
    &[("parquet", data!("formats/geo_point.parquet"))],
    &[("parquet", data!("formats/geo_multipoint.parquet"))],
    &[("ply", data!("formats/tin.ply"))],
    &[("ply", data!("formats/tin_ascii.ply"))],
    &[("obj", data!("formats/tin.obj"))],
    &[
        ("node", b"4 3 1 1\n1 0 0 7 1 1\n2 1 0 7 1 1\n3 1 1 7 1 1\n4 0 1 7 1 1\n"),
        ("ele", b"2 3 0\n1 1 2 3\n2 1 3 4\n"),
    ],
    &[(
        "poly",
        b"4 2 0 1\n1 0 0 1\n2 9 0 1\n3 9 9 1\n4 0 9 1\n2 0\n1 1 2\n2 2 3\n1\n1 2.5 2.5\n0\n",
    )],
];

/// The limit on the records of a file, which has fewer bytes. Files with compression may exceed it.
const MOST_RECORDS: u64 = 1 << 20;

/// Lets panics pass that a reader catches; the fuzzer's hook ends the process. To be called once.
pub fn expect_caught_panics() {
    let end = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if !panic_is_caught() {
            end(panic);
        }
    }));
}

/// Writes the files that the data tells, and reads them as the kind of record that it tells.
pub fn run(data: &[u8]) {
    let Some((&[sample, kind], rest)) = data.split_first_chunk::<2>() else {
        return;
    };
    let number = usize::from(sample) % SAMPLES.len();
    let mut files: Vec<(&str, Vec<u8>)> = SAMPLES[number]
        .iter()
        .map(|&(suffix, bytes)| (suffix, bytes.to_vec()))
        .collect();
    // A fourth of the values means a file of the fuzzer's own.
    match sample < 192 {
        true => rest.chunks_exact(6).for_each(|change| apply(change, &mut files)),
        false => files[0].1 = rest.to_vec(),
    }
    let folder = folder().join(number.to_string());
    fs::create_dir_all(&folder).expect("room for a folder");
    let path = |suffix: &str| folder.join("input").with_extension(suffix);
    for (suffix, bytes) in &files {
        fs::write(path(suffix), bytes).expect("room for a file");
    }
    let (suffix, bytes) = &files[0];
    let may_expand = bytes.starts_with(&[0x1f, 0x8b]) || *suffix == "parquet" || *suffix == "laz";
    let most = if may_expand { None } else { Some(MOST_RECORDS) };
    read(&path(suffix), bytes, kind, most);
}

fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| std::env::temp_dir().join(format!("fuzz-{}-input", std::process::id())))
}

/// Applies a change of six bytes: three of them are an offset, then come an operation and two
/// values.
fn apply(change: &[u8], files: &mut [(&str, Vec<u8>)]) {
    let mut at = usize::from(change[0]) | usize::from(change[1]) << 8 | usize::from(change[2]) << 16;
    at %= files.iter().map(|(_, bytes)| bytes.len()).sum::<usize>().max(1);
    for (_, bytes) in files {
        if at < bytes.len() {
            return apply_at(at, change[3], [change[4], change[5]], bytes);
        }
        at -= bytes.len();
    }
}

fn apply_at(at: usize, operation: u8, values: [u8; 2], bytes: &mut Vec<u8>) {
    let [value, other] = values;
    let length = bytes.len();
    let end = |width: usize| length.min(at + width);
    match operation % 9 {
        0 => bytes[at] = value,
        1 => bytes[at] ^= 1 << (value % 8),
        2 => bytes[at] = bytes[at].wrapping_add(value),
        3 => bytes[at..end(8)].fill(value),
        // A number of either byte order, of two or four bytes.
        4 => {
            let number = [value, other, other, value];
            let width = end(if value % 2 == 0 { 2 } else { 4 }) - at;
            bytes[at..at + width].copy_from_slice(&number[..width]);
        }
        5 => bytes.truncate(at),
        6 => drop(bytes.drain(at..end(usize::from(value)))),
        7 => {
            let from = usize::from(u16::from_le_bytes(values)) % length;
            let width = (length - from.max(at)).min(16);
            bytes.copy_within(from..from + width, at);
        }
        _ => {
            let copy = bytes[at..end(usize::from(value))].repeat(usize::from(other % 8));
            bytes.splice(at..at, copy);
        }
    }
}

/// Reads a file as the kind of record that `kind` tells.
fn read(path: &Path, bytes: &[u8], kind: u8, most: Option<u64>) {
    let paths = [path.to_owned()];
    let options = InputOptions::default()
        .skip_invalid(kind & 0x40 != 0)
        .missing_z(if kind & 0x80 == 0 {
            MissingZ::Error
        } else {
            MissingZ::Zero
        })
        .dims(2 + (kind >> 5 & 1));
    match kind % 8 {
        0 => points(PointSource::open(&paths, &options), most),
        1 => points(
            PointSource::open(&paths, &options.bounds(Rect::new(0.0, 0.0, 9.0, 1e6))),
            most,
        ),
        2 => {
            let options = options.format(Format::from_path(path));
            let stream = Box::new(std::io::Cursor::new(bytes.to_vec()));
            points(PointSource::from_reader("stream", stream, &options), most);
        }
        3 => segments(SegmentSource::open(&paths), most),
        4 => segments(SegmentSource::open_obstacles(&paths), most),
        5 => sites(SiteSource::open(&paths, Some("name")), most),
        6 => sites(SiteSource::open(&paths, None), most),
        _ if path.extension().is_some_and(|suffix| suffix == "poly") => poly(path),
        _ => segments(SegmentSource::open_edges(path, None).map(|(source, _)| source), most),
    }
}

/// Returns whether to read on. Fails if a file gives more records than it can have.
fn goes_on(records: u64, most: Option<u64>) -> bool {
    assert!(most.is_none_or(|most| records < most), "{records} records");
    records < MOST_RECORDS
}

fn points<E: std::fmt::Display>(source: Result<PointSource, E>, most: Option<u64>) {
    let Ok(mut source) = source.map_err(|error| error.to_string()) else {
        return;
    };
    let _ = source.sample(100);
    let _ = (source.expected_points(), source.identity());
    let mut batch = PointBatch::default();
    while source.next_batch(&mut batch).is_ok_and(|any| any) && goes_on(source.counts().records, most) {
        assert!(batch.points.iter().all(|point| point.is_valid()));
        assert!(batch.z.iter().all(|z| z.is_finite()));
    }
    let _ = (source.notes(), source.crs_of_files());
}

fn segments<E: std::fmt::Display>(source: Result<SegmentSource, E>, most: Option<u64>) {
    let Ok(mut source) = source.map_err(|error| error.to_string()) else {
        return;
    };
    let mut batch = SegmentBatch::default();
    while source.next_batch(&mut batch).is_ok_and(|any| any) && goes_on(source.segments(), most) {
        assert!(batch.ends.iter().flatten().all(|point| point.is_valid()));
        assert!(batch.lines.iter().all(|&line| source.origin(line).is_some()));
    }
    let _ = (source.notes(), source.crs_of_files());
}

fn sites<E: std::fmt::Display>(source: Result<SiteSource, E>, most: Option<u64>) {
    let Ok(mut source) = source.map_err(|error| error.to_string()) else {
        return;
    };
    let mut batch = SiteBatch::default();
    while source.next_batch(&mut batch).is_ok_and(|any| any) && goes_on(source.sites(), most) {
        assert!(batch.points.iter().all(|point| point.is_valid()));
    }
    let _ = (source.notes(), source.crs_of_files());
}

fn poly(path: &Path) {
    let Ok(mut source) = PolySource::open(path) else { return };
    let mut batch = SegmentBatch::default();
    while source.next_batch(&mut batch).is_ok_and(|any| any) {}
    let _ = source.holes();
}
