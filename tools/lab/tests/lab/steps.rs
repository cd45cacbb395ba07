//! `lab steps`: the pictures of docs/how_it_works.md. Tests beside the code check that what they
//! show is so.

use std::fs;

use crate::support::{data, fails, names, run};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
const PICTURES: [&str; 5] = [
    "steps-1-divide.svg",
    "steps-2-conquer.svg",
    "steps-3-merge.svg",
    "steps-4-constrain.svg",
    "steps-5-query.svg",
];

/// So the same command gives the same bytes, and the page shows what the library does now.
#[test]
fn the_pictures_of_the_page_are_those_that_the_command_draws() {
    let scratch = tempfile::tempdir().unwrap();
    let coasts = data("indonesia/indonesia_ne10m.geojson");
    let printed = run(scratch.path(), &format!("steps {coasts} -o pictures"));
    assert_eq!(printed.lines().count(), PICTURES.len());
    let folder = scratch.path().join("pictures");
    assert_eq!(names(&folder), PICTURES);
    let page = fs::read_to_string(format!("{ROOT}/docs/how_it_works.md")).unwrap();
    for name in PICTURES {
        let drawn = fs::read_to_string(folder.join(name)).unwrap();
        assert!(
            drawn.starts_with("<svg") && drawn.len() < 120_000,
            "{name}: {}",
            drawn.len()
        );
        let kept = fs::read_to_string(format!("{ROOT}/docs/pictures/{name}")).unwrap();
        assert!(
            drawn == kept,
            "{name} is another picture; `cargo run --release -p lab -- steps -o docs/pictures` draws it anew"
        );
        assert!(
            page.contains(&format!("](pictures/{name})")),
            "the page does not show {name}"
        );
    }
}

#[test]
fn coasts_of_other_places_are_refused() {
    let scratch = tempfile::tempdir().unwrap();
    let coasts = r#"{"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {},
        "geometry": {"type": "Polygon", "coordinates": [[[0,0],[1,0],[0,1],[0,0]]]}}]}"#;
    fs::write(scratch.path().join("coasts.geojson"), coasts).unwrap();
    let error = fails(scratch.path(), 1, "steps coasts.geojson -o pictures");
    assert!(error.contains("0 islands"), "{error}");
    assert!(!scratch.path().join("pictures").exists());
}
