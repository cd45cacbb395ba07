//! The rows of one element, of which some properties are wanted.

use crate::input::error::InputError;
use crate::input::flaw::Flaw;
use crate::input::formats::ply::body::{Body, Bytes, Content};
use crate::input::formats::ply::header::{Element, Encoding, Scalar};
use crate::input::formats::text_lines::{Lines, number};
use std::io;

/// The limit on the items of a list that is kept, such as the corners of a face.
pub const MOST_ITEMS: usize = 1 << 16;

/// A reader of the rows of an element.
pub struct Rows {
    pub element: Element,
    /// The number of rows read.
    pub read: u64,
    /// The numbers of the wanted properties, and of the wanted list.
    wanted: Vec<usize>,
    list: Option<usize>,
    /// The wanted values of the current row, in the order of `wanted`, and the items of the list.
    pub values: Vec<f64>,
    pub items: Vec<f64>,
    /// The bytes of a row without lists.
    record: Vec<u8>,
}

/// Where the wanted values are in a binary row without lists.
pub type Places = Vec<(usize, Scalar)>;

impl Rows {
    pub fn new(element: Element, wanted: Vec<usize>, list: Option<usize>) -> Self {
        Self {
            values: vec![0.0; wanted.len()],
            items: Vec::new(),
            record: vec![0; element.stride().unwrap_or(0)],
            element,
            read: 0,
            wanted,
            list,
        }
    }

    /// Returns where the wanted values are in a row without lists.
    pub fn places(&self) -> Places {
        let place = |&wanted: &usize| {
            let before = self.element.properties[..wanted].iter();
            let offset = before.map(|property| property.scalar.bytes()).sum();
            (offset, self.element.properties[wanted].scalar)
        };
        self.wanted.iter().map(place).collect()
    }

    /// Reads the next row; `None` after the last one.
    pub fn next(&mut self, body: &mut Body) -> Result<Option<Result<(), Flaw>>, InputError> {
        if self.read == self.element.rows {
            return Ok(None);
        }
        let row = match &mut body.content {
            Content::Lines(lines) => {
                if !self.element.properties.is_empty() && !lines.next_row()? {
                    return Err(body.ended(&self.element, self.read));
                }
                self.of_line(lines)
            }
            Content::Bytes(bytes) => {
                bytes.row = bytes.offset;
                let row = self.of_bytes(bytes);
                row.map_err(|error| body.failed(error, &self.element, self.read))?
            }
        };
        self.read += 1;
        Ok(Some(row))
    }

    /// Passes over all rows.
    pub fn skip(element: Element, body: &mut Body) -> Result<(), InputError> {
        if element.properties.is_empty() {
            return Ok(());
        }
        if let (Content::Bytes(bytes), Some(stride)) = (&mut body.content, element.stride()) {
            bytes.row = bytes.offset;
            let skipped = bytes.skip(element.rows.saturating_mul(stride as u64));
            let read = (bytes.offset - bytes.row) / stride as u64;
            return skipped.map_err(|error| body.failed(error, &element, read));
        }
        let mut rows = Self::new(element, Vec::new(), None);
        while rows.next(body)?.is_some() {}
        Ok(())
    }

    fn of_line(&mut self, lines: &Lines) -> Result<(), Flaw> {
        let mut fields = lines.text().split(u8::is_ascii_whitespace).filter(|f| !f.is_empty());
        let mut next = || fields.next().and_then(number);
        let mut read = || {
            for (n, property) in self.element.properties.iter().enumerate() {
                if property.count.is_none() {
                    let value = next()?;
                    put(&self.wanted, &mut self.values, n, value);
                    continue;
                }
                let count = whole(next()?)?;
                let keep = self.list == Some(n);
                if keep {
                    self.items.clear();
                }
                // A row has at most as many fields as bytes, so the loop ends soon.
                for _ in 0..count {
                    let item = next()?;
                    if keep {
                        self.items.push(item);
                    }
                }
            }
            Some(())
        };
        let wrong = || Flaw::PlyRow { row: lines.excerpt() };
        match read() {
            Some(()) if self.items.len() <= MOST_ITEMS => Ok(()),
            Some(()) => Err(too_long(self.items.len() as u64)),
            None => Err(wrong()),
        }
    }

    fn of_bytes(&mut self, bytes: &mut Bytes) -> io::Result<Result<(), Flaw>> {
        let encoding = bytes.encoding;
        if self.element.stride().is_some() {
            bytes.read(&mut self.record)?;
            self.decode(encoding);
            return Ok(Ok(()));
        }
        let (mut flaw, mut number) = (None, [0; 8]);
        for (n, property) in self.element.properties.iter().enumerate() {
            let mut read = |scalar: Scalar, bytes: &mut Bytes| {
                bytes.read(&mut number[..scalar.bytes()])?;
                io::Result::Ok(scalar.decode(&number, encoding))
            };
            let Some(count) = property.count else {
                let value = read(property.scalar, bytes)?;
                put(&self.wanted, &mut self.values, n, value);
                continue;
            };
            let count = whole(read(count, bytes)?);
            let length = count.unwrap_or(0);
            if self.list == Some(n) && length <= MOST_ITEMS as u64 {
                self.items.clear();
                for _ in 0..length {
                    self.items.push(read(property.scalar, bytes)?);
                }
            } else {
                bytes.skip(length * property.scalar.bytes() as u64)?;
                if self.list == Some(n) {
                    flaw = Some(too_long(length));
                }
            }
            if count.is_none() {
                // What follows cannot be found any more.
                return Err(io::Error::new(
                    io::ErrorKind::InvalidData,
                    "the length of a list is not a whole number",
                ));
            }
        }
        Ok(flaw.map_or(Ok(()), Err))
    }

    fn decode(&mut self, encoding: Encoding) {
        let mut offset = 0;
        for (n, property) in self.element.properties.iter().enumerate() {
            put_with(&self.wanted, &mut self.values, n, || {
                property.scalar.decode(&self.record[offset..], encoding)
            });
            offset += property.scalar.bytes();
        }
    }
}

/// Keeps the value of property `n` if it is wanted.
fn put(wanted: &[usize], values: &mut [f64], n: usize, value: f64) {
    put_with(wanted, values, n, || value);
}

#[inline]
fn put_with(wanted: &[usize], values: &mut [f64], n: usize, value: impl FnOnce() -> f64) {
    if let Some(at) = wanted.iter().position(|&wanted| wanted == n) {
        values[at] = value();
    }
}

/// Returns a number as the length of a list: at most that of a u32.
fn whole(value: f64) -> Option<u64> {
    let is_length = value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value);
    is_length.then_some(value as u64)
}

fn too_long(length: u64) -> Flaw {
    Flaw::TooManyCorners {
        corners: length,
        most: MOST_ITEMS,
    }
}
