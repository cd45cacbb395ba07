//! The coordinate reference system of the inputs of a build, and whether the inputs lie together.

use std::path::{Path, PathBuf};

use clap::Args;
use delaunay_tiles::crs::{Agreement, Crs, Unit};
use delaunay_tiles::geometry::{Point, Rect};
use delaunay_tiles::input::Format;
use delaunay_tiles_answers::units::Measure;
use serde::Serialize;

use crate::common;
use crate::numbers::shortened;

/// The option that overrides the systems of the inputs.
#[derive(Args, Clone, Debug)]
pub struct CrsArgs {
    /// Coordinate reference system of all inputs, such as EPSG:25832, or as WKT; overrides what the
    /// files say
    #[arg(long, value_name = "CRS", value_parser = crs, help_heading = "Input options")]
    crs: Option<Crs>,
}

/// Parses a coordinate reference system.
fn crs(text: &str) -> anyhow::Result<Crs> {
    let crs = Crs::new(text);
    anyhow::ensure!(
        crs.is_known(),
        "a coordinate reference system is a code such as EPSG:25832, or WKT"
    );
    Ok(crs)
}

impl CrsArgs {
    /// Returns whether a system is given.
    pub fn is_given(&self) -> bool {
        self.crs.is_some()
    }

    /// Returns an agreement on the given system, if there is one, or else on that of `files`.
    ///
    /// # Errors
    /// Fails if two files have different systems.
    pub fn agree<'a>(&self, files: impl IntoIterator<Item = &'a (PathBuf, String)>) -> anyhow::Result<Agreement> {
        let mut agreement = self.crs.clone().map_or_else(Agreement::default, Agreement::on);
        for (path, text) in files {
            agreement.add(path, Crs::new(text))?;
        }
        Ok(agreement)
    }
}

/// What is known of the coordinate reference system.
#[derive(Serialize)]
pub struct System {
    crs_name: Option<String>,
    epsg: Option<u32>,
    unit: Option<&'static str>,
    is_geographic: Option<bool>,
}

impl System {
    /// Returns what the text of a system tells.
    pub fn of(crs: Option<&str>) -> Self {
        let crs = crs.map(Crs::new);
        let crs = crs.as_ref();
        Self {
            crs_name: crs.and_then(Crs::name).map(str::to_owned),
            epsg: crs.and_then(Crs::epsg),
            unit: crs.map(Crs::unit).filter(|&unit| unit != Unit::Unknown).map(Unit::name),
            is_geographic: crs.and_then(Crs::is_geographic),
        }
    }
}

/// Returns the system that a text describes in a few words, with its unit.
pub fn shown(text: &str) -> String {
    /// Maximum number of characters on the screen.
    const MOST: usize = 72;
    let crs = Crs::new(text);
    shortened(&format!("{}, in {}", crs.summary(), crs.unit().name()), MOST)
}

/// The extents of the inputs.
#[derive(Clone, Debug, Default)]
pub struct Extents {
    points: Option<Rect>,
    files: Vec<(PathBuf, Rect)>,
}

impl Extents {
    /// Adds points of the inputs of points.
    pub fn add_points(&mut self, points: &[Point]) {
        let extent = self.points.unwrap_or(Rect::EMPTY);
        self.points = Some(extent.union(Rect::around(points.iter().copied())));
    }

    /// Adds the points of other inputs.
    pub fn add_all(&mut self, others: &Self) {
        let points = self.points.into_iter().chain(others.points);
        self.points = points.reduce(Rect::union);
        self.files.extend_from_slice(&others.files);
    }

    /// Adds points of another file.
    pub fn add(&mut self, file: &Path, points: impl IntoIterator<Item = Point>) {
        let extent = Rect::around(points);
        match self.files.iter_mut().find(|(of, _)| of == file) {
            Some((_, all)) => *all = all.union(extent),
            None => self.files.push((file.to_owned(), extent)),
        }
    }

    /// Returns a note for each file whose extent does not meet that of the points.
    pub fn notes(&self) -> Vec<String> {
        let shown = |rect: Rect| format!("x {} to {}, y {} to {}", rect.min_x, rect.max_x, rect.min_y, rect.max_y);
        let Some(points) = self.points.filter(|points| !points.is_empty()) else {
            return Vec::new();
        };
        let apart = self
            .files
            .iter()
            .filter(|(_, extent)| !extent.is_empty() && !extent.intersects(points));
        let notes = apart.map(|(path, extent)| {
            format!(
                "{} lies elsewhere than the points: {}; the points: {}",
                common::shown(path),
                shown(*extent),
                shown(points)
            )
        });
        notes.collect()
    }

    /// Returns whether all coordinates can be degrees.
    fn may_be_degrees(&self) -> bool {
        let degrees = Rect::new(-180.0, -90.0, 180.0, 90.0);
        let mut extents = self.files.iter().map(|(_, extent)| *extent).chain(self.points);
        extents.all(|extent| extent.union(degrees) == degrees)
    }

    /// Returns the system of files that name none: degrees if all of them, by `names`, are GeoJSON
    /// whose coordinates can be degrees. RFC 7946 says that they are.
    pub fn of_plain_geojson<'a>(&self, names: impl IntoIterator<Item = &'a str>) -> Option<Crs> {
        let mut names = names.into_iter().peekable();
        names.peek()?;
        let is_plain = |name: &str| Format::from_path(Path::new(name)) == Some(Format::GeoJson);
        (names.all(is_plain) && self.may_be_degrees()).then(|| Crs::new("OGC:CRS84"))
    }
}

/// Returns a note on a system whose lengths mislead.
pub fn note(crs: Option<&Crs>) -> Option<String> {
    let crs = crs.filter(|crs| crs.unit() == Unit::Degree)?;
    Some(format!("{}: {}", crs.summary(), crs.unit().warning()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn extents(max_x: f64) -> Extents {
        let mut extents = Extents::default();
        extents.add_points(&[Point::new(0.0, 0.0), Point::new(max_x, 1.0)]);
        extents
    }

    #[test]
    fn geojson_without_a_reference_system_has_degrees() {
        for (names, max_x, expected) in [
            (&["a.geojson"][..], 1.0, true),
            (&["a.geojson", "b.json.gz"], 180.0, true),
            (&["a.geojson"], 180.5, false),
            (&["a.geojson", "b.csv"], 1.0, false),
            (&["-"], 1.0, false),
            (&[], 1.0, false),
        ] {
            let crs = extents(max_x).of_plain_geojson(names.iter().copied());
            assert_eq!(crs.is_some(), expected, "{names:?} {max_x}");
        }
    }

    #[test]
    fn files_that_lie_elsewhere_get_a_note() {
        let mut extents = extents(3.0);
        extents.add("far.shp".as_ref(), [Point::new(3.5, 0.0)]);
        extents.add("near.shp".as_ref(), [Point::new(9.0, 0.5)]);
        extents.add("near.shp".as_ref(), [Point::new(2.0, 0.5)]);
        extents.add("empty.shp".as_ref(), []);
        let notes = extents.notes();
        assert_eq!(notes.len(), 1, "{notes:?}");
        assert!(notes[0].starts_with("far.shp") && notes[0].contains("3.5"), "{notes:?}");
    }
}
