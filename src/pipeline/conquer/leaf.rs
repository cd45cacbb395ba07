//! Conquers a leaf: its points become the core of a tile and a seam.

use crate::collections::bucket_sort::bucket_sort;
use crate::constraints::seeds::Seeds;
use crate::constraints::segment::Segment;
use crate::geometry::{HalfEdge, MortonSquare, PackedHalfEdge, Point, Rect, TriangleId, VertexIndex};
use crate::input::SiteId;
use crate::mesh::NONE;
use crate::mesh::point_table::PointTable;
use crate::pipeline::conquer::components::Components;
use crate::pipeline::conquer::constrain::constrain_leaf;
use crate::pipeline::conquer::constrain::refusal::Refusal;
use crate::pipeline::conquer::node::{Fate, Workspace};
use crate::pipeline::ingest::point_store::{Attributes, Item};
use crate::pipeline::options::DuplicateRule;
use crate::pipeline::records::{DoneEdge, OpenSide, Pending, Piece, Seam, SeamVertex};
use crate::store::{CoreDraft, EdgeSource, TileId, VertexId};

/// What comes to a leaf.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LeafInput<'a> {
    pub(crate) tile: TileId,
    pub(crate) cell: Rect,
    pub(crate) items: &'a [Item],
    pub(crate) attributes: &'a Attributes,
    /// Segments, and which of them may meet the cell.
    pub(crate) segments: &'a [Segment],
    pub(crate) its: &'a [u32],
}

/// What holds for all leaves of a build.
#[derive(Clone, Debug)]
pub(crate) struct LeafRules {
    pub(crate) duplicates: DuplicateRule,
    /// Whether there are regions to be told apart.
    pub(crate) has_regions: bool,
    /// Whether regions may be holes.
    pub(crate) has_holes: bool,
    /// Points whose regions are holes.
    pub(crate) seeds: Seeds,
    /// From this record number on points are those at which segments were split.
    pub(crate) first_crossing: u64,
    /// From this record number on points are sites.
    pub(crate) first_site: u64,
    pub(crate) site_ids: Vec<SiteId>,
}

/// Why a leaf cannot be conquered.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LeafError {
    Refused(Refusal),
    /// A ring of this obstacle does not close.
    OpenRing(EdgeSource),
}

impl From<Refusal> for LeafError {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(refusal)
    }
}

/// What a leaf gives beside its core.
#[derive(Debug)]
pub(crate) struct Leaf {
    pub(crate) open_sides: Vec<OpenSide>,
    /// Constraint edges that are done and not within the core.
    pub(crate) edges: Vec<DoneEdge>,
    /// The components of the core, unless there are no regions to be told apart; their triangles are in the core.
    pub(crate) components: Components,
    /// Those that are holes since a seed lies in them.
    pub(crate) seeded: Vec<u32>,
    pub(crate) bounds: Rect,
    pub(crate) seam: Seam,
    /// Points that lay on another.
    pub(crate) duplicates: u64,
    /// Vertices that are no points, but ends of segments or sites.
    pub(crate) ends: u64,
    /// Vertices that have no z and got 0, where others have z.
    pub(crate) without_z: u64,
    /// Constraint edges between two triangles of the core.
    pub(crate) constraint_edges: u64,
}

/// Of all records of a leaf that lie on an earlier one, the first, and where: its earliest fellow, it, the place.
pub(crate) fn first_duplicate(items: &[Item], attributes: &Attributes, first_end: u64) -> Option<([u64; 2], Point)> {
    let places = items.iter().map(|i| (i.point, attributes.record(i.position)));
    let mut places: Vec<(Point, u64)> = places.filter(|(_, record)| *record < first_end).collect();
    places.sort_unstable_by(|a, b| a.0.lex_cmp(b.0).then(a.1.cmp(&b.1)));
    let groups = places.chunk_by(|a, b| a.0 == b.0);
    let second = groups.filter_map(|group| Some(([group[0].1, group.get(1)?.1], group[0].0)));
    second.min_by_key(|(records, _)| (records[1], records[0]))
}

