//! Points and MultiPoints in WKB (OGC Simple Features), ISO's or with the flags of PostGIS.
//!
//! ```text
//! u8: 1 if little-endian | u32: type | [u32: SRID] | a point: x, y, [z], [m]; NaN if it is empty
//!                                                   | a MultiPoint: u32: points, each a WKB of its own
//! ```

use crate::input::flaw::Flaw;

/// The names of the types from 1 on.
const TYPES: [&str; 7] = [
    "Point",
    "LineString",
    "Polygon",
    "MultiPoint",
    "MultiLineString",
    "MultiPolygon",
    "GeometryCollection",
];

/// The positions of a geometry that are to come.
#[derive(Default)]
pub struct Positions {
    /// The number of bytes read.
    at: usize,
    /// The number of points to come, each with a header or, outside of a MultiPoint, without.
    left: u32,
    /// The header of the single point.
    single: Option<Header>,
    /// Whether there was a position.
    pub any: bool,
}

pub type Position = (f64, f64, Option<f64>);

#[derive(Clone, Copy)]
struct Header {
    is_little: bool,
    kind: u32,
    has_z: bool,
    has_m: bool,
}

/// Returns whether the points of a geometry have z.
pub fn has_z(wkb: &[u8]) -> bool {
    header(wkb, &mut 0).is_ok_and(|header| header.has_z)
}

impl Positions {
    /// Begins a geometry.
    pub fn of(wkb: &[u8]) -> Result<Self, Flaw> {
        let mut at = 0;
        let header = header(wkb, &mut at)?;
        match header.kind {
            1 => Ok(Self {
                at,
                left: 1,
                single: Some(header),
                any: false,
            }),
            4 => Ok(Self {
                left: number(wkb, &mut at, header.is_little)?,
                at,
                single: None,
                any: false,
            }),
            kind => Err(Flaw::NoPoint { kind: name(kind) }),
        }
    }

    /// Returns the next position of the geometry; `None` after the last one. Empty points are passed
    /// over.
    pub fn next(&mut self, wkb: &[u8]) -> Option<Result<Position, Flaw>> {
        while self.left > 0 {
            self.left -= 1;
            let point = self.point(wkb);
            match &point {
                Ok((x, y, _)) if x.is_nan() && y.is_nan() => continue,
                Ok(_) => {}
                // What follows cannot be found any more.
                Err(_) => self.left = 0,
            }
            self.any = true;
            return Some(point);
        }
        None
    }

    fn point(&mut self, wkb: &[u8]) -> Result<Position, Flaw> {
        let header = match self.single {
            Some(header) => header,
            None => header(wkb, &mut self.at)?,
        };
        if header.kind != 1 {
            return Err(Flaw::NoPoint {
                kind: format!("{} in a MultiPoint", name(header.kind)),
            });
        }
        let mut next = || {
            let bytes: [u8; 8] = take(wkb, &mut self.at)?;
            Ok(match header.is_little {
                true => f64::from_le_bytes(bytes),
                false => f64::from_be_bytes(bytes),
            })
        };
        let (x, y) = (next()?, next()?);
        let z = if header.has_z { Some(next()?) } else { None };
        if header.has_m {
            next()?;
        }
        Ok((x, y, z))
    }
}

fn header(wkb: &[u8], at: &mut usize) -> Result<Header, Flaw> {
    const Z: u32 = 0x8000_0000;
    const M: u32 = 0x4000_0000;
    const SRID: u32 = 0x2000_0000;
    let is_little = match take::<1>(wkb, at)? {
        [0] => false,
        [1] => true,
        _ => return Err(Flaw::Wkb { bytes: wkb.len() }),
    };
    let kind = number(wkb, at, is_little)?;
    if kind & SRID != 0 {
        number(wkb, at, is_little)?;
    }
    let plain = kind & !(Z | M | SRID);
    Ok(Header {
        is_little,
        kind: plain % 1000,
        has_z: kind & Z != 0 || matches!(plain / 1000, 1 | 3),
        has_m: kind & M != 0 || matches!(plain / 1000, 2 | 3),
    })
}

fn number(wkb: &[u8], at: &mut usize, is_little: bool) -> Result<u32, Flaw> {
    let bytes = take(wkb, at)?;
    Ok(match is_little {
        true => u32::from_le_bytes(bytes),
        false => u32::from_be_bytes(bytes),
    })
}

fn take<const N: usize>(wkb: &[u8], at: &mut usize) -> Result<[u8; N], Flaw> {
    let bytes = wkb.get(*at..).and_then(<[u8]>::first_chunk);
    *at += N;
    bytes.copied().ok_or(Flaw::Wkb { bytes: wkb.len() })
}

fn name(kind: u32) -> String {
    let name = (kind as usize).checked_sub(1).and_then(|n| TYPES.get(n));
    name.map_or_else(|| format!("geometry of type {kind}"), |name| (*name).to_owned())
}
