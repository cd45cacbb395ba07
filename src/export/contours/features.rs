//! Contours as features of GeoJSON and FlatGeobuf: lines with the height in the property `z`, and in
//! `closed` whether the line ends where it begins.

use std::ops::Range;
use std::path::Path;

use crate::export::error::ExportError;
use crate::export::format::Format;
use crate::export::geojson;
use crate::export::output::Output;
#[cfg(feature = "flatgeobuf")]
use crate::export::spool::Spool;
use crate::export::survey::Bounds;
use crate::export::text::{put, put_number};
use crate::geometry::Point;
use crate::store::PassReader;

/// A complete contour.
#[derive(Clone, Copy)]
pub(super) struct Contour<'a> {
    pub(super) z: f64,
    /// At least two. The last point of a closed one is the first.
    pub(super) points: &'a [Point],
    pub(super) is_closed: bool,
}

/// Features, formatted.
pub(super) struct Features {
    encoding: Encoding,
    pub(super) bytes: Vec<u8>,
    pub(super) count: u64,
    pub(super) points: u64,
    bounds: Bounds,
}

/// How features are formatted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    GeoJson,
    #[cfg(feature = "flatgeobuf")]
    FlatGeobuf,
}

impl Encoding {
    /// The number of points of a feature that are formatted at once, if it can be formatted in parts.
    const PART: usize = 1 << 14;
    /// The most bytes of a formatted point: three numbers of up to 24 digits and signs in GeoJSON.
    pub(super) const POINT_BYTES: u64 = 80;

    pub(super) fn new(format: Format) -> Result<Self, ExportError> {
        match format {
            Format::GeoJson => Ok(Self::GeoJson),
            #[cfg(feature = "flatgeobuf")]
            Format::FlatGeobuf => Ok(Self::FlatGeobuf),
            #[cfg(not(feature = "flatgeobuf"))]
            Format::FlatGeobuf => Err(crate::export::write::not_compiled("flatgeobuf")),
            format => Err(ExportError::Limit(format!(
                "contours are exported as GeoJSON or FlatGeobuf, and not as {format}"
            ))),
        }
    }

    /// Returns the memory that a contour takes for each of its points while it is read and formatted.
    pub(super) fn memory_per_point(self) -> u64 {
        let point = size_of::<Point>() as u64;
        match self {
            Self::GeoJson => point,
            // Its coordinates, a buffer that grows, and two copies of it.
            #[cfg(feature = "flatgeobuf")]
            Self::FlatGeobuf => point + 24 + 3 * 24 + 2 * 24,
        }
    }

    /// Returns the parts in which a contour of so many points is formatted.
    pub(super) fn parts(self, points: usize) -> Vec<Range<usize>> {
        match self {
            Self::GeoJson => {
                let starts = (0..points).step_by(Self::PART);
                starts.map(|start| start..points.min(start + Self::PART)).collect()
            }
            #[cfg(feature = "flatgeobuf")]
            Self::FlatGeobuf => std::iter::once(0..points).collect(),
        }
    }
}

impl Features {
    pub(super) fn new(encoding: Encoding) -> Self {
        Self {
            encoding,
            bytes: Vec::new(),
            count: 0,
            points: 0,
            bounds: Bounds::EMPTY,
        }
    }

    /// Adds a contour.
    pub(super) fn add(&mut self, contour: Contour<'_>) -> Result<(), ExportError> {
        for part in self.encoding.parts(contour.points.len()) {
            self.add_part(contour, part)?;
        }
        Ok(())
    }

    /// Adds a part of a contour; the parts come in order.
    pub(super) fn add_part(&mut self, contour: Contour<'_>, part: Range<usize>) -> Result<(), ExportError> {
        let points = &contour.points[part.clone()];
        self.count += u64::from(part.start == 0);
        self.points += points.len() as u64;
        for point in points {
            self.bounds.include([point.x, point.y, contour.z]);
        }
        match self.encoding {
            Encoding::GeoJson => {
                put_geojson(contour, part, &mut self.bytes);
                Ok(())
            }
            #[cfg(feature = "flatgeobuf")]
            Encoding::FlatGeobuf => put_flat_geobuf(contour, &mut self.bytes),
        }
    }
}

/// Appends a part of a feature, and before it what separates it from the one before.
fn put_geojson(contour: Contour<'_>, part: Range<usize>, out: &mut Vec<u8>) {
    let mut z = Vec::new();
    put_number(&mut z, contour.z);
    if part.start == 0 {
        out.extend_from_slice(b",\n{\"type\":\"Feature\",\"properties\":{\"z\":");
        out.extend_from_slice(&z);
        let is_closed = contour.is_closed;
        put(
            out,
            format_args!(",\"closed\":{is_closed}}},\"geometry\":{{\"type\":\"LineString\",\"coordinates\":["),
        );
    }
    for (index, point) in part.clone().zip(&contour.points[part.clone()]) {
        out.extend_from_slice(if index == 0 { b"[" } else { b",[" });
        for number in [point.x, point.y] {
            put_number(out, number);
            out.push(b',');
        }
        out.extend_from_slice(&z);
        out.push(b']');
    }
    if part.end == contour.points.len() {
        out.extend_from_slice(b"]}}");
    }
}

