//! What can be checked of a tile alone.

use std::collections::{HashMap, HashSet};

use xxhash_rust::xxh3::xxh3_128;

use crate::geometry::{HalfEdge, Orientation, Rect, TriangleId, VertexIndex, in_circle, orient2d};
use crate::mesh::{Topology, Twin};
use crate::store::format::ids::TileId;
use crate::store::format::tile::Tile;
use crate::store::format::tile::regions::Component;
use crate::store::verify::error::Fault;
use crate::store::verify::{regions, star};

/// Bytes that a check takes for each vertex of its tile: the places, in a table that is at least 7/16 full, and the fans.
pub(super) const BYTES_PER_VERTEX: u64 = 52;

/// What a tile adds to the whole.
pub(super) struct TileReport {
    pub(super) tile: TileId,
    pub(super) owned: u32,
    pub(super) bounds: Rect,
    pub(super) has_z: bool,
    pub(super) edges: u64,
    pub(super) constraint_edges: u64,
    pub(super) hull_edges: u64,
    pub(super) hull_minima: u64,
    pub(super) shared: HashMap<(TileId, TileId), u128>,
    pub(super) hole_triangles: u64,
    pub(super) sites: u64,
    /// What there is to say of regions, if the check is deep and the file knows any.
    pub(super) regions: Option<regions::Report>,
}

/// What a tile is checked against.
pub(super) struct Expected {
    /// Whether the file has triangles.
    pub(super) has_triangles: bool,
    /// Whether to check the geometry.
    pub(super) deep: bool,
    /// What the directory says of regions, if the file knows any.
    pub(super) regions: Option<regions::Claims>,
}

/// The coordinates' bits of the vertices of a tile.
pub(super) type Places = HashSet<(u64, u64)>;

