//! Corners and neighbours of the triangles of a core, and a half-edge for each vertex.
//!
//! A neighbour that comes earlier is stored, as a distance; one that comes later is not, because it
//! stores this one. The half-edges of the vertices follow from the corners.

use crate::store::format::codec::planes::{Cursor, Planes, unzigzag, with_planes};
use crate::store::format::damage::Damage;

/// The least and the largest width of packed integers that are coded as meshes.
pub(super) const WIDTHS: std::ops::RangeInclusive<usize> = 1..=4;

/// Triangles whose neighbours are decoded at a time. Their half-edges stay in the L1 cache.
const BATCH: usize = 256;

/// Calls a function with a constant width, which is in [`WIDTHS`].
macro_rules! with_width {
    ($width:expr, $name:ident => $call:expr) => {
        match $width {
            1 => {
                const $name: usize = 1;
                $call
            }
            2 => {
                const $name: usize = 2;
                $call
            }
            3 => {
                const $name: usize = 3;
                $call
            }
            _ => {
                const $name: usize = 4;
                $call
            }
        }
    };
}

pub(super) use with_width;

#[inline(always)]
pub(super) fn get<const WIDTH: usize>(values: &[[u8; WIDTH]], index: usize) -> u32 {
    let mut word = [0; 4];
    word[..WIDTH].copy_from_slice(&values[index]);
    u32::from_le_bytes(word)
}

#[inline(always)]
fn bytes<const WIDTH: usize>(value: u32) -> [u8; WIDTH] {
    let mut bytes = [0; WIDTH];
    bytes.copy_from_slice(&value.to_le_bytes()[..WIDTH]);
    bytes
}

/// Predicts the second corner of a triangle: if it has the first corner of the triangle before, it
/// is the next triangle around that corner.
#[inline(always)]
pub(super) fn second(first: u32, before: [u32; 2]) -> u32 {
    if first == before[0] { before[1] } else { first }
}

/// Decodes corners of `width` bytes.
pub(super) fn decode_corners(cursor: &mut Cursor<'_>, out: &mut [u8], width: usize, planes: u8) -> Result<(), Damage> {
    with_planes!(planes.min(4), PLANES => with_width!(width, WIDTH => {
        corners::<PLANES, WIDTH>(cursor, out.as_chunks_mut().0)
    }))
}

fn corners<const PLANES: usize, const WIDTH: usize>(
    cursor: &mut Cursor<'_>,
    out: &mut [[u8; WIDTH]],
) -> Result<(), Damage> {
    let (triangles, _) = out.as_chunks_mut::<3>();
    let count = triangles.len();
    let mut planes = || cursor.planes::<PLANES>(count);
    let (a, b, c) = (planes()?, planes()?, planes()?);
    let delta = |planes: &Planes<'_, PLANES>, index| unzigzag(planes.get(index)) as u32;
    let mask = u32::MAX >> (32 - 8 * WIDTH);
    let mut before = [0u32; 2];
    for (triangle, index) in triangles.iter_mut().zip(0..) {
        let first = before[0].wrapping_add(delta(&a, index)) & mask;
        let second = second(first, before).wrapping_add(delta(&b, index)) & mask;
        let third = second.wrapping_add(delta(&c, index)) & mask;
        *triangle = [bytes(first), bytes(second), bytes(third)];
        before = [first, third];
    }
    Ok(())
}

/// Decodes the neighbours of half-edges.
pub(super) fn decode_twins(cursor: &mut Cursor<'_>, out: &mut [u8], width: usize, planes: u8) -> Result<(), Damage> {
    with_planes!(planes.min(4), PLANES => with_width!(width, WIDTH => {
        twins::<PLANES, WIDTH>(cursor, out.as_chunks_mut().0)
    }))
}

fn twins<const PLANES: usize, const WIDTH: usize>(
    cursor: &mut Cursor<'_>,
    out: &mut [[u8; WIDTH]],
) -> Result<(), Damage> {
    let masks = cursor.take(out.len() / 3)?;
    let earlier: usize = masks.iter().map(|mask| (mask & 7).count_ones() as usize).sum();
    let distances = cursor.planes::<PLANES>(earlier)?;
    out.fill([0xFF; WIDTH]);
    let (mut first, mut next) = (0, 0);
    let mut are_valid = true;
    for masks in masks.chunks(BATCH) {
        // Branch-free: whether a neighbour comes earlier is unpredictable.
        let mut half_edges = [0; 3 * BATCH];
        let mut count = 0;
        for (&mask, triangle) in masks.iter().zip(0u32..) {
            for s in 0..3 {
                half_edges[count] = first + 3 * triangle + s;
                count += usize::from(mask >> s & 1);
            }
        }
        for (&half_edge, index) in half_edges[..count].iter().zip(next..) {
            let distance = distances.get(index) as u32;
            are_valid &= distance <= half_edge;
            let twin = half_edge.saturating_sub(distance);
            out[half_edge as usize] = bytes(twin);
            out[twin as usize] = bytes(half_edge);
        }
        first += 3 * masks.len() as u32;
        next += count;
    }
    match are_valid {
        true => Ok(()),
        false => Err(Damage::new("its plan has a neighbour before the first")),
    }
}

/// Derives a half-edge that starts at each vertex: the last one.
pub(super) fn decode_starts(corners: &[u8], corner_width: usize, out: &mut [u8], width: usize) -> Result<(), Damage> {
    with_width!(corner_width, CORNER => with_width!(width, WIDTH => {
        starts::<CORNER, WIDTH>(corners.as_chunks().0, out.as_chunks_mut().0)
    }))
}

fn starts<const CORNER: usize, const WIDTH: usize>(
    corners: &[[u8; CORNER]],
    out: &mut [[u8; WIDTH]],
) -> Result<(), Damage> {
    out.fill([0xFF; WIDTH]);
    for half_edge in 0..corners.len() {
        let vertex = get(corners, half_edge) as usize;
        let start = out.get_mut(vertex);
        *start.ok_or_else(|| Damage::new("its plan has a corner that is no vertex"))? = bytes(half_edge as u32);
    }
    Ok(())
}
