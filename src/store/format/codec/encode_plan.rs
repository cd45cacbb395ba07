//! Makes the plan of a buffer.

use std::ops::Range;

use crate::store::format::codec::encode_column::{encode_floats, encode_integers};
use crate::store::format::codec::encode_mesh::{encode_corners, encode_twins};
use crate::store::format::codec::fields::{Content, Field};
use crate::store::format::codec::mesh::{WIDTHS, decode_starts};
use crate::store::format::codec::plan::{CORNERS, STARTS, TABLE, TWINS};
use crate::store::format::codec::planes::PlanData;

/// The lists of a plan while it is made.
#[derive(Default)]
struct Draft {
    headers: Vec<u8>,
    sections: u32,
    /// The ranges of the sections.
    covered: Vec<Range<usize>>,
    data: PlanData,
    /// The range of the last corners, and the bytes of each.
    corners: Option<(Range<usize>, usize)>,
}

/// Makes the plan of a buffer with these fields, which are disjoint and in order.
pub(super) fn encode(buffer: &[u8], fields: &[Field]) -> PlanData {
    let mut draft = Draft::default();
    for field in fields {
        draft.add(buffer, field);
    }
    let mut bytes = draft.sections.to_le_bytes().to_vec();
    bytes.append(&mut draft.headers);
    let mut end = 0;
    for range in draft.covered {
        bytes.extend_from_slice(&buffer[end..range.start]);
        end = range.end;
    }
    bytes.extend_from_slice(&buffer[end..]);
    let mut ends = vec![bytes.len()];
    ends.extend(draft.data.ends.iter().map(|end| bytes.len() + end));
    bytes.append(&mut draft.data.bytes);
    PlanData { bytes, ends }
}

impl Draft {
    fn add(&mut self, buffer: &[u8], field: &Field) {
        let bytes = &buffer[field.range.clone()];
        match field.content {
            Content::Integers { width, columns } => self.integers(bytes, field, width, columns),
            Content::Floats { columns } => self.table(bytes, field, &vec![8; columns], true),
            Content::Foreign => self.table(bytes, field, &[8, 8, 4, 4], true),
            Content::Corners { width } if WIDTHS.contains(&width) => {
                let planes = encode_corners(&mut self.data, bytes, width);
                self.mesh(field, CORNERS, width, planes, bytes.len() / (3 * width));
                self.corners = Some((field.range.clone(), width));
            }
            Content::Corners { width } => self.integers(bytes, field, width, 3),
            Content::Twins { width } => {
                let planes = WIDTHS
                    .contains(&width)
                    .then(|| encode_twins(&mut self.data, bytes, width));
                match planes.flatten() {
                    Some(planes) => self.mesh(field, TWINS, width, planes, bytes.len() / (3 * width)),
                    None => self.integers(bytes, field, width, 3),
                }
            }
            Content::Starts { width } => match self.derives(buffer, bytes, width) {
                true => self.mesh(field, STARTS, width, 0, bytes.len() / width),
                false => self.integers(bytes, field, width, 1),
            },
        }
    }

    fn derives(&self, buffer: &[u8], starts: &[u8], width: usize) -> bool {
        let Some((corners, corner_width)) = self.corners.clone().filter(|_| WIDTHS.contains(&width)) else {
            return false;
        };
        let mut derived = vec![0; starts.len()];
        let done = decode_starts(&buffer[corners], corner_width, &mut derived, width);
        done.is_ok() && derived == starts
    }

    fn header(&mut self, field: &Field, rows: usize, rest: [u8; 4]) {
        self.headers.extend((field.range.start as u32).to_le_bytes());
        self.headers.extend((rows as u32).to_le_bytes());
        self.headers.extend(rest);
        self.sections += 1;
    }

    fn mesh(&mut self, field: &Field, kind: u8, width: usize, planes: u8, rows: usize) {
        self.header(field, rows, [kind, 0, width as u8, planes]);
        self.covered.push(field.range.clone());
    }

    /// Adds a table of integers, of one column if the rows are not complete.
    fn integers(&mut self, bytes: &[u8], field: &Field, width: usize, columns: usize) {
        let columns = if bytes.len().is_multiple_of(width * columns) {
            columns
        } else {
            1
        };
        self.table(bytes, field, &vec![width; columns], false);
    }

    /// Adds a table. Columns of eight bytes are floating-point numbers if `has_floats`.
    fn table(&mut self, bytes: &[u8], field: &Field, widths: &[usize], has_floats: bool) {
        let stride: usize = widths.iter().sum();
        let rows = bytes.len() / stride;
        self.header(field, rows, [TABLE, widths.len() as u8, 0, 0]);
        self.covered.push(field.range.start..field.range.start + rows * stride);
        let mut at = 0;
        for &width in widths {
            let values = bytes.chunks_exact(stride).map(|row| {
                let mut word = [0; 8];
                word[..width].copy_from_slice(&row[at..at + width]);
                u64::from_le_bytes(word)
            });
            let column = match width {
                8 if has_floats => encode_floats(&mut self.data, &values.map(f64::from_bits).collect::<Vec<_>>()),
                _ => encode_integers(&mut self.data, values, width as u8),
            };
            column.write(&mut self.headers);
            at += width;
        }
    }
}
