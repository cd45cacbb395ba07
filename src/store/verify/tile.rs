//! Checks of a single tile.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use xxhash_rust::xxh3::xxh3_128;

use crate::geometry::{HalfEdge, Orientation, Rect, TriangleId, VertexIndex, in_circle, orient2d};
use crate::mesh::{Topology, Twin};
use crate::store::format::component_table::Component;
use crate::store::format::digest::Digest;
use crate::store::format::ids::{TileId, VertexId};
use crate::store::format::tile::{Tile, Vertex};
use crate::store::verify::error::Fault;
use crate::store::verify::held::LineRules;
use crate::store::verify::{held, regions, shared_vertices, star};

/// Bytes that a check takes per vertex of its tile: the set of points, which is at least 7/16 full,
/// and the fans.
pub(super) const BYTES_PER_VERTEX: u64 = 52;

/// The contribution of a tile to the checks of the whole file.
pub(super) struct TileReport {
    pub(super) tile: TileId,
    pub(super) owned: u32,
    pub(super) bounds: Rect,
    pub(super) has_z: bool,
    pub(super) edges: u64,
    pub(super) hull_edges: u64,
    pub(super) hull_minima: u64,
    pub(super) shared: HashMap<(TileId, TileId), u128>,
    /// The number of vertices at which no point of the input lies.
    pub(super) ends: u64,
    pub(super) digest: Digest,
    /// The number of notes on vertices that several tiles know, if the check is deep.
    pub(super) shared_vertices: u64,
    /// The report on regions, if the check is deep and the file has regions.
    pub(super) regions: Option<regions::RegionReport>,
}

/// The facts that a tile is checked against.
pub(super) struct Expected {
    /// Whether the file has triangles.
    pub(super) has_triangles: bool,
    /// Whether to check the geometry too.
    pub(super) deep: bool,
    /// What the directory says of lines.
    pub(super) lines: Arc<LineRules>,
    /// The directory's claims about regions, if the file has regions.
    pub(super) regions: Option<regions::RegionClaims>,
}

/// The bits of the coordinates of a tile's vertices.
pub(super) type VertexPoints = HashSet<(u64, u64)>;

/// Checks the structure of a tile, and its geometry if the check is deep.
pub(super) fn check(
    tile: &Tile,
    cell: Rect,
    expected: &Expected,
    seen_points: &mut VertexPoints,
) -> Result<TileReport, Fault> {
    check_vertices(tile, cell, seen_points)?;
    let mut report = TileReport {
        tile: tile.id(),
        owned: 0,
        bounds: Rect::around(tile.points()),
        has_z: tile.vertex_count() == 0 || tile.has_z(),
        edges: 0,
        digest: Digest::of_tile(tile),
        hull_edges: 0,
        hull_minima: 0,
        shared: HashMap::new(),
        ends: held::without_point(tile),
        shared_vertices: 0,
        regions: None,
    };
    for triangle in tile.triangle_ids() {
        check_triangle(tile, triangle)?;
        if tile.owns(triangle) {
            report.owned += 1;
            report.bounds = report.bounds.union(Rect::around(tile.triangle_points(triangle)));
        }
    }
    let fans = star::fans(tile, expected.has_triangles)?;
    if expected.deep {
        report.edges = check_circles(tile)?;
        for vertex in tile.vertex_indices() {
            if let Some(hull) = star::check_turn(tile, vertex, &fans)? {
                report.hull_edges += 1;
                report.hull_minima += u64::from(hull.is_minimum);
            }
        }
        for triangle in tile.border_triangle_ids() {
            share(tile, triangle, &mut report.shared);
        }
        match &expected.regions {
            Some(claims) => report.regions = Some(regions::check(tile, claims, report.bounds)?),
            None => regions::check_none(tile)?,
        }
        if expected.has_triangles {
            held::check(tile, &fans, &expected.lines)?;
        }
        report.shared_vertices = shared_vertices::count(tile, &expected.lines);
    }
    Ok(report)
}

/// Checks that vertices are in their cell, and no two at the same point.
fn check_vertices(tile: &Tile, cell: Rect, seen_points: &mut VertexPoints) -> Result<(), Fault> {
    seen_points.clear();
    seen_points.reserve(tile.vertex_count() as usize);
    for (p, vertex) in tile.points().zip(tile.vertex_indices()) {
        let inside = cell.min_x < p.x && p.x <= cell.max_x && cell.min_y < p.y && p.y <= cell.max_y;
        if !inside {
            return Err(Fault::new(format!(
                "vertex {vertex} at ({}, {}) is outside its cell",
                p.x, p.y
            )));
        }
        if !seen_points.insert((p.x.to_bits(), p.y.to_bits())) {
            return Err(Fault::new(format!(
                "vertex {vertex} at ({}, {}) has the same coordinates as another",
                p.x, p.y
            )));
        }
    }
    Ok(())
}

