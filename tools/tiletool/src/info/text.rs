//! What a file holds, for people.

use delaunay_tiles::input::{Contents, FileInfo, ItemCounts, LasInfo};
use delaunay_tiles::shown;

use super::report::Report;
use crate::common::{self, bytes, counted, thousands};
use crate::crs;
use crate::numbers::{self, Coordinates, Row, shortened};

/// Maximum number of fields, and of characters of a name, on the screen.
const FIELDS_SHOWN: usize = 40;
const LONGEST_SHOWN: usize = 60;

/// The classes that the LAS specification names.
const CLASSES: [&str; 19] = [
    "never classified",
    "unclassified",
    "ground",
    "low vegetation",
    "medium vegetation",
    "high vegetation",
    "building",
    "low point (noise)",
    "model key point",
    "water",
    "rail",
    "road surface",
    "overlap",
    "wire guard",
    "wire conductor",
    "transmission tower",
    "wire connector",
    "bridge deck",
    "high noise",
];

/// Returns the report for people.
pub fn of(info: &FileInfo, report: &Report) -> String {
    let mut groups = vec![file_rows(info)];
    groups.extend(info.las.as_ref().map(las_rows));
    for (contents, report) in info.contents.iter().zip(&report.contents) {
        groups.push(contents_rows(contents, report.crs.as_deref()));
    }
    numbers::report(&common::shown(&info.path), &groups)
}

fn file_rows(info: &FileInfo) -> Vec<Row> {
    let mut format = match &info.variety {
        Some(variety) => format!("{}: {}", info.format, shown::text(variety)),
        None => info.format.clone(),
    };
    if info.is_gzip {
        format += ", compressed with gzip";
    }
    let mut rows = vec![("format", format)];
    if let Some(size) = info.bytes {
        rows.push(("size", format!("{} ({} bytes)", bytes(size), thousands(size))));
    }
    let layers = info.contents.iter().filter(|contents| contents.layer.is_some());
    match layers.count() {
        0 => {}
        layers => rows.push(("layers", thousands(layers as u64))),
    }
    rows
}

fn las_rows(las: &LasInfo) -> Vec<Row> {
    let show = |values: [f64; 3]| values.map(|value| value.to_string()).join(", ");
    let mut rows = vec![(
        "version",
        format!(
            "{}, point format {}, {} bytes per point",
            las.version, las.point_format, las.record_length
        ),
    )];
    for (title, text) in [("system", &las.system), ("written by", &las.software)] {
        if !text.is_empty() {
            rows.push((title, shown::text(text).into_owned()));
        }
    }
    if let Some((year, day)) = las.created {
        rows.push(("created", format!("{year}, day {day}")));
    }
    rows.push(("scale", show(las.scale)));
    rows.push(("offset", show(las.offset)));
    if let Some(copc) = las.copc {
        let levels = copc.levels.map_or("an unknown number of levels".to_owned(), |levels| {
            counted(levels.into(), "level", "levels")
        });
        rows.push(("octree", format!("{levels}; spacing {} at the root", copc.spacing)));
    }
    let class = |&(class, points): &(u8, u64)| {
        let name = CLASSES.get(usize::from(class)).copied().unwrap_or_default();
        (format!("{class} {name}"), thousands(points))
    };
    rows.extend(list("classes", las.classes.iter().map(class).collect()));
    let of_return = |&(number, points): &(u8, u64)| (number.to_string(), thousands(points));
    rows.extend(list("returns", las.returns.iter().map(of_return).collect()));
    rows
}

fn contents_rows(contents: &Contents, crs: Option<&str>) -> Vec<Row> {
    let mut rows = Vec::new();
    if let Some(layer) = &contents.layer {
        let kind = contents.declared_type.as_deref().unwrap_or_default();
        rows.push(("layer", format!("{}, {}", shown::text(layer), shown::text(kind))));
    }
    rows.extend(count_rows(&contents.counts));
    rows.extend(numbers::bounds(
        contents.bounds,
        contents.z,
        Coordinates::within(contents.bounds),
    ));
    rows.extend(crs.map(|crs| ("CRS", crs::shown(crs))));
    let fields = contents.fields.iter().take(FIELDS_SHOWN).zip(1..);
    let field = |(field, number): (&delaunay_tiles::input::Field, usize)| {
        let name = match &*field.name {
            "" => format!("column {number}"),
            name => shortened(name, LONGEST_SHOWN),
        };
        (name, shortened(&field.kind, LONGEST_SHOWN))
    };
    rows.extend(list("fields", fields.map(field).collect()));
    let hidden = contents.fields.len().saturating_sub(FIELDS_SHOWN) as u64;
    if hidden > 0 {
        rows.push(("", format!("and {} more; --json lists them all", thousands(hidden))));
    }
    rows
}

/// Returns the rows of the kinds of records that occur.
fn count_rows(counts: &ItemCounts) -> Vec<Row> {
    let features = match counts.without_geometry {
        0 => thousands(counts.features),
        without => format!(
            "{}, {} of them without geometry",
            thousands(counts.features),
            thousands(without)
        ),
    };
    let z = match counts.positions_with_z {
        0 => "without z".to_owned(),
        all if all == counts.positions => "with z".to_owned(),
        some => format!("{} of them with z", thousands(some)),
    };
    let mut rows = Vec::new();
    if counts.features > 0 {
        rows.push(("features", features));
    }
    for (title, number) in [
        ("points", counts.points),
        ("multi-points", counts.multi_points),
        ("lines", counts.lines),
        ("multi-lines", counts.multi_lines),
        ("polygons", counts.polygons),
        ("multi-polygons", counts.multi_polygons),
        ("faces", counts.faces),
        ("edges", counts.edges),
        ("segments", counts.segments),
        ("hole points", counts.holes),
        ("withheld", counts.withheld),
        ("invalid", counts.invalid),
        ("sites", counts.sites),
    ] {
        if number > 0 {
            rows.push((title, thousands(number)));
        }
    }
    if counts.positions > 0 {
        rows.push(("positions", format!("{}, {z}", thousands(counts.positions))));
    }
    if rows.is_empty() {
        rows.push(("records", "none".to_owned()));
    }
    rows
}

/// Returns rows of two columns.
fn list(title: &'static str, cells: Vec<(String, String)>) -> Vec<Row> {
    let width = cells.iter().map(|(left, _)| left.chars().count()).max().unwrap_or(0);
    let row = |(n, (left, right)): (usize, (String, String))| {
        let title = if n == 0 { title } else { "" };
        (title, format!("{left:<width$}  {right}").trim_end().to_owned())
    };
    cells.into_iter().enumerate().map(row).collect()
}
