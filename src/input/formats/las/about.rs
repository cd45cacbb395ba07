//! What a LAS file says of itself, and the counts of its classes and returns.

use crate::input::about::{About, CopcInfo, Field, LasInfo};
use crate::input::formats::las::layout::Layout;
use crate::input::formats::las::problem::{FileReader, trimmed};
use ::las::point::Format;
use ::las::raw::Vlr;
use ::las::raw::header::Header;
use std::io::{Read, Seek, SeekFrom};

/// The length of an entry that describes extra bytes, and of one of COPC's list of nodes.
const EXTRA: usize = 192;
const NODE: usize = 32;
/// The limit on the pages of the list of nodes that are to be read.
const MOST_PAGES: usize = 1 << 16;

/// The counts over all points of a file, and what its header says.
pub struct Census {
    info: LasInfo,
    fields: Vec<Field>,
    classes: [u64; 256],
    returns: [u64; 16],
}

impl Census {
    /// Takes the header, and reads the list of nodes of COPC.
    pub fn new(file: &mut FileReader, header: &Header, records: &[Vlr], layout: &Layout, size: u64) -> Self {
        let text = |field: &[u8]| String::from_utf8_lossy(trimmed(field)).trim().to_owned();
        let (day, year) = (header.file_creation_day_of_year, header.file_creation_year);
        let number = header.point_data_record_format & 0x3f;
        Self {
            info: LasInfo {
                version: header.version.to_string(),
                point_format: number,
                record_length: header.point_data_record_length,
                is_compressed: header.point_data_record_format & 0x80 != 0,
                system: text(&header.system_identifier),
                software: text(&header.generating_software),
                created: (year > 0).then_some((year, day)),
                scale: layout.scale,
                offset: layout.offset,
                copc: copc(file, records, size),
                ..LasInfo::default()
            },
            fields: fields(number, header.point_data_record_length, records),
            classes: [0; 256],
            returns: [0; 16],
        }
    }

    /// Counts points.
    pub fn add(&mut self, records: &[u8], layout: &Layout) {
        for record in records.chunks_exact(layout.length) {
            let (class, number, _) = layout.class_and_return(record);
            self.classes[usize::from(class)] += 1;
            self.returns[usize::from(number & 15)] += 1;
        }
    }

    pub fn about(&self) -> About {
        fn occurring(counts: &[u64]) -> Vec<(u8, u64)> {
            let counts = (0..=u8::MAX).zip(counts.iter().copied());
            counts.filter(|(_, count)| *count > 0).collect()
        }
        let variety = match (self.info.is_compressed, self.info.copc) {
            (_, Some(_)) => "COPC",
            (true, None) => "LAZ",
            (false, None) => "LAS",
        };
        About {
            variety: Some(variety.to_owned()),
            fields: self.fields.clone(),
            las: Some(LasInfo {
                classes: occurring(&self.classes),
                returns: occurring(&self.returns),
                ..self.info.clone()
            }),
        }
    }
}

/// Returns the fields of the points of a format.
fn fields(number: u8, length: u16, records: &[Vlr]) -> Vec<Field> {
    let Ok(format) = Format::new(number) else {
        return Vec::new();
    };
    let (returns, angle) = match format.is_extended {
        true => ("4 bits", "i16, 0.006 degrees"),
        false => ("3 bits", "i8, degrees"),
    };
    let class = if format.is_extended { "u8" } else { "5 bits" };
    let mut fields = vec![
        ("x", "i32, scaled"),
        ("y", "i32, scaled"),
        ("z", "i32, scaled"),
        ("intensity", "u16"),
        ("return_number", returns),
        ("number_of_returns", returns),
        ("classification", class),
        ("scan_angle", angle),
        ("user_data", "u8"),
        ("point_source_id", "u16"),
    ];
    fields.extend(format.has_gps_time.then_some(("gps_time", "f64")));
    if format.has_color {
        fields.extend([("red", "u16"), ("green", "u16"), ("blue", "u16")]);
    }
    fields.extend(format.has_nir.then_some(("nir", "u16")));
    fields.extend(format.has_waveform.then_some(("wave_packet", "29 bytes")));
    let mut fields: Vec<Field> = fields.into_iter().map(|(name, kind)| Field::new(name, kind)).collect();
    fields.extend(extra_fields(usize::from(length - format.len().min(length)), records));
    fields
}

