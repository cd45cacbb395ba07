//! The header of a file, and its features one after the other.

use crate::input::about::{Field, MOST_FIELDS};
use crate::input::bytes::ByteInput;
use crate::input::caught::catch;
use crate::input::error::InputError;
use crate::input::formats::flatgeobuf::geometry::add_geometry;
use crate::input::formats::flatgeobuf::ids::{self, find_field, id};
use crate::input::formats::shapes::{Blocks, Decoded, Decoder, Feature, Shapes};
use crate::shown;
use ::flatgeobuf::{
    Column, GeometryType, Header, size_prefixed_root_as_feature_with_opts, size_prefixed_root_as_header,
};
use flatbuffers_of_flatgeobuf::VerifierOptions;

/// The limit on the length in bytes of the header.
const LONGEST_HEADER: u64 = 10 << 20;

/// The limit on the bytes of a feature when all its parts are apart, for each byte that it has. Parts
/// may refer to the same bytes, so that a short feature could have any number of positions. Tables
/// share only their lists of fields, which are as long as a few of them.
const MOST_SHARED: usize = 8;

/// The number of bytes of a node of the index.
const NODE: u64 = 40;

/// Reads the header and skips the index.
pub fn open(input: ByteInput) -> Result<Box<dyn Shapes>, InputError> {
    let mut blocks = Blocks::new(input);
    let mut magic = Vec::new();
    blocks.read(8, &mut magic, "the beginning of a FlatGeobuf file")?;
    let is_magic = magic.starts_with(b"fgb") && magic[4..].starts_with(b"fgb");
    if !is_magic || magic[3] > ::flatgeobuf::VERSION {
        let newest = ::flatgeobuf::VERSION;
        let problem = format!("this is not a FlatGeobuf file of version {newest} or older");
        return Err(blocks.damaged(problem, None));
    }
    let mut header = Vec::new();
    read_prefixed(&mut blocks, LONGEST_HEADER, &mut header, "the header")?;
    let table = match size_prefixed_root_as_header(&header) {
        Ok(table) => table,
        Err(error) => return Err(blocks.damaged("the header is invalid".to_owned(), Some(Box::new(error)))),
    };
    let (kind, count, node_size) = (table.geometry_type(), table.features_count(), table.index_node_size());
    let crs = crs(&table);
    let Some(index) = index_length(count, node_size) else {
        let problem = format!("an index of {count} features with nodes of {node_size}");
        return Err(blocks.damaged(problem, None));
    };
    blocks.skip(index, "the index")?;
    Ok(Box::new(Decoded::new(FlatGeobuf {
        blocks,
        header,
        kind,
        count: (count > 0).then_some(count),
        crs,
        field: None,
        feature: Vec::new(),
        has_rest: false,
    })))
}

/// Reads a length and as many bytes. `block` gets both.
fn read_prefixed(blocks: &mut Blocks, most: u64, block: &mut Vec<u8>, what: &str) -> Result<(), InputError> {
    block.clear();
    blocks.read(4, block, format_args!("the length of {what}"))?;
    let length = block.as_slice().try_into().map_or(0, u32::from_le_bytes);
    if u64::from(length) > most {
        return Err(blocks.damaged(format!("{what} has {length} bytes; {most} is the limit"), None));
    }
    blocks.read(u64::from(length), block, what)
}

/// Returns the number of bytes of the index; `None` if there is no such index.
fn index_length(count: u64, node_size: u16) -> Option<u64> {
    if count == 0 || node_size == 0 {
        return Some(0);
    }
    if node_size < 2 {
        return None;
    }
    let (mut level, mut nodes) = (count, count);
    while level > 1 {
        level = level.div_ceil(u64::from(node_size));
        nodes = nodes.checked_add(level)?;
    }
    // Even the index of one feature has a root.
    nodes.max(2).checked_mul(NODE)
}

/// Returns the coordinate reference system as `EPSG:…` or as WKT.
fn crs(header: &Header) -> Option<String> {
    let crs = header.crs()?;
    let text = |text: Option<&str>| text.map(str::trim).filter(|text| !text.is_empty()).map(str::to_owned);
    if crs.code() > 0 {
        let org = text(crs.org()).unwrap_or_else(|| "EPSG".to_owned());
        return Some(format!("{org}:{}", crs.code()));
    }
    text(crs.wkt()).or_else(|| text(crs.name()))
}

struct FlatGeobuf {
    blocks: Blocks,
    /// The header with its length.
    header: Vec<u8>,
    /// The type of all geometries, or unknown.
    kind: GeometryType,
    /// The number of features, if the header tells it.
    count: Option<u64>,
    crs: Option<String>,
    field: Option<ids::Field>,
    /// The current feature with its length.
    feature: Vec<u8>,
    /// Whether bytes follow the last feature.
    has_rest: bool,
}

impl FlatGeobuf {
    /// Adds the geometries and the id of the feature that was read, or returns what is wrong.
    fn parse(&self, into: &mut Feature) -> Result<(), String> {
        let options = VerifierOptions {
            max_tables: self.feature.len(),
            max_apparent_size: self.feature.len().saturating_mul(MOST_SHARED),
            ..VerifierOptions::default()
        };
        let table = size_prefixed_root_as_feature_with_opts(&options, &self.feature);
        let table = table.map_err(|error| error.to_string())?;
        if let Some(geometry) = table.geometry() {
            add_geometry(&geometry, self.kind, into)?;
        }
        if let Some(field) = &self.field {
            into.id = id(&table, field)?;
        }
        Ok(())
    }
}

impl Decoder for FlatGeobuf {
    fn decode(&mut self, number: u64, feature: &mut Feature) -> Result<bool, InputError> {
        match self.count {
            Some(count) if number == count => {
                self.has_rest = !self.blocks.is_at_end()?;
                return Ok(false);
            }
            None if self.blocks.is_at_end()? => return Ok(false),
            _ => {}
        }
        let what = format!("feature {number}");
        read_prefixed(&mut self.blocks, u64::from(u32::MAX), &mut self.feature, &what)?;
        let parsed = catch(|| self.parse(feature));
        let problem = match parsed {
            Some(Ok(())) => return Ok(true),
            Some(Err(problem)) => problem,
            None => "it cannot be decoded".to_owned(),
        };
        Err(self.blocks.damaged(format!("{what} is invalid: {problem}"), None))
    }

    fn keep_ids(&mut self, field: &str) {
        // The header was verified before.
        let columns = size_prefixed_root_as_header(&self.header)
            .ok()
            .and_then(|header| header.columns());
        self.field = Some(find_field(columns, field));
    }

    fn fields(&self) -> Vec<Field> {
        // The header was verified before.
        let header = size_prefixed_root_as_header(&self.header).ok();
        let columns = header.and_then(|header| header.columns()).into_iter().flatten();
        let field = |column: Column| Field::new(column.name(), column.type_().variant_name().unwrap_or("unknown"));
        columns.take(MOST_FIELDS).map(field).collect()
    }

    fn crs(&self) -> Option<&str> {
        self.crs.as_deref()
    }

    fn notes(&self) -> Vec<String> {
        let (path, count) = (shown::path(&self.blocks.path), self.count.unwrap_or(0));
        let note = || format!("{path}: what follows the {count} features that the header announces is not read");
        self.has_rest.then(note).into_iter().collect()
    }
}
