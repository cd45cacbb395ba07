//! The contents of vector data: geometries by type, their positions, and fields.

use crate::input::content;
use crate::input::describe::info::Contents;
use crate::input::error::InputError;
#[cfg(feature = "geopackage")]
use crate::input::formats::geopackage;
use crate::input::formats::shapes::{Event, Kind, Shapes};
use crate::input::formats::vector::Vector;
#[cfg(feature = "geopackage")]
use crate::input::layer;
use crate::input::watch::{Reading, Watched};
use std::fs::File;
use std::path::Path;
use std::sync::Arc;

/// Reads all features of all layers.
pub fn scan(path: &Path, vector: Vector, reading: &Reading) -> Result<Vec<Contents>, InputError> {
    let file = Watched::open(path, reading, None)?;
    let watch = Arc::clone(&file.watch);
    content::check(path, vector.format(), &file.head())?;
    let contents = scan_layers(file, vector).map_err(|error| watch.explain(error))?;
    watch.check()?;
    Ok(contents)
}

fn scan_layers(file: Watched<Arc<File>>, vector: Vector) -> Result<Vec<Contents>, InputError> {
    #[cfg(feature = "geopackage")]
    if vector == Vector::GeoPackage && file.watch.size().is_some() {
        let mut layers = geopackage::list(&file)?;
        if let Some((_, name)) = layer::split(&file.watch.path) {
            layers.retain(|layer| layer.name == name);
        }
        if !layers.is_empty() {
            return layers.into_iter().map(|layer| scan_layer(&file, layer)).collect();
        }
        // The error says which layers there are.
    }
    Ok(vec![scan_shapes(&mut *vector.start_file(file)?)?])
}

#[cfg(feature = "geopackage")]
fn scan_layer(file: &Watched<Arc<File>>, layer: geopackage::ListedLayer) -> Result<Contents, InputError> {
    let mut contents = scan_shapes(&mut *geopackage::open_layer(file, Some(&layer.name))?)?;
    contents.layer = Some(layer.name);
    contents.declared_type = Some(layer.geometry_type);
    Ok(contents)
}

/// Reads all features.
fn scan_shapes(shapes: &mut dyn Shapes) -> Result<Contents, InputError> {
    shapes.keep_fields();
    let mut contents = Contents::new();
    // The numbers of valid positions in the current geometry, and of geometries in the feature.
    let (mut valid, mut geometries) = (0, 0);
    while let Some(event) = shapes.next_event()? {
        let counts = &mut contents.counts;
        match event {
            Event::Position(position) => match position.point_z() {
                Ok(end) => {
                    valid += 1;
                    contents.add_position(end.point, end.z.unwrap_or(f64::NAN));
                }
                Err(_) => counts.invalid += 1,
            },
            Event::LineEnd(_) => {}
            Event::Geometry(kind, _) => {
                geometries += 1;
                let valid = std::mem::take(&mut valid);
                if matches!(kind, Kind::Point | Kind::MultiPoint) {
                    counts.sites += valid;
                }
                match kind {
                    Kind::Point => counts.points += 1,
                    Kind::MultiPoint => counts.multi_points += 1,
                    Kind::LineString => counts.lines += 1,
                    Kind::MultiLineString => counts.multi_lines += 1,
                    Kind::Polygon => counts.polygons += 1,
                    Kind::MultiPolygon => counts.multi_polygons += 1,
                    // They have no positions of their own.
                    Kind::FeatureCollection | Kind::Feature | Kind::GeometryCollection => {}
                }
            }
            Event::Record(_) => {
                counts.features += 1;
                counts.without_geometry += u64::from(std::mem::take(&mut geometries) == 0);
            }
        }
    }
    contents.fields = shapes.fields();
    contents.crs = shapes.crs().map(str::to_owned);
    Ok(contents)
}
