//! The regions of an edited file: a pass over all tiles joins adjacent triangles.
//!
//! In: the tiles, in order, twice. Out: for each triangle its region, the number of obstacles that
//! cover it, and whether it is in a hole. This works as in a
//! [build](crate::pipeline::finish::regions), but here the nodes that are joined are the parts of a
//! tile that no constraint passes through. A triangle that several tiles store joins parts of these
//! tiles. It is remembered until the last of them has come.
//!
//! Regions keep their former numbers as far as these are still free. So tiles that are not affected
//! need not be written again.

use foldhash::{HashMap, HashMapExt};

use crate::collections::union_find::{UnionFind, WeightedUnionFind};
use crate::constraints::seeds::{HoleRules, Seeds};
use crate::edit::error::EditError;
use crate::edit::tile::EditTile;
use crate::geometry::{HalfEdge, TriangleId};
use crate::mesh::{Topology, Twin};
use crate::store::{Component, Directory, EdgeSource, Metadata, Tile, TileId, VertexId};

/// The number of a region that had none.
const NEW: u64 = u64::MAX;

/// The parts of a tile: the part of each triangle, and the number of parts.
pub(crate) struct TileParts {
    of_triangles: Vec<u32>,
    count: u32,
}

impl TileParts {
    /// Finds the parts of a tile. They are numbered by their first triangles.
    pub(crate) fn of(tile: &EditTile) -> Self {
        let (order, _) = tile.in_order();
        let triangle_count = tile.triangle_count();
        let mut sets = UnionFind::new(triangle_count);
        for &triangle in &order {
            for half_edge in HalfEdge::of_triangle(triangle) {
                if let Twin::HalfEdge(twin) = tile.twin(half_edge)
                    && twin < half_edge
                    && !tile.is_constraint(half_edge)
                {
                    sets.union(triangle.0, twin.triangle().0);
                }
            }
        }
        let mut this = Self {
            // Entries of removed triangles mean nothing.
            of_triangles: vec![0; triangle_count as usize],
            count: 0,
        };
        let mut of_sets = vec![None; triangle_count as usize];
        for &triangle in &order {
            this.of_triangles[triangle.index()] = *of_sets[sets.find(triangle.0) as usize].get_or_insert_with(|| {
                this.count += 1;
                this.count - 1
            });
        }
        this
    }
}

/// The known properties of a region.
#[derive(Clone, Copy, Default)]
struct RegionMarks {
    /// Whether it may extend over several tiles.
    is_spanning: bool,
    is_seeded: bool,
    reaches_hull: bool,
}

/// The join of parts, which takes all tiles in order.
pub(crate) struct RegionJoin {
    /// Node 0 is the outside.
    regions: UnionFind,
    depths: WeightedUnionFind,
    marks: Vec<RegionMarks>,
    /// The former region number of each part, or [`NEW`].
    previous: Vec<u64>,
    /// The first part of each tile, by its number.
    first: Vec<u32>,
    /// Triangles of several tiles some of which have not come: one of their parts, and the number
    /// of tiles that are left.
    waiting: HashMap<[VertexId; 3], (u32, u8)>,
    seeds: Seeds,
    rules: HoleRules,
    pub(crate) constraint_edges: u64,
}

impl RegionJoin {
    /// Bytes of memory of each part.
    pub(crate) const BYTES: u64 = 32;

    pub(crate) fn new(directory: &Directory) -> Self {
        Self {
            regions: UnionFind::new(1),
            depths: WeightedUnionFind::new(1),
            marks: vec![RegionMarks::default()],
            previous: vec![0],
            first: vec![0; directory.tiles.len()],
            waiting: HashMap::new(),
            seeds: Seeds::new(directory.lists.hole_points.clone()),
            rules: HoleRules {
                has_holes: true,
                exterior: directory.metadata.exterior_is_hole,
            },
            constraint_edges: 0,
        }
    }

    /// Returns the bytes of memory that it takes.
    pub(crate) fn byte_size(&self) -> u64 {
        self.marks.len() as u64 * Self::BYTES + 64 * self.waiting.len() as u64
    }

