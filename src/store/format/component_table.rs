//! The component table of a tile: what the file knows of each component of the tile, apart from the
//! tile itself.
//!
//! A component is a set of triangles of a tile that are connected within it without crossing a
//! constraint. A change elsewhere in the file may change the region of a component, its depth, or
//! whether it is a hole, but not the tile. So these are stored here, with what an edit must know of
//! a tile that it does not read: the links to components of other tiles, and the sum of the hashes
//! of the triangles.
//!
//! A table is a sequence of bytes. Numbers are in LEB128: seven bits in each byte, from the lowest
//! on; the top bit says that another byte follows. A table is the number of components, and for
//! each component, in order:
//!
//! - a byte of flags: 1 hole, 2 seeded, 4 open, 8 at the hull
//! - the number of the region, and the depth in zigzag
//! - the number of its triangles that belong to the tile, and if that is not 0 the sum of their
//!   hashes, in 16 bytes, little-endian
//! - the number of its links, and for each the number of the other tile less that of this one, in
//!   zigzag, and the number of the component in that tile

use crate::store::format::damage::Damage;
use crate::store::format::digest::DigestSum;
use crate::store::format::ids::TileId;

/// The flags of a component in a table.
const HOLE: u8 = 1;
const SEEDED: u8 = 2;
const OPEN: u8 = 4;
const AT_HULL: u8 = 8;

/// The minimum number of bytes of a component in a table.
const MIN_BYTES: usize = 5;

/// The properties that all triangles of a component of a tile share.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Component {
    /// The number of the region.
    pub(crate) region: u64,
    /// The number of obstacles that cover the component.
    pub(crate) depth: i32,
    /// Whether the region is a hole.
    pub(crate) is_hole: bool,
}

/// A component of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct ComponentId {
    pub(crate) tile: TileId,
    pub(crate) number: u32,
}

/// What a component table says of a component.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct ComponentRecord {
    /// Its region, with what holds for the whole region.
    pub(crate) component: Component,
    /// Whether a seed of a hole lies in it.
    pub(crate) is_seeded: bool,
    /// Whether it has a hull edge that is no constraint.
    pub(crate) is_open: bool,
    /// Whether it has a hull edge.
    pub(crate) is_at_hull: bool,
    /// Its triangles that belong to the tile.
    pub(crate) triangles: DigestSum,
    /// Other components of the same region, sorted: the first component of this tile that it is
    /// connected with within the tile, and for each of its triangles that belongs to another tile
    /// the component of that tile that has it.
    pub(crate) links: Vec<ComponentId>,
}

/// Encodes the table of a tile.
pub(crate) fn encode(tile: TileId, records: &[ComponentRecord]) -> Vec<u8> {
    let mut out = Vec::with_capacity(40 * records.len() + 1);
    put(&mut out, records.len() as u64);
    for record in records {
        let Component { region, depth, is_hole } = record.component;
        let flags = [
            (HOLE, is_hole),
            (SEEDED, record.is_seeded),
            (OPEN, record.is_open),
            (AT_HULL, record.is_at_hull),
        ];
        out.push(
            flags
                .into_iter()
                .filter(|(_, is_set)| *is_set)
                .map(|(flag, _)| flag)
                .sum(),
        );
        put(&mut out, region);
        put(&mut out, zigzag(depth.into()));
        put(&mut out, record.triangles.count);
        if record.triangles.count > 0 {
            out.extend(record.triangles.sum.to_le_bytes());
        }
        put(&mut out, record.links.len() as u64);
        for link in &record.links {
            put(&mut out, zigzag(i64::from(link.tile.0) - i64::from(tile.0)));
            put(&mut out, link.number.into());
        }
    }
    out
}

/// Decodes the table of a tile. The error says what is wrong.
pub(crate) fn decode(tile: TileId, bytes: &[u8]) -> Result<Vec<ComponentRecord>, Damage> {
    decode_with(tile, bytes, |record| record)
}

/// Decodes the table of a tile, and returns what `keep` makes of each record.
pub(crate) fn decode_with<T>(
    tile: TileId,
    bytes: &[u8],
    keep: impl Fn(ComponentRecord) -> T,
) -> Result<Vec<T>, Damage> {
    let wrong = || Damage::new("its component table is malformed");
    let mut rest = Rest(bytes);
    let count = rest.number().filter(|&count| count <= (bytes.len() / MIN_BYTES) as u64);
    let count = count.filter(|&count| count > 0).ok_or_else(wrong)?;
    let mut kept = Vec::with_capacity(count as usize);
    for _ in 0..count {
        kept.push(keep(rest.record(tile).ok_or_else(wrong)?));
    }
    match rest.0.is_empty() {
        true => Ok(kept),
        false => Err(wrong()),
    }
}

