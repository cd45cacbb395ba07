//! Regions, holes, and the lines that edges come from.
//!
//! In each tile: triangles that no constraint parts are of one region, and alike; every constraint that belongs to the tile has
//! a source, is a wall if one of these is, and changes the depth by what they say, the plane outside the hull being of depth 0.
//! As edges belong to one tile each, that is proven of the whole file. Of regions that lie in one tile, the tile tells whether they
//! are holes for a reason; of the others a table does, once all tiles have been seen.
//!
//! Not proven is that all triangles of a region are connected with each other. Nor is it that no obstacle is inside out under another
//! one, where the sum of what covers the ground is too small: only the obstacles' files tell which rings belong together, and whoever
//! has them checks each polygon by itself.

use xxhash_rust::xxh3::xxh3_128;

use crate::geometry::{HalfEdge, Orientation, Point, Rect, TriangleId, orient2d};
use crate::mesh::{Topology, Twin};
use crate::store::format::damage::Damage;
use crate::store::format::metadata::{LineSource, Metadata};
use crate::store::format::tile::Tile;
use crate::store::format::tile::regions::Component;
use crate::store::verify::error::Fault;

/// Bytes that the check takes for each vertex of its tile, if every triangle is a region.
pub(super) const BYTES_PER_VERTEX: u64 = 3 * size_of::<Region>() as u64;
/// Bytes that it takes for each region that may lie in several tiles.
pub(super) const BYTES_PER_SPANNING: u64 = size_of::<(i32, Marks)>() as u64;

/// What the directory says, which tiles are held to.
pub(super) struct Claims {
    regions: u64,
    spanning: u64,
    exterior_is_hole: bool,
    /// By x.
    seeds: Vec<Point>,
    lines: Vec<LineSource>,
}

impl Claims {
    pub(super) fn of(metadata: &Metadata) -> Self {
        let mut seeds: Vec<Point> = metadata.seeds.iter().map(|seed| seed.normalized()).collect();
        seeds.sort_unstable_by(|a, b| a.lex_cmp(*b));
        Self {
            regions: metadata.regions,
            spanning: metadata.spanning_regions,
            exterior_is_hole: metadata.exterior_is_hole,
            seeds,
            lines: metadata.lines.clone(),
        }
    }

    /// Whether a region may be what it is said to be.
    fn check_hole(&self, number: u64, depth: i32, marks: Marks) -> Result<(), Damage> {
        if depth < 0 {
            return Err(Damage::new(format!(
                "region {number} is covered {depth} times: an obstacle is inside out there, and may free what another one covers"
            )));
        }
        let must = depth > 0 || marks.has(Marks::SEEDED) || self.exterior_is_hole && marks.has(Marks::OPEN);
        match marks.has(Marks::HOLE) {
            true if !must && !marks.has(Marks::TOUCHED) => Err(Damage::new(format!(
                "region {number} is a hole, but nothing makes it one"
            ))),
            false if must => Err(Damage::new(format!(
                "region {number} is no hole, but should be: its depth is {depth}, or a seed lies in it, or it is outside"
            ))),
            _ => Ok(()),
        }
    }

    /// The seeds with an x from `min` to `max`.
    fn seeds_within(&self, min: f64, max: f64) -> &[Point] {
        let start = self.seeds.partition_point(|seed| seed.x < min);
        let end = self.seeds.partition_point(|seed| seed.x <= max);
        &self.seeds[start..end.max(start)]
    }
}

/// What is known of a region, bit by bit.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
struct Marks(u8);

impl Marks {
    /// It has triangles.
    const SEEN: Self = Self(1);
    const HOLE: Self = Self(2);
    /// It has a hull edge that is no constraint.
    const OPEN: Self = Self(4);
    /// A seed lies in it.
    const SEEDED: Self = Self(8);
    /// A seed lies at a vertex or on a constraint of it, so that it may be meant or not.
    const TOUCHED: Self = Self(16);

    fn has(self, mark: Self) -> bool {
        self.0 & mark.0 != 0
    }

    fn add(&mut self, mark: Self) {
        self.0 |= mark.0;
    }
}

/// A region, or a component of one, as a tile knows it.
#[derive(Clone, Copy)]
struct Region {
    number: u64,
    depth: i32,
    marks: Marks,
}

/// What a tile adds to the whole.
pub(super) struct Report {
    /// The regions in it that may lie in several tiles.
    spanning: Vec<Region>,
    /// The regions that lie in it alone, the sum of the hashes of their numbers, and how many are holes.
    locals: u64,
    sum: u128,
    local_holes: u64,
}

/// What the tiles add up to.
pub(super) struct Totals {
    spanning: Vec<(i32, Marks)>,
    locals: u64,
    sum: u128,
    local_holes: u64,
}