/// Triangulates the points of a leaf. Its core is left in the workspace.
pub(crate) fn conquer(workspace: &mut Workspace, input: LeafInput<'_>, rules: &LeafRules) -> Result<Leaf, LeafError> {
    let LeafInput {
        tile,
        items,
        attributes,
        ..
    } = input;
    let kept = kept_items(items, attributes, rules.duplicates);
    let mut core = std::mem::replace(&mut workspace.core, CoreDraft::empty());
    let without_z = put_vertices(&mut core, &kept, attributes);
    put_sites(&mut core, items, attributes, rules);
    let seam = triangulate(workspace, &core.points, input)?;
    let mut open_sides = core_triangles(workspace, &mut core);
    let elsewhere = take_edges(&mut core, &workspace.edges);
    let vertex = |index: u32| seam_vertex(tile, &core.points, index);
    let edges = elsewhere.into_iter().map(|piece| DoneEdge {
        ends: piece.ends.map(vertex),
        source: piece.source,
    });
    let first_end = rules.duplicates.first_end;
    let mut leaf = Leaf {
        bounds: Rect::around(core.points.iter().copied()),
        edges: edges.collect(),
        components: Components::default(),
        seeded: Vec::new(),
        seam,
        duplicates: (items.len() - kept.len()) as u64,
        ends: core.records.iter().filter(|&&record| record >= first_end).count() as u64,
        without_z,
        constraint_edges: core.edge_sources.chunk_by(|a, b| a.0 == b.0).count() as u64,
        open_sides: Vec::new(),
    };
    if rules.has_regions {
        // Where lines are put off, rings do not close yet; regions are found when all is there.
        let has_rings = rules.has_holes && workspace.deferral.is_empty();
        leaf.components = components(&core, &mut open_sides, has_rings).map_err(LeafError::OpenRing)?;
        leaf.seeded = seeded(&core, input.cell, &leaf.components, &rules.seeds);
        if leaf.components.count > 1 {
            core.components.append(&mut leaf.components.of_triangles);
        }
    }
    leaf.open_sides = open_sides;
    workspace.core = core;
    Ok(leaf)
}

/// The items that become vertices: one for each place, along a space-filling curve.
fn kept_items(items: &[Item], attributes: &Attributes, rule: DuplicateRule) -> Vec<Item> {
    match items {
        // More points at one place than a tile may have vertices: there need not be memory to sort them.
        [first, rest @ ..] if rest.iter().all(|item| { item.point } == { first.point }) => {
            let better = |best, item| {
                if precedes(item, best, attributes, rule) {
                    item
                } else {
                    best
                }
            };
            vec![*rest.iter().fold(first, better)]
        }
        _ => merge_duplicates(in_spatial_order(items), attributes, rule),
    }
}

/// Puts the vertices into an empty core. Returns how many of them have no z, and got 0.
fn put_vertices(core: &mut CoreDraft, kept: &[Item], attributes: &Attributes) -> u64 {
    core.clear();
    core.points.extend(kept.iter().map(|item| item.point));
    core.records
        .extend(kept.iter().map(|item| attributes.record(item.position)));
    if attributes.has_z() {
        core.z.extend(kept.iter().map(|item| attributes.z(item.position)));
    }
    let mut without_z = 0;
    for z in core.z.iter_mut().filter(|z| z.is_nan()) {
        *z = 0.0;
        without_z += 1;
    }
    without_z
}

/// Triangulates the points and inserts the segments. The mesh is left in the workspace.
fn triangulate(workspace: &mut Workspace, points: &[Point], input: LeafInput<'_>) -> Result<Seam, LeafError> {
    let LeafInput { tile, cell, .. } = input;
    let (vertices, unsettled) = workspace.run(points, cell, |_| true);
    workspace.side_bits.clear();
    workspace.edges.clear();
    let pending = if input.its.is_empty() {
        Pending::default()
    } else {
        constrain_leaf(workspace, points, input.segments, input.its, tile, cell == Rect::PLANE)?
    };
    Ok(Seam {
        level: 1,
        below: points.len() as u64,
        unsettled,
        pending,
        vertices: vertices
            .into_iter()
            .map(|index| seam_vertex(tile, points, index))
            .collect(),
    })
}

