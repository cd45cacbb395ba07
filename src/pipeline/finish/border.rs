//! Assembles a tile's border from its late triangles and the boundary half-edges of its core.

use crate::geometry::{HalfEdge, Rect};
use crate::mesh::Twin;
use crate::pipeline::finish::border_mesh::{BorderMesh, BorderTriangle};
use crate::pipeline::finish::component_records::{CoreRecords, component_records};
use crate::pipeline::finish::regions::Regions;
use crate::pipeline::finish::tile_components::TileComponents;
use crate::pipeline::output::border_log::GroupBorders;
use crate::pipeline::records::{Anchor, LoggedEdge, TileState};
use crate::store::{BorderDraft, ComponentRecord, Digest, LinePart, TileId};

/// A border, and what it adds to the tile's directory entry.
#[derive(Debug)]
pub(crate) struct Border {
    pub(crate) draft: BorderDraft,
    pub(crate) records: Vec<ComponentRecord>,
    /// The digest of what belongs to the tile: the border's triangles, constraint edges except
    /// those between two core triangles, and the triangles of both core and border that are in
    /// holes.
    pub(crate) digest: Digest,
    /// Bounding box of the corners of the border's triangles that belong to the tile.
    pub(crate) bounds: Rect,
    /// Number of holes that are closed components of the core.
    pub(crate) closed_holes: u64,
}

/// What is known of the regions of a tile.
#[derive(Clone, Copy, Debug)]
pub(crate) enum TileRegions<'a> {
    /// Regions are not distinguished.
    One,
    /// Not all lines are inserted. An edit inserts them and finds the regions.
    Unknown,
    Known {
        all: &'a Regions,
        /// The components of the core that contain seeds, sorted.
        seeded: &'a [u32],
    },
}

/// Assembles the border of a tile.
pub(crate) fn assemble(
    tile: TileId,
    state: &TileState,
    group: &GroupBorders,
    mesh: &BorderMesh,
    regions: TileRegions<'_>,
) -> Border {
    let (neighbours, core_links) = link(mesh);
    let mut logged: Vec<LoggedEdge> = group.edges_of(tile).collect();
    let mut digest = edge_digest(&mut logged);
    digest.triangles = mesh.owned;
    let along = logged.iter();
    let along = along.map(|edge| (edge.ends.map(|id| mesh.corner(id)), edge.source));
    let (edges, edge_sources) = match mesh.half_edges.is_empty() {
        true => edges(along.collect()),
        false => (Vec::new(), edge_sources(mesh, along)),
    };
    let mut draft = BorderDraft {
        vertices: state.vertices,
        core_triangles: state.core_triangles,
        vertex_sides: vertex_sides(mesh),
        foreign: mesh.foreign.iter().map(|v| (v.id, v.point)).collect(),
        foreign_z: group.has_z.then(|| mesh.foreign.iter().map(|v| v.z).collect()),
        triangles: mesh.late.iter().map(|late| late.corners).collect(),
        neighbours,
        core_links,
        constraints: mesh.late.iter().map(BorderTriangle::edge_bits).collect(),
        // Set below if there are several.
        components: Vec::new(),
        edge_sources,
        edges,
    };
    let Labelled {
        mut of_late,
        records,
        closed_holes,
    } = labelled(tile, state, group, mesh, regions);
    for record in records.iter().filter(|record| record.component.is_hole) {
        digest.holes += record.triangles;
    }
    if of_late.iter().any(|&component| component > 0) {
        draft.components.append(&mut of_late);
    }
    Border {
        draft,
        records,
        digest,
        bounds: mesh.bounds,
        closed_holes,
    }
}

/// The components of a tile with their regions.
struct Labelled {
    /// The component of each late triangle.
    of_late: Vec<u32>,
    records: Vec<ComponentRecord>,
    closed_holes: u64,
}

fn labelled(
    tile: TileId,
    state: &TileState,
    group: &GroupBorders,
    mesh: &BorderMesh,
    regions: TileRegions<'_>,
) -> Labelled {
    let components = match regions {
        TileRegions::One => TileComponents::one(mesh),
        _ => TileComponents::of(mesh, state),
    };
    let (records, closed_holes) = match regions {
        TileRegions::One => {
            let core = CoreRecords {
                regions: &[],
                triangles: &[state.core_sum],
            };
            (component_records(tile, &components, mesh, group, None, core), 0)
        }
        TileRegions::Unknown => (vec![ComponentRecord::default(); components.count()], 0),
        TileRegions::Known { all, seeded } => {
            let anchors: Vec<Anchor> = group.anchors_of(tile).collect();
            let of_core = all.of_core(tile, state, &anchors, seeded);
            let closed = of_core[state.open_components as usize..].iter();
            let closed_holes = closed.filter(|region| region.is_hole).count() as u64;
            let core = CoreRecords {
                regions: &of_core,
                triangles: &anchors.iter().map(|anchor| anchor.triangles).collect::<Vec<_>>(),
            };
            let mut records = component_records(tile, &components, mesh, group, Some(all), core);
            for &component in seeded {
                records[component as usize].is_seeded = true;
            }
            (records, closed_holes)
        }
    };
    Labelled {
        of_late: components.of_late,
        records,
        closed_holes,
    }
}