/// The part of a table that is not decoded yet.
struct Rest<'a>(&'a [u8]);

impl Rest<'_> {
    fn bytes<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*first)
    }

    fn number(&mut self) -> Option<u64> {
        let mut value = 0u64;
        for shift in (0..64).step_by(7) {
            let [byte] = self.bytes()?;
            let bits = u64::from(byte & 0x7f);
            if bits << shift >> shift != bits {
                return None;
            }
            value |= bits << shift;
            if byte & 0x80 == 0 {
                return Some(value);
            }
        }
        None
    }

    fn record(&mut self, tile: TileId) -> Option<ComponentRecord> {
        let [flags] = self.bytes()?;
        if flags & !(HOLE | SEEDED | OPEN | AT_HULL) != 0 {
            return None;
        }
        let region = self.number()?;
        let depth = i32::try_from(unzigzag(self.number()?)).ok()?;
        let count = self.number()?;
        let sum = match count {
            0 => 0,
            _ => u128::from_le_bytes(self.bytes()?),
        };
        let links = self.number()?;
        // A link takes two bytes at least.
        if links > (self.0.len() / 2) as u64 {
            return None;
        }
        let links: Option<Vec<ComponentId>> = (0..links).map(|_| self.link(tile)).collect();
        Some(ComponentRecord {
            component: Component {
                region,
                depth,
                is_hole: flags & HOLE != 0,
            },
            is_seeded: flags & SEEDED != 0,
            is_open: flags & OPEN != 0,
            is_at_hull: flags & AT_HULL != 0,
            triangles: DigestSum { count, sum },
            links: links?,
        })
    }

    fn link(&mut self, tile: TileId) -> Option<ComponentId> {
        let other = i64::from(tile.0).checked_add(unzigzag(self.number()?))?;
        Some(ComponentId {
            tile: TileId(u32::try_from(other).ok()?),
            number: u32::try_from(self.number()?).ok()?,
        })
    }
}

fn put(out: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

/// Maps a signed number to an unsigned one, which is small if the signed one is close to 0: 0, 1,
/// 2, 3 stand for 0, −1, 1, −2.
fn zigzag(value: i64) -> u64 {
    ((value << 1) ^ (value >> 63)) as u64
}

fn unzigzag(value: u64) -> i64 {
    (value >> 1) as i64 ^ -((value & 1) as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn records() -> Vec<ComponentRecord> {
        let id = |tile, number| ComponentId {
            tile: TileId(tile),
            number,
        };
        vec![
            ComponentRecord {
                component: Component {
                    region: u64::MAX,
                    depth: i32::MIN,
                    is_hole: true,
                },
                is_seeded: true,
                is_open: true,
                is_at_hull: true,
                triangles: DigestSum {
                    count: 300,
                    sum: u128::MAX - 5,
                },
                links: vec![id(0, 0), id(7, 200), id(u32::MAX, u32::MAX)],
            },
            ComponentRecord::default(),
            ComponentRecord {
                component: Component {
                    region: 128,
                    depth: 3,
                    is_hole: false,
                },
                ..ComponentRecord::default()
            },
        ]
    }

    #[test]
    fn tables_are_decoded_as_they_were_encoded() {
        for tile in [0, 7, u32::MAX].map(TileId) {
            let table = encode(tile, &records());
            assert_eq!(decode(tile, &table), Ok(records()));
        }
    }

    #[test]
    fn malformed_tables_are_errors() {
        let tile = TileId(7);
        let table = encode(tile, &records());
        for end in 0..table.len() {
            assert!(decode(tile, &table[..end]).is_err(), "cut off at {end}");
        }
        assert!(decode(tile, &[&table[..], &[0]].concat()).is_err());
        assert!(decode(tile, &[0]).is_err());
        // A count that the table has no room for must not be believed.
        assert!(decode(tile, &[0xff, 0xff, 0xff, 0xff, 0x0f, 0, 0, 0, 0, 0]).is_err());
        assert!(decode(tile, &[1, 0, 0, 0, 0, 0xff, 0xff, 0xff, 0x7f, 0, 0]).is_err());
        // A flag that is not known, a number of more than 64 bits, a depth of more than 32 bits, a
        // link below tile 0.
        assert!(decode(tile, &[1, 16, 0, 0, 0, 0]).is_err());
        assert!(decode(tile, &[&[1, 0][..], &[0xff; 9], &[2, 0, 0, 0]].concat()).is_err());
        assert!(decode(tile, &[1, 0, 0, 0x80, 0x80, 0x80, 0x80, 0x10, 0, 0]).is_err());
        assert!(decode(tile, &[1, 0, 0, 0, 0, 1, 17, 0]).is_err());
    }
}