    /// Adds the next tile. `before` is the tile in the file, if it is unchanged.
    ///
    /// Returns an error if a ring does not close, with the line of one of its edges.
    pub(crate) fn take(&mut self, tile: &EditTile, parts: &TileParts, before: Option<&Tile>) -> Result<(), EditError> {
        let first = self.marks.len() as u32;
        self.first[tile.id.0 as usize] = first;
        let end = first
            .checked_add(parts.count)
            .ok_or_else(|| EditError::Internal("too many parts".to_owned()))?;
        self.regions.grow(parts.count);
        self.depths.grow(parts.count);
        self.marks.resize(end as usize, RegionMarks::default());
        self.previous.resize(end as usize, NEW);
        let node = |triangle: TriangleId| first + parts.of_triangles[triangle.index()];
        let (order, core_count) = tile.in_order();
        if let Some(before) = before {
            // In an unchanged tile, triangles have the same numbers as in the file.
            for &triangle in &order {
                let previous = &mut self.previous[node(triangle) as usize];
                *previous = (*previous).min(before.region(triangle));
            }
        }
        for &triangle in &order[core_count..] {
            self.join_across_tiles(tile, triangle, node(triangle));
        }
        self.seed(tile, &order, node);
        for &triangle in &order {
            for half_edge in HalfEdge::of_triangle(triangle) {
                if tile.twin(half_edge) == Twin::Hull && !tile.is_constraint(half_edge) {
                    self.marks[node(triangle) as usize].reaches_hull = true;
                    // Without a constraint in between, the region is as deep as the outside.
                    self.deepen([node(triangle), 0], 0, None)?;
                }
            }
        }
        for (half_edge, sources) in tile.owned_constraints() {
            self.constraint_edges += 1;
            let left = node(half_edge.triangle());
            let twin = tile.twin(half_edge).half_edge();
            let right = twin.map_or(0, |twin| node(twin.triangle()));
            // Sources are seen from the smaller corner.
            let is_against = tile.origin(half_edge) > tile.destination(half_edge);
            let change: i32 = sources.iter().map(|source| source.depth_change()).sum();
            self.deepen(
                [left, right],
                if is_against { -change } else { change },
                sources.first().map(|part| part.source()),
            )?;
        }
        Ok(())
    }

    fn deepen(&mut self, [left, right]: [u32; 2], change: i32, source: Option<EdgeSource>) -> Result<(), EditError> {
        if self.depths.union(left, right, change) {
            return Ok(());
        }
        Err(EditError::OpenRing {
            line: source.map_or(0, |source| source.number()),
        })
    }

    /// Joins the parts of several tiles that have a triangle in common.
    fn join_across_tiles(&mut self, tile: &EditTile, triangle: TriangleId, node: u32) {
        let (corners, _) = tile.triangle(HalfEdge::new(triangle, 0));
        let mut ids = corners.map(|vertex| vertex.id);
        if ids.iter().all(|id| id.tile == tile.id) {
            return;
        }
        self.marks[node as usize].is_spanning = true;
        ids.sort_unstable();
        let more_tiles = 1 + u8::from(ids[0].tile != ids[1].tile && ids[1].tile != ids[2].tile);
        let Some((other, left)) = self.waiting.get_mut(&ids) else {
            self.waiting.insert(ids, (node, more_tiles));
            return;
        };
        let other = *other;
        *left -= 1;
        if *left == 0 {
            self.waiting.remove(&ids);
        }
        self.regions.union(node, other);
        // Both are parts of one region.
        self.depths.union(node, other, 0);
    }

    fn seed(&mut self, tile: &EditTile, order: &[TriangleId], node: impl Fn(TriangleId) -> u32) {
        if self.seeds.is_empty() {
            return;
        }
        for &triangle in order {
            let (corners, _) = tile.triangle(HalfEdge::new(triangle, 0));
            if self.seeds.any_in(corners.map(|vertex| vertex.point)) {
                self.marks[node(triangle) as usize].is_seeded = true;
            }
        }
    }

