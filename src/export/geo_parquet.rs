//! GeoParquet 1.1 (<https://geoparquet.org/releases/v1.1.0/>): a table of features with their geometry
//! as well-known binary, in row groups of bounded size.
//!
//! Rows come in the order of the tiles. Since tiles are compact, the statistics of the columns x and y
//! of vertices let readers skip row groups. The other columns are those of FlatGeobuf.
//!
//! The reference system is written as PROJJSON, which the specification demands (see `crs_member`).

use std::io::{self, Write};
use std::mem;
use std::sync::Arc;

use ::parquet::basic::{Compression, Encoding};
use ::parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use ::parquet::errors::ParquetError;
use ::parquet::file::metadata::KeyValue;
use ::parquet::file::properties::{EnabledStatistics, WriterProperties};
use ::parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use ::parquet::schema::parser::parse_message_type;
use bytes::Bytes;
use futures::future::{BoxFuture, FutureExt};

use super::columns::{ColumnKind, signed};
use super::crs_member::CrsMember;
use super::error::{Contradiction, ExportError};
use super::feature::{KINDS, Value};
use super::numbering::Numbering;
use super::output::{ExportJob, Output, Sink, blocking};
use super::survey::Bounds;
use super::text::put;
use super::tile_part::TilePart;
use super::what::What;
use crate::crs::Crs;
use crate::store::Needs;

/// The number of rows in a row group, except the last one.
const GROUP: usize = 1 << 16;
/// The bytes that a row takes while its group is encoded, at most: as it came, in columns, encoded and
/// compressed.
const PER_ROW: u64 = 600;
/// The key of the reference system's text, where it is not PROJJSON.
const CRS_TEXT: &str = "delaunay-tiles:crs";
/// The number that stands for a missing value. No sound file comes near.
const MISSING: i64 = i64::MIN;

pub(super) async fn write<W: Write + Send + 'static>(
    job: &mut ExportJob<'_>,
    output: &mut Output<W>,
) -> Result<(), ExportError> {
    job.passes(1);
    let what = job.numbering.what();
    let crs = job.reader().directory().lists.crs.as_deref().map(Crs::new);
    let crs = CrsMember::of(crs.as_ref());
    job.notes.extend(crs.note());
    let mut groups = RowGroups {
        table: Some(Table::new(&job.numbering, what, crs).map_err(failed)?),
        row_bytes: Shape::new(&job.numbering, what).row_bytes(),
        rows: Vec::new(),
        output,
    };
    let needs = ExportJob::needs();
    let needs = Needs {
        fixed: needs.fixed + PER_ROW * GROUP as u64,
        ..needs
    };
    let rows = move |numbering: &Numbering, part: &TilePart, out: &mut Vec<u8>| put_rows(numbering, what, part, out);
    job.pass_to(&mut groups, what.cut(), needs, rows).await?;
    groups.finish().await
}

/// Appends a row for each feature: the coordinates of its corners, then its values.
fn put_rows(numbering: &Numbering, what: What, part: &TilePart, out: &mut Vec<u8>) -> Result<(), Contradiction> {
    let has_z = numbering.reader().metadata().has_z;
    part.for_each_feature(numbering, what, |corners, values| {
        for &corner in corners {
            let p = part.tile.point(corner);
            let z = has_z.then(|| part.tile.z(corner).unwrap_or(0.0));
            for number in [p.x, p.y].into_iter().chain(z) {
                out.extend_from_slice(&number.to_le_bytes());
            }
        }
        for &value in values {
            let number = match value {
                Value::Number(number) => signed(number)?,
                Value::Text(text) => KINDS.iter().position(|&kinds| kinds == text).unwrap_or(0) as i64,
                Value::Missing => MISSING,
            };
            out.extend_from_slice(&number.to_le_bytes());
        }
        Ok(())
    })
}

fn failed(error: ParquetError) -> ExportError {
    ExportError::Write {
        suffix: "parquet",
        source: io::Error::other(error),
    }
}

/// Collects rows, and encodes each group of them on a thread for blocking work.
struct RowGroups<'o, W> {
    /// `None` while a thread encodes.
    table: Option<Table>,
    row_bytes: usize,
    rows: Vec<u8>,
    output: &'o mut Output<W>,
}

impl<W: Write + Send + 'static> Sink for RowGroups<'_, W> {
    fn push(&mut self, chunk: Vec<u8>) -> BoxFuture<'_, Result<(), ExportError>> {
        let pushed = async move {
            self.rows.extend_from_slice(&chunk);
            let group = GROUP * self.row_bytes;
            while self.rows.len() >= group {
                let rest = self.rows.split_off(group);
                let rows = mem::replace(&mut self.rows, rest);
                self.encode(move |table| table.put_group(rows)).await?;
            }
            Ok(())
        };
        pushed.boxed()
    }
}

