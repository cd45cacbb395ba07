//! JSON (RFC 8259) piece by piece, from a stream.
//!
//! In: bytes. Out: one [`Event`] after the other, each value well-formed up to here, or an error with the byte offset.
//! Several values may follow each other, with blanks, line ends or RFC 8142's record separators between them.
//! Why not `serde_json`: it hands over a value when it has all of it, and calls back where a batch wants to
//! stop in the middle. Here memory is bounded by the nesting, at most [`DEEPEST`], and not by any value's size.

use super::bytes::Buffered;
use super::error::excerpt;
use super::{InputError, Place};

/// The deepest nesting, as in `serde_json`.
const DEEPEST: usize = 128;
/// The longest number in bytes.
const LONGEST_NUMBER: usize = 1024;
/// How much of a string is kept.
const KEPT: usize = 4096;

/// A piece of JSON.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Event {
    ObjectStart,
    ObjectEnd,
    ArrayStart,
    ArrayEnd,
    /// The name of a member: [`Json::text`].
    Key,
    /// A string: [`Json::text`].
    String,
    Number(f64),
    /// `true`, `false` or `null`.
    Literal,
    /// No more values.
    End,
}

/// What may come next.
#[derive(Clone, Copy, PartialEq)]
enum State {
    Value,
    /// A value or the end of the array.
    FirstValue,
    Key,
    /// A key or the end of the object.
    FirstKey,
    /// A comma or the end of what is open; between values, nothing is.
    AfterValue,
}

pub(super) struct Json {
    bytes: Buffered,
    state: State,
    /// What is open, from the outside in: true for objects.
    open: Vec<bool>,
    text: Vec<u8>,
    /// The offset of the piece given last.
    offset: u64,
}

impl Json {
    /// Passes over a byte order mark.
    pub fn new(mut bytes: Buffered) -> Result<Self, InputError> {
        while bytes.data().len() < 3 && bytes.more()? {}
        if bytes.data().starts_with(b"\xef\xbb\xbf") {
            bytes.consume(3);
        }
        Ok(Self {
            bytes,
            state: State::AfterValue,
            open: Vec::new(),
            text: Vec::new(),
            offset: 0,
        })
    }

    /// The first bytes of the string or key given last.
    pub fn text(&self) -> &[u8] {
        &self.text
    }

    /// The offset of the piece given last.
    pub fn offset(&self) -> u64 {
        self.offset
    }

    /// How many objects and arrays are open.
    pub fn depth(&self) -> usize {
        self.open.len()
    }

    /// An error at the piece given last.
    pub fn malformed(&self, problem: String, hint: &'static str) -> InputError {
        InputError::Malformed {
            path: self.bytes.path(),
            place: Place::Byte(self.offset),
            problem,
            hint,
            source: None,
        }
    }

    fn syntax(&self, problem: impl Into<String>) -> InputError {
        self.malformed(problem.into(), "this is no JSON; is the file cut short?")
    }

    #[inline]
    fn peek(&mut self) -> Result<Option<u8>, InputError> {
        loop {
            if let Some(&byte) = self.bytes.data().first() {
                return Ok(Some(byte));
            }
            if !self.bytes.more()? {
                return Ok(None);
            }
        }
    }

    fn need(&mut self) -> Result<u8, InputError> {
        match self.peek()? {
            Some(byte) => Ok(byte),
            None => {
                self.offset = self.bytes.offset();
                Err(self.syntax("the file ends in the middle of a value"))
            }
        }
    }

    /// Consumes one byte and gives it.
    fn take(&mut self) -> Result<u8, InputError> {
        let byte = self.need()?;
        self.bytes.consume(1);
        Ok(byte)
    }

    fn skip_blanks(&mut self) -> Result<(), InputError> {
        while self.peek()?.is_some() {
            let blanks = |b: &u8| matches!(b, b' ' | b'\t' | b'\n' | b'\r' | 0x1e);
            let n = self.bytes.data().iter().take_while(|b| blanks(b)).count();
            self.bytes.consume(n);
            if !self.bytes.data().is_empty() {
                break;
            }
        }
        self.offset = self.bytes.offset();
        Ok(())
    }

    /// The next piece.
    pub fn next(&mut self) -> Result<Event, InputError> {
        self.skip_blanks()?;
        if self.state == State::AfterValue {
            match self.open.last().copied() {
                None if self.peek()?.is_none() => return Ok(Event::End),
                None => self.state = State::Value,
                Some(is_object) => match self.need()? {
                    b',' => {
                        self.bytes.consume(1);
                        self.skip_blanks()?;
                        self.state = if is_object { State::Key } else { State::Value };
                    }
                    b'}' if is_object => return self.close(Event::ObjectEnd),
                    b']' if !is_object => return self.close(Event::ArrayEnd),
                    byte => return Err(self.syntax(unexpected(byte, "a comma or the end of what is open"))),
                },
            }
        }
        match (self.state, self.need()?) {
            (State::FirstKey, b'}') => self.close(Event::ObjectEnd),
            (State::FirstValue, b']') => self.close(Event::ArrayEnd),
            (State::FirstKey | State::Key, b'"') => {
                self.string()?;
                let key_offset = self.offset;
                self.skip_blanks()?;
                match self.take()? {
                    b':' => {}
                    byte => return Err(self.syntax(unexpected(byte, "a colon"))),
                }
                self.offset = key_offset;
                self.state = State::Value;
                Ok(Event::Key)
            }
            (State::FirstKey | State::Key, byte) => Err(self.syntax(unexpected(byte, "the name of a member"))),
            (_, b'{') => self.start(true),
            (_, b'[') => self.start(false),
            (_, b'"') => {
                self.string()?;
                self.state = State::AfterValue;
                Ok(Event::String)
            }
            (_, b'-' | b'0'..=b'9') => {
                self.state = State::AfterValue;
                self.number().map(Event::Number)
            }
            (_, b't') => self.literal(b"true"),
            (_, b'f') => self.literal(b"false"),
            (_, b'n') => self.literal(b"null"),
            (_, byte) => Err(self.syntax(unexpected(byte, "a value"))),
        }
    }