/// Returns the digest of constraint edges, which are given once for each of their sources. Sorts
/// them by their ends.
fn edge_digest(edges: &mut [LoggedEdge]) -> Digest {
    let mut digest = Digest::default();
    edges.sort_unstable_by_key(|edge| edge.ends);
    for of_edge in edges.chunk_by(|a, b| a.ends == b.ends) {
        digest.add_constraint_edge(of_edge[0].points);
        for edge in of_edge {
            digest.add_edge_source(edge.points, edge.source.source());
        }
    }
    digest
}

/// Returns, for each constraint edge, its smallest half-edge with each of its sources, seen along
/// that half-edge.
fn edge_sources(mesh: &BorderMesh, edges: impl Iterator<Item = ([u32; 2], LinePart)>) -> Vec<(u32, LinePart)> {
    let on_half_edge = |([from, to], source): ([u32; 2], LinePart)| {
        let ends = [from.min(to), from.max(to)];
        let index = mesh.half_edges.partition_point(|keyed| keyed.ends < ends);
        let keyed = mesh.half_edges.get(index).filter(|keyed| keyed.ends == ends)?;
        let is_along = mesh.from(keyed) == from;
        Some((keyed.half_edge.0, if is_along { source } else { source.reversed() }))
    };
    let found = edges.map(on_half_edge);
    // A done edge has triangles, and all triangles around its first end are in the tile.
    let mut sources: Vec<(u32, LinePart)> = found
        .inspect(|found| debug_assert!(found.is_some()))
        .flatten()
        .collect();
    sources.sort_unstable();
    sources
}

/// Returns the edges of a tile without triangles, and for each edge its index with each of its
/// sources.
fn edges(mut along: Vec<([u32; 2], LinePart)>) -> (Vec<[u32; 2]>, Vec<(u32, LinePart)>) {
    along.sort_unstable();
    let (mut edges, mut sources) = (Vec::new(), Vec::new());
    for ((ends, of_edge), index) in along.chunk_by(|a, b| a.0 == b.0).map(|all| (all[0].0, all)).zip(0..) {
        edges.push(ends);
        sources.extend(of_edge.iter().map(|&(_, source)| (index, source)));
    }
    (edges, sources)
}

/// Returns the twins of the late triangles' half-edges, and the pairs of twins of a core and a
/// border half-edge.
fn link(mesh: &BorderMesh) -> (Vec<[Twin; 3]>, Vec<(u32, u32)>) {
    let mut neighbours = vec![[Twin::Hull; 3]; mesh.late.len()];
    let mut core_links = Vec::new();
    let mut set = |half_edge: HalfEdge, twin: Twin| {
        if let Some(late) = half_edge.triangle().0.checked_sub(mesh.core_triangles) {
            neighbours[late as usize][half_edge.corner() as usize] = twin;
        }
    };
    for pair in mesh.edges() {
        match pair {
            [one, other] => {
                set(one.half_edge, Twin::HalfEdge(other.half_edge));
                set(other.half_edge, Twin::HalfEdge(one.half_edge));
                if one.half_edge.triangle().0 < mesh.core_triangles {
                    core_links.push((one.half_edge.0, other.half_edge.0));
                }
            }
            // Both ends belong to other tiles, and so does the twin's triangle, if there is one.
            [one] if !mesh.is_hull(one) => set(one.half_edge, Twin::Elsewhere),
            // One end belongs to this tile, so a twin would be here: the half-edge is on the hull.
            _ => debug_assert_eq!(pair.len(), 1),
        }
    }
    core_links.sort_unstable();
    (neighbours, core_links)
}

/// Returns an outgoing half-edge for each vertex of the tile that is a corner of the border but not
/// of the core.
fn vertex_sides(mesh: &BorderMesh) -> Vec<(u32, u32)> {
    // If a vertex's star is partly in the core, a boundary half-edge ends the core's part of it.
    let mut in_core: Vec<u32> = mesh.boundary_edges.iter().flat_map(|o| [o.from, o.to]).collect();
    in_core.sort_unstable();
    let corners = mesh
        .late
        .iter()
        .flat_map(|late| late.corners)
        .zip(3 * mesh.core_triangles..);
    let mut sides: Vec<(u32, u32)> = corners
        .filter(|(corner, _)| *corner < mesh.vertices && in_core.binary_search(corner).is_err())
        .collect();
    sides.sort_unstable();
    sides.dedup_by_key(|s| s.0);
    sides
}
