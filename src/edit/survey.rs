//! What the search for regions needs to know of a tile. It is found when the tile is written, so that
//! the tile need not be read again.

use std::collections::BTreeSet;

use foldhash::{HashMap, HashMapExt, HashSet, HashSetExt};

use crate::collections::union_find::UnionFind;
use crate::constraints::seeds::Seeds;
use crate::edit::tile::parts::TileParts;
use crate::edit::tile::{EditTile, TriangleOrder};
use crate::geometry::{HalfEdge, Point, TriangleId};
use crate::mesh::{Topology, Twin};
use crate::store::{
    ComponentId, ComponentRecord, DigestSum, EdgeSource, TileId, VertexId, component_table, triangle_hash,
};

/// A triangle that several tiles store.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SharedTriangle {
    /// The ends of its first half-edge, from its smallest corner on.
    pub(crate) key: [VertexId; 2],
    /// The tile that it belongs to.
    pub(crate) owner: TileId,
    /// The number of tiles that store it.
    pub(crate) tiles: u8,
    /// The part of the surveyed tile that it is in.
    pub(crate) part: u32,
}

impl SharedTriangle {
    /// Describes a triangle by the ids and the points of its corners.
    pub(crate) fn of(corners: [(VertexId, Point); 3], part: u32) -> Self {
        let [a, b, c] = corners.map(|(id, _)| id);
        let owner = corners.iter().min_by(|(_, p), (_, q)| p.lex_cmp(*q));
        let others = u8::from(b.tile != a.tile) + u8::from(c.tile != a.tile && c.tile != b.tile);
        Self {
            key: [[a, b], [b, c], [c, a]].into_iter().min().unwrap_or([a, b]),
            owner: owner.map_or(a.tile, |(id, _)| id.tile),
            tiles: 1 + others,
            part,
        }
    }
}

/// The change of depth from the part on the left of a constraint to that on its right; `None` is the
/// plane outside the hull.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct DepthChange {
    pub(crate) sides: [Option<u32>; 2],
    pub(crate) change: i32,
}

/// What the search for regions needs to know of a tile.
#[derive(Debug)]
pub(crate) struct TileSurvey {
    pub(crate) tile: TileId,
    /// The number of parts.
    pub(crate) parts: u32,
    /// The number of the triangles that belong to the tile, and the sum of their hashes.
    pub(crate) triangles: DigestSum,
    /// The component table, without regions, depths and links; empty without parts.
    pub(crate) table: Vec<u8>,
    /// The parts that are connected within the tile without a constraint between: each with the first
    /// part that it is connected with.
    pub(crate) linked: Vec<[u32; 2]>,
    pub(crate) shared: Vec<SharedTriangle>,
    /// The other tiles that store triangles of this one.
    pub(crate) neighbours: Vec<TileId>,
    /// The changes of depth across constraints and the hull, each once, with one of the lines there.
    pub(crate) changes: Vec<(DepthChange, Option<EdgeSource>)>,
}

/// Surveys, as many as a limit of memory allows.
#[derive(Debug)]
pub(crate) struct Surveys {
    all: HashMap<TileId, TileSurvey>,
    bytes: u64,
    limit: u64,
}

impl Surveys {
    /// Creates an empty set that keeps up to `limit` bytes of surveys.
    pub(crate) fn within(limit: u64) -> Self {
        Self {
            all: HashMap::new(),
            bytes: 0,
            limit,
        }
    }

    /// Keeps a survey in the place of an earlier one of the tile, if the limit allows.
    pub(crate) fn put(&mut self, survey: TileSurvey) {
        self.take(survey.tile);
        if self.bytes + survey.byte_size() <= self.limit {
            self.bytes += survey.byte_size();
            self.all.insert(survey.tile, survey);
        }
    }

    /// Returns the survey of a tile, which is no longer kept.
    pub(crate) fn take(&mut self, tile: TileId) -> Option<TileSurvey> {
        let survey = self.all.remove(&tile)?;
        self.bytes -= survey.byte_size();
        Some(survey)
    }
}

impl TileSurvey {
    pub(crate) fn of(tile: &EditTile, order: &TriangleOrder, parts: &TileParts, seeds: &Seeds) -> Self {
        let records = records(tile, order, parts, seeds);
        let border = &order.border;
        let neighbours: HashSet<TileId> = border
            .iter()
            .flat_map(|&triangle| tile.triangle(HalfEdge::new(triangle, 0)).0)
            .map(|corner| corner.id.tile)
            .filter(|&other| other != tile.id)
            .collect();
        Self {
            tile: tile.id,
            parts: parts.count(),
            triangles: records.iter().fold(DigestSum::default(), |mut sum, record| {
                sum += record.triangles;
                sum
            }),
            // A tile without triangles has no components, and no table.
            table: match records.is_empty() {
                true => Vec::new(),
                false => component_table::encode(tile.id, &records),
            },
            linked: linked(tile, parts, order),
            shared: border
                .iter()
                .map(|&triangle| shared(tile, triangle, parts.of_triangle(triangle)))
                .collect(),
            neighbours: neighbours.into_iter().collect(),
            changes: changes(tile, parts, &records),
        }
    }