/// Checks a tile: its structure, and its geometry if the check is deep.
pub(super) fn check(tile: &Tile, cell: Rect, expected: &Expected, places: &mut Places) -> Result<TileReport, Fault> {
    check_vertices(tile, cell, places)?;
    let mut report = TileReport {
        tile: tile.id(),
        owned: 0,
        bounds: Rect::around(tile.points()),
        has_z: tile.vertex_count() == 0 || tile.z(VertexIndex(0)).is_some(),
        edges: 0,
        constraint_edges: tile.owned_constraints().count() as u64,
        hull_edges: 0,
        hull_minima: 0,
        shared: HashMap::new(),
        hole_triangles: 0,
        sites: tile.site_count().into(),
        regions: None,
    };
    for triangle in tile.triangle_ids() {
        check_triangle(tile, triangle)?;
        if tile.owns(triangle) {
            report.owned += 1;
            report.hole_triangles += u64::from(tile.is_hole(triangle));
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
    }
    Ok(report)
}

/// Vertices lie in their cell, each at a place of its own, and z is a number.
fn check_vertices(tile: &Tile, cell: Rect, places: &mut Places) -> Result<(), Fault> {
    places.clear();
    places.reserve(tile.vertex_count() as usize);
    for (p, vertex) in tile.points().zip(tile.vertex_indices()) {
        let inside = cell.min_x < p.x && p.x <= cell.max_x && cell.min_y < p.y && p.y <= cell.max_y;
        if !inside {
            return Err(Fault::new(format!(
                "vertex {vertex} at ({}, {}) lies outside its cell",
                p.x, p.y
            )));
        }
        if !places.insert((p.x.to_bits(), p.y.to_bits())) {
            return Err(Fault::new(format!(
                "vertex {vertex} at ({}, {}) lies on another",
                p.x, p.y
            )));
        }
        if tile.z(vertex).is_some_and(|z| !z.is_finite()) {
            return Err(Fault::new(format!("vertex {vertex} has no finite z")));
        }
    }
    Ok(())
}

/// Three different corners, one of them the tile's own, counter-clockwise; neighbours agree.
fn check_triangle(tile: &Tile, triangle: TriangleId) -> Result<(), Fault> {
    let corners = tile.corners(triangle);
    let own = corners.iter().filter(|&&corner| tile.has_vertex(corner)).count();
    if own == 0 || corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0] {
        return Err(Fault::at(triangle, "it has no corner in its tile, or one twice"));
    }
    let [a, b, c] = tile.triangle_points(triangle);
    if orient2d(a, b, c) != Orientation::CounterClockwise {
        return Err(Fault::at(triangle, "it is not counter-clockwise"));
    }
    for side in HalfEdge::of_triangle(triangle) {
        let ends = [tile.origin(side), tile.destination(side)];
        let foreign = ends.iter().all(|&corner| !tile.has_vertex(corner));
        match tile.twin(side) {
            Twin::HalfEdge(twin) => {
                let (there, other) = ([tile.destination(twin), tile.origin(twin)], twin.triangle());
                if tile.twin(twin) != Twin::HalfEdge(side) || there != ends {
                    return Err(Fault::at(
                        triangle,
                        format!("it and triangle {other} disagree on their edge"),
                    ));
                }
                let what = |side: HalfEdge| (tile.is_constraint(side), tile.is_wall(side));
                if what(side) != what(twin) {
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

/// The circle of each edge with both its triangles in the tile is empty, unless it is a constraint. Returns how many belong to the tile.
fn check_circles(tile: &Tile) -> Result<u64, Fault> {
    let mut edges = 0;
    for side in tile.half_edges() {
        let [from, to] = tile.ends(side);
        let first = if from.point.lex_cmp(to.point).is_lt() { from } else { to };
        let mine = first.id.tile == tile.id();
        match tile.twin(side) {
            Twin::HalfEdge(twin) if side < twin && tile.is_constraint(side) => edges += u64::from(mine),
            Twin::HalfEdge(twin) if side < twin => {
                let opposite = tile.point(tile.apex(twin));
                let [a, b, c] = tile.triangle_points(side.triangle());
                if in_circle(a, b, c, opposite) {
                    let reason = format!("its circle holds the far corner of triangle {}", twin.triangle());
                    return Err(Fault::at(side.triangle(), reason));
                }
                edges += u64::from(mine);
            }
            Twin::Hull => edges += u64::from(mine),
            Twin::HalfEdge(_) | Twin::Elsewhere => {}
        }
    }
    Ok(edges)
}

/// Adds a border triangle to the sums of the pairs of tiles that it joins: once for its owner, once against for others.
fn share(tile: &Tile, triangle: TriangleId, sums: &mut HashMap<(TileId, TileId), u128>) {
    let owner = owner(tile, triangle);
    let hash = hash(tile, triangle);
    let mut others = tile.vertices(triangle).map(|v| v.id.tile).to_vec();
    others.sort_unstable();
    others.dedup();
    let mut add = |pair, hash: u128| {
        let sum = sums.entry(pair).or_default();
        *sum = sum.wrapping_add(hash);
    };
    if owner == tile.id() {
        others
            .iter()
            .filter(|&&t| t != owner)
            .for_each(|&t| add((owner, t), hash));
    } else {
        add((owner, tile.id()), hash.wrapping_neg());
    }
}

/// The tile that a triangle belongs to.
pub(super) fn owner(tile: &Tile, triangle: TriangleId) -> TileId {
    let [a, b, c] = tile.vertices(triangle);
    let smaller = |p: crate::store::format::tile::Vertex, q: crate::store::format::tile::Vertex| {
        if p.point.lex_cmp(q.point).is_le() { p } else { q }
    };
    smaller(smaller(a, b), c).id.tile
}

/// A hash of a triangle's corners, their numbers and places, of which sides are constraints and walls, from the smallest
/// corner on, and of its region.
pub(super) fn hash(tile: &Tile, triangle: TriangleId) -> u128 {
    let mut corners = tile.vertices(triangle);
    let smallest = (0..3).min_by_key(|&i| corners[i].id).unwrap_or(0);
    corners.rotate_left(smallest);
    let mut sides = HalfEdge::of_triangle(triangle)
        .map(|side| u64::from(tile.is_constraint(side)) | u64::from(tile.is_wall(side)) << 1);
    sides.rotate_left(smallest);
    let Component { region, depth, is_hole } = tile.component(triangle);
    let of_corners = corners.iter().zip(sides).flat_map(|(v, side)| {
        let id = u64::from(v.id.tile.0) << 32 | u64::from(v.id.index.0);
        [id, v.point.x.to_bits(), v.point.y.to_bits(), side]
    });
    let of_region = [region, i64::from(depth) as u64, u64::from(is_hole)];
    let bytes: Vec<u8> = of_corners.chain(of_region).flat_map(u64::to_le_bytes).collect();
    xxh3_128(&bytes)
}
