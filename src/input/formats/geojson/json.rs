//! JSON (RFC 8259) as a stream of tokens, read by `struson`.
//!
//! In: bytes. Out: the tokens that a caller asks for, or an error with the byte offset. Several
//! values may follow each other, separated by blanks, line ends or RFC 8142's record separators.
//! This is a thin layer over the library: it bounds the names and numbers that are stored, turns
//! record separators into blanks, and words the errors. Strings that are not UTF-8, and escapes of
//! half a surrogate pair, are errors everywhere, even in parts that are skipped.
//!
//! `struson` is used and not `serde_json`: `serde_json` returns a value only when it has all of it,
//! and its callbacks cannot stop in the middle of a value, as a full batch requires. With
//! `struson`, memory is bounded by the nesting, not by the size of a value.

use std::io;
use std::io::{BufReader, ErrorKind, Read};
use std::path::Path;
use std::sync::Arc;

pub use struson::reader::ValueType;
use struson::reader::{JsonReader, JsonStreamReader, JsonSyntaxError, ReaderError, ReaderSettings, SyntaxErrorKind};

use crate::input::bytes::{BUFFER, ByteInput};
use crate::input::error::{InputError, Location};

/// The limit on the nesting depth, as in `serde_json`.
const DEEPEST: u32 = 128;
/// The length limit of a name, number or string that is stored. A skipped one may have any length.
const LONGEST: usize = 2 << 20;

pub struct Json {
    json: JsonStreamReader<Source>,
    origin: Origin,
    /// The offset of the last token examined.
    offset: u64,
}

/// The origin of the bytes, for errors.
struct Origin {
    path: Arc<Path>,
    /// The length of the byte order mark, which the library does not see.
    mark: u64,
}

/// The bytes as the library gets them.
struct Source {
    read: BufReader<Box<dyn Read + Send>>,
    /// The number of bytes that may still be read for the current token.
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
        // A record separator cannot occur within a value.
        for byte in &mut buf[..n] {
            *byte = if *byte == 0x1e { b' ' } else { *byte };
        }
        Ok(n)
    }
}

impl Json {
    /// Skips a byte order mark.
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

    /// Returns whether there is no value at all. To be called only at the beginning.
    pub fn is_blank(&mut self) -> bool {
        let kind = SyntaxErrorKind::IncompleteDocument;
        matches!(self.json.peek(), Err(ReaderError::SyntaxError(error)) if error.kind == kind)
    }

    /// Returns whether there is another member or element, or another value outside of all objects
    /// and arrays. Not to be called at the beginning.
    pub fn has_next(&mut self) -> Result<bool, InputError> {
        self.step(JsonStreamReader::has_next)
    }

    /// Returns the type of the next value.
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

    /// Skips a value.
    pub fn skip(&mut self) -> Result<(), InputError> {
        limited(&mut self.json, usize::MAX)
            .skip_value()
            .map_err(|e| self.origin.explain(e))
    }

    /// Returns the name of the next member.
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

    /// Returns a number as it is written.
    pub fn number_text(&mut self) -> Result<&str, InputError> {
        limited(&mut self.json, LONGEST)
            .next_number_as_str()
            .map_err(|e| self.origin.explain(e))
    }

    /// Examines the next token, and records its offset.
    fn step<T>(
        &mut self,
        look: impl FnOnce(&mut JsonStreamReader<Source>) -> Result<T, ReaderError>,
    ) -> Result<T, InputError> {
        let found = look(limited(&mut self.json, usize::MAX)).map_err(|e| self.origin.explain(e));
        self.offset = self.origin.offset(self.json.current_position(false).data_pos);
        found
    }

    /// Returns the offset of the last token examined.
    pub fn offset(&self) -> u64 {
        self.offset
    }

    /// Returns an error at the last token examined.
    pub fn malformed(&self, problem: impl Into<String>, hint: &'static str) -> InputError {
        self.origin.malformed(self.offset, problem, hint)
    }
}

/// Limits how many bytes may be read from now on.
fn limited(json: &mut JsonStreamReader<Source>, bytes: usize) -> &mut JsonStreamReader<Source> {
    json.reader_mut().left = bytes;
    json
}

impl Origin {
    /// Converts an offset of the library, which always has one, to an offset in the input.
    fn offset(&self, offset: Option<u64>) -> u64 {
        self.mark + offset.unwrap_or(0)
    }

    fn malformed(&self, offset: u64, problem: impl Into<String>, hint: &'static str) -> InputError {
        InputError::malformed(&self.path, Location::Byte(offset), problem, hint)
    }

    #[cold]
    fn explain(&self, error: ReaderError) -> InputError {
        let (problem, hint, location) = match error {
            ReaderError::SyntaxError(JsonSyntaxError { kind, location }) => {
                (words(kind), "this is not JSON; is the file cut short?", location)
            }
            ReaderError::MaxNestingDepthExceeded { location, .. } => (
                format!("nesting deeper than {DEEPEST}"),
                "GeoJSON needs no such nesting",
                location,
            ),
            ReaderError::IoError { error, location } if error.kind() == ErrorKind::InvalidData => {
                (error.to_string(), "this is not JSON, or not in UTF-8", location)
            }
            ReaderError::IoError { error, location } => {
                return InputError::read(&self.path, self.offset(location.data_pos), error);
            }
            // Cannot occur: types are checked before, and numbers have no limit.
            error => return self.malformed(0, error.to_string(), "this is not the expected JSON"),
        };
        self.malformed(self.offset(location.data_pos), problem, hint)
    }
}

/// Turns the library's name of an error into words: `MissingComma` becomes `missing comma`.
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
