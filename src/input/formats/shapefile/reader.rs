//! The header of a file, and its records one after the other.

use crate::input::about::Field;
use crate::input::bytes::ByteInput;
use crate::input::caught::catch;
use crate::input::error::InputError;
use crate::input::formats::shapefile::beside::{Ids, crs_beside, fields_beside};
use crate::input::formats::shapefile::record::add_record;
use crate::input::formats::shapes::{Blocks, Decoded, Decoder, Feature, Shapes};
use crate::input::watch::Watch;
use crate::shown;
use ::shapefile::header::Header;
use std::sync::Arc;

/// The length in bytes of the header, and of that of a record.
const HEADER: u64 = 100;
const RECORD_HEADER: u64 = 8;

/// Reads the header.
pub fn open(input: ByteInput) -> Result<Box<dyn Shapes>, InputError> {
    let watch = Arc::clone(&input.watch);
    let mut blocks = Blocks::new(input);
    let mut header = Vec::new();
    blocks.read(HEADER, &mut header, "the header")?;
    let header = match Header::read_from(&mut header.as_slice()) {
        Ok(header) => header,
        Err(error) => return Err(blocks.damaged("the header is invalid".to_owned(), Some(Box::new(error)))),
    };
    // The length is in words of two bytes, and is a signed number in the crate.
    let length = 2 * u64::from(header.file_length.cast_unsigned());
    let left = length.saturating_sub(HEADER);
    if blocks.left().is_some_and(|there| there < left) || length < HEADER {
        let there = HEADER + blocks.left().unwrap_or(left);
        let problem = format!("the header says that the file has {length} bytes, and it has {there}");
        return Err(blocks.cut_short(problem));
    }
    let crs = crs_beside(&watch);
    Ok(Box::new(Decoded::new(Shapefile {
        blocks,
        watch,
        length,
        crs,
        record: Vec::new(),
        ids: None,
        lone_holes: 0,
        has_rest: false,
    })))
}

struct Shapefile {
    blocks: Blocks,
    watch: Arc<Watch>,
    /// The length of the file in bytes, according to its header.
    length: u64,
    crs: Option<String>,
    /// The current record.
    record: Vec<u8>,
    ids: Option<Ids>,
    /// The number of rings that are directed as holes but are in no outer ring.
    lone_holes: u64,
    /// Whether bytes follow the length that the header tells.
    has_rest: bool,
}

impl Decoder for Shapefile {
    fn decode(&mut self, number: u64, feature: &mut Feature) -> Result<bool, InputError> {
        if self.blocks.position >= self.length {
            self.has_rest = !self.blocks.is_at_end()?;
            return Ok(false);
        }
        let what = format!("record {number}");
        self.record.clear();
        self.blocks
            .read(RECORD_HEADER, &mut self.record, format_args!("the header of {what}"))?;
        let words = self
            .record
            .last_chunk::<4>()
            .map_or(0, |words| u32::from_be_bytes(*words));
        let (length, left) = (
            2 * u64::from(words),
            self.length - self.blocks.position.min(self.length),
        );
        if length > left {
            let problem = format!("{what} has {length} bytes, and {left} are left of those that the header tells");
            return Err(self.blocks.damaged(problem, None));
        }
        self.record.clear();
        self.blocks.read(length, &mut self.record, &what)?;
        let problem = match catch(|| add_record(&mut self.record, feature)) {
            Some(Ok(lone_holes)) => {
                self.lone_holes += lone_holes;
                if let Some(ids) = &mut self.ids {
                    feature.id = ids.id(number)?;
                }
                return Ok(true);
            }
            Some(Err(problem)) => problem,
            None => "it cannot be decoded".to_owned(),
        };
        Err(self.blocks.damaged(format!("{what} is invalid: {problem}"), None))
    }

    fn keep_ids(&mut self, field: &str) {
        self.ids = Some(Ids::new(&self.watch, field));
    }

    fn fields(&self) -> Vec<Field> {
        fields_beside(&self.watch)
    }

    fn crs(&self) -> Option<&str> {
        self.crs.as_deref()
    }

    fn notes(&self) -> Vec<String> {
        let (path, holes, length) = (shown::path(&self.blocks.path), self.lone_holes, self.length);
        let lone = (holes > 0).then(|| {
            format!("{path}: {holes} rings are directed as holes but are in no outer ring; each is read as a polygon")
        });
        let rest = || format!("{path}: what follows the {length} bytes that the header announces is not read");
        lone.into_iter().chain(self.has_rest.then(rest)).collect()
    }
}