/// Checks that a triangle has three different corners, one of them the tile's own, in
/// counter-clockwise order, and that it agrees with its neighbours.
fn check_triangle(tile: &Tile, triangle: TriangleId) -> Result<(), Fault> {
    let corners = tile.corners(triangle);
    let own = corners.iter().filter(|&&corner| tile.has_vertex(corner)).count();
    if own == 0 || corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0] {
        return Err(Fault::at(
            triangle,
            "it has no corner in its tile, or the same corner twice",
        ));
    }
    let [a, b, c] = tile.triangle_points(triangle);
    if orient2d(a, b, c) != Orientation::CounterClockwise {
        return Err(Fault::at(triangle, "it is not counter-clockwise"));
    }
    for half_edge in HalfEdge::of_triangle(triangle) {
        let ends = [tile.origin(half_edge), tile.destination(half_edge)];
        let foreign = ends.iter().all(|&corner| !tile.has_vertex(corner));
        match tile.twin(half_edge) {
            Twin::HalfEdge(twin) => {
                let (there, other) = ([tile.destination(twin), tile.origin(twin)], twin.triangle());
                if tile.twin(twin) != Twin::HalfEdge(half_edge) || there != ends {
                    return Err(Fault::at(
                        triangle,
                        format!("it and triangle {other} disagree on their edge"),
                    ));
                }
                let kind = |half_edge: HalfEdge| (tile.is_constraint(half_edge), tile.is_wall(half_edge));
                if kind(half_edge) != kind(twin) {
                    return Err(Fault::at(
                        triangle,
                        format!("it and triangle {other} disagree on whether their edge is a constraint, or a wall"),
                    ));
                }
            }
            Twin::Elsewhere if foreign => {}
            Twin::Hull if !foreign => {}
            Twin::Elsewhere | Twin::Hull => {
                return Err(Fault::at(triangle, "it has no neighbour where there must be one"));
            }
        }
    }
    Ok(())
}

/// Checks that the circle of each edge with both its triangles in the tile is empty, unless the
/// edge is a constraint. Returns the number of edges that belong to the tile.
fn check_circles(tile: &Tile) -> Result<u64, Fault> {
    let mut edges = 0;
    for half_edge in tile.half_edges() {
        let [from, to] = tile.ends(half_edge);
        let first = if from.point.lex_cmp(to.point).is_lt() { from } else { to };
        let mine = first.id.tile == tile.id();
        match tile.twin(half_edge) {
            Twin::HalfEdge(twin) if half_edge < twin && tile.is_constraint(half_edge) => edges += u64::from(mine),
            Twin::HalfEdge(twin) if half_edge < twin => {
                let opposite = tile.point(tile.apex(twin));
                let [a, b, c] = tile.triangle_points(half_edge.triangle());
                if in_circle(a, b, c, opposite) {
                    let reason = format!(
                        "its circle contains the opposite corner of triangle {}",
                        twin.triangle()
                    );
                    return Err(Fault::at(half_edge.triangle(), reason));
                }
                edges += u64::from(mine);
            }
            Twin::Hull => edges += u64::from(mine),
            Twin::HalfEdge(_) | Twin::Elsewhere => {}
        }
    }
    Ok(edges)
}

/// Adds the hash of a border triangle to the sums of the pairs of tiles that share it: positive in
/// the owner, negative in the others.
fn share(tile: &Tile, triangle: TriangleId, sums: &mut HashMap<(TileId, TileId), u128>) {
    let owner = owner(tile, triangle);
    let hash = hash(tile, triangle);
    let mut add = |pair, hash: u128| {
        let sum = sums.entry(pair).or_default();
        *sum = sum.wrapping_add(hash);
    };
    if owner == tile.id() {
        others_with(tile, triangle)
            .into_iter()
            .for_each(|other| add((owner, other), hash));
    } else {
        add((owner, tile.id()), hash.wrapping_neg());
    }
}

/// Returns the other tiles that have a triangle.
pub(super) fn others_with(tile: &Tile, triangle: TriangleId) -> Vec<TileId> {
    let mut others = tile.vertices(triangle).map(|v| v.id.tile).to_vec();
    others.sort_unstable();
    others.dedup();
    others.retain(|&other| other != tile.id());
    others
}

/// Returns the tile that a triangle belongs to.
pub(super) fn owner(tile: &Tile, triangle: TriangleId) -> TileId {
    let [a, b, c] = tile.vertices(triangle);
    let smaller = |p: Vertex, q: Vertex| {
        if p.point.lex_cmp(q.point).is_le() { p } else { q }
    };
    smaller(smaller(a, b), c).id.tile
}

/// Returns the corners of a triangle, from the one with the smallest id on, and the place of this
/// one among the triangle's corners.
fn smallest_first(tile: &Tile, triangle: TriangleId) -> ([VertexIndex; 3], usize) {
    let mut corners = tile.corners(triangle);
    let smallest = (0..3).min_by_key(|&i| tile.vertex(corners[i]).id).unwrap_or(0);
    corners.rotate_left(smallest);
    (corners, smallest)
}

/// Returns the z of each corner of a triangle, with the ids of the corners, from the corner with
/// the smallest id on.
pub(super) fn heights(tile: &Tile, triangle: TriangleId) -> [(VertexId, Option<f64>); 3] {
    let (corners, _) = smallest_first(tile, triangle);
    corners.map(|corner| (tile.vertex(corner).id, tile.z(corner)))
}

/// Returns a hash of a triangle's corners, with their ids, points and z, from the corner with the
/// smallest id on, of which of its edges are constraints and walls, and of its component.
pub(super) fn hash(tile: &Tile, triangle: TriangleId) -> u128 {
    let (corners, smallest) = smallest_first(tile, triangle);
    let mut bits = HalfEdge::of_triangle(triangle)
        .map(|half_edge| u64::from(tile.is_constraint(half_edge)) | u64::from(tile.is_wall(half_edge)) << 1);
    bits.rotate_left(smallest);
    let Component { region, depth, is_hole } = tile.component(triangle);
    let of_corners = corners.into_iter().zip(bits).flat_map(|(corner, bits)| {
        let Vertex { id, point } = tile.vertex(corner);
        let number = u64::from(id.tile.0) << 32 | u64::from(id.index.0);
        let z = tile.z(corner).map_or(0, f64::to_bits);
        [number, point.x.to_bits(), point.y.to_bits(), z, bits]
    });
    let of_region = [region, i64::from(depth) as u64, u64::from(is_hole)];
    let bytes: Vec<u8> = of_corners.chain(of_region).flat_map(u64::to_le_bytes).collect();
    xxh3_128(&bytes)
}