impl<W: Write + Send + 'static> RowGroups<'_, W> {
    /// Runs `work` with the table on a thread for blocking work, and writes what it encoded.
    async fn encode(
        &mut self,
        work: impl FnOnce(&mut Table) -> Result<(), ParquetError> + Send + 'static,
    ) -> Result<(), ExportError> {
        let mut table = self.table.take().expect("it came back from encoding");
        let (table, encoded) = blocking(move || {
            let encoded = work(&mut table).and_then(|()| table.take_bytes());
            (table, encoded)
        })
        .await?;
        self.table = Some(table);
        self.output.push(encoded.map_err(failed)?).await
    }

    /// Writes the last rows and the description of the table.
    async fn finish(mut self) -> Result<(), ExportError> {
        let rows = mem::take(&mut self.rows);
        self.encode(move |table| {
            if !rows.is_empty() {
                table.put_group(rows)?;
            }
            table.finish()
        })
        .await
    }
}

/// What the rows of a table consist of.
#[derive(Clone, Copy)]
struct Shape {
    what: What,
    /// The number of coordinates of a corner: 2 or 3.
    dims: usize,
    /// The number of corners of a feature.
    corners: usize,
}

impl Shape {
    fn new(numbering: &Numbering, what: What) -> Self {
        Self {
            what,
            dims: if numbering.reader().metadata().has_z { 3 } else { 2 },
            corners: match what {
                What::Triangles => 3,
                What::Vertices => 1,
                What::Edges => 2,
            },
        }
    }

    fn coordinates(self) -> usize {
        self.dims * self.corners
    }

    fn row_bytes(self) -> usize {
        8 * (self.coordinates() + self.what.columns().len())
    }

    /// Returns the type of the rows.
    fn schema(self) -> String {
        let mut columns: Vec<_> = self
            .what
            .columns()
            .iter()
            .map(|(name, kind)| match kind {
                ColumnKind::Number => format!("required int64 {name};"),
                ColumnKind::OptionalNumber => format!("optional int64 {name};"),
                ColumnKind::Kinds => format!("optional binary {name} (STRING);"),
            })
            .collect();
        columns.extend(self.coordinate_columns().map(|name| format!("required double {name};")));
        columns.push("required binary geometry;".to_owned());
        format!("message {} {{ {} }}", self.what, columns.join(" "))
    }

    /// Returns the columns of coordinates, which only vertices have.
    fn coordinate_columns(self) -> impl Iterator<Item = &'static str> {
        let count = if self.what == What::Vertices { self.dims } else { 0 };
        ["x", "y", "z"].into_iter().take(count)
    }

    /// Returns the bytes of well-known binary before the coordinates.
    fn wkb_prefix(self) -> Vec<u8> {
        let (kind, numbers): (u32, &[u32]) = match self.what {
            What::Vertices => (1, &[]),
            What::Edges => (2, &[2]),
            // A ring of four points, of which the last is the first.
            What::Triangles => (3, &[1, 4]),
        };
        let kind = kind + if self.dims == 3 { 1000 } else { 0 };
        let mut prefix = vec![1];
        for number in [kind].iter().chain(numbers) {
            prefix.extend_from_slice(&number.to_le_bytes());
        }
        prefix
    }
}

/// A table as it is encoded.
struct Table {
    shape: Shape,
    crs: CrsMember,
    writer: SerializedFileWriter<Vec<u8>>,
    bounds: Bounds,
}

impl Table {
    fn new(numbering: &Numbering, what: What, crs: CrsMember) -> Result<Self, ParquetError> {
        let shape = Shape::new(numbering, what);
        let schema = Arc::new(parse_message_type(&shape.schema())?);
        let mut properties = WriterProperties::builder()
            .set_created_by(concat!("delaunay-tiles ", env!("CARGO_PKG_VERSION")).to_owned())
            .set_compression(Compression::SNAPPY)
            .set_dictionary_enabled(false)
            .set_statistics_enabled(EnabledStatistics::Chunk)
            // An index of pages would be in memory until the end.
            .set_offset_index_disabled(true)
            .set_column_statistics_enabled("geometry".into(), EnabledStatistics::None);
        for &(name, kind) in what.columns() {
            properties = match kind {
                ColumnKind::Kinds => properties.set_column_dictionary_enabled(name.into(), true),
                _ => properties.set_column_encoding(name.into(), Encoding::DELTA_BINARY_PACKED),
            };
        }
        Ok(Self {
            shape,
            crs,
            writer: SerializedFileWriter::new(Vec::new(), schema, Arc::new(properties.build()))?,
            bounds: Bounds::EMPTY,
        })
    }

