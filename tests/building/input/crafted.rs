//! Files of vector data that nobody writes by accident: each would once have been read without an
//! end, in any amount of memory, or with features left out.

use crate::input::{gzip, segments, sites};
use crate::support::test_data::data;
use delaunay_tiles::input::{InputError, InputOptions, PointSource, SegmentSource, SiteSource};
use std::fs;
use std::path::{Path, PathBuf};

fn formats(name: &str) -> PathBuf {
    data("formats").join(name)
}

fn lines(path: &Path) -> Result<segments::Segments, InputError> {
    SegmentSource::open(&[path.to_owned()]).and_then(segments::drain)
}

/// Returns the message of an error, with those of its causes.
#[track_caller]
fn message<T>(result: Result<T, InputError>) -> String {
    let mut error: &dyn std::error::Error = &result.map(|_| ()).unwrap_err();
    let mut text = error.to_string();
    while let Some(cause) = error.source() {
        text = format!("{text}: {cause}");
        error = cause;
    }
    text
}

#[track_caller]
fn assert_says<T>(result: Result<T, InputError>, parts: &[&str]) {
    let message = message(result);
    for part in parts {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
}

/// A thousand parts that are one would have had a thousand times its positions.
#[test]
fn parts_of_a_flatgeobuf_that_share_their_positions_are_refused() {
    use flatbuffers_of_flatgeobuf::FlatBufferBuilder;
    use flatgeobuf::{Feature, FeatureArgs, Geometry, GeometryArgs, GeometryType, Header, HeaderArgs};
    let file = |parts: usize| {
        let mut bytes = b"fgb\x03fgb\x01".to_vec();
        let mut builder = FlatBufferBuilder::new();
        let header = Header::create(
            &mut builder,
            &HeaderArgs {
                index_node_size: 0,
                ..HeaderArgs::default()
            },
        );
        builder.finish_size_prefixed(header, None);
        bytes.extend(builder.finished_data());
        let mut builder = FlatBufferBuilder::new();
        let xy = Some(builder.create_vector(&vec![1.5f64; 20_000]));
        let part = Geometry::create(
            &mut builder,
            &GeometryArgs {
                xy,
                type_: GeometryType::MultiPoint,
                ..GeometryArgs::default()
            },
        );
        let parts = Some(builder.create_vector(&vec![part; parts]));
        let all = Geometry::create(
            &mut builder,
            &GeometryArgs {
                parts,
                type_: GeometryType::GeometryCollection,
                ..GeometryArgs::default()
            },
        );
        let feature = Feature::create(
            &mut builder,
            &FeatureArgs {
                geometry: Some(all),
                ..FeatureArgs::default()
            },
        );
        builder.finish_size_prefixed(feature, None);
        bytes.extend(builder.finished_data());
        bytes
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("shared.fgb");
    fs::write(&path, file(1)).unwrap();
    let read = PointSource::open(std::slice::from_ref(&path), &InputOptions::default()).and_then(crate::input::drain);
    assert_eq!(read.unwrap().points.len(), 10_000);
    fs::write(&path, file(1000)).unwrap();
    let read = PointSource::open(&[path], &InputOptions::default()).and_then(crate::input::drain);
    assert_says(read, &["shared.fgb", "feature 0 is invalid"]);
}

#[test]
fn features_behind_the_count_of_a_flatgeobuf_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("more.fgb");
    let mut bytes = fs::read(formats("lines.fgb")).unwrap();
    fs::write(&path, &bytes).unwrap();
    assert_eq!(lines(&path).unwrap().source.notes(), [""; 0]);
    bytes.extend([0; 4]);
    fs::write(&path, &bytes).unwrap();
    let read = lines(&path).unwrap();
    let notes = read.source.notes();
    assert!(
        notes[0].ends_with("what follows the 30 features that the header announces is not read"),
        "{notes:?}"
    );
}

/// Returns a `.shp` file with one polygon of these rings.
fn polygons(rings: &[&[[f64; 2]]]) -> Vec<u8> {
    let points: Vec<[f64; 2]> = rings.concat();
    let mut record = vec![5, 0, 0, 0];
    record.extend([0; 32]);
    record.extend((rings.len() as u32).to_le_bytes());
    record.extend((points.len() as u32).to_le_bytes());
    let mut first = 0u32;
    for ring in rings {
        record.extend(first.to_le_bytes());
        first += ring.len() as u32;
    }
    points
        .iter()
        .flatten()
        .for_each(|number| record.extend(number.to_le_bytes()));
    let mut bytes = fs::read(formats("polygons.shp")).unwrap()[..100].to_vec();
    bytes[32] = 5;
    bytes.extend(1u32.to_be_bytes());
    bytes.extend((record.len() as u32 / 2).to_be_bytes());
    bytes.extend(record);
    let words = (bytes.len() as u32 / 2).to_be_bytes();
    bytes[24..28].copy_from_slice(&words);
    bytes
}

#[test]
fn holes_of_a_shapefile_in_no_outer_ring_are_reported() {
    let square = |x: f64, is_hole: bool| {
        let mut ring = [[x, 0.0], [x, 1.0], [x + 1.0, 1.0], [x + 1.0, 0.0], [x, 0.0]];
        if is_hole {
            ring.reverse();
        }
        ring
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lone.shp");
    let rings = [
        square(0.0, false),
        square(10.0, false),
        square(20.0, true),
        square(30.0, true),
    ];
    let rings: Vec<&[[f64; 2]]> = rings.iter().map(|ring| &ring[..]).collect();
    let mut bytes = polygons(&rings);
    bytes.extend([0; 8]);
    fs::write(&path, bytes).unwrap();
    let read = SegmentSource::open_obstacles(std::slice::from_ref(&path))
        .and_then(segments::drain)
        .unwrap();
    let notes = read.source.notes().join("\n");
    for part in [
        "2 rings are directed as holes but are in no outer ring",
        "what follows the 488 bytes that the header announces is not read",
    ] {
        assert!(notes.contains(part), "{notes}");
    }
    fs::write(&path, polygons(&rings[..2])).unwrap();
    let read = SegmentSource::open_obstacles(&[path])
        .and_then(segments::drain)
        .unwrap();
    assert_eq!(read.source.notes(), [""; 0]);
}

/// An empty part has four bytes in the file, and a list of its own in memory.
#[test]
fn more_parts_than_points_of_a_shapefile_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("parts.shp");
    let ring = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    fs::write(&path, polygons(&[&ring, &[], &[], &[]])).unwrap();
    assert_says(lines(&path), &["parts.shp", "3 points are not enough for 4 parts"]);
}

/// What one source has read of the ids must not be mixed with another table.
#[test]
fn files_beside_a_shapefile_must_not_change_while_it_is_read() {
    for suffix in ["dbf", "prj"] {
        let folder = tempfile::tempdir().unwrap();
        let path = |suffix: &str| folder.path().join("sites").with_extension(suffix);
        for suffix in ["shp", "dbf", "prj"] {
            fs::copy(formats("sites").with_extension(suffix), path(suffix)).unwrap();
        }
        let change = || {
            let bytes = fs::read(path(suffix)).unwrap();
            fs::write(path(suffix), [&bytes[..], b" "].concat()).unwrap();
        };
        let says = |read: Result<sites::Sites, InputError>| match read {
            Err(InputError::Changed { path: changed, .. }) => assert_eq!(changed, path(suffix)),
            other => panic!("{suffix}: {:?}", other.map(|read| read.ids)),
        };
        // While it is open, and between two openings: of two files, the second is closed meanwhile.
        for paths in [vec![path("shp")], vec![formats("sites.geojson"), path("shp")]] {
            let source = SiteSource::open(&paths, Some("name")).unwrap();
            let noted = source.stamps().iter().any(|(of, _)| *of == path(suffix));
            assert!(noted, "{suffix}");
            change();
            says(sites::drain(source));
        }
    }
}

#[test]
fn a_gzip_file_with_a_wrong_name_is_called_gzip() {
    let folder = tempfile::tempdir().unwrap();
    let text = gzip(b"1,2,3,4\n5,6,7,8\n");
    for name in ["a.las", "a.las.gz", "a.laz", "a.parquet", "a.gpkg", "a.shp", "a.fgb"] {
        let path = folder.path().join(name);
        fs::write(&path, &text).unwrap();
        let read = PointSource::open(&[path], &InputOptions::default()).and_then(crate::input::drain);
        assert_says(read, &[name, "this is gzip", "decompress it"]);
    }
    let path = folder.path().join("a.csv.gz");
    fs::write(&path, gzip(b"ply\nformat ascii 1.0\n")).unwrap();
    let read = PointSource::open(&[path], &InputOptions::default()).and_then(crate::input::drain);
    assert_says(
        read,
        &["a.csv.gz", "by its content, which is gzip, this is ply, and not text"],
    );
}

mod geopackage {
    use super::{assert_says, formats, lines};
    use crate::input::sites;
    use delaunay_tiles::input::SiteSource;
    use rusqlite::Connection;
    use std::fs;
    use std::path::{Path, PathBuf};

    /// Makes a layer `a` of the columns `columns` in a copy of a file.
    fn with_layer(folder: &Path, columns: &str) -> PathBuf {
        let path = folder.join("crafted.gpkg");
        fs::copy(formats("lines.gpkg"), &path).unwrap();
        let sql = format!(
            "DROP TABLE IF EXISTS a; CREATE TABLE a ({columns});
             INSERT INTO gpkg_contents (table_name, data_type, identifier) VALUES ('a', 'features', 'a');
             INSERT INTO gpkg_geometry_columns (table_name, column_name, geometry_type_name, srs_id, z, m)
             VALUES ('a', 'g', 'GEOMETRY', 0, 1, 0);"
        );
        Connection::open(&path).unwrap().execute_batch(&sql).unwrap();
        path
    }

    fn layer(path: &Path) -> PathBuf {
        format!("{}:a", path.display()).into()
    }

    /// The query by numbers of rows would take the column, and leave out all but one of equal numbers.
    #[test]
    fn a_column_named_like_the_number_of_a_row_hides_no_feature() {
        let folder = tempfile::tempdir().unwrap();
        let path = with_layer(folder.path(), "rowid INTEGER, g BLOB");
        let connection = Connection::open(&path).unwrap();
        for _ in 0..20 {
            connection
                .execute("INSERT INTO a (rowid, g) SELECT 7, geom FROM lines", [])
                .unwrap();
        }
        drop(connection);
        let once = lines(&formats("lines.gpkg")).unwrap();
        let read = lines(&layer(&path)).unwrap();
        assert_eq!(read.source.segments(), 20 * once.source.segments());
    }

    /// A short expression would make a geometry of any length for each row.
    #[test]
    fn computed_geometries_and_virtual_tables_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = with_layer(
            folder.path(),
            "n INTEGER, g BLOB GENERATED ALWAYS AS (zeroblob(n)) VIRTUAL",
        );
        assert_says(lines(&layer(&path)), &["the layer `a` computes its geometries"]);
        let sql = "DROP TABLE a; CREATE VIRTUAL TABLE a USING rtree(g, low, high)";
        Connection::open(&path).unwrap().execute_batch(sql).unwrap();
        assert_says(lines(&layer(&path)), &["the layer `a` is a view or a virtual table"]);
    }

    #[test]
    fn a_field_that_is_not_in_the_table_is_named_with_those_that_are() {
        let open = |field: &str| SiteSource::open(&[formats("all.gpkg:sites")], Some(field)).and_then(sites::drain);
        assert_eq!(open("name").unwrap().ids.len(), 20);
        assert_says(
            open("size"),
            &["all.gpkg", "there is no field `size`; there are ", "name"],
        );
    }

    /// Rows would be read again and again, since the last number decides what comes next.
    #[test]
    fn rows_that_are_not_in_order_are_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = with_layer(folder.path(), "g BLOB");
        let connection = Connection::open(&path).unwrap();
        connection
            .execute("INSERT INTO a SELECT geom FROM lines LIMIT 3", [])
            .unwrap();
        let sql = "SELECT rootpage, (SELECT page_size FROM pragma_page_size) FROM sqlite_schema WHERE name = 'a'";
        let at = connection.query_row(sql, [], |row| {
            let (page, size): (u32, u32) = (row.get(0)?, row.get(1)?);
            Ok(((page - 1) * size) as usize)
        });
        let at = at.unwrap();
        drop(connection);
        assert!(lines(&layer(&path)).is_ok());
        let mut bytes = fs::read(&path).unwrap();
        assert_eq!(bytes[at..at + 5], [13, 0, 0, 0, 3], "a leaf of three rows");
        bytes[at + 8..at + 14].reverse();
        (0..3).for_each(|cell| bytes[at + 8 + 2 * cell..at + 10 + 2 * cell].reverse());
        fs::write(&path, bytes).unwrap();
        assert_says(
            lines(&layer(&path)),
            &["its number is not above that of the row before"],
        );
    }
}