    /// Numbers the regions. `metadata` has the former number of regions that might extend over
    /// several tiles.
    pub(crate) fn finish(mut self, metadata: &Metadata) -> Result<RegionLabels, EditError> {
        if !self.waiting.is_empty() {
            return Err(EditError::Internal(
                "a triangle is missing in one of its tiles".to_owned(),
            ));
        }
        let nodes = self.marks.len() as u32;
        let mut roots = Vec::new();
        for node in 1..nodes {
            let root = self.regions.find(node);
            if root == node {
                roots.push(root);
                continue;
            }
            let marks = self.marks[node as usize];
            let of_root = &mut self.marks[root as usize];
            of_root.is_spanning |= marks.is_spanning;
            of_root.is_seeded |= marks.is_seeded;
            of_root.reaches_hull |= marks.reaches_hull;
            self.previous[root as usize] = self.previous[root as usize].min(self.previous[node as usize]);
        }
        let numbers = number_regions(&roots, &self.marks, &self.previous, metadata);
        let mut of_regions = vec![Component::default(); nodes as usize];
        let mut labels = RegionLabels {
            first: self.first,
            of_parts: Vec::new(),
            regions: roots.len() as u64,
            spanning: numbers.spanning,
            hole_regions: 0,
        };
        let (_, outside) = self.depths.find(0);
        for (&root, &region) in roots.iter().zip(&numbers.of_roots) {
            let depth = self.depths.find(root).1 - outside;
            let marks = self.marks[root as usize];
            let is_hole = self.rules.is_hole(depth, marks.is_seeded, marks.reaches_hull);
            labels.hole_regions += u64::from(is_hole);
            of_regions[root as usize] = Component { region, depth, is_hole };
        }
        labels.of_parts = (0..nodes)
            .map(|node| of_regions[self.regions.find(node) as usize])
            .collect();
        Ok(labels)
    }
}

struct RegionNumbers {
    of_roots: Vec<u64>,
    spanning: u64,
}

/// Numbers regions. Those that may extend over several tiles get the first numbers. Each region
/// keeps its former number where possible.
fn number_regions(roots: &[u32], marks: &[RegionMarks], previous: &[u64], metadata: &Metadata) -> RegionNumbers {
    let count = roots.len() as u64;
    let spanning_now = roots.iter().filter(|&&root| marks[root as usize].is_spanning).count() as u64;
    let spanning = spanning_now.max(metadata.spanning_regions.min(count));
    let mut is_taken = vec![false; roots.len()];
    let mut of_roots = vec![None; roots.len()];
    for (&root, number) in roots.iter().zip(&mut of_roots) {
        let wanted = previous[root as usize];
        let fits = wanted < count && (wanted < spanning || !marks[root as usize].is_spanning);
        if fits && !is_taken[wanted as usize] {
            is_taken[wanted as usize] = true;
            *number = Some(wanted);
        }
    }
    // Spanning regions take free numbers first. Theirs must be among the first numbers, so other
    // regions may have to give these up.
    let mut low = 0;
    let mut displaced = Vec::new();
    let mut holder: HashMap<u64, usize> = HashMap::new();
    for (index, number) in of_roots.iter().enumerate() {
        if let Some(number) = number.filter(|number| *number < spanning)
            && !marks[roots[index] as usize].is_spanning
        {
            holder.insert(number, index);
        }
    }
    for index in 0..roots.len() {
        if of_roots[index].is_some() || !marks[roots[index] as usize].is_spanning {
            continue;
        }
        while low < spanning && is_taken[low as usize] && !holder.contains_key(&low) {
            low += 1;
        }
        if let Some(other) = holder.remove(&low) {
            displaced.push(other);
        }
        is_taken[low as usize] = true;
        of_roots[index] = Some(low);
        low += 1;
    }
    for &index in &displaced {
        of_roots[index] = None;
    }
    let mut free = (0..count).filter(|&number| !is_taken[number as usize]);
    let of_roots = of_roots
        .into_iter()
        .map(|number| number.or_else(|| free.next()).unwrap_or(NEW));
    RegionNumbers {
        of_roots: of_roots.collect(),
        spanning,
    }
}

/// The properties of the regions of all triangles.
pub(crate) struct RegionLabels {
    first: Vec<u32>,
    of_parts: Vec<Component>,
    pub(crate) regions: u64,
    pub(crate) spanning: u64,
    pub(crate) hole_regions: u64,
}

impl RegionLabels {
    /// Returns the properties of the region of a triangle.
    pub(crate) fn of(&self, tile: TileId, parts: &TileParts, triangle: TriangleId) -> Component {
        let node = self.first[tile.0 as usize] + parts.of_triangles[triangle.index()];
        self.of_parts[node as usize]
    }
}
