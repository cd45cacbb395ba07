//! The formats of vector data give the same records as GeoJSON of the same features. GDAL wrote the
//! files (`tests/data/formats/make.py`).

use crate::input::segments::{self, Segments};
use crate::input::sites::{self, Sites};
use crate::input::{Read, drain, gzip};
use crate::support::test_data::data;
use delaunay_tiles::input::{InputError, InputOptions, PointSource, SegmentSource, SiteId, SiteSource};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The files with the features of a layer, other than GeoJSON.
fn others(layer: &str) -> Vec<PathBuf> {
    [
        format!("{layer}.fgb"),
        format!("{layer}.shp"),
        format!("all.gpkg:{layer}"),
    ]
    .iter()
    .map(|name| formats(name))
    .collect()
}

fn formats(name: &str) -> PathBuf {
    data("formats").join(name)
}

fn lines(path: &Path) -> Result<Segments, InputError> {
    SegmentSource::open(&[path.to_owned()]).and_then(segments::drain)
}

fn obstacles(path: &Path) -> Result<Segments, InputError> {
    SegmentSource::open_obstacles(&[path.to_owned()]).and_then(segments::drain)
}

fn points(path: &Path) -> Result<Read, InputError> {
    PointSource::open(&[path.to_owned()], &InputOptions::default()).and_then(drain)
}

fn found_sites(path: &Path, id_field: Option<&str>) -> Result<Sites, InputError> {
    SiteSource::open(&[path.to_owned()], id_field).and_then(sites::drain)
}

/// Everything that a source of segments says about a file but its name.
fn summary(read: &Segments) -> (u64, Vec<String>) {
    let notes = read.source.notes().iter();
    let notes = notes.map(|note| note.split_once(": ").map_or(note.clone(), |(_, rest)| rest.to_owned()));
    let lines = read.source.sources().iter().map(|(_, lines)| lines).sum();
    (lines, notes.collect())
}

/// Numbers of which some may be NaN.
fn bits(z: &[[f64; 2]]) -> Vec<[u64; 2]> {
    z.iter().map(|ends| ends.map(f64::to_bits)).collect()
}

#[track_caller]
fn assert_same(found: &Segments, expected: &Segments) {
    assert!(expected.ends.len() > 100);
    assert_eq!(found.ends, expected.ends);
    assert_eq!(bits(&found.z), bits(&expected.z));
    assert_eq!(found.lines, expected.lines);
    assert_eq!(summary(found), summary(expected));
}

#[test]
fn lines_of_all_formats_are_the_same() {
    let expected = lines(&formats("lines.geojson")).unwrap();
    assert!(expected.source.has_z());
    // One feature has no geometry, and is a line nevertheless.
    assert_eq!(summary(&expected).0, 30);
    for path in others("lines") {
        assert_same(&lines(&path).unwrap(), &expected);
    }
}

#[test]
fn obstacles_of_all_formats_are_the_same() {
    let expected = obstacles(&formats("polygons.geojson")).unwrap();
    for path in others("polygons") {
        let found = obstacles(&path).unwrap();
        assert_same(&found, &expected);
        let origin = found.source.origin(found.lines[100]).unwrap();
        assert_eq!(origin.what, "feature");
        let wrong =
            obstacles(&path.with_file_name(path.file_name().unwrap().to_str().unwrap().replace("polygons", "lines")));
        let message = wrong.unwrap_err().to_string();
        assert!(message.contains("String; obstacles are Polygons"), "{message}");
    }
}

/// A shapefile may have turned rings round, and each format may give any of the ends first.
#[test]
fn rings_as_lines_are_the_same_edges() {
    let edges = |path: &Path| {
        let mut edges = lines(path).unwrap().ends;
        for edge in &mut edges {
            let [a, b, c, d] = *edge;
            *edge = if (a, b) < (c, d) { [a, b, c, d] } else { [c, d, a, b] };
        }
        edges.sort_by(|one, other| one.partial_cmp(other).unwrap());
        edges
    };
    let expected = edges(&formats("polygons.geojson"));
    for path in others("polygons") {
        assert_eq!(edges(&path), expected);
    }
}

#[test]
fn sites_and_their_ids_are_the_same() {
    for field in [None, Some("number"), Some("name")] {
        let expected = found_sites(&formats("sites.geojson"), field).unwrap();
        match field {
            Some("name") => assert_eq!(expected.ids[3], SiteId::Text("no 3, ä".to_owned())),
            field => assert_eq!(expected.ids[3], SiteId::Number(field.map_or(3, |_| 21))),
        }
        for path in others("sites") {
            let found = found_sites(&path, field).unwrap();
            assert_eq!(found.points, expected.points);
            assert_eq!(found.ids, expected.ids, "{}", path.display());
        }
    }
    for path in others("sites") {
        let message = found_sites(&path, Some("size")).unwrap_err().to_string();
        assert!(
            message.contains("size") || message.contains("cannot be read"),
            "{message}"
        );
    }
    for path in others("clusters") {
        let expected = found_sites(&formats("clusters.geojson"), None).unwrap();
        assert_eq!(found_sites(&path, None).unwrap().points, expected.points);
    }
}

#[test]
fn points_are_the_same() {
    for layer in ["lines", "sites", "clusters"] {
        let expected = points(&formats(&format!("{layer}.geojson"))).unwrap();
        for path in others(layer) {
            let found = points(&path).unwrap();
            assert_eq!(found.points, expected.points);
            assert_eq!(found.z, expected.z);
            assert_eq!(found.records, expected.records);
        }
    }
    let all = points(&formats("polygons.geojson")).unwrap();
    for path in others("polygons") {
        assert_eq!(points(&path).unwrap().points.len(), all.points.len());
    }
}

