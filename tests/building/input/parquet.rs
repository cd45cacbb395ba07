//! Parquet and GeoParquet, written by pyarrow (`tests/data/formats/make_points.py`).

use crate::input::{Read, assert_says, data, drain, file, stream, with_format};
use delaunay_tiles::input::{Format, InputError, InputOptions, PointSource};
use std::fs;

pub const FILES: [&str; 6] = [
    "columns.parquet",
    "columns_f32.parquet",
    "columns_decimal.parquet",
    "geo_wkb.parquet",
    "geo_multipoint.parquet",
    "geo_point.parquet",
];

fn open(name: &str, options: &InputOptions) -> Result<Read, InputError> {
    PointSource::open(&[data(&format!("formats/{name}"))], options).and_then(drain)
}

/// Returns the points that all the files have.
fn points() -> Vec<([f64; 2], f64)> {
    let text = fs::read_to_string(data("formats/points.csv")).unwrap();
    let row = |row: &str| {
        let numbers: Vec<f64> = row.split(',').map(|field| field.parse().unwrap()).collect();
        ([numbers[0], numbers[1]], numbers[2])
    };
    text.lines().skip(1).map(row).collect()
}

#[test]
fn points_come_from_columns_and_geometries() {
    for name in FILES {
        let read = open(name, &InputOptions::default()).unwrap();
        let has_all = name != "geo_wkb.parquet";
        let expected = points().into_iter().enumerate();
        let expected: Vec<_> = expected
            .filter(|(n, _)| has_all || n % 7 != 6)
            .map(|(_, p)| p)
            .collect();
        let found: Vec<_> = read.points.iter().zip(&read.z).map(|(p, z)| ([p.0, p.1], *z)).collect();
        assert_eq!(found, expected, "{name}");
        assert!(read.records.iter().copied().eq(0..expected.len() as u64), "{name}");
        let crs = match name {
            "geo_wkb.parquet" => Some("EPSG:25833".to_owned()),
            "geo_multipoint.parquet" => Some("OGC:CRS84".to_owned()),
            "geo_point.parquet" => {
                let text = &read.source.crs_of_files()[0].1;
                assert!(text.starts_with('{') && text.contains("UTM zone 33N"), "{text}");
                Some(text.clone())
            }
            _ => None,
        };
        assert_eq!(
            read.source.crs_of_files().first().map(|(_, crs)| crs),
            crs.as_ref(),
            "{name}"
        );
        let note = match name {
            "geo_wkb.parquet" => Some("28 rows have no geometry"),
            "geo_multipoint.parquet" => Some("1 rows have no geometry"),
            _ => None,
        };
        let notes = read.source.notes();
        assert_eq!(notes.len(), usize::from(note.is_some()), "{name}: {notes:?}");
        assert!(note.is_none_or(|note| notes[0].ends_with(note)), "{name}: {notes:?}");
    }
}

#[test]
fn columns_are_chosen_by_name_and_number() {
    let read = |columns: &str| {
        open(
            "columns.parquet",
            &InputOptions::default().columns(Some(columns.parse().unwrap())),
        )
    };
    let by_name = read("Z,ID").unwrap();
    let by_number = read("4,1").unwrap();
    assert_eq!(by_name.points, by_number.points);
    assert!(by_name.z.is_empty());
    let z: Vec<f64> = points().iter().map(|(_, z)| *z).collect();
    assert!(by_name.points.iter().enumerate().all(|(n, p)| *p == (z[n], n as f64)));
    assert_says(
        read("x,5"),
        &["columns.parquet: no column `5` among `id, x, y, z`; name the columns"],
    );
    assert_says(read("x,w"), &["no column `w` among `id, x, y, z`"]);
    let parts = InputOptions::default().columns(Some("geometry.x,geometry.z".parse().unwrap()));
    let parts = open("geo_point.parquet", &parts).unwrap();
    assert_eq!(parts.points[7], (points()[7].0[0], z[7]));
    let no_number = InputOptions::default().columns(Some("name,geometry.x".parse().unwrap()));
    assert_says(
        open("geo_point.parquet", &no_number),
        &["the column `name` is not a number in each row"],
    );
}

#[test]
fn files_and_streams_that_are_no_parquet_file_are_refused() {
    let bytes = fs::read(data("formats/columns.parquet")).unwrap();
    for options in [with_format(Format::Parquet), InputOptions::default()] {
        assert_says(
            stream(&bytes, &options),
            &["stream: Parquet is not read from a stream; give the name of a file"],
        );
    }
    for no_parquet in [&b""[..], b"PAR1", b"PAR1PAR1", b"x,y\n1,2\n", &bytes[..bytes.len() - 1]] {
        assert_says(
            file("a.parquet", no_parquet, &InputOptions::default()),
            &["a.parquet: "],
        );
    }
    let mut longer = bytes.clone();
    let at = longer.len() - 8;
    longer[at..at + 4].copy_from_slice(&7_000_000u32.to_le_bytes());
    assert_says(
        file("a.parquet", &longer, &InputOptions::default()),
        &["metadata of 7000000 bytes in a file of"],
    );
    longer[at..at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
    assert_says(
        file("a.parquet", &longer, &InputOptions::default()),
        &["metadata of 4294967295 bytes; the limit is 8388608"],
    );
}

/// The crate would recurse into each group.
#[test]
fn a_schema_of_many_nested_groups_is_refused() {
    // Field 2, a list of structures with a name (field 4) and one child each (field 5).
    let count = 200_000u32;
    let mut metadata = vec![0x29, 0xfc];
    let mut rest = count;
    while rest >= 0x80 {
        metadata.push(rest as u8 | 0x80);
        rest >>= 7;
    }
    metadata.push(rest as u8);
    (0..count).for_each(|_| metadata.extend([0x48, 1, b'a', 0x15, 2, 0]));
    metadata.push(0);
    let mut bytes = b"PAR1".to_vec();
    bytes.extend(&metadata);
    bytes.extend((metadata.len() as u32).to_le_bytes());
    bytes.extend(b"PAR1");
    assert_says(
        file("a.parquet", &bytes, &InputOptions::default()),
        &["a.parquet: a schema of 200000 elements, nested 200000 deep"],
    );
}

/// The header of the first page comes right behind the file's first 4 bytes.
#[test]
fn a_page_that_claims_too_much_is_refused() {
    let mut bytes = fs::read(data("formats/columns.parquet")).unwrap();
    let x = bytes.windows(2).position(|window| window == [0x15, 0]).unwrap();
    // The type of the page, then its size before compression: 2^31 - 1, in as many bytes as before
    // and three of the next numbers, which then make no sense.
    bytes[x + 2..x + 8].copy_from_slice(&[0x15, 0xfe, 0xff, 0xff, 0xff, 0x0f]);
    let options = InputOptions::default().columns(Some("id,x".parse().unwrap()));
    assert_says(
        file("a.parquet", &bytes, &options),
        &["a.parquet: row 0: the rows from here on cannot be read"],
    );
}