#[cfg(feature = "flatgeobuf")]
fn put_flat_geobuf(contour: Contour<'_>, out: &mut Vec<u8>) -> Result<(), ExportError> {
    use ::flatgeobuf::{Feature, FeatureArgs, Geometry, GeometryArgs};
    use flatbuffers_of_flatgeobuf::FlatBufferBuilder;

    let points = contour.points;
    // Offsets in a feature have 31 bits.
    if points.len() > (i32::MAX as usize - 1024) / 24 {
        return Err(ExportError::Limit(format!(
            "the contour at {} has {} points, too many for a feature of FlatGeobuf; choose GeoJSON",
            contour.z,
            points.len()
        )));
    }
    let mut properties = Vec::new();
    properties.extend_from_slice(&0u16.to_le_bytes());
    properties.extend_from_slice(&contour.z.to_le_bytes());
    properties.extend_from_slice(&1u16.to_le_bytes());
    properties.push(u8::from(contour.is_closed));
    let mut builder = FlatBufferBuilder::with_capacity(24 * points.len() + 256);
    let xy: Vec<f64> = points.iter().flat_map(|point| [point.x, point.y]).collect();
    let xy = builder.create_vector(&xy);
    let z = builder.create_vector(&vec![contour.z; points.len()]);
    let geometry = GeometryArgs {
        xy: Some(xy),
        z: Some(z),
        ..GeometryArgs::default()
    };
    let feature = FeatureArgs {
        geometry: Some(Geometry::create(&mut builder, &geometry)),
        properties: Some(builder.create_vector(&properties)),
        columns: None,
    };
    let feature = Feature::create(&mut builder, &feature);
    builder.finish_size_prefixed(feature, None);
    out.extend_from_slice(builder.finished_data());
    Ok(())
}

/// The output, and what was written to it.
pub(super) struct FeatureSink<W> {
    output: Output<W>,
    /// The features of FlatGeobuf, whose number and bounds are in the header before them.
    #[cfg(feature = "flatgeobuf")]
    spool: Option<Spool>,
    #[cfg(feature = "flatgeobuf")]
    bounds: Bounds,
    pub(super) count: u64,
    pub(super) points: u64,
}

impl<W: std::io::Write + Send + 'static> FeatureSink<W> {
    /// Opens an output. Features that must wait for a header wait in a file in `scratch`.
    pub(super) async fn open(
        reader: &PassReader,
        encoding: Encoding,
        mut output: Output<W>,
        #[cfg_attr(
            not(feature = "flatgeobuf"),
            allow(unused_variables, reason = "only FlatGeobuf waits")
        )]
        scratch: &Path,
    ) -> Result<Self, ExportError> {
        if encoding == Encoding::GeoJson {
            output.push(geojson::header(reader)).await?;
        }
        Ok(Self {
            output,
            #[cfg(feature = "flatgeobuf")]
            spool: match encoding {
                Encoding::GeoJson => None,
                Encoding::FlatGeobuf => Some(Spool::create(scratch).await?),
            },
            #[cfg(feature = "flatgeobuf")]
            bounds: Bounds::EMPTY,
            count: 0,
            points: 0,
        })
    }

    /// Takes features.
    pub(super) async fn push(&mut self, mut features: Features) -> Result<(), ExportError> {
        let is_first = self.points == 0;
        self.count += features.count;
        self.points += features.points;
        if features.bytes.is_empty() {
            return Ok(());
        }
        #[cfg(feature = "flatgeobuf")]
        if let Some(spool) = &mut self.spool {
            self.bounds.union(&features.bounds);
            return spool.append(features.bytes).await;
        }
        if is_first {
            // Nothing is before it.
            features.bytes.drain(..b",\n".len());
        }
        self.output.push(features.bytes).await
    }

    /// Writes what is before and behind the features. Returns the output and the number of its bytes.
    pub(super) async fn finish(
        mut self,
        #[cfg_attr(
            not(feature = "flatgeobuf"),
            allow(unused_variables, reason = "only FlatGeobuf needs it")
        )]
        reader: &PassReader,
    ) -> Result<(W, u64), ExportError> {
        #[cfg(feature = "flatgeobuf")]
        if let Some(spool) = &mut self.spool {
            use ::flatgeobuf::{ColumnType, GeometryType};

            use crate::export::flat_geobuf::{Contents, header};

            let contents = Contents {
                name: "contours",
                geometry: GeometryType::LineString,
                has_z: true,
                columns: &[("z", ColumnType::Double, false), ("closed", ColumnType::Bool, false)],
                count: self.count,
                bounds: self.bounds,
            };
            self.output.push(header(reader, &contents)).await?;
            spool.copy(0..spool.length(), &mut self.output).await?;
            return self.output.finish().await;
        }
        self.output.push(geojson::FOOTER.to_vec()).await?;
        self.output.finish().await
    }
}
