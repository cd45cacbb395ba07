//! Maps of obstacles and sites, as GeoJSON and text.

use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use distributions::{Map, MapKind};

use crate::common;
use crate::output::StreamOutput;

/// The number of records after which an interruption is noticed.
const BLOCK: usize = 1 << 12;

/// A map to write.
pub(super) struct Order {
    pub(super) kind: MapKind,
    pub(super) obstacles: u64,
    pub(super) sites: u64,
    pub(super) seed: u64,
}

impl Order {
    /// Writes the files of the map, and prints a summary.
    pub(super) fn run(&self, output: &Path, json: bool) -> anyhow::Result<()> {
        let site_path = output.with_extension("sites.csv");
        let paths = [output, &site_path];
        let map = Map::new(self.kind, self.obstacles, self.seed);
        write(map, self.sites, paths, &common::interruption())?;
        if json {
            let json = serde_json::json!({
                "kind": self.kind.name(),
                "seed": self.seed,
                "obstacles": self.obstacles,
                "output": output.to_string_lossy(),
                "sites": self.sites,
                "sites_output": site_path.to_string_lossy(),
            });
            return common::print_json("the summary", &json);
        }
        let counts = [
            common::counted(self.obstacles, "obstacle", "obstacles"),
            common::counted(self.sites, "site", "sites"),
        ];
        for (count, path) in counts.iter().zip(paths) {
            common::tell(format_args!("{count} in {}", common::shown(path)));
        }
        Ok(())
    }
}

/// Writes the obstacles of a map as GeoJSON, one to a line, and its sites as rows `x,y`. Both files
/// get their names when both are complete.
pub(super) fn write(map: Map, sites: u64, paths: [&Path; 2], stop: &AtomicBool) -> anyhow::Result<()> {
    let [mut polygons, mut points] = [None, None];
    for (path, file) in paths.into_iter().zip([&mut polygons, &mut points]) {
        let failed = || format!("cannot write {}", common::shown(path));
        let is_polygons = path == paths[0];
        let mut output = StreamOutput::create(path).with_context(failed)?;
        let mut out = BufWriter::with_capacity(1 << 20, output.file());
        let written = if is_polygons {
            write_obstacles(map, &mut out, stop)
        } else {
            write_sites(map, sites, &mut out, stop)
        };
        written.and_then(|()| out.flush()).with_context(failed)?;
        drop(out);
        output.sync().with_context(failed)?;
        *file = Some(output);
    }
    // The obstacles get their name last, so a process that sees new obstacles sees new sites.
    for (path, file) in paths.into_iter().zip([polygons, points]).rev() {
        let published = file.map_or(Ok(()), StreamOutput::publish);
        published.with_context(|| format!("cannot write {}", common::shown(path)))?;
    }
    Ok(())
}

fn write_obstacles(map: Map, out: &mut dyn Write, stop: &AtomicBool) -> io::Result<()> {
    write!(out, "{{\"type\":\"FeatureCollection\",\"features\":[")?;
    for (number, corners) in map.obstacles().enumerate() {
        check(number, stop)?;
        let comma = if number == 0 { "" } else { "," };
        write!(
            out,
            "{comma}\n{{\"type\":\"Feature\",\"properties\":{{}},\"geometry\":{{\"type\":\"Polygon\",\"coordinates\":[["
        )?;
        for [x, y] in &corners {
            write!(out, "[{x},{y}],")?;
        }
        let [x, y] = corners[0];
        write!(out, "[{x},{y}]]]}}}}")?;
    }
    writeln!(out, "\n]}}")
}

fn write_sites(map: Map, count: u64, out: &mut dyn Write, stop: &AtomicBool) -> io::Result<()> {
    for (number, [x, y]) in map.sites(count).enumerate() {
        check(number, stop)?;
        writeln!(out, "{x},{y}")?;
    }
    Ok(())
}

fn check(number: usize, stop: &AtomicBool) -> io::Result<()> {
    if number.is_multiple_of(BLOCK) && stop.load(Ordering::Relaxed) {
        return Err(io::Error::other("interrupted; no file was written"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use distributions::MapKind;
    use serde_json::Value;

    use super::*;

    #[test]
    fn a_map_is_written_as_geojson_and_text() {
        let folder = tempfile::tempdir().unwrap();
        let paths = ["city.geojson", "city.sites.csv"].map(|name| folder.path().join(name));
        let map = Map::new(MapKind::City, 30, 2);
        let [polygons, points] = [0, 1].map(|i| paths[i].as_path());
        write(map, 50, [polygons, points], &AtomicBool::new(false)).unwrap();
        let json: Value = serde_json::from_slice(&fs::read(polygons).unwrap()).unwrap();
        let features = json["features"].as_array().unwrap();
        assert_eq!(features.len(), 30);
        for (feature, corners) in features.iter().zip(map.obstacles()) {
            let ring = feature["geometry"]["coordinates"][0].as_array().unwrap();
            let read = ring.iter().map(|p| [0, 1].map(|i| p[i].as_f64().unwrap()));
            assert!(read.eq(corners.iter().chain(&corners[..1]).copied()));
        }
        let rows = fs::read_to_string(points).unwrap();
        let read = rows.lines().map(|row| row.split_once(',').unwrap());
        let read = read.map(|(x, y)| [x, y].map(|x| x.parse::<f64>().unwrap()));
        assert!(read.eq(map.sites(50)));
    }

    #[test]
    fn an_interruption_leaves_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let paths = ["city.geojson", "city.sites.csv"].map(|name| folder.path().join(name));
        let map = Map::new(MapKind::Parks, 30, 2);
        let error = write(map, 50, [&paths[0], &paths[1]], &AtomicBool::new(true)).unwrap_err();
        assert!(format!("{error:#}").contains("interrupted"), "{error:#}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