/// Checks the regions of a tile, and the sources of its edges.
pub(super) fn check(tile: &Tile, claims: &Claims, bounds: Rect) -> Result<Report, Fault> {
    if tile.component_count() > tile.triangle_count().max(1) {
        return Err(Fault::new("it has more components than triangles"));
    }
    let components = (0..tile.component_count()).map(|number| {
        let Component { region, depth, is_hole } = tile.component_at(number);
        Region {
            number: region,
            depth,
            marks: if is_hole { Marks::HOLE } else { Marks::default() },
        }
    });
    let mut components: Vec<Region> = components.collect();
    let mut edges_with_sources = 0;
    for triangle in tile.triangle_ids() {
        let component = &mut components[tile.component_number(triangle) as usize];
        component.marks.add(Marks::SEEN);
        check_number(tile, triangle, component.number, claims)?;
        for side in HalfEdge::of_triangle(triangle) {
            match check_side(tile, side, claims)? {
                Side::Open => component.marks.add(Marks::OPEN),
                Side::WithSources => edges_with_sources += 1,
                Side::Other => {}
            }
        }
    }
    if edges_with_sources != tile.edges_with_sources() {
        return Err(Fault::new(
            "it has sources for edges that are no constraints of its own",
        ));
    }
    mark_seeds(tile, claims, bounds, &mut components);
    let regions = joined(components)?;
    // Of a tile without triangles there is a component in name only.
    let regions: Vec<Region> = regions.into_iter().filter(|r| r.marks.has(Marks::SEEN)).collect();
    let mut report = Report {
        spanning: Vec::new(),
        locals: 0,
        sum: 0,
        local_holes: 0,
    };
    for region in regions {
        if region.number < claims.spanning {
            report.spanning.push(region);
            continue;
        }
        claims
            .check_hole(region.number, region.depth, region.marks)
            .map_err(Fault::new)?;
        report.locals += 1;
        report.sum = report.sum.wrapping_add(hash(region.number));
        report.local_holes += u64::from(region.marks.has(Marks::HOLE));
    }
    Ok(report)
}

/// A file that knows no regions has nothing that belongs to them.
pub(super) fn check_none(tile: &Tile) -> Result<(), Fault> {
    let has_labels = tile.component_count() != 1 || tile.component_at(0) != Component::default();
    let has_walls = tile.half_edges().any(|side| tile.is_wall(side));
    // Without triangles there are edges, but no regions.
    let has_sources = tile.edges_with_sources() > 0 && tile.triangle_count() > 0;
    if has_labels || has_walls || has_sources {
        return Err(Fault::new(
            "it has regions, walls or sources, and the directory says that there are no regions",
        ));
    }
    Ok(())
}

fn check_number(tile: &Tile, triangle: TriangleId, region: u64, claims: &Claims) -> Result<(), Fault> {
    if region >= claims.regions {
        let regions = claims.regions;
        return Err(Fault::at(
            triangle,
            format!("it is of region {region}, and there are {regions}"),
        ));
    }
    let is_crossing = || tile.corners(triangle).iter().any(|&corner| !tile.has_vertex(corner));
    if region >= claims.spanning && is_crossing() {
        let reason = format!("it stands in several tiles, and its region {region} lies in one by its number");
        return Err(Fault::at(triangle, reason));
    }
    Ok(())
}

/// What a side is for the region to its left.
enum Side {
    /// A way out: on the hull, and no constraint.
    Open,
    /// On a constraint that belongs to the tile; each such edge once.
    WithSources,
    /// Anything else.
    Other,
}

/// Checks an edge that has both its triangles in the tile, or is on the hull; once.
fn check_side(tile: &Tile, side: HalfEdge, claims: &Claims) -> Result<Side, Fault> {
    let (triangle, here) = (side.triangle(), tile.component(side.triangle()));
    let twin = tile.twin(side);
    let (there, beyond) = match twin {
        Twin::HalfEdge(twin) if side < twin => {
            let other = twin.triangle();
            (tile.component(other), format!("triangle {other}"))
        }
        Twin::HalfEdge(_) | Twin::Elsewhere => return Ok(Side::Other),
        Twin::Hull => (Component::default(), "the plane outside".to_owned()),
    };
    let is_hull = twin == Twin::Hull;
    let change = i64::from(here.depth) - i64::from(there.depth);
    if !tile.is_constraint(side) {
        if here != there && !is_hull || change != 0 {
            let reason = format!(
                "no constraint parts it from {beyond}, but they differ in region, depth, or whether they are a hole"
            );
            return Err(Fault::at(triangle, reason));
        }
        return Ok(if is_hull { Side::Open } else { Side::Other });
    }
    let [from, to] = tile.ends(side);
    let smaller = if from.point.lex_cmp(to.point).is_lt() { from } else { to };
    if smaller.id.tile != tile.id() {
        return Ok(Side::Other);
    }
    let (mut count, mut is_wall, mut expected) = (0, false, 0);
    for source in tile.edge_sources(side) {
        count += 1;
        is_wall |= source.is_wall();
        expected += i64::from(source.depth_change());
        if !LineSource::knows(&claims.lines, source) {
            let reason = format!("its edge to {beyond} comes from {source:?}, which the directory does not know");
            return Err(Fault::at(triangle, reason));
        }
    }
    let wrong = |reason: String| Err(Fault::at(triangle, format!("its edge to {beyond} {reason}")));
    if count == 0 {
        return wrong("is a constraint without a source".to_owned());
    }
    if is_wall != tile.is_wall(side) {
        return wrong("and the sources of the edge disagree on whether it is a wall".to_owned());
    }
    if change != expected {
        return wrong(format!(
            "changes the depth by {change}, and by its sources by {expected}"
        ));
    }
    Ok(Side::WithSources)
}

