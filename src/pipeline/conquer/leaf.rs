//! Conquers a leaf: makes the core of a tile and a seam from its points.

use crate::constraints::seeds::Seeds;
use crate::constraints::segment::Segment;
use crate::geometry::{HalfEdge, MortonSquare, PackedHalfEdge, Point, Rect, TriangleId, VertexIndex};
use crate::input::SiteId;
use crate::mesh::NONE;
use crate::mesh::point_table::PointTable;
use crate::pipeline::conquer::components::Components;
use crate::pipeline::conquer::constrain::constrain_leaf;
use crate::pipeline::conquer::constrain::refusal::Refusal;
use crate::pipeline::conquer::core_digest;
use crate::pipeline::conquer::node::{Fate, Workspace};
use crate::pipeline::context::Given;
use crate::pipeline::ingest::point_store::Attributes;
use crate::pipeline::options::{BuildOptions, DuplicateRule};
use crate::pipeline::records::{BoundaryEdge, DoneEdge, Pending, Seam, SeamVertex, Subsegment};
use crate::store::divide::Item;
use crate::store::{CoreDraft, Digest, EdgeSource, TileId, VertexId};

/// The input of a leaf.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LeafInput<'a> {
    pub(crate) tile: TileId,
    pub(crate) cell: Rect,
    pub(crate) items: &'a [Item],
    pub(crate) attributes: &'a Attributes,
    /// The block's segments, and the indices of those that may meet the cell.
    pub(crate) segments: &'a [Segment],
    pub(crate) segment_indices: &'a [u32],
}

/// The settings that all leaves of a build share.
#[derive(Clone, Debug)]
pub(crate) struct LeafRules {
    pub(crate) duplicates: DuplicateRule,
    /// Whether regions are distinguished.
    pub(crate) has_regions: bool,
    /// Whether regions may be holes.
    pub(crate) has_holes: bool,
    /// Points whose regions are holes.
    pub(crate) seeds: Seeds,
    /// First record number of the points at which segments were split.
    pub(crate) first_crossing: u64,
    /// First record number of sites.
    pub(crate) first_site: u64,
    pub(crate) site_ids: Vec<SiteId>,
}

impl LeafRules {
    /// Returns the rules for an input with lines or without. Takes the ids of its sites.
    pub(crate) fn of(given: &mut Given, options: &BuildOptions, first_end: u64, has_lines: bool) -> Self {
        let has_hole_rules = !given.seeds.is_empty() || options.exterior_is_hole;
        Self {
            duplicates: DuplicateRule {
                duplicates: options.duplicates,
                first_end,
            },
            has_regions: has_lines || has_hole_rules,
            has_holes: given.has_obstacles || has_hole_rules,
            seeds: Seeds::new(given.seeds.clone()),
            first_site: if given.site_count > 0 {
                given.first_site
            } else {
                u64::MAX
            },
            site_ids: std::mem::take(&mut given.site_ids),
            first_crossing: given.first_crossing,
        }
    }
}

/// Error of conquering a leaf.
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

/// The results of a leaf, apart from its core.
#[derive(Debug)]
pub(crate) struct Leaf {
    pub(crate) boundary_edges: Vec<BoundaryEdge>,
    /// Constraint edges that are done and not within the core.
    pub(crate) edges: Vec<DoneEdge>,
    /// The components of the core, if regions are distinguished. The core holds the components of
    /// its triangles.
    pub(crate) components: Components,
    /// The components that are holes because they contain a seed.
    pub(crate) seeded: Vec<u32>,
    pub(crate) bounds: Rect,
    pub(crate) seam: Seam,
    /// Number of points at the position of another one.
    pub(crate) duplicates: u64,
    /// Number of vertices that are segment ends or sites, not points.
    pub(crate) ends: u64,
    /// Whether sites are at some of its vertices.
    pub(crate) has_sites: bool,
    /// Number of vertices without z that got 0, when others have z.
    pub(crate) without_z: u64,
    /// Number of constraint edges between two triangles of the core.
    pub(crate) constraint_edges: u64,
    /// The digest of the core.
    pub(crate) digest: Digest,
}