#[test]
fn a_layer_of_mixed_types_gives_all_of_them() {
    let (mixed, expected) = (formats("mixed.fgb"), formats("mixed.geojson"));
    assert_same(&lines(&mixed).unwrap(), &lines(&expected).unwrap());
    assert_eq!(
        found_sites(&mixed, None).unwrap().points,
        found_sites(&expected, None).unwrap().points
    );
}

#[test]
fn each_file_tells_its_reference_system() {
    let all = ["lines", "polygons", "sites"].into_iter().flat_map(others);
    for path in all.chain([formats("lines.geojson"), formats("sites.geojson")]) {
        let source = SegmentSource::open(std::slice::from_ref(&path)).unwrap();
        let [(found, crs)] = source.crs_of_files() else {
            panic!("{:?}", source.crs_of_files())
        };
        assert_eq!(*found, path);
        let suffix = path.extension().unwrap().to_str().unwrap();
        match suffix {
            "geojson" => assert_eq!(crs, "urn:ogc:def:crs:EPSG::25833"),
            "shp" => assert!(crs.starts_with("PROJCS[\"ETRS"), "{crs}"),
            _ => assert_eq!(crs, "EPSG:25833"),
        }
        let sites = SiteSource::open(&[path.clone(), formats("sites.geojson")], None).unwrap();
        // A file that is given twice is listed once.
        let files = BTreeSet::from([path, formats("sites.geojson")]);
        assert_eq!(sites.crs_of_files().len(), files.len());
    }
}

/// A name without a known suffix does not hide what a file is; a wrong one is an error.
#[test]
fn files_are_recognised_by_their_content() {
    let folder = tempfile::tempdir().unwrap();
    let expected = lines(&formats("lines.geojson")).unwrap();
    let mut files = vec![formats("lines.geojson")];
    files.extend(others("lines").into_iter().filter(|path| path.exists()));
    files.push(formats("lines.gpkg"));
    for file in &files {
        let unnamed = folder.path().join("lines.data");
        fs::copy(file, &unnamed).unwrap();
        assert_same(&lines(&unnamed).unwrap(), &expected);
        assert_eq!(points(&unnamed).unwrap().points, points(file).unwrap().points);
        for suffix in ["geojson", "csv", "shp", "fgb", "gpkg", "las"] {
            let wrong = folder.path().join(format!("wrong.{suffix}"));
            fs::copy(file, &wrong).unwrap();
            let is_right = file.extension().unwrap() == suffix;
            // Text that is no table gets the error of a row.
            let is_told = !is_right && (suffix != "csv" || !file.ends_with("lines.geojson"));
            match points(&wrong) {
                Ok(_) => assert!(is_right, "{suffix}"),
                Err(error) if is_told => {
                    let message = error.to_string();
                    assert!(
                        message.contains("wrong.") && message.contains("by its content"),
                        "{message}"
                    );
                }
                Err(_) => assert!(!is_right, "{suffix}"),
            }
        }
    }
    let unknown = folder.path().join("unknown.data");
    fs::write(&unknown, "1,2,3,4\n").unwrap();
    assert!(matches!(lines(&unknown), Err(InputError::UnknownFormat { .. })));
}

#[test]
fn streams_may_be_compressed_and_files_with_layers_may_not() {
    let folder = tempfile::tempdir().unwrap();
    let expected = lines(&formats("lines.geojson")).unwrap();
    for path in others("lines").iter().filter(|path| path.exists()) {
        let suffix = path.extension().unwrap().to_str().unwrap();
        for name in [format!("lines.{suffix}.gz"), "lines.data".to_owned()] {
            let zipped = folder.path().join(name);
            fs::write(&zipped, gzip(&fs::read(path).unwrap())).unwrap();
            assert_same(&lines(&zipped).unwrap(), &expected);
        }
    }
    let zipped = folder.path().join("lines.gpkg.gz");
    fs::write(&zipped, gzip(&fs::read(formats("lines.gpkg")).unwrap())).unwrap();
    let message = lines(&zipped).unwrap_err().to_string();
    assert!(message.contains("GeoPackage") || message.contains("gzip"), "{message}");
}

#[test]
fn one_of_several_layers_must_be_named() {
    let message = |name: &str| lines(&formats(name)).unwrap_err().to_string();
    let several = message("all.gpkg");
    for part in ["all.gpkg", "lines, polygons, sites, clusters", "FILE.gpkg:LAYER"] {
        assert!(several.contains(part), "{several}");
    }
    let unknown = message("all.gpkg:rivers");
    assert!(
        unknown.contains("`rivers`") && unknown.contains("lines, polygons"),
        "{unknown}"
    );
    assert_same(
        &lines(&formats("lines.gpkg")).unwrap(),
        &lines(&formats("lines.gpkg:lines")).unwrap(),
    );
    assert!(matches!(
        lines(&formats("none.gpkg:lines")),
        Err(InputError::Open { .. })
    ));
}

#[test]
fn a_geopackage_with_pending_changes_is_refused_and_none_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lines.gpkg");
    fs::copy(formats("lines.gpkg"), &path).unwrap();
    lines(&path).unwrap();
    let names: Vec<_> = fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    assert_eq!(names, ["lines.gpkg"]);
    fs::write(folder.path().join("lines.gpkg-wal"), b"changes").unwrap();
    let message = lines(&path).unwrap_err().to_string();
    assert!(message.contains("-wal"), "{message}");
}
