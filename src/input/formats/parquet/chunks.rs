//! The bytes of a Parquet file, and the limits on its pages.

use crate::input::formats::parquet::thrift;
use crate::input::watch::Watched;
use ::parquet::basic::{Compression, Encoding};
use ::parquet::column::page::{Page, PageMetadata, PageReader};
use ::parquet::errors::{ParquetError, Result};
use ::parquet::file::reader::{ChunkReader, Length, SerializedPageReader};
use bytes::{Buf, Bytes};
use flate2::read::MultiGzDecoder;
use parking_lot::Mutex;
use std::fs::File;
use std::io;
use std::io::{Read, Seek, SeekFrom};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

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

/// The bytes of the pages of one column chunk.
pub struct PageBytes {
    chunks: Arc<Chunks>,
    codec: Compression,
    /// The number of bytes at the beginning of the next page that are not compressed.
    plain: AtomicUsize,
}

impl PageBytes {
    pub fn new(chunks: &Arc<Chunks>, codec: Compression) -> Result<Self> {
        if codec == Compression::LZ4 {
            // The crate has three formats for this codec, one of which it decodes without a limit.
            return Err(refused(
                "pages in the old codec LZ4, which is not read; write them with LZ4_RAW, ZSTD or SNAPPY".to_owned(),
            ));
        }
        Ok(Self {
            chunks: Arc::clone(chunks),
            codec,
            plain: AtomicUsize::new(0),
        })
    }

    /// Fails if a page is longer than the limit when it is decompressed. The crate decodes all
    /// other codecs into as many bytes as the page's header tells.
    fn check_gzip(&self, page: &[u8]) -> Result<()> {
        let compressed = page.get(self.plain.load(Ordering::Relaxed)..);
        let (Some(compressed), Compression::GZIP(_)) = (compressed, self.codec) else {
            return Ok(());
        };
        let most = (LONGEST_PAGE + OVERHEAD) as u64;
        // Where it is no gzip, it has no length, and the crate reports that.
        let mut start = MultiGzDecoder::new(compressed).take(most + 1);
        match io::copy(&mut start, &mut io::sink()) {
            Ok(length) if length > most => Err(refused(format!(
                "a page of more than {most} bytes; the limit is {LONGEST_PAGE}"
            ))),
            _ => Ok(()),
        }
    }
}

impl Length for PageBytes {
    fn len(&self) -> u64 {
        self.chunks.len()
    }
}

impl ChunkReader for PageBytes {
    type T = bytes::buf::Reader<Bytes>;

    /// Returns a page's header. Nothing else is read in this way.
    fn get_read(&self, start: u64) -> Result<Self::T> {
        let mut length = HEADER;
        loop {
            let bytes = self.chunks.read(start, length)?;
            match thrift::page_header(&bytes) {
                Some(header)
                    if header
                        .sizes
                        .iter()
                        .all(|&size| size <= (LONGEST_PAGE + OVERHEAD) as i64) =>
                {
                    let plain = usize::try_from(header.levels).unwrap_or(0);
                    self.plain.store(plain, Ordering::Relaxed);
                    return Ok(Bytes::from(bytes).reader());
                }
                Some(header) => {
                    let size = header.sizes[0].max(header.sizes[1]);
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
            true => self.chunks.read(start, length)?,
            false => Vec::new(),
        };
        if bytes.len() < length {
            let size = self.chunks.size;
            return Err(refused(format!("a page of {length} bytes at byte {start} of {size}")));
        }
        self.check_gzip(&bytes)?;
        Ok(bytes.into())
    }
}

/// The pages of a column chunk, within the limits.
pub struct Pages {
    pages: SerializedPageReader<PageBytes>,
    /// The number of values in the pages so far, null or not.
    values: Arc<AtomicU64>,
}

impl Pages {
    /// Counts the values of the pages that are handed out in `values`.
    pub fn new(pages: SerializedPageReader<PageBytes>, values: Arc<AtomicU64>) -> Self {
        Self { pages, values }
    }

    fn check(&self, page: Page) -> Result<Page> {
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
            Page::DataPage {
                encoding, num_values, ..
            }
            | Page::DataPageV2 {
                encoding, num_values, ..
            } => match encoding {
                Encoding::PLAIN
                | Encoding::PLAIN_DICTIONARY
                | Encoding::RLE_DICTIONARY
                | Encoding::DELTA_BINARY_PACKED
                | Encoding::BYTE_STREAM_SPLIT => {
                    self.values.fetch_add(u64::from(*num_values), Ordering::Relaxed);
                }
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
        self.pages.get_next_page()?.map(|page| self.check(page)).transpose()
    }

    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>> {
        self.pages.peek_next_page()
    }

    fn skip_next_page(&mut self) -> Result<()> {
        self.pages.skip_next_page()
    }
}

fn refused(what: String) -> ParquetError {
    ParquetError::General(what)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::watch::Reading;
    use ::parquet::basic::GzipLevel;
    use flate2::write::GzEncoder;
    use std::io::Write;

    /// Returns the error of reading a page that gzip makes of `length` bytes behind `plain` others.
    fn error_of_page(plain: usize, length: usize) -> Option<String> {
        let mut encoder = GzEncoder::new(vec![7; plain], flate2::Compression::fast());
        encoder.write_all(&vec![0; length]).unwrap();
        let page = encoder.finish().unwrap();
        assert!(page.len() < length / 100);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("page");
        std::fs::write(&path, &page).unwrap();
        let file = Watched::open(&path, &Reading::default(), None).unwrap();
        let chunks = Arc::new(Chunks::new(file, page.len() as u64));
        let pages = PageBytes::new(&chunks, Compression::GZIP(GzipLevel::default())).unwrap();
        pages.plain.store(plain, Ordering::Relaxed);
        pages.get_bytes(0, page.len()).err().map(|error| error.to_string())
    }

    /// The crate would decode all of it, whatever the header says.
    #[test]
    fn a_gzip_page_of_more_bytes_than_the_limit_is_refused() {
        for plain in [0, 12] {
            assert_eq!(error_of_page(plain, LONGEST_PAGE), None);
            let error = error_of_page(plain, LONGEST_PAGE + OVERHEAD + 1).unwrap();
            assert!(error.contains("the limit is 16777216"), "{error}");
        }
    }
}
