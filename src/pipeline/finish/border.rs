//! Puts a tile's border together from its late triangles and the open sides of its core.

use crate::geometry::{HalfEdge, Rect};
use crate::mesh::Twin;
use crate::pipeline::finish::border_mesh::{BorderMesh, Late};
use crate::pipeline::finish::regions::Regions;
use crate::pipeline::output::border_log::GroupBorders;
use crate::pipeline::records::{Anchor, TileState};
pub(crate) use crate::store::format::components::components;
use crate::store::{BorderDraft, EdgeSource, TileId};

/// A border, and what it adds to the tile's entry.
#[derive(Debug)]
pub(crate) struct Border {
    pub(crate) draft: BorderDraft,
    /// Its triangles that belong to the tile.
    pub(crate) owned: u32,
    /// Around the corners of these.
    pub(crate) bounds: Rect,
    /// Constraint edges that belong to the tile, but for those between two triangles of the core.
    pub(crate) constraint_edges: u64,
    /// Triangles of the tile in holes.
    pub(crate) hole_triangles: u64,
    /// Holes that are closed components of the core.
    pub(crate) closed_holes: u64,
}

/// The regions of a tile.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TileRegions<'a> {
    pub(crate) all: &'a Regions,
    /// The components of the core that seeds lie in, in order.
    pub(crate) seeded: &'a [u32],
}

/// Makes the border of a tile.
pub(crate) fn assemble(
    tile: TileId,
    state: &TileState,
    group: &GroupBorders,
    mesh: &BorderMesh,
    regions: Option<TileRegions<'_>>,
) -> Border {
    let (neighbours, core_links) = link(mesh);
    let along = group.edges_of(tile);
    let along = along.map(|(ends, source)| (ends.map(|id| mesh.corner(id)), source));
    let (edges, edge_sources) = match mesh.sides.is_empty() {
        true => edges(along.collect()),
        false => (Vec::new(), edge_sources(mesh, along)),
    };
    let mut draft = BorderDraft {
        vertices: state.vertices,
        core_triangles: state.core_triangles,
        vertex_sides: vertex_sides(mesh),
        foreign: mesh.foreign.iter().map(|v| (v.id, v.point)).collect(),
        triangles: mesh.late.iter().map(|late| late.corners).collect(),
        neighbours,
        core_links,
        constraints: mesh.late.iter().map(Late::side_bits).collect(),
        // Below, if there are regions.
        components: Vec::new(),
        regions: Vec::new(),
        edge_sources,
        edges,
    };
    let (mut hole_triangles, mut closed_holes) = (0, 0);
    if let Some(TileRegions { all, seeded }) = regions {
        let anchors: Vec<Anchor> = group.anchors_of(tile).collect();
        let of_core = all.of_core(tile, state, &anchors, seeded);
        let closed = of_core[state.open_components as usize..].iter();
        closed_holes = closed.filter(|region| region.is_hole).count() as u64;
        let in_holes = of_core.iter().zip(&anchors).filter(|(region, _)| region.is_hole);
        hole_triangles = in_holes.map(|(_, anchor)| u64::from(anchor.triangles)).sum();
        let of_late = mesh.late.iter().map(|late| all.of_late(late.number));
        let with_regions = of_late.clone().zip(&mesh.late);
        hole_triangles += with_regions
            .filter(|(region, late)| region.is_hole && late.is_own)
            .count() as u64;
        (draft.regions, draft.components) = components(of_core, of_late);
    }
    Border {
        constraint_edges: draft.edge_sources.chunk_by(|a, b| a.0 == b.0).count() as u64,
        draft,
        owned: mesh.late.iter().filter(|late| late.is_own).count() as u32,
        bounds: mesh.bounds,
        hole_triangles,
        closed_holes,
    }
}

/// The smallest side on each constraint edge, with each of its sources as seen along it.
fn edge_sources(mesh: &BorderMesh, edges: impl Iterator<Item = ([u32; 2], EdgeSource)>) -> Vec<(u32, EdgeSource)> {
    let on_side = |([from, to], source): ([u32; 2], EdgeSource)| {
        let ends = [from.min(to), from.max(to)];
        let place = mesh.sides.partition_point(|side| side.edge < ends);
        let side = mesh.sides.get(place).filter(|side| side.edge == ends)?;
        let is_along = mesh.from(side) == from;
        Some((side.side.0, if is_along { source } else { source.reversed() }))
    };
    let found = edges.map(on_side);
    // An edge that is done has triangles, and those around its first end are all in the tile.
    let mut sources: Vec<(u32, EdgeSource)> = found
        .inspect(|found| debug_assert!(found.is_some()))
        .flatten()
        .collect();
    sources.sort_unstable();
    sources
}

/// The edges of a tile without triangles, and the place of each with each of its sources.
fn edges(mut along: Vec<([u32; 2], EdgeSource)>) -> (Vec<[u32; 2]>, Vec<(u32, EdgeSource)>) {
    along.sort_unstable();
    let (mut edges, mut sources) = (Vec::new(), Vec::new());
    for ((ends, of_edge), place) in along.chunk_by(|a, b| a.0 == b.0).map(|all| (all[0].0, all)).zip(0..) {
        edges.push(ends);
        sources.extend(of_edge.iter().map(|&(_, source)| (place, source)));
    }
    (edges, sources)
}

/// The sides across those of the late triangles, and the pairs of core and border sides.
fn link(mesh: &BorderMesh) -> (Vec<[Twin; 3]>, Vec<(u32, u32)>) {
    let mut neighbours = vec![[Twin::Hull; 3]; mesh.late.len()];
    let mut core_links = Vec::new();
    let mut set = |side: HalfEdge, twin: Twin| {
        if let Some(late) = side.triangle().0.checked_sub(mesh.core_triangles) {
            neighbours[late as usize][side.corner() as usize] = twin;
        }
    };
    for pair in mesh.edges() {
        match pair {
            [one, other] => {
                set(one.side, Twin::HalfEdge(other.side));
                set(other.side, Twin::HalfEdge(one.side));
                if one.side.triangle().0 < mesh.core_triangles {
                    core_links.push((one.side.0, other.side.0));
                }
            }
            // Both ends belong to other tiles, and so does the triangle across, if there is one.
            [one] if one.edge[0] >= mesh.vertices => set(one.side, Twin::Elsewhere),
            // An end is ours, so a triangle across would be here: the side is on the hull.
            _ => debug_assert_eq!(pair.len(), 1),
        }
    }
    core_links.sort_unstable();
    (neighbours, core_links)
}

/// A leaving side for each vertex of the tile that is a corner of the border but not of the core.
fn vertex_sides(mesh: &BorderMesh) -> Vec<(u32, u32)> {
    // Where the star of a vertex lies partly in the core, an open side ends its core part.
    let mut in_core: Vec<u32> = mesh.open_sides.iter().flat_map(|o| [o.from, o.to]).collect();
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
