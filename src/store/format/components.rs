//! The components of a tile: triangles that are connected without passing a constraint.

use std::collections::HashMap;

/// No component yet.
const NONE: u32 = u32::MAX;
use crate::store::format::encode::CoreDraft;
use crate::store::format::tile::regions::Component;

/// The component of each triangle of a core, numbered in the order of their first triangles.
pub(crate) fn of_core(core: &CoreDraft) -> Vec<u32> {
    joined(core).0
}

/// Numbers the components in the order of their first triangles. Returns that of each triangle, and how many there are.
///
/// From each triangle that none has reached yet, all are reached that are connected with it.
pub(crate) fn joined(core: &CoreDraft) -> (Vec<u32>, u32) {
    let count = core.triangles.len();
    // Whether a neighbour is new nobody can foretell, so nothing branches there: each is written down, and stays if it is. What lies across
    // the end of the core counts as a triangle that was reached before.
    let mut of_triangles: Vec<u32> = vec![NONE; count + 1];
    of_triangles[count] = 0;
    let mut reached: Vec<u32> = vec![0; count + 3];
    let mut components = 0;
    for first in 0..count {
        if of_triangles[first] != NONE {
            continue;
        }
        of_triangles[first] = components;
        reached[0] = first as u32;
        let mut left = 1;
        while left > 0 {
            left -= 1;
            let triangle = reached[left];
            let bits = core.constraints.get(triangle as usize).copied().unwrap_or(0);
            for (s, &twin) in core.neighbours[triangle as usize].iter().enumerate() {
                let other = twin.triangle_or_more().min(count as u32);
                let of_other = &mut of_triangles[other as usize];
                let is_new = (*of_other == NONE) & (bits >> s & 1 == 0);
                *of_other = if is_new { components } else { *of_other };
                reached[left] = other;
                left += usize::from(is_new);
            }
        }
        components += 1;
    }
    of_triangles.truncate(count);
    (of_triangles, components)
}

/// The components of a tile: those of its core, and behind them those that its border triangles have alone; and that of each
/// border triangle.
pub(crate) fn components(
    of_core: Vec<Component>,
    of_late: impl Iterator<Item = Component>,
) -> (Vec<Component>, Vec<u32>) {
    let mut all = of_core;
    let places = all.iter().zip(0..all.len() as u32).rev();
    let places = places.map(|(component, place)| (component.region, place));
    let mut places: HashMap<u64, u32> = places.collect();
    let mut of_triangles = Vec::new();
    for component in of_late {
        let place = *places.entry(component.region).or_insert_with(|| {
            all.push(component);
            all.len() as u32 - 1
        });
        of_triangles.push(place);
    }
    if of_triangles.iter().all(|&place| place == 0) {
        of_triangles.clear();
    }
    (all, of_triangles)
}