/// A vertex of a leaf for those who do not know its core.
fn seam_vertex(tile: TileId, points: &[Point], index: u32) -> SeamVertex {
    SeamVertex {
        id: VertexId {
            tile,
            index: VertexIndex(index),
        },
        point: points[index as usize],
    }
}

/// The components of a core, noted at its open sides too, and anchored if its rings are complete. The error is an obstacle
/// whose ring does not close.
fn components(core: &CoreDraft, open_sides: &mut [OpenSide], has_rings: bool) -> Result<Components, EdgeSource> {
    let mut components = Components::of(core, open_sides);
    if has_rings {
        components.anchor(core, &core.edge_sources)?;
    }
    for side in open_sides {
        side.component = components.of_triangles[side.side.triangle().index()];
    }
    Ok(components)
}

/// Puts all sites among the items into a core that has their vertices.
fn put_sites(core: &mut CoreDraft, items: &[Item], attributes: &Attributes, rules: &LeafRules) {
    if rules.first_site == u64::MAX {
        return;
    }
    let site_of = |item: &Item| {
        Some((
            item.point,
            attributes.record(item.position).checked_sub(rules.first_site)?,
        ))
    };
    let sites: Vec<(Point, u64)> = items.iter().filter_map(site_of).collect();
    if sites.is_empty() {
        return;
    }
    let index = PointTable::new(&core.points);
    let placed = sites.into_iter().filter_map(|(place, site)| {
        let (number, text) = match &rules.site_ids[site as usize] {
            SiteId::Number(number) => (*number, ""),
            SiteId::Text(text) => (site, text.as_str()),
        };
        Some((index.at(place)?, number, text))
    });
    let mut placed: Vec<(u32, u64, &str)> = placed.collect();
    placed.sort_unstable();
    core.sites
        .extend(placed.iter().map(|&(vertex, number, _)| (vertex, number)));
    if placed.iter().any(|(.., text)| !text.is_empty()) {
        core.site_ids.extend(placed.iter().map(|&(.., text)| text.to_owned()));
    }
}

/// The components of a core that seeds lie in.
fn seeded(core: &CoreDraft, cell: Rect, components: &Components, seeds: &Seeds) -> Vec<u32> {
    let mut seeded = Vec::new();
    // A core lies within its cell.
    if seeds.within(cell).next().is_some() {
        for (corners, &component) in core.triangles.iter().zip(&components.of_triangles) {
            if seeds.any_in(corners.map(|v| core.points[v as usize])) {
                seeded.push(component);
            }
        }
        seeded.sort_unstable();
        seeded.dedup();
    }
    seeded
}

/// Notes the sources of the edges within the core. Returns the pieces that became others.
fn take_edges(core: &mut CoreDraft, pieces: &[Piece]) -> Vec<Piece> {
    if pieces.is_empty() {
        return Vec::new();
    }
    let mut within: Vec<([u32; 2], HalfEdge)> = Vec::new();
    let sides = core.neighbours.iter().zip(&core.constraints).zip(&core.triangles);
    for (((neighbours, bits), corners), triangle) in sides.zip(0u32..) {
        for (s, &twin) in neighbours.iter().enumerate().filter(|(s, _)| bits >> s & 1 == 1) {
            let side = HalfEdge::new(TriangleId(triangle), s as u32);
            if twin.get().is_some_and(|twin| side < twin) {
                let (from, to) = (corners[s], corners[(s + 1) % 3]);
                within.push(([from.min(to), from.max(to)], side));
            }
        }
    }
    let within = bucket_sort(
        &within,
        core.points.len(),
        |(ends, _)| ends[0],
        |&(ends, side)| (ends[1], side),
    );
    let mut elsewhere = Vec::new();
    let mut edges = within.iter().peekable();
    for piece in pieces {
        while edges.next_if(|(ends, _)| *ends < piece.ends).is_some() {}
        match edges.peek() {
            Some(&&(ends, side)) if ends == piece.ends => {
                let from = core.triangles.as_flattened()[side.index()];
                let source = if from == ends[0] {
                    piece.source
                } else {
                    piece.source.reversed()
                };
                core.edge_sources.push((side.0, source));
            }
            _ => elsewhere.push(*piece),
        }
    }
    let triangle = |&(side, _): &(u32, EdgeSource)| HalfEdge(side).triangle().0;
    core.edge_sources = bucket_sort(&core.edge_sources, core.triangles.len(), triangle, |&both| both);
    elsewhere
}

