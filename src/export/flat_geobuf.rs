//! FlatGeobuf (<https://flatgeobuf.org>): features as FlatBuffers, after a header with the columns, the
//! reference system, the number of features and their bounds.
//!
//! The features come in the order of the tiles, so there is no index, which would have to be in memory
//! and before all features. The writer of crate `flatgeobuf` keeps something of each feature in memory
//! even without an index, so only its builders are used.

use std::io::Write;

use ::flatgeobuf::{
    Column, ColumnArgs, ColumnType, Crs as FlatCrs, CrsArgs, Feature, FeatureArgs, Geometry, GeometryArgs,
    GeometryType, Header, HeaderArgs,
};
use flatbuffers_of_flatgeobuf::FlatBufferBuilder;

use super::columns::{ColumnKind, signed};
use super::error::{Contradiction, ExportError};
use super::feature::Value;
use super::numbering::Numbering;
use super::output::{ExportJob, Output};
use super::survey::{Bounds, Survey};
use super::tile_part::{CHUNK_BYTES, TilePart};
use super::what::What;
use crate::crs::Crs;
use crate::geometry::VertexIndex;
use crate::store::PassReader;

/// The first bytes of a file of version 3.
const MAGIC: [u8; 8] = *b"fgb\x03fgb\0";

pub(super) async fn write<W: Write + Send + 'static>(
    job: &mut ExportJob<'_>,
    output: &mut Output<W>,
) -> Result<(), ExportError> {
    let what = job.numbering.what();
    job.passes(1);
    let survey = match job.count(what.cut()) {
        Some(count) if job.numbering.writes_all(what.cut()) => Survey {
            count,
            bounds: bounds_of_file(&job.numbering),
        },
        _ => {
            job.passes(1);
            job.survey(what.cut()).await?
        }
    };
    let contents = Contents {
        name: &what.to_string(),
        geometry: match what {
            What::Triangles => GeometryType::Polygon,
            What::Vertices => GeometryType::Point,
            What::Edges => GeometryType::LineString,
        },
        has_z: job.reader().metadata().has_z,
        columns: &columns_of(what),
        count: survey.count,
        bounds: survey.bounds,
    };
    output.push(header(job.reader(), &contents)).await?;
    let features = move |numbering: &Numbering, part: &TilePart, out: &mut Vec<u8>| {
        out.reserve(CHUNK_BYTES as usize / 2);
        let mut builder = FlatBufferBuilder::with_capacity(1024);
        let mut properties = Vec::new();
        part.for_each_feature(numbering, what, |corners, values| {
            builder.reset();
            put_feature(&mut builder, part, corners, values, &mut properties)?;
            out.extend_from_slice(builder.finished_data());
            Ok(())
        })
    };
    job.pass(output, what.cut(), features).await
}

/// Returns the bounds of all vertices, without those of z.
fn bounds_of_file(numbering: &Numbering) -> Bounds {
    let bounds = numbering.reader().metadata().bounds;
    Bounds {
        min: [bounds.min_x, bounds.min_y, 0.0],
        max: [bounds.max_x, bounds.max_y, 0.0],
    }
}

/// What the header of a file says.
pub(super) struct Contents<'a> {
    pub(super) name: &'a str,
    pub(super) geometry: GeometryType,
    pub(super) has_z: bool,
    /// The names and types of the columns, and whether values may be missing.
    pub(super) columns: &'a [(&'static str, ColumnType, bool)],
    pub(super) count: u64,
    pub(super) bounds: Bounds,
}

/// Returns the columns of features.
fn columns_of(what: What) -> Vec<(&'static str, ColumnType, bool)> {
    let column = |&(name, kind): &(&'static str, ColumnKind)| {
        let column_type = match kind {
            // GDAL reads unsigned numbers of 64 bits as floating-point numbers.
            ColumnKind::Number | ColumnKind::OptionalNumber => ColumnType::Long,
            ColumnKind::Kinds => ColumnType::String,
        };
        (name, column_type, kind != ColumnKind::Number)
    };
    what.columns().iter().map(column).collect()
}

