//! Lines, obstacles and sites in each format of vector data: the same triangulation as from GeoJSON.

use std::path::Path;

use crate::support::{data, fails, run};

/// The files of a layer in the formats that this tool was built with.
fn others(layer: &str) -> Vec<String> {
    let mut names = Vec::new();
    if cfg!(feature = "flatgeobuf") {
        names.push(format!("formats/{layer}.fgb"));
    }
    if cfg!(feature = "shapefile") {
        names.push(format!("formats/{layer}.shp"));
    }
    if cfg!(feature = "geopackage") {
        names.push(format!("formats/all.gpkg:{layer}"));
    }
    names.iter().map(|name| data(name)).collect()
}

/// Builds a file with these options. Returns its digest.
#[track_caller]
fn digest(folder: &Path, options: &str) -> String {
    run(
        folder,
        &format!("build {options} -o t.tiles --tile-vertices 40 --quiet --force"),
    );
    run(folder, "digest --recompute t.tiles")
}

#[test]
fn the_same_features_in_all_formats_give_the_same_digest() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    for (layer, options) in [
        ("lines", &["--segments", "--walls"][..]),
        ("polygons", &["--obstacles", "--walls"]),
        ("sites", &["--site-id name --sites"]),
    ] {
        for option in options {
            let geojson = data(&format!("formats/{layer}.geojson"));
            let expected = digest(folder, &format!("{option} {geojson}"));
            for other in others(layer) {
                assert_eq!(digest(folder, &format!("{option} {other}")), expected, "{other}");
                run(folder, &format!("verify --deep t.tiles {option} {other}"));
            }
        }
    }
}

/// A spatial index gives the features, and so the lines, another order.
#[cfg(feature = "flatgeobuf")]
#[test]
fn the_order_of_a_spatial_index_does_not_matter() {
    let scratch = tempfile::tempdir().unwrap();
    let of_file = |name: &str| digest(scratch.path(), &format!("--segments {}", data(name)));
    assert_eq!(of_file("formats/lines_indexed.fgb"), of_file("formats/lines.geojson"));
}

#[test]
fn lines_of_any_format_are_added_to_a_file() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let corners = "399900,5799900\n400500,5799900\n400500,5800500\n399900,5800500\n";
    std::fs::write(folder.join("corners.csv"), corners).unwrap();
    let constrained = |file: &str| {
        run(folder, "build corners.csv -o t.tiles --quiet --force");
        run(folder, &format!("constrain t.tiles --segments {file} --missing-z zero"));
        run(folder, "digest --recompute t.tiles")
    };
    let expected = constrained(&data("formats/lines.geojson"));
    for other in others("lines") {
        assert_eq!(constrained(&other), expected, "{other}");
    }
}

#[test]
fn mistakes_in_the_choice_of_a_file_are_explained() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let all = data("formats/all.gpkg");
    let error = fails(folder, 1, &format!("build --segments {all} -o t.tiles"));
    match cfg!(feature = "geopackage") {
        true => assert!(
            error.contains("lines, polygons, sites, clusters") && error.contains("FILE.gpkg:LAYER"),
            "{error}"
        ),
        false => assert!(error.contains("without the feature `geopackage`"), "{error}"),
    }
    std::fs::copy(data("formats/lines.fgb"), folder.join("lines.geojson")).unwrap();
    let error = fails(folder, 1, "build --segments lines.geojson -o t.tiles");
    assert!(error.contains("flatgeobuf, and not geojson"), "{error}");
}
