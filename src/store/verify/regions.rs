//! Checks of regions, holes, and the sources of edges.
//!
//! In each tile, triangles that no constraint separates must have the same region, depth and kind.
//! Every constraint that belongs to the tile must have a source, must be a wall if one of its
//! sources is, and must change the depth as its sources say. The plane outside the hull has depth
//! 0. Each edge belongs to one tile, so these checks prove the same for the whole file. The reasons
//! for holes are checked in the tile for regions within one tile, and in a table, once all tiles
//! have been checked, for the others.
//!
//! This does not prove that all triangles of a region are connected with each other. Nor does it
//! prove that no obstacle is inside out under another one, where the sum of the coverage is too
//! small: `polygons` checks each polygon separately.

use xxhash_rust::xxh3::xxh3_128;

use crate::geometry::{HalfEdge, Orientation, Point, Rect, TriangleId, orient2d};
use crate::mesh::{Topology, Twin};
use crate::store::format::component_table::Component;
use crate::store::format::damage::Damage;
use crate::store::format::directory::Directory;
use crate::store::format::line_source::LineSource;
use crate::store::format::metadata::Metadata;
use crate::store::format::tile::Tile;
use crate::store::verify::error::Fault;

/// Bytes that the check takes per vertex of its tile, if every triangle is a region of its own.
pub(super) const BYTES_PER_VERTEX: u64 = 3 * size_of::<Region>() as u64;
/// Bytes that the check takes per region that may extend over several tiles.
pub(super) const BYTES_PER_SPANNING: u64 = size_of::<(i32, RegionFlags)>() as u64;

/// The claims of the directory that tiles are checked against.
pub(super) struct RegionClaims {
    regions: u64,
    spanning: u64,
    exterior_is_hole: bool,
    /// Sorted by x.
    seeds: Vec<Point>,
    lines: Vec<LineSource>,
}

impl RegionClaims {
    pub(super) fn of(directory: &Directory) -> Self {
        let Directory { metadata, lists, .. } = directory;
        let mut seeds: Vec<Point> = lists.hole_points.iter().map(|seed| seed.normalized()).collect();
        seeds.sort_unstable_by(|a, b| a.lex_cmp(*b));
        Self {
            regions: metadata.regions,
            spanning: metadata.spanning_regions,
            exterior_is_hole: metadata.exterior_is_hole,
            seeds,
            lines: lists.lines.clone(),
        }
    }

    /// Checks that a region is a hole if something makes it one, and only then, except that it may
    /// be a hole if a seed touches it. Checks that its depth is not negative.
    fn check_hole(&self, number: u64, depth: i32, flags: RegionFlags) -> Result<(), Damage> {
        if depth < 0 {
            return Err(Damage::new(format!(
                "region {number} is covered {depth} times: an obstacle is inside out there, and may uncover what another obstacle covers"
            )));
        }
        let must = depth > 0 || flags.has(RegionFlags::SEEDED) || self.exterior_is_hole && flags.has(RegionFlags::OPEN);
        match flags.has(RegionFlags::HOLE) {
            true if !must && !flags.has(RegionFlags::TOUCHED) => Err(Damage::new(format!(
                "region {number} is a hole, but nothing makes it one"
            ))),
            false if must => Err(Damage::new(format!(
                "region {number} is no hole, but should be: its depth is {depth}, or there is a seed in it, or it is outside"
            ))),
            _ => Ok(()),
        }
    }

    /// Returns the seeds with an x from `min` to `max`.
    fn seeds_within(&self, min: f64, max: f64) -> &[Point] {
        let start = self.seeds.partition_point(|seed| seed.x < min);
        let end = self.seeds.partition_point(|seed| seed.x <= max);
        &self.seeds[start..end.max(start)]
    }
}

/// What is known of a region, as flags.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
struct RegionFlags(u8);

impl RegionFlags {
    /// The region has triangles.
    const SEEN: Self = Self(1);
    const HOLE: Self = Self(2);
    /// The region has a hull edge that is no constraint.
    const OPEN: Self = Self(4);
    /// There is a seed in the region.
    const SEEDED: Self = Self(8);
    /// There is a seed at a vertex or on a constraint of the region, which may or may not refer to
    /// it.
    const TOUCHED: Self = Self(16);

    fn has(self, flag: Self) -> bool {
        self.0 & flag.0 != 0
    }

    fn add(&mut self, flag: Self) {
        self.0 |= flag.0;
    }
}

