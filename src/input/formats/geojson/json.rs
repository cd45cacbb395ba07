//! JSON (RFC 8259) piece by piece, from a stream, by `struson`.
//!
//! In: bytes. Out: what a caller asks for, or an error with the byte offset. Several values may follow each other, with
//! blanks, line ends or RFC 8142's record separators between them. This is a thin layer over the library: it bounds the
//! names and numbers that are kept, turns record separators into blanks, and words the errors. Strings that are no UTF-8,
//! and escapes that are half of a surrogate pair, are errors anywhere, even in what is passed over.
//! Why `struson` and not `serde_json`: that hands over a value when it has all of it, and calls back where a batch wants
//! to stop in the middle. Here memory is bounded by the nesting, and not by any value's size.

use std::io;
use std::io::{BufReader, ErrorKind, Read};
use std::path::Path;
use std::sync::Arc;

pub use struson::reader::ValueType;
use struson::reader::{JsonReader, JsonStreamReader, JsonSyntaxError, ReaderError, ReaderSettings, SyntaxErrorKind};

use crate::input::bytes::{BUFFER, ByteInput};
use crate::input::error::{InputError, Place};

/// The deepest nesting, as in `serde_json`.
const DEEPEST: u32 = 128;
/// The longest name, number or string that is kept. What is passed over may be of any length.
const LONGEST: usize = 2 << 20;

pub struct Json {
    json: JsonStreamReader<Source>,
    origin: Origin,
    /// The offset of the piece looked at last.
    offset: u64,
}

/// Where the bytes come from, for errors.
struct Origin {
    path: Arc<Path>,
    /// The length of the byte order mark, which the library does not see.
    mark: u64,
}

/// The bytes as the library gets them.
struct Source {
    read: BufReader<Box<dyn Read + Send>>,
    /// How many the piece that is being read may still have.
    left: usize,
}

impl Read for Source {
    fn read(&mut self, buf: &mut [u8]) -> io::Result<usize> {
        if self.left == 0 {
            let problem = format!("a name, number or string of more than {LONGEST} bytes");
            return Err(io::Error::new(ErrorKind::InvalidData, problem));
        }
        let n = self.read.read(buf)?;
        self.left = self.left.saturating_sub(n);
        // Within a value there can be no record separator.
        for byte in &mut buf[..n] {
            *byte = if *byte == 0x1e { b' ' } else { *byte };
        }
        Ok(n)
    }
}

impl Json {
    /// Passes over a byte order mark.
    pub fn new(mut input: ByteInput) -> Self {
        let mark = input.skip_mark();
        let source = Source {
            read: BufReader::with_capacity(BUFFER, input.read),
            left: usize::MAX,
        };
        let settings = ReaderSettings {
            allow_multiple_top_level: true,
            max_nesting_depth: Some(DEEPEST),
            restrict_number_values: false,
            track_path: false,
            ..ReaderSettings::default()
        };
        Self {
            json: JsonStreamReader::new_custom(source, settings),
            origin: Origin { path: input.path, mark },
            offset: 0,
        }
    }

    /// Whether there is no value at all. To be asked at the beginning.
    pub fn is_blank(&mut self) -> bool {
        let kind = SyntaxErrorKind::IncompleteDocument;
        matches!(self.json.peek(), Err(ReaderError::SyntaxError(error)) if error.kind == kind)
    }

    /// Whether there is another member, element or, outside of all, value. Not to be asked at the beginning.
    pub fn has_next(&mut self) -> Result<bool, InputError> {
        self.step(JsonStreamReader::has_next)
    }

    /// The type of the value that comes.
    pub fn peek(&mut self) -> Result<ValueType, InputError> {
        self.step(JsonStreamReader::peek)
    }

    pub fn begin_object(&mut self) -> Result<(), InputError> {
        self.json.begin_object().map_err(|e| self.origin.explain(e))
    }

    pub fn end_object(&mut self) -> Result<(), InputError> {
        self.json.end_object().map_err(|e| self.origin.explain(e))
    }

