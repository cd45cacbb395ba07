//! Turns a tile that was changed into the drafts of a core and a border.
//!
//! Triangles whose corners are all the tile's own are of the core, the others of the border. What was late when the tile was first
//! written may so be of the core now.

use crate::edit::tile::{BEYOND, EditTile, ON_HULL};
use crate::geometry::{HalfEdge, PackedHalfEdge, Point, Rect};
use crate::mesh::{NONE, Twin, next_side};
use crate::store::format::components::{components, of_core};
use crate::store::{Across, BorderDraft, Component, CoreDraft, TileEntry, VertexId};

/// What a tile is when it is written.
pub(crate) struct Drafts {
    pub(crate) core: CoreDraft,
    pub(crate) border: BorderDraft,
    /// Triangles that belong to the tile, and those of them that are in holes.
    owned: u32,
    in_holes: u32,
    bounds: Rect,
}

impl EditTile {
    /// The core and the border. `label` tells what is true of the region of the triangle at a place; without it the tile says nothing of
    /// regions.
    pub(crate) fn drafts(&self, label: Option<&dyn Fn(u32) -> Component>) -> Drafts {
        let (order, core_count) = self.in_order();
        let mut places = vec![NONE; self.triangles.len()];
        for (&place, number) in order.iter().zip(0..) {
            places[place as usize] = number;
        }
        let core_sides = 3 * core_count as u32;
        let side_now = |side: u32| 3 * places[(side / 3) as usize] + side % 3;
        let (of_core, of_border) = order.split_at(core_count);
        let (foreign, corner_now) = self.foreign_in_order(of_border);
        let corners = |&place: &u32| self.triangles[place as usize].map(|corner| corner_now[corner as usize]);
        let across = |&place: &u32| self.across[place as usize];
        let bits = |places: &[u32]| {
            let bits: Vec<u8> = places.iter().map(|&place| self.bits[place as usize]).collect();
            if bits.iter().all(|&bits| bits == 0) {
                Vec::new()
            } else {
                bits
            }
        };
        let in_core = |value: u32| match value {
            ON_HULL | BEYOND => PackedHalfEdge::NONE,
            side if side_now(side) < core_sides => HalfEdge(side_now(side)).into(),
            _ => PackedHalfEdge::NONE,
        };
        let in_border = |value: u32| match value {
            ON_HULL => Twin::Hull,
            BEYOND => Twin::Elsewhere,
            side => Twin::HalfEdge(HalfEdge(side_now(side))),
        };
        let linked = of_core
            .iter()
            .flat_map(|place| across(place).map(move |value| (value, *place)).into_iter().enumerate());
        let core_links = linked.filter_map(|(s, (value, place))| {
            let other = (value < BEYOND)
                .then(|| side_now(value))
                .filter(|&other| other >= core_sides)?;
            Some((side_now(3 * place + s as u32), other))
        });
        let mut core_links: Vec<(u32, u32)> = core_links.collect();
        core_links.sort_unstable();
        let core = CoreDraft {
            points: self.points.clone(),
            z: self.z.clone(),
            records: self.records.clone(),
            triangles: of_core.iter().map(corners).collect(),
            neighbours: of_core.iter().map(|place| across(place).map(in_core)).collect(),
            constraints: bits(of_core),
            sites: self.sites.clone(),
            site_ids: self.site_ids.clone(),
            // Below, once the rest is known.
            components: Vec::new(),
            edge_sources: Vec::new(),
        };
        let border = BorderDraft {
            vertices: self.points.len() as u32,
            core_triangles: core_count as u32,
            foreign,
            triangles: of_border.iter().map(corners).collect(),
            neighbours: of_border.iter().map(|place| across(place).map(in_border)).collect(),
            core_links,
            constraints: bits(of_border),
            // Below, once the rest is known.
            vertex_sides: Vec::new(),
            components: Vec::new(),
            regions: Vec::new(),
            edge_sources: Vec::new(),
            // Files without triangles are not edited.
            edges: Vec::new(),
        };
        let owned = order.iter().filter(|&&place| self.owns(place));
        let is_in_hole = |place: u32| label.is_some_and(|label| label(place).is_hole);
        let (owned, in_holes) = owned.fold((0, 0), |(owned, in_holes), &place| {
            (owned + 1, in_holes + u32::from(is_in_hole(place)))
        });
        let mut drafts = Drafts {
            owned,
            in_holes,
            bounds: self.bounds(&order),
            core,
            border,
        };
        drafts.border.vertex_sides = vertex_sides(&drafts.core, &drafts.border);
        self.put_sources(&mut drafts, side_now);
        if let Some(label) = label {
            put_regions(&mut drafts, |triangle| label(order[triangle as usize]));
        }
        drafts
    }

