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
                // The input may be in another format than that of the build.
                run(folder, &format!("verify --deep t.tiles {option} {geojson}"));
            }
        }
    }
}

#[cfg(feature = "flatgeobuf")]
#[test]
fn the_order_of_a_spatial_index_changes_only_the_numbers_of_lines() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let sums = |name: &str| {
        let digest = digest(folder, &format!("--segments {}", data(name)));
        let lines: Vec<String> = digest.lines().map(str::to_owned).collect();
        lines
    };
    let (plain, indexed) = (sums("formats/lines.fgb"), sums("formats/lines_indexed.fgb"));
    assert_eq!(plain.len(), indexed.len());
    for (one, other) in plain.iter().zip(&indexed) {
        // Only the sources of the edges have the numbers of lines.
        assert_eq!(one == other, !one.contains("source"), "{one}\n{other}");
    }
}

#[test]
fn lines_of_any_format_are_added_to_a_file() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let sites = data("formats/sites.geojson");
    let constrained = |file: &str| {
        run(folder, &format!("build {sites} -o t.tiles --quiet --force"));
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
