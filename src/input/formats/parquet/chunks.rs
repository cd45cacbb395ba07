//! The bytes of a Parquet file, and the limits on its pages.

use crate::input::formats::parquet::thrift;
use crate::input::watch::Watched;
use ::parquet::basic::Encoding;
use ::parquet::column::page::{Page, PageMetadata, PageReader};
use ::parquet::errors::{ParquetError, Result};
use ::parquet::file::reader::{ChunkReader, Length, SerializedPageReader};
use bytes::{Buf, Bytes};
use parking_lot::Mutex;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::sync::Arc;

/// The limit on the bytes of a page.
const LONGEST_PAGE: usize = 16 << 20;

/// What compression may add to a page that it cannot make shorter.
const OVERHEAD: usize = 1 << 20;

/// The limit on the values of a dictionary.
const LARGEST_DICTIONARY: u32 = 1 << 20;

/// The bytes of a page's header that are read first, and at most.
const HEADER: usize = 1 << 10;
const LONGEST_HEADER: usize = 1 << 20;

/// A file.
pub struct Chunks {
    file: Mutex<Watched<Arc<File>>>,
    size: u64,
}

impl Chunks {
    pub fn new(file: Watched<Arc<File>>, size: u64) -> Self {
        let file = Mutex::new(file);
        Self { file, size }
    }

    /// Returns the bytes from `start` on, at most `length`; fewer at the file's end.
    pub fn read(&self, start: u64, length: usize) -> Result<Vec<u8>> {
        let rest = self.size.saturating_sub(start);
        let length = (length as u64).min(rest);
        let mut bytes = Vec::with_capacity(length as usize);
        let mut file = self.file.lock();
        file.seek(SeekFrom::Start(start))?;
        file.by_ref().take(length).read_to_end(&mut bytes)?;
        Ok(bytes)
    }
}

impl Length for Chunks {
    fn len(&self) -> u64 {
        self.size
    }
}

impl ChunkReader for Chunks {
    type T = bytes::buf::Reader<Bytes>;

    /// Returns a page's header. Nothing else is read in this way.
    fn get_read(&self, start: u64) -> Result<Self::T> {
        let mut length = HEADER;
        loop {
            let bytes = self.read(start, length)?;
            match thrift::page_sizes(&bytes) {
                Some(sizes) if sizes.iter().all(|&size| size <= (LONGEST_PAGE + OVERHEAD) as i64) => {
                    return Ok(Bytes::from(bytes).reader());
                }
                Some([size, other]) => {
                    let size = size.max(other);
                    return Err(refused(format!("a page of {size} bytes; the limit is {LONGEST_PAGE}")));
                }
                None if bytes.len() < length || length >= LONGEST_HEADER => {
                    return Err(refused(format!("no header of a page at byte {start}")));
                }
                None => length *= 8,
            }
        }
    }

    fn get_bytes(&self, start: u64, length: usize) -> Result<Bytes> {
        let bytes = match length <= LONGEST_PAGE + OVERHEAD {
            true => self.read(start, length)?,
            false => Vec::new(),
        };
        match bytes.len() == length {
            true => Ok(bytes.into()),
            false => Err(refused(format!(
                "a page of {length} bytes at byte {start} of {}",
                self.size
            ))),
        }
    }
}

/// The pages of a column chunk, within the limits.
pub struct Pages(pub SerializedPageReader<Chunks>);

impl Pages {
    fn check(page: Page) -> Result<Page> {
        match &page {
            Page::DictionaryPage { buf, num_values, .. } => {
                // Each value has at least 4 bytes: a float, an integer, or the length of bytes.
                if *num_values > LARGEST_DICTIONARY || *num_values as usize > buf.len() / 4 {
                    return Err(refused(format!(
                        "a dictionary of {num_values} values in {} bytes; the limit is {LARGEST_DICTIONARY} values",
                        buf.len()
                    )));
                }
            }
            Page::DataPage { encoding, .. } | Page::DataPageV2 { encoding, .. } => match encoding {
                Encoding::PLAIN
                | Encoding::PLAIN_DICTIONARY
                | Encoding::RLE_DICTIONARY
                | Encoding::DELTA_BINARY_PACKED
                | Encoding::BYTE_STREAM_SPLIT => {}
                _ => {
                    return Err(refused(format!(
                        "values in the encoding {encoding}, which is not read; write them plainly or with a dictionary"
                    )));
                }
            },
        }
        Ok(page)
    }
}

impl Iterator for Pages {
    type Item = Result<Page>;

    fn next(&mut self) -> Option<Result<Page>> {
        self.get_next_page().transpose()
    }
}

impl PageReader for Pages {
    fn get_next_page(&mut self) -> Result<Option<Page>> {
        self.0.get_next_page()?.map(Self::check).transpose()
    }

    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>> {
        self.0.peek_next_page()
    }

    fn skip_next_page(&mut self) -> Result<()> {
        self.0.skip_next_page()
    }
}

fn refused(what: String) -> ParquetError {
    ParquetError::General(what)
}
