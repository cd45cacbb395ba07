//! Encodes corners and neighbours.

use crate::store::format::codec::mesh::{get, second, with_width};
use crate::store::format::codec::planes::{PlanData, planes_for, zigzag};

/// Returns packed integers of `width` bytes, which is in [`WIDTHS`].
fn values(packed: &[u8], width: usize) -> Vec<u32> {
    with_width!(width, WIDTH => {
        let packed = packed.as_chunks::<WIDTH>().0;
        (0..packed.len()).map(|index| get(packed, index)).collect()
    })
}

/// Returns the signed difference of two integers of `width` bytes, mapped to an unsigned one.
fn delta(value: u32, before: u32, width: usize) -> u64 {
    let unused = 32 - 8 * width as u32;
    zigzag(((value.wrapping_sub(before) << unused) as i32 >> unused).into())
}

/// Encodes corners. Returns the number of planes.
pub(super) fn encode_corners(out: &mut PlanData, packed: &[u8], width: usize) -> u8 {
    let corners = values(packed, width);
    let deltas = || {
        let mut before = [0; 2];
        corners.as_chunks().0.iter().map(move |&[a, b, c]| {
            let deltas = [
                delta(a, before[0], width),
                delta(b, second(a, before), width),
                delta(c, b, width),
            ];
            before = [a, c];
            deltas
        })
    };
    let all = deltas().fold(0, |all, deltas| deltas.iter().fold(all, |all, delta| all | delta));
    let planes = planes_for(all);
    for corner in 0..3 {
        let deltas: Vec<u64> = deltas().map(|deltas| deltas[corner]).collect();
        out.planes(&deltas, planes);
    }
    planes as u8
}

/// Encodes neighbours. Returns the number of planes, or `None` if they are not mutual.
pub(super) fn encode_twins(out: &mut PlanData, packed: &[u8], width: usize) -> Option<u8> {
    let twins = values(packed, width);
    let none = u32::MAX >> (32 - 8 * width);
    let mut masks = vec![0; twins.len() / 3];
    let mut distances = Vec::new();
    for (half_edge, &twin) in twins.iter().enumerate() {
        if twin == none {
            continue;
        }
        let index = twin as usize;
        if index == half_edge || twins.get(index).is_none_or(|&back| back as usize != half_edge) {
            return None;
        }
        if index < half_edge {
            masks[half_edge / 3] |= 1 << (half_edge % 3);
            distances.push((half_edge - index) as u64);
        }
    }
    out.part(masks.into_iter());
    Some(out.all_planes(&distances))
}