/// A region, or a component of one, as seen in one tile.
#[derive(Clone, Copy)]
struct Region {
    number: u64,
    depth: i32,
    flags: RegionFlags,
}

/// The contribution of a tile to the checks of the whole file.
pub(super) struct RegionReport {
    /// The regions of the tile that may extend over several tiles.
    spanning: Vec<Region>,
    /// The number of regions within this tile, the sum of the hashes of their numbers, and the
    /// number of holes among them.
    locals: u64,
    sum: u128,
    local_holes: u64,
    /// The number of sources of edges that are obstacles.
    pub(super) obstacles: u64,
}

/// The sums over all tiles.
pub(super) struct RegionTotals {
    spanning: Vec<(i32, RegionFlags)>,
    locals: u64,
    sum: u128,
    local_holes: u64,
}

/// Checks the regions of a tile, and the sources of its edges.
pub(super) fn check(tile: &Tile, claims: &RegionClaims, bounds: Rect) -> Result<RegionReport, Fault> {
    if tile.component_count() > tile.triangle_count().max(1) {
        return Err(Fault::new("it has more components than triangles"));
    }
    let components = (0..tile.component_count()).map(|number| {
        let Component { region, depth, is_hole } = tile.component_at(number);
        Region {
            number: region,
            depth,
            flags: if is_hole {
                RegionFlags::HOLE
            } else {
                RegionFlags::default()
            },
        }
    });
    let mut components: Vec<Region> = components.collect();
    let (mut edges_with_sources, mut obstacles) = (0, 0);
    for triangle in tile.triangle_ids() {
        let component = &mut components[tile.component_number(triangle) as usize];
        component.flags.add(RegionFlags::SEEN);
        check_number(tile, triangle, component.number, claims)?;
        for half_edge in HalfEdge::of_triangle(triangle) {
            match check_edge(tile, half_edge, claims)? {
                EdgeRole::Open => component.flags.add(RegionFlags::OPEN),
                EdgeRole::OwnedConstraint(its) => {
                    edges_with_sources += 1;
                    obstacles += its;
                }
                EdgeRole::Other => {}
            }
        }
    }
    if edges_with_sources != tile.edges_with_sources() {
        return Err(Fault::new(
            "it has sources for edges that are no constraints of its own",
        ));
    }
    mark_seeds(tile, claims, bounds, &mut components)?;
    let regions = joined(components)?;
    // The one component of a tile without triangles has no region.
    let regions: Vec<Region> = regions.into_iter().filter(|r| r.flags.has(RegionFlags::SEEN)).collect();
    let mut report = RegionReport {
        spanning: Vec::new(),
        locals: 0,
        sum: 0,
        local_holes: 0,
        obstacles,
    };
    for region in regions {
        if region.number < claims.spanning {
            report.spanning.push(region);
            continue;
        }
        claims
            .check_hole(region.number, region.depth, region.flags)
            .map_err(Fault::new)?;
        report.locals += 1;
        report.sum = report.sum.wrapping_add(hash(region.number));
        report.local_holes += u64::from(region.flags.has(RegionFlags::HOLE));
    }
    Ok(report)
}

/// Checks that a tile of a file without regions has no regions, walls or sources.
pub(super) fn check_none(tile: &Tile) -> Result<(), Fault> {
    let is_seeded = tile.component_records().iter().any(|record| record.is_seeded);
    let has_labels = is_seeded || tile.component_count() != 1 || tile.component_at(0) != Component::default();
    let has_walls = tile.half_edges().any(|half_edge| tile.is_wall(half_edge));
    // Without triangles there are edges with sources, but no regions.
    let has_sources = tile.edges_with_sources() > 0 && tile.triangle_count() > 0;
    if has_labels || has_walls || has_sources {
        return Err(Fault::new(
            "it has regions, walls or sources, but the directory says that there are no regions",
        ));
    }
    Ok(())
}

fn check_number(tile: &Tile, triangle: TriangleId, region: u64, claims: &RegionClaims) -> Result<(), Fault> {
    if region >= claims.regions {
        let regions = claims.regions;
        return Err(Fault::at(
            triangle,
            format!("it is of region {region}, but there are {regions} regions"),
        ));
    }
    let is_crossing = || tile.corners(triangle).iter().any(|&corner| !tile.has_vertex(corner));
    if region >= claims.spanning && is_crossing() {
        let reason =
            format!("it is in several tiles, but its region {region} has the number of a region within one tile");
        return Err(Fault::at(triangle, reason));
    }
    Ok(())
}