    pub fn begin_array(&mut self) -> Result<(), InputError> {
        self.json.begin_array().map_err(|e| self.origin.explain(e))
    }

    pub fn end_array(&mut self) -> Result<(), InputError> {
        self.json.end_array().map_err(|e| self.origin.explain(e))
    }

    /// Passes over a value.
    pub fn skip(&mut self) -> Result<(), InputError> {
        limited(&mut self.json, usize::MAX)
            .skip_value()
            .map_err(|e| self.origin.explain(e))
    }

    /// The name of the member that comes.
    pub fn name(&mut self) -> Result<&str, InputError> {
        limited(&mut self.json, LONGEST)
            .next_name()
            .map_err(|e| self.origin.explain(e))
    }

    pub fn string(&mut self) -> Result<&str, InputError> {
        limited(&mut self.json, LONGEST)
            .next_str()
            .map_err(|e| self.origin.explain(e))
    }

    pub fn number(&mut self) -> Result<f64, InputError> {
        Ok(self.number_text()?.parse().unwrap_or(f64::NAN))
    }

    /// A number as it is written.
    pub fn number_text(&mut self) -> Result<&str, InputError> {
        limited(&mut self.json, LONGEST)
            .next_number_as_str()
            .map_err(|e| self.origin.explain(e))
    }

    /// Looks at what comes, and notes where it is.
    fn step<T>(
        &mut self,
        look: impl FnOnce(&mut JsonStreamReader<Source>) -> Result<T, ReaderError>,
    ) -> Result<T, InputError> {
        let found = look(limited(&mut self.json, usize::MAX)).map_err(|e| self.origin.explain(e));
        self.offset = self.origin.offset(self.json.current_position(false).data_pos);
        found
    }

    /// The offset of the piece looked at last.
    pub fn offset(&self) -> u64 {
        self.offset
    }

    /// An error at the piece looked at last.
    pub fn malformed(&self, problem: impl Into<String>, hint: &'static str) -> InputError {
        self.origin.malformed(self.offset, problem, hint)
    }
}

/// Sets how many bytes may be read from now on.
fn limited(json: &mut JsonStreamReader<Source>, bytes: usize) -> &mut JsonStreamReader<Source> {
    json.reader_mut().left = bytes;
    json
}

impl Origin {
    /// An offset as the library tells it; it always does.
    fn offset(&self, offset: Option<u64>) -> u64 {
        self.mark + offset.unwrap_or(0)
    }

    fn malformed(&self, offset: u64, problem: impl Into<String>, hint: &'static str) -> InputError {
        InputError::malformed(&self.path, Place::Byte(offset), problem, hint)
    }

    #[cold]
    fn explain(&self, error: ReaderError) -> InputError {
        let (problem, hint, location) = match error {
            ReaderError::SyntaxError(JsonSyntaxError { kind, location }) => {
                (words(kind), "this is no JSON; is the file cut short?", location)
            }
            ReaderError::MaxNestingDepthExceeded { location, .. } => (
                format!("nesting deeper than {DEEPEST}"),
                "this is not what maps are made of",
                location,
            ),
            ReaderError::IoError { error, location } if error.kind() == ErrorKind::InvalidData => {
                (error.to_string(), "this is no JSON, or not in UTF-8", location)
            }
            ReaderError::IoError { error, location } => {
                return InputError::read(&self.path, self.offset(location.data_pos), error);
            }
            // Does not happen: types are looked at before, and numbers have no limit.
            error => return self.malformed(0, error.to_string(), "this is no JSON as it is expected"),
        };
        self.malformed(self.offset(location.data_pos), problem, hint)
    }
}

/// The library's name for an error as words: `MissingComma` is `missing comma`.
fn words(kind: SyntaxErrorKind) -> String {
    if kind == SyntaxErrorKind::IncompleteDocument {
        return "the file ends in the middle of a value".to_owned();
    }
    let mut words = String::new();
    for letter in kind.to_string().chars() {
        if letter.is_ascii_uppercase() && !words.is_empty() {
            words.push(' ');
        }
        words.push(letter.to_ascii_lowercase());
    }
    words
}
