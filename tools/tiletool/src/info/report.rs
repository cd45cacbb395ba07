//! The output of `info --json`.

use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::{Contents, Field, FileInfo, LasInfo};
use delaunay_tiles::shown;
use serde::Serialize;

use crate::crs::{Extents, System};
use crate::numbers::Bounds;

/// What a file holds. Its field names are stable keys of `--json`.
#[derive(Serialize)]
pub struct Report {
    file: String,
    format: String,
    variety: Option<String>,
    bytes: Option<u64>,
    is_gzip: bool,
    pub contents: Vec<ContentsReport>,
    las: Option<LasReport>,
    notes: Vec<String>,
}

/// The contents of a file or layer.
#[derive(Serialize)]
pub struct ContentsReport {
    layer: Option<String>,
    declared_type: Option<String>,
    #[serde(flatten)]
    counts: Counts,
    bounds: Option<Bounds>,
    min_z: Option<f64>,
    max_z: Option<f64>,
    pub crs: Option<String>,
    #[serde(flatten)]
    system: System,
    fields: Vec<FieldReport>,
}

#[derive(Serialize)]
struct Counts {
    features: u64,
    without_geometry: u64,
    points: u64,
    multi_points: u64,
    line_strings: u64,
    multi_line_strings: u64,
    polygons: u64,
    multi_polygons: u64,
    positions: u64,
    positions_with_z: u64,
    sites: u64,
    faces: u64,
    edges: u64,
    segments: u64,
    holes: u64,
    withheld: u64,
    invalid: u64,
}

#[derive(Serialize)]
struct FieldReport {
    name: String,
    r#type: String,
}

#[derive(Serialize)]
struct LasReport {
    version: String,
    point_format: u8,
    record_bytes: u16,
    is_compressed: bool,
    system: String,
    software: String,
    created_year: Option<u16>,
    created_day: Option<u16>,
    scale: [f64; 3],
    offset: [f64; 3],
    classes: Vec<ClassReport>,
    returns: Vec<ReturnReport>,
    copc_levels: Option<u32>,
    copc_spacing: Option<f64>,
}

#[derive(Serialize)]
struct ClassReport {
    class: u8,
    points: u64,
}

#[derive(Serialize)]
struct ReturnReport {
    r#return: u8,
    points: u64,
}

impl Report {
    pub fn new(info: &FileInfo) -> Self {
        Self {
            file: info.path.to_string_lossy().into_owned(),
            format: info.format.clone(),
            variety: info.variety.clone(),
            bytes: info.bytes,
            is_gzip: info.is_gzip,
            contents: info
                .contents
                .iter()
                .map(|contents| ContentsReport::new(info, contents))
                .collect(),
            las: info.las.as_ref().map(LasReport::new),
            notes: info.notes.iter().map(|note| shown::message(note)).collect(),
        }
    }
}

impl ContentsReport {
    fn new(info: &FileInfo, contents: &Contents) -> Self {
        let counts = contents.counts;
        let crs = contents.crs.clone().or_else(|| geojson_crs(info, contents));
        Self {
            layer: contents.layer.clone(),
            declared_type: contents.declared_type.clone(),
            counts: Counts {
                features: counts.features,
                without_geometry: counts.without_geometry,
                points: counts.points,
                multi_points: counts.multi_points,
                line_strings: counts.lines,
                multi_line_strings: counts.multi_lines,
                polygons: counts.polygons,
                multi_polygons: counts.multi_polygons,
                positions: counts.positions,
                positions_with_z: counts.positions_with_z,
                sites: counts.sites,
                faces: counts.faces,
                edges: counts.edges,
                segments: counts.segments,
                holes: counts.holes,
                withheld: counts.withheld,
                invalid: counts.invalid,
            },
            bounds: Bounds::new(contents.bounds),
            min_z: contents.z.map(|[low, _]| low),
            max_z: contents.z.map(|[_, high]| high),
            system: System::of(crs.as_deref()),
            crs,
            fields: contents.fields.iter().map(FieldReport::new).collect(),
        }
    }
}

/// Returns the system of GeoJSON that names none, as a build takes it.
fn geojson_crs(info: &FileInfo, contents: &Contents) -> Option<String> {
    let bounds = contents.bounds;
    let corners = [
        Point::new(bounds.min_x, bounds.min_y),
        Point::new(bounds.max_x, bounds.max_y),
    ];
    let mut extents = Extents::default();
    extents.add(&info.path, corners.into_iter().filter(|_| !bounds.is_empty()));
    let name = info.path.to_string_lossy();
    Some(extents.of_plain_geojson([&*name])?.text().to_owned())
}

impl FieldReport {
    fn new(field: &Field) -> Self {
        Self {
            name: field.name.clone(),
            r#type: field.kind.clone(),
        }
    }
}

impl LasReport {
    fn new(las: &LasInfo) -> Self {
        let classes = las.classes.iter().map(|&(class, points)| ClassReport { class, points });
        let returns = las.returns.iter().map(|&(number, points)| ReturnReport {
            r#return: number,
            points,
        });
        Self {
            version: las.version.clone(),
            point_format: las.point_format,
            record_bytes: las.record_length,
            is_compressed: las.is_compressed,
            system: las.system.clone(),
            software: las.software.clone(),
            created_year: las.created.map(|(year, _)| year),
            created_day: las.created.map(|(_, day)| day),
            scale: las.scale,
            offset: las.offset,
            classes: classes.collect(),
            returns: returns.collect(),
            copc_levels: las.copc.and_then(|copc| copc.levels),
            copc_spacing: las.copc.map(|copc| copc.spacing),
        }
    }
}