/// The role of a half-edge for the region to its left.
enum EdgeRole {
    /// A hull edge that is no constraint, so the region is open to the outside.
    Open,
    /// A constraint that belongs to the tile, with the number of its sources that are obstacles.
    /// Each such edge is reported once.
    OwnedConstraint(u64),
    /// Anything else.
    Other,
}

/// Checks an edge, which has both its triangles in the tile or is on the hull. Each edge is checked
/// at one of its half-edges only.
fn check_edge(tile: &Tile, half_edge: HalfEdge, claims: &RegionClaims) -> Result<EdgeRole, Fault> {
    let (triangle, here) = (half_edge.triangle(), tile.component(half_edge.triangle()));
    let twin = tile.twin(half_edge);
    let (there, neighbour) = match twin {
        Twin::HalfEdge(twin) if half_edge < twin => {
            let other = twin.triangle();
            (tile.component(other), format!("triangle {other}"))
        }
        Twin::HalfEdge(_) | Twin::Elsewhere => return Ok(EdgeRole::Other),
        Twin::Hull => (Component::default(), "the plane outside".to_owned()),
    };
    let is_hull = twin == Twin::Hull;
    let change = i64::from(here.depth) - i64::from(there.depth);
    if !tile.is_constraint(half_edge) {
        if here != there && !is_hull || change != 0 {
            let reason = format!(
                "no constraint separates it from {neighbour}, but they differ in region, depth, or whether they are a hole"
            );
            return Err(Fault::at(triangle, reason));
        }
        return Ok(if is_hull { EdgeRole::Open } else { EdgeRole::Other });
    }
    let [from, to] = tile.ends(half_edge);
    let smaller = if from.point.lex_cmp(to.point).is_lt() { from } else { to };
    if smaller.id.tile != tile.id() {
        return Ok(EdgeRole::Other);
    }
    let (mut count, mut is_wall, mut expected, mut obstacles) = (0, false, 0, 0);
    for source in tile.edge_sources(half_edge) {
        count += 1;
        is_wall |= source.is_wall();
        expected += i64::from(source.depth_change());
        obstacles += u64::from(source.depth_change() != 0);
        if !LineSource::knows(&claims.lines, source) {
            let reason = format!("its edge to {neighbour} comes from {source:?}, which the directory does not know");
            return Err(Fault::at(triangle, reason));
        }
    }
    let wrong = |reason: String| Err(Fault::at(triangle, format!("its edge to {neighbour} {reason}")));
    if count == 0 {
        return wrong("is a constraint without a source".to_owned());
    }
    if is_wall != tile.is_wall(half_edge) {
        return wrong("and the sources of the edge disagree on whether it is a wall".to_owned());
    }
    if change != expected {
        return wrong(format!(
            "changes the depth by {change}, but its sources change it by {expected}"
        ));
    }
    Ok(EdgeRole::OwnedConstraint(obstacles))
}

/// Finds the seeds in triangles of the tile, and sets the flags of their components. Checks that the
/// component table says the same.
fn mark_seeds(tile: &Tile, claims: &RegionClaims, bounds: Rect, components: &mut [Region]) -> Result<(), Fault> {
    check_seeded(tile, claims)?;
    if claims.seeds_within(bounds.min_x, bounds.max_x).is_empty() {
        return Ok(());
    }
    for triangle in tile.owned_triangles() {
        let corners = tile.triangle_points(triangle);
        let around = Rect::around(corners);
        for &seed in claims.seeds_within(around.min_x, around.max_x) {
            if let Some(flag) = seed_flag(tile, triangle, corners, seed) {
                components[tile.component_number(triangle) as usize].flags.add(flag);
            }
        }
    }
    Ok(())
}

/// Checks that the component table says of a component that there is a seed in it if there is one,
/// and only if one at least touches it.
fn check_seeded(tile: &Tile, claims: &RegionClaims) -> Result<(), Fault> {
    let mut found = vec![RegionFlags::default(); tile.component_count() as usize];
    if !claims.seeds.is_empty() {
        for triangle in tile.triangle_ids() {
            let corners = tile.triangle_points(triangle);
            let around = Rect::around(corners);
            let seeds = claims.seeds_within(around.min_x, around.max_x).iter();
            let flags = seeds.filter_map(|&seed| seed_flag(tile, triangle, corners, seed));
            let component = &mut found[tile.component_number(triangle) as usize];
            flags.for_each(|flag| component.add(flag));
        }
    }
    for ((record, found), number) in tile.component_records().iter().zip(found).zip(0..) {
        let must = found.has(RegionFlags::SEEDED);
        if record.is_seeded && found == RegionFlags::default() || must && !record.is_seeded {
            return Err(Fault::new(format!(
                "the component table is wrong on whether there is a seed in component {number}"
            )));
        }
    }
    Ok(())
}

