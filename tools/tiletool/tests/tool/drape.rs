//! Lines, obstacles and sites without z take it from the surface of the points.

use std::fs;

use crate::support::{fails, json, run};

/// A slope of 21 by 21 points, z = 100 + x / 4 - y / 8, and lines without z.
fn scratch() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut ground = "x,y,z\n".to_owned();
    for (x, y) in (0..21).flat_map(|x| (0..21).map(move |y| (f64::from(x), f64::from(y)))) {
        ground += &format!("{x},{y},{}\n", 100.0 + x / 4.0 - y / 8.0);
    }
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("ground.csv", &ground);
    write("lakes.csv", "0.5,0.5,16.5,16.5\n3,9.5,9.5,3\n");
    write("out.csv", "18.5,10.25,24,10.25\n");
    write("shops.csv", "12,12\n3.25,7.5\n");
    folder
}

/// Returns what `query locate` or another command prints of z at a point.
fn z_at(folder: &std::path::Path, file: &str, x: f64, y: f64) -> f64 {
    let found = json(folder, &format!("query z {file} --at {x},{y} --json"));
    found["z"].as_f64().unwrap()
}
