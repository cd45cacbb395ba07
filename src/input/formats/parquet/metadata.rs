//! The end of a Parquet file: its metadata, within limits.

use crate::input::caught::catch;
use crate::input::formats::parquet::chunks::Chunks;
use crate::input::formats::parquet::thrift;
use ::parquet::errors::ParquetError;
use ::parquet::file::metadata::{ParquetMetaData, ParquetMetaDataReader};
use ::parquet::file::reader::Length;

/// The limit on the bytes of the metadata.
const LONGEST: u64 = 8 << 20;

/// The limits on the schema.
const MOST_ELEMENTS: u64 = 10_000;
const DEEPEST: usize = 32;
const MOST_PATH_BYTES: u64 = 16 << 20;

/// What is wrong with a file, as a whole or in its pages.
pub struct Problem {
    pub problem: String,
    pub hint: &'static str,
    pub source: Option<ParquetError>,
}

impl Problem {
    pub fn new(problem: impl Into<String>, hint: &'static str) -> Self {
        Self {
            problem: problem.into(),
            hint,
            source: None,
        }
    }

    /// The problem that the decoder reports, or that it panicked.
    pub fn decoding(what: impl Into<String>, source: Option<ParquetError>) -> Self {
        let hint = "the file is damaged or cut short, or written in a way that is not supported";
        Self {
            source,
            ..Self::new(what, hint)
        }
    }
}

const NO_PARQUET: &str = "this is not a Parquet file, or it is cut short";

/// Reads the metadata.
pub fn read(chunks: &Chunks) -> Result<ParquetMetaData, Problem> {
    let unreadable = |error| Problem::decoding("the metadata at the end cannot be read", Some(error));
    let size = chunks.len();
    let begin = chunks.read(0, 4).map_err(unreadable)?;
    let end = chunks.read(size.saturating_sub(8), 8).map_err(unreadable)?;
    let (Some((length, b"PAR1")), b"PAR1") = (end.split_first_chunk::<4>(), &*begin) else {
        let is_encrypted = end.ends_with(b"PARE");
        return Err(match is_encrypted {
            true => Problem::new("the file is encrypted", "decrypt it first"),
            false => Problem::new("the file does not begin and end with `PAR1`", NO_PARQUET),
        });
    };
    let length = u64::from(u32::from_le_bytes(*length));
    if length > LONGEST {
        let problem = format!("metadata of {length} bytes; the limit is {LONGEST}");
        return Err(Problem::new(
            problem,
            "write the file with larger row groups, or with fewer columns",
        ));
    }
    let Some(start) = size.checked_sub(8 + length) else {
        let problem = format!("metadata of {length} bytes in a file of {size} bytes");
        return Err(Problem::new(problem, NO_PARQUET));
    };
    let bytes = chunks.read(start, length as usize).map_err(unreadable)?;
    check_schema(&bytes)?;
    match catch(|| ParquetMetaDataReader::decode_metadata(&bytes)) {
        Some(Ok(metadata)) => Ok(metadata),
        Some(Err(error)) => Err(unreadable(error)),
        None => Err(Problem::decoding("the metadata at the end cannot be read", None)),
    }
}

fn check_schema(metadata: &[u8]) -> Result<(), Problem> {
    let Some(schema) = thrift::schema(metadata) else {
        return Err(Problem::decoding("the metadata at the end cannot be read", None));
    };
    if schema.elements > MOST_ELEMENTS || schema.depth > DEEPEST || schema.path_bytes > MOST_PATH_BYTES {
        return Err(Problem::new(
            format!(
                "a schema of {} elements, nested {} deep, with {} bytes of paths",
                schema.elements, schema.depth, schema.path_bytes
            ),
            "the limits are 10,000 elements, 32 levels and 16 MiB; write the coordinates alone",
        ));
    }
    Ok(())
}