    fn start(&mut self, is_object: bool) -> Result<Event, InputError> {
        if self.open.len() >= DEEPEST {
            return Err(self.malformed(
                format!("nesting deeper than {DEEPEST}"),
                "this is not what maps are made of",
            ));
        }
        self.bytes.consume(1);
        self.open.push(is_object);
        let (state, event) = match is_object {
            true => (State::FirstKey, Event::ObjectStart),
            false => (State::FirstValue, Event::ArrayStart),
        };
        self.state = state;
        Ok(event)
    }

    fn close(&mut self, event: Event) -> Result<Event, InputError> {
        self.bytes.consume(1);
        self.open.pop();
        self.state = State::AfterValue;
        Ok(event)
    }

    fn literal(&mut self, word: &[u8]) -> Result<Event, InputError> {
        for &expected in word {
            let byte = self.take()?;
            if byte != expected {
                return Err(self.syntax(unexpected(byte, "true, false or null")));
            }
        }
        self.state = State::AfterValue;
        Ok(Event::Literal)
    }

    fn number(&mut self) -> Result<f64, InputError> {
        // Almost always the number and the byte behind it are at hand.
        let mut length = 0;
        loop {
            let data = self.bytes.data();
            length += data[length..].iter().take_while(|b| is_numeric(**b)).count();
            if length < data.len() || length > LONGEST_NUMBER || !self.bytes.more()? {
                break;
            }
        }
        let digits = &self.bytes.data()[..length];
        let value = is_number(digits).then(|| super::lines::number(digits)).flatten();
        let Some(value) = value.filter(|_| length <= LONGEST_NUMBER) else {
            return Err(self.syntax(format!("`{}` is no number", excerpt(digits))));
        };
        self.bytes.consume(length);
        Ok(value)
    }

    /// Reads a string into `text`, as far as it is kept.
    fn string(&mut self) -> Result<(), InputError> {
        self.text.clear();
        self.bytes.consume(1);
        loop {
            self.need()?;
            let data = self.bytes.data();
            let plain = |b: &u8| !matches!(b, b'"' | b'\\' | 0..=0x1f);
            let n = data.iter().take_while(|b| plain(b)).count();
            let kept = n.min(KEPT.saturating_sub(self.text.len()));
            self.text.extend_from_slice(&data[..kept]);
            self.bytes.consume(n);
            match self.peek()? {
                Some(b'"') => {
                    self.bytes.consume(1);
                    return Ok(());
                }
                Some(b'\\') => self.escape()?,
                Some(byte @ 0..=0x1f) => return Err(self.syntax(unexpected(byte, "the end of a string"))),
                _ => {}
            }
        }
    }

    fn escape(&mut self) -> Result<(), InputError> {
        self.bytes.consume(1);
        let byte = self.take()?;
        let escaped = match byte {
            b'"' | b'\\' | b'/' => char::from(byte),
            b'b' => '\u{8}',
            b'f' => '\u{c}',
            b'n' => '\n',
            b'r' => '\r',
            b't' => '\t',
            b'u' => {
                let mut code = 0;
                for _ in 0..4 {
                    let byte = self.take()?;
                    let Some(digit) = char::from(byte).to_digit(16) else {
                        return Err(self.syntax(unexpected(byte, "four hexadecimal digits")));
                    };
                    code = code * 16 + digit;
                }
                // Halves of a surrogate pair become replacement characters: no name that is looked for has any.
                char::from_u32(code).unwrap_or(char::REPLACEMENT_CHARACTER)
            }
            _ => return Err(self.syntax(unexpected(byte, "an escape"))),
        };
        if self.text.len() < KEPT {
            self.text.extend_from_slice(escaped.encode_utf8(&mut [0; 4]).as_bytes());
        }
        Ok(())
    }
}

fn unexpected(byte: u8, expected: &str) -> String {
    format!("`{}` where {expected} is due", char::from(byte).escape_default())
}

fn is_numeric(byte: u8) -> bool {
    matches!(byte, b'0'..=b'9' | b'-' | b'+' | b'.' | b'e' | b'E')
}

/// Whether the bytes are a number by JSON's grammar, which is narrower than Rust's.
fn is_number(bytes: &[u8]) -> bool {
    let digits = |bytes: &[u8]| bytes.iter().take_while(|b| b.is_ascii_digit()).count();
    let rest = bytes.strip_prefix(b"-").unwrap_or(bytes);
    let whole = digits(rest);
    if whole == 0 || (whole > 1 && rest[0] == b'0') {
        return false;
    }
    let mut rest = &rest[whole..];
    if let Some(fraction) = rest.strip_prefix(b".") {
        let n = digits(fraction);
        if n == 0 {
            return false;
        }
        rest = &fraction[n..];
    }
    if let [b'e' | b'E', exponent @ ..] = rest {
        let exponent = match exponent {
            [b'+' | b'-', exponent @ ..] => exponent,
            _ => exponent,
        };
        let n = digits(exponent);
        return n > 0 && n == exponent.len();
    }
    rest.is_empty()
}