/// Returns the bytes before the first feature.
pub(super) fn header(reader: &PassReader, contents: &Contents<'_>) -> Vec<u8> {
    let mut builder = FlatBufferBuilder::new();
    let columns: Vec<_> = contents
        .columns
        .iter()
        .map(|&(name, type_, nullable)| {
            let args = ColumnArgs {
                name: Some(builder.create_string(name)),
                type_,
                nullable,
                ..ColumnArgs::default()
            };
            Column::create(&mut builder, &args)
        })
        .collect();
    let crs = reader.directory().lists.crs.as_deref().map(Crs::new);
    let crs = crs.map(|crs| {
        let epsg = crs.epsg().and_then(|code| i32::try_from(code).ok());
        let name = (epsg.is_none() && crs.wkt().is_none()).then_some(crs.text());
        let args = CrsArgs {
            org: epsg.map(|_| builder.create_string("EPSG")),
            code: epsg.unwrap_or(0),
            name: name.map(|name| builder.create_string(name)),
            wkt: crs.wkt().map(|wkt| builder.create_string(&wkt)),
            ..CrsArgs::default()
        };
        FlatCrs::create(&mut builder, &args)
    });
    let Bounds { min, max } = contents.bounds;
    let envelope = [min[0], min[1], max[0], max[1]];
    let args = HeaderArgs {
        name: Some(builder.create_string(contents.name)),
        envelope: (!contents.bounds.is_empty()).then(|| builder.create_vector(&envelope)),
        geometry_type: contents.geometry,
        has_z: contents.has_z,
        columns: Some(builder.create_vector(&columns)),
        features_count: contents.count,
        index_node_size: 0,
        crs,
        ..HeaderArgs::default()
    };
    let header = Header::create(&mut builder, &args);
    builder.finish_size_prefixed(header, None);
    [&MAGIC, builder.finished_data()].concat()
}

/// Puts a feature into an empty builder.
fn put_feature(
    builder: &mut FlatBufferBuilder<'_>,
    part: &TilePart,
    corners: &[VertexIndex],
    values: &[Value],
    properties: &mut Vec<u8>,
) -> Result<(), Contradiction> {
    properties.clear();
    for (&value, column) in values.iter().zip(0u16..) {
        if value == Value::Missing {
            continue;
        }
        properties.extend_from_slice(&column.to_le_bytes());
        match value {
            Value::Number(number) => properties.extend_from_slice(&signed(number)?.to_le_bytes()),
            Value::Text(text) => {
                properties.extend_from_slice(&(text.len() as u32).to_le_bytes());
                properties.extend_from_slice(text.as_bytes());
            }
            Value::Missing => {}
        }
    }
    // A polygon ends at its first corner.
    let closing = corners.first().filter(|_| corners.len() == 3);
    let (mut xy, mut z) = ([0.0; 8], [0.0; 4]);
    let mut count = 0;
    for &corner in corners.iter().chain(closing) {
        let p = part.tile.point(corner);
        xy[2 * count..2 * count + 2].copy_from_slice(&[p.x, p.y]);
        z[count] = part.tile.z(corner).unwrap_or(0.0);
        count += 1;
    }
    let geometry = GeometryArgs {
        z: part.tile.has_z().then(|| builder.create_vector(&z[..count])),
        xy: Some(builder.create_vector(&xy[..2 * count])),
        ..GeometryArgs::default()
    };
    let feature = FeatureArgs {
        geometry: Some(Geometry::create(builder, &geometry)),
        properties: Some(builder.create_vector(properties)),
        columns: None,
    };
    let feature = Feature::create(builder, &feature);
    builder.finish_size_prefixed(feature, None);
    Ok(())
}