/// Finds the seeds that lie in triangles of the tile.
fn mark_seeds(tile: &Tile, claims: &Claims, bounds: Rect, components: &mut [Region]) {
    if claims.seeds_within(bounds.min_x, bounds.max_x).is_empty() {
        return;
    }
    for triangle in tile.owned_triangles() {
        let corners = tile.triangle_points(triangle);
        let around = Rect::around(corners);
        for &seed in claims.seeds_within(around.min_x, around.max_x) {
            if let Some(mark) = mark_of(tile, triangle, corners, seed) {
                components[tile.component_number(triangle) as usize].marks.add(mark);
            }
        }
    }
}

/// What a seed means for the region of a triangle; nothing if it lies outside the triangle.
fn mark_of(tile: &Tile, triangle: TriangleId, corners: [Point; 3], seed: Point) -> Option<Marks> {
    let mut on_edges = 0;
    let mut on_constraint = false;
    let [a, b, c] = corners;
    for (side, [from, to]) in HalfEdge::of_triangle(triangle)
        .into_iter()
        .zip([[a, b], [b, c], [c, a]])
    {
        match orient2d(from, to, seed) {
            Orientation::CounterClockwise => {}
            Orientation::Collinear => {
                on_edges += 1;
                on_constraint |= tile.is_constraint(side);
            }
            Orientation::Clockwise => return None,
        }
    }
    // On two edges at once lie their vertices.
    Some(if on_constraint || on_edges == 2 {
        Marks::TOUCHED
    } else {
        Marks::SEEDED
    })
}

/// Components by region; those of one region must agree, and each must have a triangle.
fn joined(mut components: Vec<Region>) -> Result<Vec<Region>, Fault> {
    let has_triangles = components.iter().any(|c| c.marks.has(Marks::SEEN));
    if has_triangles && let Some(empty) = components.iter().position(|c| !c.marks.has(Marks::SEEN)) {
        return Err(Fault::new(format!("component {empty} has no triangles")));
    }
    components.sort_unstable_by_key(|component| component.number);
    let mut alike = true;
    components.dedup_by(|component, region| {
        let is_same = component.number == region.number;
        if is_same {
            alike &=
                (component.depth, component.marks.has(Marks::HOLE)) == (region.depth, region.marks.has(Marks::HOLE));
            region.marks.add(component.marks);
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

impl Totals {
    pub(super) fn new(claims: &Claims) -> Self {
        Self {
            spanning: vec![(0, Marks::default()); claims.spanning as usize],
            locals: 0,
            sum: 0,
            local_holes: 0,
        }
    }

    pub(super) fn add(&mut self, report: &Report) -> Result<(), Fault> {
        self.locals += report.locals;
        self.sum = self.sum.wrapping_add(report.sum);
        self.local_holes += report.local_holes;
        for region in &report.spanning {
            let (depth, marks) = &mut self.spanning[region.number as usize];
            if !marks.has(Marks::SEEN) {
                *depth = region.depth;
            } else if (*depth, marks.has(Marks::HOLE)) != (region.depth, region.marks.has(Marks::HOLE)) {
                return Err(Fault::new(format!(
                    "it differs from others in the depth of region {}, or in whether it is a hole",
                    region.number
                )));
            }
            marks.add(region.marks);
        }
        Ok(())
    }

    /// Checks what no tile can tell alone.
    pub(super) fn check(&self, claims: &Claims, metadata: &Metadata) -> Result<(), Damage> {
        let mut holes = self.local_holes;
        for (&(depth, marks), number) in self.spanning.iter().zip(0..) {
            if !marks.has(Marks::SEEN) {
                return Err(Damage::new(format!("region {number} has no triangles")));
            }
            claims.check_hole(number, depth, marks)?;
            holes += u64::from(marks.has(Marks::HOLE));
        }
        let sum = || (claims.spanning..claims.regions).map(hash).fold(0, u128::wrapping_add);
        if self.locals != claims.regions - claims.spanning || self.sum != sum() {
            return Err(Damage::new(format!(
                "regions from {} to {} should lie in one tile each, and each should be there",
                claims.spanning, claims.regions
            )));
        }
        if holes != metadata.hole_regions {
            let expected = metadata.hole_regions;
            return Err(Damage::new(format!(
                "{holes} regions are holes, and the directory says {expected}"
            )));
        }
        Ok(())
    }
}
