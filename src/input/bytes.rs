//! Bytes from files and streams, decompressed, with their first bytes available for inspection.
//!
//! In: a file or a stream. Out: a [`ByteInput`], from which formats that need no seeking read. gzip
//! is decompressed here (all members of the file), so that no format has to handle it.

use std::io;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use crate::input::error::InputError;
use crate::input::watch::{Reading, Watch, Watched};

/// The size in bytes of a read buffer, and of a read.
pub const BUFFER: usize = 256 << 10;

/// The first bytes of a gzip file: the magic number and deflate, the only defined method (RFC
/// 1952).
const GZIP: [u8; 3] = [0x1f, 0x8b, 8];

/// Returns whether a file that begins with `head` is gzip.
pub fn is_gzip(head: &[u8]) -> bool {
    head.starts_with(&GZIP)
}

/// An opened input, before the reader of its format takes it.
pub struct ByteInput {
    /// The name for messages.
    pub path: Arc<Path>,
    /// The decompressed bytes, from the first one on.
    pub read: Box<dyn Read + Send>,
    /// The number of decompressed bytes, if known.
    pub size: Option<u64>,
    /// A copy of the first decompressed bytes: a few hundred, or fewer if the input is shorter.
    pub head: Vec<u8>,
    /// Whether the bytes were decompressed.
    pub was_gzip: bool,
    /// The state of the input.
    pub watch: Arc<Watch>,
}

impl ByteInput {
    /// Reads the first bytes and decompresses gzip. An input is gzip if it begins with gzip's magic
    /// number and, unless `by_magic` is set, its name ends in `.gz`.
    pub fn new(read: Watched<impl Read + Send + 'static>, by_magic: bool) -> Result<Self, InputError> {
        let watch = Arc::clone(&read.watch);
        let suffix = watch.path.extension();
        let named = suffix.is_some_and(|suffix| suffix.eq_ignore_ascii_case("gz"));
        let size = watch.size();
        let plain = Self::with_head(watch, Box::new(read), size)?;
        if !(is_gzip(&plain.head) && (by_magic || named)) {
            return Ok(plain);
        }
        let read = Stoppable {
            read: gunzip(plain.read, &plain.path)?,
            reading: plain.watch.reading.clone(),
        };
        let unzipped = Self::with_head(plain.watch, Box::new(read), None)?;
        Ok(Self {
            was_gzip: true,
            ..unzipped
        })
    }

    /// Skips a byte order mark and returns its length.
    pub fn skip_mark(&mut self) -> u64 {
        const MARK: &[u8] = b"\xef\xbb\xbf";
        if !self.head.starts_with(MARK) {
            return 0;
        }
        // The head is in memory, so this cannot fail.
        io::copy(&mut self.read.by_ref().take(MARK.len() as u64), &mut io::sink()).unwrap_or(0)
    }

    fn with_head(watch: Arc<Watch>, mut read: Box<dyn Read + Send>, size: Option<u64>) -> Result<Self, InputError> {
        let (path, mut head) = (Arc::clone(&watch.path), Vec::new());
        match read.by_ref().take(512).read_to_end(&mut head) {
            Ok(_) => Ok(Self {
                path,
                read: Box::new(io::Cursor::new(head.clone()).chain(read)),
                size,
                head,
                was_gzip: false,
                watch,
            }),
            Err(source) => Err(InputError::read(&path, 0, source)),
        }
    }
}

/// Decompressed bytes, with a check whether the reading was stopped: few compressed bytes may
/// expand to very many.
struct Stoppable {
    read: Box<dyn Read + Send>,
    reading: Reading,
}

impl Read for Stoppable {
    fn read(&mut self, buf: &mut [u8]) -> io::Result<usize> {
        self.reading.check_io()?;
        self.read.read(buf)
    }
}

/// The number of compressed bytes read at once; small, since their count shows the progress.
#[cfg(feature = "text")]
const COMPRESSED: usize = 32 << 10;

#[cfg(feature = "text")]
fn gunzip(read: Box<dyn Read + Send>, _: &Path) -> Result<Box<dyn Read + Send>, InputError> {
    let read = io::BufReader::with_capacity(COMPRESSED, read);
    Ok(Box::new(flate2::bufread::MultiGzDecoder::new(read)))
}

#[cfg(not(feature = "text"))]
fn gunzip(_: Box<dyn Read + Send>, path: &Path) -> Result<Box<dyn Read + Send>, InputError> {
    Err(InputError::MissingFeature {
        path: path.to_owned(),
        what: "gzip".to_owned(),
        feature: "text",
    })
}