    /// The vertices of other tiles that border triangles have, by id; and what each corner is among own and these.
    fn foreign_in_order(&self, of_border: &[u32]) -> (Vec<(VertexId, Point)>, Vec<u32>) {
        let own = self.points.len();
        let mut is_used = vec![false; self.foreign.len()];
        for &corner in of_border.iter().flat_map(|&place| &self.triangles[place as usize]) {
            if let Some(place) = (corner as usize).checked_sub(own) {
                is_used[place] = true;
            }
        }
        let mut used: Vec<usize> = (0..self.foreign.len()).filter(|&place| is_used[place]).collect();
        used.sort_unstable_by_key(|&place| self.foreign[place].id);
        let mut corner_now: Vec<u32> = (0..(own + self.foreign.len()) as u32).collect();
        for (&place, number) in used.iter().zip(own as u32..) {
            corner_now[own + place] = number;
        }
        let foreign = used
            .iter()
            .map(|&place| (self.foreign[place].id, self.foreign[place].point));
        (foreign.collect(), corner_now)
    }

    /// The box around the tile's vertices and the corners of what belongs to it.
    fn bounds(&self, places: &[u32]) -> Rect {
        let owned = places.iter().filter(|&&place| self.owns(place));
        let corners = owned.flat_map(|&place| self.triangles[place as usize].map(|corner| self.vertex(corner).point));
        Rect::around(self.points.iter().copied().chain(corners))
    }

    fn put_sources(&self, drafts: &mut Drafts, side_now: impl Fn(u32) -> u32) {
        let core_sides = 3 * drafts.border.core_triangles;
        for (side, sources) in self.owned_constraints() {
            let ends = [side, next_side(side)].map(|side| self.origin(side));
            let other = match self.across(side) {
                Across::Side(other) => other,
                Across::Hull | Across::Elsewhere => side,
            };
            let [this, other] = [side_now(side), side_now(other)];
            // They are kept as seen from the smaller corner, and written as seen along the smaller side.
            let is_against = (ends[0] > ends[1]) != (other < this);
            let in_core = this.max(other) < core_sides && this != other;
            let list = if in_core {
                &mut drafts.core.edge_sources
            } else {
                &mut drafts.border.edge_sources
            };
            list.extend(sources.iter().map(|source| {
                let source = if is_against { source.reversed() } else { *source };
                (this.min(other), source)
            }));
        }
        drafts.core.edge_sources.sort_unstable();
        drafts.border.edge_sources.sort_unstable();
    }
}

/// What the directory is to know of a tile.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Counts {
    vertices: u32,
    core_triangles: u32,
    border_triangles: u32,
    owned: u32,
    pub(crate) in_holes: u32,
    bounds: Rect,
}

impl Drafts {
    pub(crate) fn counts(&self) -> Counts {
        Counts {
            vertices: self.core.points.len() as u32,
            core_triangles: self.core.triangles.len() as u32,
            border_triangles: self.border.triangles.len() as u32,
            owned: self.owned,
            in_holes: self.in_holes,
            bounds: self.bounds,
        }
    }
}

impl Counts {
    /// The entry of the tile, but for where it lies.
    pub(crate) fn entry(self, before: &TileEntry, generation: u32) -> TileEntry {
        TileEntry {
            core: before.core,
            border: before.border,
            generation,
            vertices: self.vertices,
            core_triangles: self.core_triangles,
            border_triangles: self.border_triangles,
            owned_triangles: self.owned,
            bounds: self.bounds,
        }
    }
}

/// A leaving side for each vertex of the tile that is a corner of the border but not of the core.
fn vertex_sides(core: &CoreDraft, border: &BorderDraft) -> Vec<(u32, u32)> {
    let mut has_one = vec![false; border.vertices as usize];
    for &corner in core.triangles.as_flattened() {
        has_one[corner as usize] = true;
    }
    let mut sides = Vec::new();
    for (&corner, side) in border.triangles.as_flattened().iter().zip(3 * border.core_triangles..) {
        if let Some(has_one) = has_one.get_mut(corner as usize)
            && !*has_one
        {
            *has_one = true;
            sides.push((corner, side));
        }
    }
    sides.sort_unstable();
    sides
}

/// Puts down which region each triangle is of: components of the core are connected within it, those of border triangles go
/// by their region.
fn put_regions(drafts: &mut Drafts, label: impl Fn(u32) -> Component) {
    let core_count = drafts.core.triangles.len() as u32;
    let mut of_core = of_core(&drafts.core);
    let mut regions: Vec<Component> = Vec::new();
    for (triangle, &component) in (0u32..).zip(&of_core) {
        if component as usize == regions.len() {
            regions.push(label(triangle));
        }
    }
    let of_border = (core_count..core_count + drafts.border.triangles.len() as u32).map(label);
    (drafts.border.regions, drafts.border.components) = components(regions, of_border);
    if of_core.iter().all(|&component| component == 0) {
        of_core.clear();
    }
    drafts.core.components = of_core;
}
