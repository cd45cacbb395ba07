//! Reads constraints, components and sites of a tile as the format's page describes them.

use crate::format::page::Page;
use crate::format::reader::packed;
use crate::support::flat::Table;

/// Returns `count` bits, from the lowest of the first byte on; all `false` if the vector is absent.
pub fn bits(table: Table<'_>, slot: usize, count: usize) -> Vec<bool> {
    bits_or(false, table, slot, count)
}

/// Returns `count` bits, from the lowest of the first byte on; all `absent` if there is no vector.
pub fn bits_or(absent: bool, table: Table<'_>, slot: usize, count: usize) -> Vec<bool> {
    let Some((first, length)) = table.vector(slot) else {
        return vec![absent; count];
    };
    assert_eq!(length, count.div_ceil(8));
    (0..count)
        .map(|bit| table.bytes[first + bit / 8] >> (bit % 8) & 1 == 1)
        .collect()
}

/// Returns the integers of an array that may be absent.
pub fn optional(page: &Page, table: Table<'_>, slot: usize) -> Option<Vec<u64>> {
    let integers = packed(page, table.table(slot)?, 0);
    Some(integers.into_iter().map(|v| v.unwrap()).collect())
}

/// A source of an edge: its line, its code, and whether it begins and ends a segment.
pub type Source = (u64, u8, [bool; 2]);

/// Returns half-edges, each with a source of its edge. `ends` has two bits for each.
pub fn sources(half_edges: &[u64], sources: &[u64], ends: &[bool]) -> Vec<(usize, Source)> {
    assert_eq!([half_edges.len(), 2 * sources.len()], [sources.len(), ends.len()]);
    assert!(
        half_edges.iter().zip(sources).is_sorted_by(|a, b| a < b),
        "pairs ascend"
    );
    let entries = half_edges.iter().zip(sources).zip(ends.as_chunks().0);
    entries
        .map(|((&half_edge, &source), &ends)| (half_edge as usize, (source / 4, (source % 4) as u8, ends)))
        .collect()
}

/// Returns the component of each triangle.
pub fn read_components(page: &Page, components: [(Table<'_>, usize); 2], triangles: [usize; 2]) -> Vec<usize> {
    let parts = components.into_iter().zip(triangles);
    parts
        .flat_map(|((table, slot), count)| {
            let components = optional(page, table, slot).unwrap_or_else(|| vec![0; count]);
            assert_eq!(components.len(), count);
            components
        })
        .map(|component| component as usize)
        .collect()
}

/// Returns vertex, number and id of each site.
pub fn read_sites(page: &Page, core: Table<'_>) -> Vec<(usize, u64, String)> {
    let slot = |field| page.slot("Core", field);
    let pairs = optional(page, core, slot("sites")).unwrap_or_default();
    let ids = core.string(slot("site_ids")).unwrap_or_default();
    let ends = optional(page, core, slot("site_id_ends")).unwrap_or_else(|| vec![0; pairs.len() / 2]);
    let mut start = 0;
    let sites = pairs.chunks(2).zip(ends).map(|(pair, end)| {
        let id = ids[start..end as usize].to_owned();
        start = end as usize;
        let id = if id.is_empty() { pair[1].to_string() } else { id };
        (pair[0] as usize, pair[1], id)
    });
    let sites: Vec<_> = sites.collect();
    assert_eq!(start, ids.len());
    assert!(sites.is_sorted_by(|a, b| (a.0, a.1) < (b.0, b.1)), "sites ascend");
    sites
}