/// Returns the flag that a seed sets for the region of a triangle, or `None` if the seed is outside
/// the triangle.
fn seed_flag(tile: &Tile, triangle: TriangleId, corners: [Point; 3], seed: Point) -> Option<RegionFlags> {
    let mut on_edges = 0;
    let mut on_constraint = false;
    let [a, b, c] = corners;
    for (half_edge, [from, to]) in HalfEdge::of_triangle(triangle)
        .into_iter()
        .zip([[a, b], [b, c], [c, a]])
    {
        match orient2d(from, to, seed) {
            Orientation::CounterClockwise => {}
            Orientation::Collinear => {
                on_edges += 1;
                on_constraint |= tile.is_constraint(half_edge);
            }
            Orientation::Clockwise => return None,
        }
    }
    // A point on two edges is their common vertex.
    Some(if on_constraint || on_edges == 2 {
        RegionFlags::TOUCHED
    } else {
        RegionFlags::SEEDED
    })
}

/// Joins components by region. Components of the same region must agree, and each must have a
/// triangle.
fn joined(mut components: Vec<Region>) -> Result<Vec<Region>, Fault> {
    let has_triangles = components.iter().any(|c| c.flags.has(RegionFlags::SEEN));
    if has_triangles && let Some(empty) = components.iter().position(|c| !c.flags.has(RegionFlags::SEEN)) {
        return Err(Fault::new(format!("component {empty} has no triangles")));
    }
    components.sort_unstable_by_key(|component| component.number);
    let mut alike = true;
    components.dedup_by(|component, region| {
        let is_same = component.number == region.number;
        if is_same {
            alike &= (component.depth, component.flags.has(RegionFlags::HOLE))
                == (region.depth, region.flags.has(RegionFlags::HOLE));
            region.flags.add(component.flags);
        }
        is_same
    });
    if !alike {
        return Err(Fault::new(
            "components of a region differ in depth, or in whether they are holes",
        ));
    }
    Ok(components)
}

fn hash(region: u64) -> u128 {
    xxh3_128(&region.to_le_bytes())
}

impl RegionTotals {
    pub(super) fn new(claims: &RegionClaims) -> Self {
        Self {
            spanning: vec![(0, RegionFlags::default()); claims.spanning as usize],
            locals: 0,
            sum: 0,
            local_holes: 0,
        }
    }

    pub(super) fn add(&mut self, report: &RegionReport) -> Result<(), Fault> {
        self.locals += report.locals;
        self.sum = self.sum.wrapping_add(report.sum);
        self.local_holes += report.local_holes;
        for region in &report.spanning {
            let (depth, flags) = &mut self.spanning[region.number as usize];
            if !flags.has(RegionFlags::SEEN) {
                *depth = region.depth;
            } else if (*depth, flags.has(RegionFlags::HOLE)) != (region.depth, region.flags.has(RegionFlags::HOLE)) {
                return Err(Fault::new(format!(
                    "it and other tiles disagree on the depth of region {}, or on whether it is a hole",
                    region.number
                )));
            }
            flags.add(region.flags);
        }
        Ok(())
    }

    /// Checks the facts that need all tiles.
    pub(super) fn check(&self, claims: &RegionClaims, metadata: &Metadata) -> Result<(), Damage> {
        let mut holes = self.local_holes;
        for (&(depth, flags), number) in self.spanning.iter().zip(0..) {
            if !flags.has(RegionFlags::SEEN) {
                return Err(Damage::new(format!("region {number} has no triangles")));
            }
            claims.check_hole(number, depth, flags)?;
            holes += u64::from(flags.has(RegionFlags::HOLE));
        }
        let sum = || (claims.spanning..claims.regions).map(hash).fold(0, u128::wrapping_add);
        if self.locals != claims.regions - claims.spanning || self.sum != sum() {
            return Err(Damage::new(format!(
                "regions from {} to {} should be within one tile each, and each should exist",
                claims.spanning, claims.regions
            )));
        }
        if holes != metadata.hole_regions {
            let expected = metadata.hole_regions;
            return Err(Damage::new(format!(
                "{holes} regions are holes, but the directory says {expected}"
            )));
        }
        Ok(())
    }
}
