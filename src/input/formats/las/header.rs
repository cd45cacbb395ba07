//! The header of a LAS file, and the variable length records after it.

use crate::input::formats::las::copc::is_info;
use crate::input::formats::las::problem::{FileReader, Problem, trimmed};
use ::las::raw::Vlr;
use ::las::raw::header::Header;
use std::io::{Read, Seek, SeekFrom};

/// The length limit of a coordinate reference system in an extended record, in bytes.
const LONGEST_WKT: u64 = 1 << 20;

/// The keys of GeoTIFF for the kind of system (1 is a projected one), and for the codes of a
/// geographic and of a projected system.
const MODEL: u16 = 1024;
const GEOGRAPHIC: u16 = 2048;
const PROJECTED: u16 = 3072;

/// Reads the header from the file's beginning.
pub fn header(file: &mut FileReader) -> Result<Header, Problem> {
    let mut magic = [0; 4];
    match file.read_exact(&mut magic) {
        Ok(()) if magic == *b"LASF" => {}
        _ => {
            return Err(Problem {
                hint: "this is not a LAS or LAZ file",
                ..Problem::damaged("the file does not begin with `LASF`")
            });
        }
    }
    let seek_start = file.seek(SeekFrom::Start(0)).map(drop);
    seek_start
        .map_err(::las::Error::from)
        .and_then(|()| Header::read_from(file))
        .map_err(|error| Problem::cut_short("the header cannot be read").caused_by(error))
}

/// Returns the number of points. The legacy field wins if it is not zero, as the specification
/// requires.
pub fn count(header: &Header) -> u64 {
    match (header.number_of_point_records, &header.large_file) {
        (0, Some(large)) => large.number_of_point_records,
        (count, _) => u64::from(count),
    }
}

/// Reads the variable length records. Each has at most 64 KiB, and all end before the points.
pub fn records(file: &mut FileReader, header: &Header, end: u64) -> Result<Vec<Vlr>, Problem> {
    const SHORTEST: u64 = 54;
    let mut records = Vec::new();
    let mut position = u64::from(header.header_size);
    let number = header.number_of_variable_length_records;
    for n in 0..number {
        if position + SHORTEST > end {
            return Err(Problem::cut_short(format!(
                "variable length record {n} of {number} is not before the points (byte {end})"
            )));
        }
        let read = match file.seek(SeekFrom::Start(position)) {
            Ok(_) => Vlr::read_from(&mut *file, false),
            Err(error) => Err(error.into()),
        };
        let record = read.map_err(|error| {
            Problem::cut_short(format!("variable length record {n} of {number} cannot be read")).caused_by(error)
        })?;
        position += SHORTEST + record.data.len() as u64;
        // Only these records are used later; a file may have many others. In a COPC file, its own is
        // the first one: another program than one that knows COPC may keep it elsewhere.
        let is_used = match trimmed(&record.user_id) {
            b"LASF_Projection" | b"laszip encoded" => true,
            b"LASF_Spec" => record.record_id == 4,
            _ => n == 0 && is_info(&record),
        };
        if is_used {
            records.push(record);
        }
    }
    if position > end {
        return Err(Problem::cut_short(format!(
            "variable length records reach beyond byte {end}"
        )));
    }
    Ok(records)
}

/// Returns the coordinate reference system as WKT, or as `EPSG:…` from GeoTIFF keys.
pub fn crs(records: &[Vlr]) -> Option<String> {
    let find = |id: u16| {
        let is_it = |r: &&Vlr| r.record_id == id && trimmed(&r.user_id) == b"LASF_Projection";
        records.iter().find(is_it).map(|r| &r.data[..])
    };
    if let Some(wkt) = find(2112).and_then(wkt) {
        return Some(wkt);
    }
    // GeoTIFF's directory: a header of four u16, then key, location, count, value for each key.
    let (numbers, _) = find(34735)?.as_chunks::<2>();
    let numbers: Vec<u16> = numbers.iter().map(|&n| u16::from_le_bytes(n)).collect();
    let (entries, _) = numbers.get(4..)?.as_chunks::<4>();
    let value = |key: u16| Some(entries.iter().find(|e| e[0] == key && e[1] == 0)?[3]);
    // A projected system has also the key of the geographic one that it is based on.
    let code = value(PROJECTED).or_else(|| value(GEOGRAPHIC).filter(|_| value(MODEL) != Some(1)))?;
    // 32767 is "user-defined".
    (code > 0 && code < 32767).then(|| format!("EPSG:{code}"))
}

fn wkt(data: &[u8]) -> Option<String> {
    let text = String::from_utf8_lossy(trimmed(data)).trim().to_owned();
    (!text.is_empty()).then_some(text)
}

/// Returns the WKT in an extended record, if there is a sound one. Errors are ignored, since this
/// is only metadata.
pub fn extended_wkt(file: &mut FileReader, header: &Header, size: u64) -> Option<String> {
    let evlr = header.evlr?;
    let mut position = evlr.start_of_first_evlr;
    for _ in 0..evlr.number_of_evlrs {
        if position.checked_add(60)? > size {
            return None;
        }
        file.seek(SeekFrom::Start(position)).ok()?;
        let mut head = [0; 60];
        file.read_exact(&mut head).ok()?;
        let length = u64::from_le_bytes(head[20..28].try_into().ok()?);
        position = position.checked_add(60)?.checked_add(length)?;
        let id = u16::from_le_bytes([head[18], head[19]]);
        if trimmed(&head[2..18]) == b"LASF_Projection" && id == 2112 {
            let mut data = Vec::new();
            file.take(length.min(LONGEST_WKT)).read_to_end(&mut data).ok()?;
            return wkt(&data);
        }
    }
    None
}
