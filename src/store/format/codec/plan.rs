//! The plan of a buffer: what Zstandard compresses in place of it.
//!
//! A plan lists sections of the buffer with their codings, followed by all bytes that are in no
//! section, and by the data of the sections. `schema/FORMAT.md` specifies it. The decoder knows
//! nothing of the buffer's content, so it decodes whatever the encoder has found.

use std::ops::Range;

use crate::store::format::codec::column::Column;
use crate::store::format::codec::mesh;
use crate::store::format::codec::planes::Cursor;
use crate::store::format::damage::Damage;

/// The kinds of sections, as they are stored.
pub(super) const TABLE: u8 = 0;
pub(super) const CORNERS: u8 = 1;
pub(super) const TWINS: u8 = 2;
pub(super) const STARTS: u8 = 3;

/// The most sections of a plan. A core has at most 11 arrays, and a border 12.
const MAX_SECTIONS: u32 = 64;

/// A section of a buffer.
#[derive(Debug)]
enum Section {
    /// Rows of some columns.
    Table(Vec<Column>),
    /// Corners of triangles, of `width` bytes each.
    Corners { width: usize, planes: u8 },
    /// Neighbours of half-edges, of `width` bytes each.
    Twins { width: usize, planes: u8 },
    /// A half-edge for each vertex, of `width` bytes.
    Starts { width: usize },
}

impl Section {
    /// Reads a section and the range of the buffer that it describes.
    fn read(cursor: &mut Cursor<'_>) -> Result<(Self, Range<usize>), Damage> {
        let start = u32::from_le_bytes(cursor.array()?) as usize;
        let rows = u32::from_le_bytes(cursor.array()?) as usize;
        let [kind, columns, width, planes] = cursor.array()?;
        let width = usize::from(width);
        let (section, row) = match kind {
            TABLE => {
                let columns = (0..columns).map(|_| Column::read(cursor));
                let columns = columns.collect::<Result<Vec<_>, _>>()?;
                let row = columns.iter().map(|column| column.width()).sum();
                (Self::Table(columns), row)
            }
            CORNERS => (Self::Corners { width, planes }, 3 * width),
            TWINS => (Self::Twins { width, planes }, 3 * width),
            STARTS => (Self::Starts { width }, width),
            _ => return Err(Damage::new(format!("its plan has a section of kind {kind}"))),
        };
        let is_mesh = kind != TABLE;
        if row == 0 || is_mesh && (!mesh::WIDTHS.contains(&width) || planes > 4) {
            return Err(Damage::new("its plan has a section of a wrong width"));
        }
        let end = rows.checked_mul(row).and_then(|length| length.checked_add(start));
        let end = end.ok_or_else(out_of_range)?;
        Ok((section, start..end))
    }
}

fn out_of_range() -> Damage {
    Damage::new("its plan has a section out of range or out of order")
}

/// Decodes a plan into the buffer that it describes, of known length.
pub(super) fn decode(plan: &[u8], out: &mut [u8]) -> Result<(), Damage> {
    let mut cursor = Cursor::new(plan);
    let count = u32::from_le_bytes(cursor.array()?);
    if count > MAX_SECTIONS {
        return Err(Damage::new(format!("its plan has {count} sections")));
    }
    let sections = (0..count).map(|_| Section::read(&mut cursor));
    let sections = sections.collect::<Result<Vec<_>, _>>()?;
    let ends = sections.iter().map(|(_, range)| range.end);
    let ends = std::iter::once(0).chain(ends).collect::<Vec<_>>();
    let starts = sections.iter().map(|(_, range)| range.start).chain([out.len()]);
    for (end, start) in ends.into_iter().zip(starts) {
        let gap = out.get_mut(end..start).ok_or_else(out_of_range)?;
        gap.copy_from_slice(cursor.take(gap.len())?);
    }
    // The corners that were decoded last, and the bytes of each.
    let mut corners = None;
    for (section, range) in sections {
        let (done, rest) = out.split_at_mut(range.start);
        let rows = rest.get_mut(..range.len()).ok_or_else(out_of_range)?;
        match section {
            Section::Table(columns) => {
                let stride = columns.iter().map(|column| column.width()).sum();
                let mut at = 0;
                for column in columns {
                    column.decode(&mut cursor, rows, stride, at)?;
                    at += column.width();
                }
            }
            Section::Corners { width, planes } => {
                mesh::decode_corners(&mut cursor, rows, width, planes)?;
                corners = Some((range, width));
            }
            Section::Twins { width, planes } => mesh::decode_twins(&mut cursor, rows, width, planes)?,
            Section::Starts { width } => {
                let corners = corners
                    .clone()
                    .and_then(|(range, width)| Some((done.get(range)?, width)));
                let (corners, corner_width) = corners.ok_or_else(out_of_range)?;
                mesh::decode_starts(corners, corner_width, rows, width)?;
            }
        }
    }
    cursor.end()
}