/// Returns the first record of a leaf that is at the position of an earlier one: the smallest
/// record number there, its own number, and the position.
pub(crate) fn first_duplicate(items: &[Item], attributes: &Attributes, first_end: u64) -> Option<([u64; 2], Point)> {
    let records = items.iter().map(|i| (i.point, attributes.record(i.position)));
    let mut records: Vec<(Point, u64)> = records.filter(|(_, record)| *record < first_end).collect();
    records.sort_unstable_by(|a, b| a.0.lex_cmp(b.0).then(a.1.cmp(&b.1)));
    let groups = records.chunk_by(|a, b| a.0 == b.0);
    let second = groups.filter_map(|group| Some(([group[0].1, group.get(1)?.1], group[0].0)));
    second.min_by_key(|(records, _)| (records[1], records[0]))
}

/// Triangulates the points of a leaf. Leaves its core in the workspace.
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
    let ends = put_input_points(&mut core, rules.duplicates.first_end);
    put_sites(&mut core, items, attributes, rules);
    let vertex = |index: u32| seam_vertex(tile, &core, index);
    let seam = triangulate(workspace, &core.points, input, vertex)?;
    let mut boundary_edges = core_triangles(workspace, &mut core);
    let elsewhere = take_edges(&mut core, &workspace.edges);
    let vertex = |index: u32| seam_vertex(tile, &core, index);
    let edges = elsewhere.into_iter().map(|subsegment| DoneEdge {
        ends: subsegment.ends.map(vertex),
        source: subsegment.source,
    });
    let mut leaf = Leaf {
        bounds: Rect::around(core.points.iter().copied()),
        edges: edges.collect(),
        components: Components::default(),
        seeded: Vec::new(),
        seam,
        duplicates: (items.len() - kept.len()) as u64,
        ends,
        has_sites: !core.sites.is_empty(),
        without_z,
        constraint_edges: core.edge_sources.chunk_by(|a, b| a.0 == b.0).count() as u64,
        digest: core_digest::without_triangles(&core),
        boundary_edges: Vec::new(),
    };
    if rules.has_regions {
        // With deferred lines, rings do not close yet. The edit that inserts these lines finds the
        // regions.
        let has_rings = rules.has_holes && leaf.seam.pending.deferred.is_empty();
        leaf.components = components(&core, &mut boundary_edges, has_rings).map_err(LeafError::OpenRing)?;
        for anchor in &leaf.components.anchors {
            leaf.digest.triangles += anchor.triangles;
        }
        leaf.seeded = seeded(&core, input.cell, &leaf.components, &rules.seeds);
        if leaf.components.count > 1 {
            core.components.append(&mut leaf.components.of_triangles);
        }
    } else {
        core_digest::add_triangles(&core, &mut leaf.digest);
    }
    leaf.boundary_edges = boundary_edges;
    workspace.core = core;
    Ok(leaf)
}