    /// Returns the bytes of memory that it takes.
    pub(crate) fn byte_size(&self) -> u64 {
        let lists = size_of_val(&*self.linked)
            + size_of_val(&*self.shared)
            + size_of_val(&*self.neighbours)
            + size_of_val(&*self.changes);
        (size_of::<Self>() + self.table.len() + lists) as u64
    }
}

/// Returns the component table of a tile in a file without regions and constraints, where each tile is
/// one component. `triangles` is the sum of the triangles that belong to the tile.
pub(crate) fn table_without_regions(tile: &EditTile, order: &TriangleOrder, triangles: DigestSum) -> Vec<u8> {
    if order.all().next().is_none() {
        return Vec::new();
    }
    let owners = order.border.iter().map(|&triangle| shared(tile, triangle, 0).owner);
    let others: BTreeSet<TileId> = owners.filter(|&owner| owner != tile.id).collect();
    let mut half_edges = order.all().flat_map(HalfEdge::of_triangle);
    let is_at_hull = half_edges.any(|half_edge| tile.twin(half_edge) == Twin::Hull);
    let record = ComponentRecord {
        is_open: is_at_hull,
        is_at_hull,
        triangles,
        links: others.into_iter().map(|tile| ComponentId { tile, number: 0 }).collect(),
        ..ComponentRecord::default()
    };
    component_table::encode(tile.id, &[record])
}

/// Returns what the triangles of a tile say of its parts, without regions, depths and links.
fn records(tile: &EditTile, order: &TriangleOrder, parts: &TileParts, seeds: &Seeds) -> Vec<ComponentRecord> {
    let mut records = vec![ComponentRecord::default(); parts.count() as usize];
    let core = order.core.iter().map(|&triangle| (triangle, true));
    let of_border = order.border.iter().map(|&triangle| (triangle, tile.owns(triangle)));
    for (triangle, is_owned) in core.chain(of_border) {
        let record = &mut records[parts.of_triangle(triangle) as usize];
        describe(tile, triangle, is_owned, seeds, record);
    }
    records
}

/// Adds what a triangle, which may belong to the tile, says of its component.
fn describe(tile: &EditTile, triangle: TriangleId, is_owned: bool, seeds: &Seeds, record: &mut ComponentRecord) {
    let points = tile.corner_points(triangle);
    if is_owned {
        record.triangles.add_hash(triangle_hash(points));
    }
    record.is_seeded |= !seeds.is_empty() && seeds.any_in(points);
    for half_edge in HalfEdge::of_triangle(triangle) {
        if tile.twin(half_edge) == Twin::Hull {
            record.is_at_hull = true;
            record.is_open |= !tile.is_constraint(half_edge);
        }
    }
}

/// Returns the parts that are connected within a tile, each with the first one that it is connected
/// with. There are such parts if they are the components that a build gave to a core.
fn linked(tile: &EditTile, parts: &TileParts, order: &TriangleOrder) -> Vec<[u32; 2]> {
    if parts.count() < 2 {
        return Vec::new();
    }
    let mut sets = UnionFind::new(parts.count());
    let half_edges = order.all().flat_map(HalfEdge::of_triangle);
    for half_edge in half_edges.filter(|&half_edge| !tile.is_constraint(half_edge)) {
        let Twin::HalfEdge(twin) = tile.twin(half_edge) else {
            continue;
        };
        let both = [half_edge, twin].map(|half_edge| parts.of_triangle(half_edge.triangle()));
        if both[0] < both[1] {
            sets.union(both[0], both[1]);
        }
    }
    let mut firsts = vec![None; parts.count() as usize];
    let mut linked = Vec::new();
    for part in 0..parts.count() {
        match &mut firsts[sets.find(part) as usize] {
            Some(first) => linked.push([part, *first]),
            first => *first = Some(part),
        }
    }
    linked
}

/// Describes a triangle of the border, in this part.
fn shared(tile: &EditTile, triangle: TriangleId, part: u32) -> SharedTriangle {
    let corners = tile.triangle(HalfEdge::new(triangle, 0)).0;
    SharedTriangle::of(corners.map(|corner| (corner.id, corner.point)), part)
}

/// Returns the changes of depth across the constraints of a tile and at the hull. `records` are those
/// of its parts.
fn changes(tile: &EditTile, parts: &TileParts, records: &[ComponentRecord]) -> Vec<(DepthChange, Option<EdgeSource>)> {
    let part = |half_edge: HalfEdge| parts.of_triangle(half_edge.triangle());
    let open = records.iter().zip(0..).filter(|(record, _)| record.is_open);
    // Without a constraint in between, the region is as deep as the outside.
    let open = open.map(|(_, part)| {
        let sides = [Some(part), None];
        (DepthChange { sides, change: 0 }, None)
    });
    let constraints = tile.owned_constraints().map(|(half_edge, sources)| {
        let sides = [Some(part(half_edge)), tile.twin(half_edge).half_edge().map(part)];
        // Sources are seen from the smaller corner.
        let is_against = tile.origin(half_edge) > tile.destination(half_edge);
        let change: i32 = sources.iter().map(|source| source.depth_change()).sum();
        let change = if is_against { -change } else { change };
        (DepthChange { sides, change }, sources.first().map(|part| part.source()))
    });
    let mut seen = HashSet::new();
    open.chain(constraints)
        .filter(|(change, _)| seen.insert(*change))
        .collect()
}