/// Copies the settled triangles and their adjacency, and notes the sides where it ends.
fn core_triangles(workspace: &Workspace, core: &mut CoreDraft) -> Vec<OpenSide> {
    let (mesh, fates) = (&workspace.mesh, &workspace.fates);
    let mut settled = 0;
    let renumbered: Vec<u32> = fates
        .iter()
        .map(|&fate| {
            let mine = settled;
            settled += u32::from(fate == Fate::Settled);
            if fate == Fate::Settled { mine } else { NONE }
        })
        .collect();
    let mut open_sides = Vec::new();
    for (triangle, fate) in (0u32..).zip(fates) {
        if *fate != Fate::Settled {
            continue;
        }
        let corners = mesh.triangles[triangle as usize];
        let bits = workspace.side_bits.get(triangle as usize).copied().unwrap_or(0);
        let mut neighbours = [PackedHalfEdge::NONE; 3];
        for (s, twin) in mesh.neighbours[triangle as usize].iter().enumerate() {
            let other = twin.get().map_or(NONE, |twin| renumbered[twin.triangle().index()]);
            match twin.get().filter(|_| other != NONE) {
                Some(twin) => neighbours[s] = HalfEdge::new(TriangleId(other), twin.corner()).into(),
                None => open_sides.push(OpenSide {
                    from: corners[s],
                    to: corners[(s + 1) % 3],
                    side: HalfEdge::new(TriangleId(core.triangles.len() as u32), s as u32),
                    is_constraint: bits >> s & 1 == 1,
                    component: 0,
                }),
            }
        }
        if !workspace.side_bits.is_empty() {
            core.constraints.push(bits);
        }
        core.triangles.push(corners);
        core.neighbours.push(neighbours);
    }
    open_sides
}

/// The items along a space-filling curve, so that what lies close together stands close together in the tile; items at one
/// place stand side by side.
fn in_spatial_order(items: &[Item]) -> Vec<Item> {
    let square = MortonSquare::around(Rect::around(items.iter().map(|item| item.point)));
    let mask = (items.len() as u64).next_power_of_two() - 1;
    let mut keyed: Vec<u64> = items
        .iter()
        .zip(0u64..)
        .map(|(item, place)| square.key(item.point) & !mask | place)
        .collect();
    keyed.sort_unstable();
    let mut ordered: Vec<Item> = keyed.iter().map(|key| items[(key & mask) as usize]).collect();
    // A cell of the curve may hold several places.
    let mut start = 0;
    for cell in keyed.chunk_by(|a, b| (a ^ b) <= mask) {
        let end = start + cell.len();
        if cell.len() > 1 {
            ordered[start..end].sort_unstable_by(|a, b| { a.point }.lex_cmp(b.point));
        }
        start = end;
    }
    ordered
}

/// One item for each place; items at one place must stand side by side.
fn merge_duplicates(mut items: Vec<Item>, attributes: &Attributes, rule: DuplicateRule) -> Vec<Item> {
    items.dedup_by(|next, kept| {
        let equal = { next.point } == { kept.point };
        if equal && precedes(next, kept, attributes, rule) {
            *kept = *next;
        }
        equal
    });
    items
}

/// Whether `a` is kept rather than `b`.
fn precedes(a: &Item, b: &Item, attributes: &Attributes, rule: DuplicateRule) -> bool {
    let of = |item: &Item| (attributes.z(item.position), attributes.record(item.position));
    rule.prefers(of(a), of(b))
}
