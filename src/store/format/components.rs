//! The components of a tile: sets of triangles that are connected without crossing a constraint.

use std::collections::HashMap;

use crate::store::format::encode::CoreDraft;
use crate::store::format::tile::regions::Component;

/// No component yet.
const NONE: u32 = u32::MAX;

/// Returns the component of each triangle of a core, numbered in the order of their first
/// triangles.
pub(crate) fn of_core(core: &CoreDraft) -> Vec<u32> {
    joined(core).0
}

/// Numbers the components of a core in the order of their first triangles. Returns the component of
/// each triangle, and the number of components.
///
/// Starts from each triangle that is not in a component yet, and visits all triangles that are
/// connected with it.
pub(crate) fn joined(core: &CoreDraft) -> (Vec<u32>, u32) {
    let count = core.triangles.len();
    // Branch-free, because the test whether a neighbour is new is unpredictable: each neighbour is
    // written to `reached`, and kept only if it is new. A twin outside the core maps to index
    // `count`, which counts as already visited.
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

/// Returns the components of a tile, those of its core first and then those of its border triangles
/// only, and the component of each border triangle.
///
/// The second list is empty if all border triangles belong to component 0.
pub(crate) fn components(
    of_core: Vec<Component>,
    of_late: impl Iterator<Item = Component>,
) -> (Vec<Component>, Vec<u32>) {
    let mut all = of_core;
    let indices = all.iter().zip(0..all.len() as u32).rev();
    let indices = indices.map(|(component, index)| (component.region, index));
    let mut indices: HashMap<u64, u32> = indices.collect();
    let mut of_triangles = Vec::new();
    for component in of_late {
        let index = *indices.entry(component.region).or_insert_with(|| {
            all.push(component);
            all.len() as u32 - 1
        });
        of_triangles.push(index);
    }
    if of_triangles.iter().all(|&index| index == 0) {
        of_triangles.clear();
    }
    (all, of_triangles)
}
