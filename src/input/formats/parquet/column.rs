//! The values of one column in one row group.

use crate::input::formats::parquet::chunks::{Chunks, PageBytes, Pages};
use ::parquet::basic::ConvertedType;
use ::parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use ::parquet::data_type::{ByteArray, DataType, DoubleType, FloatType, Int32Type, Int64Type};
use ::parquet::errors::{ParquetError, Result};
use ::parquet::file::metadata::RowGroupMetaData;
use ::parquet::file::reader::SerializedPageReader;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

pub struct Column {
    reader: ColumnReader,
    /// The definition level of a value that is not null.
    defined: i16,
    levels: Vec<i16>,
    /// For decimals, the power of ten by which integers are divided.
    divisor: f64,
    is_unsigned: bool,
    /// The number of values in the pages that the reader has taken, and of those that were read.
    in_pages: Arc<AtomicU64>,
    read: u64,
}

impl Column {
    /// Begins to read leaf `leaf` of a row group.
    pub fn new(chunks: &Arc<Chunks>, group: &RowGroupMetaData, leaf: usize) -> Result<Self> {
        let about = group.column(leaf);
        let descriptor = about.column_descr_ptr();
        let rows = usize::try_from(group.num_rows())?;
        let bytes = Arc::new(PageBytes::new(chunks, about.compression())?);
        let pages = SerializedPageReader::new(bytes, about, rows, None)?;
        let in_pages = Arc::new(AtomicU64::new(0));
        let is_decimal = descriptor.converted_type() == ConvertedType::DECIMAL;
        Ok(Self {
            defined: descriptor.max_def_level(),
            levels: Vec::new(),
            divisor: if is_decimal {
                10f64.powi(descriptor.type_scale())
            } else {
                1.0
            },
            is_unsigned: descriptor.converted_type() == ConvertedType::UINT_32,
            reader: get_column_reader(descriptor, Box::new(Pages::new(pages, Arc::clone(&in_pages)))),
            in_pages,
            read: 0,
        })
    }

    /// Appends the numbers of the next `rows` rows; `None` for null.
    pub fn numbers(&mut self, rows: usize, numbers: &mut Vec<Option<f64>>) -> Result<()> {
        let (defined, divisor) = (self.defined, self.divisor);
        let levels = &mut self.levels;
        match &mut self.reader {
            ColumnReader::DoubleColumnReader(reader) => {
                take::<DoubleType, _>(reader, defined, rows, levels, numbers, |value| value)
            }
            ColumnReader::FloatColumnReader(reader) => {
                take::<FloatType, _>(reader, defined, rows, levels, numbers, f64::from)
            }
            ColumnReader::Int32ColumnReader(reader) if self.is_unsigned => {
                take::<Int32Type, _>(reader, defined, rows, levels, numbers, |value| f64::from(value as u32))
            }
            ColumnReader::Int32ColumnReader(reader) => {
                take::<Int32Type, _>(reader, defined, rows, levels, numbers, |value| {
                    f64::from(value) / divisor
                })
            }
            ColumnReader::Int64ColumnReader(reader) => {
                take::<Int64Type, _>(reader, defined, rows, levels, numbers, |value| value as f64 / divisor)
            }
            _ => Err(ParquetError::General("the column has no numbers".to_owned())),
        }
    }

    /// Appends the bytes of the next rows, at most `rows`; `None` for null. Returns their number,
    /// which is not 0 unless `rows` is. They hold the page that they are in, so they are of one page.
    pub fn bytes(&mut self, rows: usize, bytes: &mut Vec<Option<ByteArray>>) -> Result<usize> {
        let ColumnReader::ByteArrayColumnReader(reader) = &mut self.reader else {
            return Err(ParquetError::General("the column has no bytes".to_owned()));
        };
        let in_page = self.in_pages.load(Ordering::Relaxed).saturating_sub(self.read);
        // The first row of a page is read alone: before, the number of those in it is not known.
        let rows = rows.min(usize::try_from(in_page).unwrap_or(usize::MAX).max(1));
        take(reader, self.defined, rows, &mut self.levels, bytes, |value| value)?;
        self.read += rows as u64;
        Ok(rows)
    }
}

/// Appends the values of the next `rows` rows, converted.
fn take<T: DataType, V>(
    reader: &mut ColumnReaderImpl<T>,
    defined: i16,
    rows: usize,
    levels: &mut Vec<i16>,
    taken: &mut Vec<Option<V>>,
    convert: impl Fn(T::T) -> V,
) -> Result<()> {
    levels.clear();
    let mut values = Vec::new();
    let (found, ..) = reader.read_records(rows, Some(levels), None, &mut values)?;
    if found != rows {
        return Err(ParquetError::General(format!(
            "a column of a row group ends after {found} of {rows} rows"
        )));
    }
    let mut values = values.into_iter().map(convert);
    match defined {
        0 => taken.extend(values.map(Some)),
        _ => taken.extend(
            levels
                .iter()
                .map(|&level| if level == defined { values.next() } else { None }),
        ),
    }
    match taken.len() == rows {
        true => Ok(()),
        false => Err(ParquetError::General("a column has more values than rows".to_owned())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::watch::{Reading, Watched};
    use ::parquet::file::metadata::ParquetMetaDataReader;
    use ::parquet::file::properties::WriterProperties;
    use ::parquet::file::writer::SerializedFileWriter;
    use ::parquet::schema::parser::parse_message_type;

    /// Rows of several pages would hold all of these pages in memory.
    #[test]
    fn bytes_are_read_page_by_page() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bytes.parquet");
        let schema = Arc::new(parse_message_type("message m { required binary b; }").unwrap());
        let properties = WriterProperties::builder()
            .set_dictionary_enabled(false)
            .set_write_batch_size(1)
            .set_data_page_size_limit(1000);
        let file = std::fs::File::create(&path).unwrap();
        let mut writer = SerializedFileWriter::new(file, schema, Arc::new(properties.build())).unwrap();
        let mut group = writer.next_row_group().unwrap();
        let mut column = group.next_column().unwrap().unwrap();
        let values: Vec<ByteArray> = (0..100u8).map(|n| vec![n; 100].into()).collect();
        column
            .typed::<::parquet::data_type::ByteArrayType>()
            .write_batch(&values, None, None)
            .unwrap();
        column.close().unwrap();
        group.close().unwrap();
        writer.close().unwrap();

        let file = std::fs::File::open(&path).unwrap();
        let size = file.metadata().unwrap().len();
        let metadata = ParquetMetaDataReader::new().parse_and_finish(&file).unwrap();
        let watched = Watched::open(&path, &Reading::default(), None).unwrap();
        let chunks = Arc::new(Chunks::new(watched, size));
        let mut column = Column::new(&chunks, metadata.row_group(0), 0).unwrap();
        let mut all = Vec::new();
        while all.len() < values.len() {
            let mut some = Vec::new();
            let rows = column.bytes(values.len() - all.len(), &mut some).unwrap();
            assert!((1..=10).contains(&rows) && rows == some.len(), "{rows} rows");
            all.extend(some.into_iter().flatten());
        }
        assert_eq!(all, values);
    }
}