/// Returns the items that become vertices: one for each position, along a space-filling curve.
fn kept_items(items: &[Item], attributes: &Attributes, rule: DuplicateRule) -> Vec<Item> {
    match items {
        // There may be more points at one position than a tile may have vertices, and no memory to
        // sort them.
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

/// Puts the vertices into an empty core. Returns the number of vertices that have no z and got 0.
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

/// Notes at which vertices points of the input lie. Returns the number of the other vertices.
///
/// A vertex has the record number of a point if one lies there, and points have the numbers below
/// `first_end`.
fn put_input_points(core: &mut CoreDraft, first_end: u64) -> u64 {
    let ends = core.records.iter().filter(|&&record| record >= first_end).count() as u64;
    if ends > 0 {
        core.input_points
            .extend(core.records.iter().map(|&record| record < first_end));
    }
    ends
}

/// Triangulates the points and inserts the segments. Leaves the mesh in the workspace.
fn triangulate(
    workspace: &mut Workspace,
    points: &[Point],
    input: LeafInput<'_>,
    vertex: impl Fn(u32) -> SeamVertex,
) -> Result<Seam, LeafError> {
    let cell = input.cell;
    let (vertices, unsettled) = workspace.run(points, cell, |_| true);
    workspace.edge_bits.clear();
    workspace.edges.clear();
    let pending = if input.segment_indices.is_empty() {
        Pending::default()
    } else {
        constrain_leaf(
            workspace,
            points,
            input.segments,
            input.segment_indices,
            &vertex,
            cell == Rect::PLANE,
        )?
    };
    Ok(Seam {
        level: 1,
        below: points.len() as u64,
        unsettled,
        pending,
        vertices: vertices.into_iter().map(vertex).collect(),
    })
}

/// Returns a leaf's vertex with its tile, position and z.
fn seam_vertex(tile: TileId, core: &CoreDraft, index: u32) -> SeamVertex {
    SeamVertex {
        id: VertexId {
            tile,
            index: VertexIndex(index),
        },
        point: core.points[index as usize],
        z: core.z.get(index as usize).copied().unwrap_or(0.0),
    }
}

/// Finds the components of a core, sets them in its boundary half-edges, and anchors them if its
/// rings are complete.
///
/// # Errors
/// Returns a source of an obstacle whose ring does not close.
fn components(
    core: &CoreDraft,
    boundary_edges: &mut [BoundaryEdge],
    has_rings: bool,
) -> Result<Components, EdgeSource> {
    let mut components = Components::of(core, boundary_edges);
    if has_rings {
        components.anchor(core, &core.edge_sources)?;
    }
    for edge in boundary_edges {
        edge.component = components.of_triangles[edge.half_edge.triangle().index()];
    }
    Ok(components)
}

/// Adds all sites among the items to a core that has their vertices.
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
    let placed = sites.into_iter().filter_map(|(point, site)| {
        let (number, text) = match &rules.site_ids[site as usize] {
            SiteId::Number(number) => (*number, ""),
            SiteId::Text(text) => (site, text.as_str()),
        };
        Some((index.at(point)?, number, text))
    });
    let mut placed: Vec<(u32, u64, &str)> = placed.collect();
    placed.sort_unstable();
    core.sites
        .extend(placed.iter().map(|&(vertex, number, _)| (vertex, number)));
    if placed.iter().any(|(.., text)| !text.is_empty()) {
        core.site_ids.extend(placed.iter().map(|&(.., text)| text.to_owned()));
    }
}

/// Returns the components of a core that contain seeds, sorted.
fn seeded(core: &CoreDraft, cell: Rect, components: &Components, seeds: &Seeds) -> Vec<u32> {
    let mut seeded = Vec::new();
    // A core is within its cell.
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

/// Adds the sources of the edges within the core to it, in the order of their half-edges. Returns
/// the subsegments that are edges outside it. `subsegments` is sorted.
fn take_edges(core: &mut CoreDraft, subsegments: &[Subsegment]) -> Vec<Subsegment> {
    if subsegments.is_empty() {
        return Vec::new();
    }
    let starts = starts_by_end(subsegments, core.points.len());
    let mut is_within = vec![false; subsegments.len()];
    let triangles = core.neighbours.iter().zip(&core.constraints).zip(&core.triangles);
    for (((neighbours, bits), corners), triangle) in triangles.zip(0u32..) {
        let mut left = bits & 0b111;
        while left != 0 {
            let s = left.trailing_zeros();
            left &= left - 1;
            let half_edge = HalfEdge::new(TriangleId(triangle), s);
            if neighbours[s as usize].get().is_none_or(|twin| twin < half_edge) {
                continue;
            }
            let [from, to] = [corners[s as usize], corners[(s as usize + 1) % 3]];
            let (first, second) = (from.min(to), from.max(to));
            let range = starts[first as usize] as usize..starts[first as usize + 1] as usize;
            let start = range.start + subsegments[range.clone()].partition_point(|along| along.ends[1] < second);
            let before = core.edge_sources.len();
            for index in (start..range.end).take_while(|&index| subsegments[index].ends[1] == second) {
                is_within[index] = true;
                let source = subsegments[index].source;
                let source = if from == first { source } else { source.reversed() };
                core.edge_sources.push((half_edge.0, source));
            }
            core.edge_sources[before..].sort_unstable();
        }
    }
    let elsewhere = subsegments.iter().zip(is_within).filter(|(_, is_within)| !is_within);
    elsewhere.map(|(subsegment, _)| *subsegment).collect()
}

/// Returns, for each vertex, the index of the first of the sorted subsegments from this vertex or a
/// later one, and at last their number.
fn starts_by_end(subsegments: &[Subsegment], vertices: usize) -> Vec<u32> {
    let mut starts = vec![0; vertices + 1];
    for subsegment in subsegments {
        starts[subsegment.ends[0] as usize + 1] += 1;
    }
    for vertex in 0..vertices {
        starts[vertex + 1] += starts[vertex];
    }
    starts
}

/// Copies the settled triangles and their adjacency into the core. Returns its boundary half-edges.
fn core_triangles(workspace: &Workspace, core: &mut CoreDraft) -> Vec<BoundaryEdge> {
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
    let mut boundary_edges = Vec::new();
    for (triangle, fate) in (0u32..).zip(fates) {
        if *fate != Fate::Settled {
            continue;
        }
        let corners = mesh.triangles[triangle as usize];
        let bits = workspace.edge_bits.get(triangle as usize).copied().unwrap_or(0);
        let mut neighbours = [PackedHalfEdge::NONE; 3];
        for (s, twin) in mesh.neighbours[triangle as usize].iter().enumerate() {
            let other = twin.get().map_or(NONE, |twin| renumbered[twin.triangle().index()]);
            match twin.get().filter(|_| other != NONE) {
                Some(twin) => neighbours[s] = HalfEdge::new(TriangleId(other), twin.corner()).into(),
                None => boundary_edges.push(BoundaryEdge {
                    from: corners[s],
                    to: corners[(s + 1) % 3],
                    half_edge: HalfEdge::new(TriangleId(core.triangles.len() as u32), s as u32),
                    is_constraint: bits >> s & 1 == 1,
                    component: 0,
                }),
            }
        }
        if !workspace.edge_bits.is_empty() {
            core.constraints.push(bits);
        }
        core.triangles.push(corners);
        core.neighbours.push(neighbours);
    }
    boundary_edges
}

/// Returns the items along a space-filling curve, so that neighbours are close together in the
/// tile. Items at the same position are adjacent.
fn in_spatial_order(items: &[Item]) -> Vec<Item> {
    let square = MortonSquare::around(Rect::around(items.iter().map(|item| item.point)));
    let mask = (items.len() as u64).next_power_of_two() - 1;
    let mut keyed: Vec<u64> = items
        .iter()
        .zip(0u64..)
        .map(|(item, index)| square.key(item.point) & !mask | index)
        .collect();
    keyed.sort_unstable();
    let mut ordered: Vec<Item> = keyed.iter().map(|key| items[(key & mask) as usize]).collect();
    // A cell of the curve may contain several positions.
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

/// Keeps one item for each position. Items at the same position must be adjacent.
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

/// Returns whether `a` is kept rather than `b`.
fn precedes(a: &Item, b: &Item, attributes: &Attributes, rule: DuplicateRule) -> bool {
    let of = |item: &Item| (attributes.z(item.position), attributes.record(item.position));
    rule.prefers(of(a), of(b))
}