/// Returns the extra fields that a record describes, and the bytes that none does.
fn extra_fields(mut bytes: usize, records: &[Vlr]) -> Vec<Field> {
    let described = find(records, b"LASF_Spec", 4).unwrap_or_default();
    let mut fields = Vec::new();
    for entry in described.chunks_exact(EXTRA) {
        let (kind, size) = extra_kind(entry[2], entry[3]);
        if bytes == 0 || size > bytes {
            break;
        }
        bytes -= size;
        let name = String::from_utf8_lossy(trimmed(&entry[4..36])).into_owned();
        fields.push(Field::new(name, kind));
    }
    if bytes > 0 {
        fields.push(Field::new(
            "extra_bytes",
            format!("{bytes} bytes that nothing describes"),
        ));
    }
    fields
}

/// Returns the name of the type of an extra field, and its bytes.
fn extra_kind(kind: u8, option: u8) -> (String, usize) {
    const SCALARS: [(&str, usize); 10] = [
        ("u8", 1),
        ("i8", 1),
        ("u16", 2),
        ("i16", 2),
        ("u32", 4),
        ("i32", 4),
        ("u64", 8),
        ("i64", 8),
        ("f32", 4),
        ("f64", 8),
    ];
    // 11 to 30 are pairs and triples of these, which version R14 gave up.
    let Some(number) = usize::from(kind).checked_sub(1).filter(|number| *number < 30) else {
        return (format!("{option} bytes"), usize::from(option));
    };
    let (name, size) = SCALARS[number % 10];
    match number / 10 {
        0 => (name.to_owned(), size),
        more => (format!("{} × {name}", more + 1), (more + 1) * size),
    }
}

fn find<'a>(records: &'a [Vlr], user: &[u8], id: u16) -> Option<&'a [u8]> {
    let is_it = |record: &&Vlr| record.record_id == id && trimmed(&record.user_id) == user;
    records.iter().find(is_it).map(|record| &record.data[..])
}

/// Returns what the record of COPC says. Its list of nodes is only metadata, so errors are ignored.
fn copc(file: &mut FileReader, records: &[Vlr], size: u64) -> Option<CopcInfo> {
    let info = find(records, b"copc", 1)?;
    let number = |at: usize| Some(u64::from_le_bytes(info.get(at..at + 8)?.try_into().ok()?));
    Some(CopcInfo {
        spacing: f64::from_bits(number(32)?),
        levels: levels(file, [number(40)?, number(48)?], size),
    })
}

/// Returns the number of levels of the nodes that are listed in the page at this offset and of this
/// length, and in those that it refers to.
fn levels(file: &mut FileReader, root: [u64; 2], size: u64) -> Option<u32> {
    let (mut pages, mut levels, mut left) = (vec![root], 0, size);
    while let Some([offset, length]) = pages.pop() {
        // No page is read twice in a sound file, so all of them are no longer than the file.
        left = left.checked_sub(length)?;
        if offset.checked_add(length)? > size {
            return None;
        }
        file.seek(SeekFrom::Start(offset)).ok()?;
        for _ in 0..length / NODE as u64 {
            let mut node = [0; NODE];
            file.read_exact(&mut node).ok()?;
            let int = |at: usize| node[at..at + 4].try_into().map_or(0, i32::from_le_bytes);
            let level = u32::try_from(int(0)).ok()?;
            levels = levels.max(level.checked_add(1)?);
            if int(28) == -1 {
                let offset = node[16..24].try_into().map(u64::from_le_bytes).ok()?;
                pages.push([offset, u64::try_from(int(24)).ok()?]);
                if pages.len() > MOST_PAGES {
                    return None;
                }
            }
        }
    }
    Some(levels)
}