    /// Encodes a group of rows.
    fn put_group(&mut self, rows: Vec<u8>) -> Result<(), ParquetError> {
        let shape = self.shape;
        let coordinates = shape.coordinates();
        let number = |row: &[u8], at: usize| i64::from_le_bytes(row[8 * at..8 * at + 8].try_into().expect("8 bytes"));
        let column = |at: usize| rows.chunks_exact(shape.row_bytes()).map(move |row| number(row, at));
        let mut group = self.writer.next_row_group()?;
        for (&(_, kind), at) in shape.what.columns().iter().zip(coordinates..) {
            let numbers = column(at);
            match kind {
                ColumnKind::Number => put_column::<Int64Type>(&mut group, &numbers.collect::<Vec<_>>(), None)?,
                ColumnKind::OptionalNumber => {
                    let levels: Vec<_> = column(at).map(|number| i16::from(number != MISSING)).collect();
                    let numbers: Vec<_> = numbers.filter(|&number| number != MISSING).collect();
                    put_column::<Int64Type>(&mut group, &numbers, Some(&levels))?;
                }
                ColumnKind::Kinds => {
                    let levels: Vec<_> = column(at).map(|number| i16::from(number != MISSING)).collect();
                    let numbers = numbers.filter(|&number| number != MISSING);
                    let texts: Vec<_> = numbers
                        .map(|number| ByteArray::from(KINDS[number as usize & 7]))
                        .collect();
                    put_column::<ByteArrayType>(&mut group, &texts, Some(&levels))?;
                }
            }
        }
        for at in 0..shape.coordinate_columns().count() {
            let numbers: Vec<_> = column(at).map(|bits| f64::from_bits(bits as u64)).collect();
            put_column::<DoubleType>(&mut group, &numbers, None)?;
        }
        let geometries = geometries(shape, &rows, &mut self.bounds);
        put_column::<ByteArrayType>(&mut group, &geometries, None)?;
        group.close()?;
        Ok(())
    }

    /// Encodes the description of the table, which comes last.
    fn finish(&mut self) -> Result<(), ParquetError> {
        let Shape { what, dims, .. } = self.shape;
        let kind = match what {
            What::Triangles => "Polygon",
            What::Vertices => "Point",
            What::Edges => "LineString",
        };
        let mut geo = Vec::new();
        put(
            &mut geo,
            format_args!(
                "{{\"version\":\"1.1.0\",\"primary_column\":\"geometry\",\"columns\":{{\"geometry\":{{\
                 \"encoding\":\"WKB\",\"geometry_types\":[\"{kind}{}\"]",
                if dims == 3 { " Z" } else { "" }
            ),
        );
        if let Some(crs) = self.crs.json() {
            put(&mut geo, format_args!(",\"crs\":{crs}"));
        }
        if what == What::Triangles {
            geo.extend_from_slice(b",\"orientation\":\"counterclockwise\"");
        }
        if !self.bounds.is_empty() {
            let Bounds { min, max } = self.bounds;
            let bbox = [&min[..dims], &max[..dims]].concat();
            put(&mut geo, format_args!(",\"bbox\":{bbox:?}"));
        }
        geo.extend_from_slice(b"}}}");
        let geo = String::from_utf8_lossy(&geo).into_owned();
        self.writer
            .append_key_value_metadata(KeyValue::new("geo".to_owned(), geo));
        if let CrsMember::Text(text) = &self.crs {
            let text = KeyValue::new(CRS_TEXT.to_owned(), text.clone());
            self.writer.append_key_value_metadata(text);
        }
        self.writer.finish()?;
        Ok(())
    }

    /// Takes the bytes encoded so far.
    fn take_bytes(&mut self) -> Result<Vec<u8>, ParquetError> {
        self.writer.flush()?;
        Ok(mem::take(self.writer.inner_mut()))
    }
}

fn put_column<T: ::parquet::data_type::DataType>(
    group: &mut SerializedRowGroupWriter<'_, Vec<u8>>,
    values: &[T::T],
    levels: Option<&[i16]>,
) -> Result<(), ParquetError> {
    let mut column = group
        .next_column()?
        .ok_or_else(|| ParquetError::General("a row group has too few columns".to_owned()))?;
    column.typed::<T>().write_batch(values, levels, None)?;
    column.close()
}

/// Returns the geometry of each row as well-known binary, and adds their corners to `bounds`.
fn geometries(shape: Shape, rows: &[u8], bounds: &mut Bounds) -> Vec<ByteArray> {
    let prefix = shape.wkb_prefix();
    let (corner_bytes, closing) = (8 * shape.dims, shape.what == What::Triangles);
    let length = prefix.len() + corner_bytes * (shape.corners + usize::from(closing));
    let count = rows.len() / shape.row_bytes();
    let mut all = Vec::with_capacity(count * length);
    for row in rows.chunks_exact(shape.row_bytes()) {
        let corners = &row[..8 * shape.coordinates()];
        for corner in corners.chunks_exact(corner_bytes) {
            let mut position = [0.0; 3];
            for (number, bytes) in position.iter_mut().zip(corner.as_chunks::<8>().0) {
                *number = f64::from_le_bytes(*bytes);
            }
            bounds.include(position);
        }
        all.extend_from_slice(&prefix);
        all.extend_from_slice(corners);
        if closing {
            all.extend_from_slice(&corners[..corner_bytes]);
        }
    }
    let all = Bytes::from(all);
    (0..count)
        .map(|row| ByteArray::from(all.slice(row * length..(row + 1) * length)))
        .collect()
}
