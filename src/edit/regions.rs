//! The regions of an edited file.
//!
//! In: the component tables of the tiles that are as they were, and the *fresh* tiles themselves:
//! those that were changed, and in a draft, which has no tables yet, all. Out: the component tables
//! of all tiles.
//!
//! The nodes that are joined are the components of all tiles. Components of one region are linked
//! within a tile, and between tiles by the triangles that both store. Links between tiles that are
//! as they were are in their tables. Links with fresh tiles follow from the triangles that these
//! share with others, so the neighbours of fresh tiles are read too.
//!
//! A second, weighted union-find joins components across constraints with the change of depth. In a
//! tile that is as it was, no constraint of this edit crosses the cell, which is convex. So
//! whatever this edit covers, it covers all components of the tile as many times, and the
//! differences of their depths stay the same.

use std::collections::BTreeSet;

use crate::collections::union_find::{UnionFind, WeightedUnionFind};
use crate::constraints::seeds::HoleRules;
use crate::edit::error::EditError;
use crate::edit::new_links::NewLinks;
use crate::edit::region_numbers::{NEW, ToNumber, number_regions};
use crate::edit::shared_triangles::SharedTriangles;
use crate::edit::survey::{DepthChange, SharedTriangle, TileSurvey};
use crate::store::{
    Component, ComponentId, ComponentRecord, DigestSum, Directory, EdgeSource, Metadata, Tile, TileId, component_table,
};

/// The node of the plane outside the hull.
const OUTSIDE: u32 = 0;
/// No obstacles cover a place more often.
const MAX_DEPTH: u32 = 1 << 24;

/// The join of components.
pub(crate) struct RegionJoin {
    regions: UnionFind,
    depths: WeightedUnionFind,
    /// The component table of each tile, by its number. In those of fresh tiles, regions and links
    /// are not known.
    tables: Vec<Vec<u8>>,
    /// The node of the first component of each tile, by its number.
    first: Vec<u32>,
    /// The number of components of each tile.
    counts: Vec<u32>,
    /// The tiles in the order of their nodes.
    order: Vec<TileId>,
    nodes: u32,
    /// Bytes of all tables.
    table_bytes: u64,
    is_fresh: Vec<bool>,
    shared: SharedTriangles,
    /// Links from and to components of fresh tiles.
    links: NewLinks,
    neighbours: BTreeSet<TileId>,
    rules: HoleRules,
}

impl RegionJoin {
    /// Creates a join. `is_fresh` says for each number whether it is that of a fresh tile.
    pub(crate) fn new(directory: &Directory, is_fresh: Vec<bool>) -> Self {
        let tiles = directory.tiles.len();
        Self {
            regions: UnionFind::new(1),
            depths: WeightedUnionFind::new(1),
            tables: vec![Vec::new(); tiles],
            first: vec![OUTSIDE; tiles],
            counts: vec![0; tiles],
            order: Vec::new(),
            nodes: 1,
            table_bytes: 0,
            is_fresh,
            shared: SharedTriangles::default(),
            links: NewLinks::default(),
            neighbours: BTreeSet::new(),
            rules: HoleRules {
                has_holes: true,
                exterior: directory.metadata.exterior_is_hole,
            },
        }
    }

    /// Returns the bytes of memory that it takes.
    pub(crate) fn byte_size(&self) -> u64 {
        let of_nodes = size_of::<[u32; 3]>() as u64 * u64::from(self.nodes);
        let of_tables = self.table_bytes + size_of::<Vec<u8>>() as u64 * self.tables.len() as u64;
        of_nodes + of_tables + self.shared.byte_size() + self.links.byte_size()
    }

    /// Returns whether a tile is fresh.
    pub(crate) fn is_fresh(&self, tile: TileId) -> bool {
        self.is_fresh.get(tile.0 as usize).is_some_and(|&is_fresh| is_fresh)
    }

    fn node(&self, id: ComponentId) -> u32 {
        self.first[id.tile.0 as usize] + id.number
    }

    /// Returns the component that a node stands for.
    fn component(&self, node: u32) -> ComponentId {
        let place = self.order.partition_point(|tile| self.first[tile.0 as usize] <= node);
        // Nodes follow the outside, so there is a tile before.
        let tile = self.order[place - 1];
        ComponentId {
            tile,
            number: node - self.first[tile.0 as usize],
        }
    }

    fn add_nodes(&mut self, tile: TileId, count: u32, table: Vec<u8>) -> Result<(), EditError> {
        let next = self.nodes.checked_add(count);
        let next = next.ok_or_else(|| EditError::Internal("too many components".to_owned()))?;
        self.first[tile.0 as usize] = std::mem::replace(&mut self.nodes, next);
        self.counts[tile.0 as usize] = count;
        self.regions.grow(count);
        self.depths.grow(count);
        self.table_bytes += table.len() as u64;
        self.tables[tile.0 as usize] = table;
        self.order.push(tile);
        Ok(())
    }

    /// Adds a tile that is as it was, with its component table. All such tiles come before the fresh
    /// ones.
    pub(crate) fn know(&mut self, tile: TileId, components: u32, table: Vec<u8>) -> Result<(), EditError> {
        self.add_nodes(tile, components, table)
    }

    /// Joins the components of all tiles that are as they were, once they are known.
    ///
    /// # Errors
    /// Returns a tile whose table contradicts itself or another one.
    pub(crate) fn join_known(&mut self) -> Result<(), TileId> {
        for place in 0..self.order.len() {
            let tile = self.order[place];
            self.join_table(tile).ok_or(tile)?;
        }
        Ok(())
    }

    /// Returns the records of a tile's table.
    fn records(&self, tile: TileId) -> Option<Vec<ComponentRecord>> {
        component_table::decode(tile, &self.tables[tile.0 as usize]).ok()
    }

    /// Joins the components of a table. Returns `None` if it contradicts itself or others.
    fn join_table(&mut self, tile: TileId) -> Option<()> {
        let records = self.records(tile)?;
        let base = records.first()?.component.depth;
        let first = self.first[tile.0 as usize];
        for (record, node) in records.iter().zip(first..) {
            let Component { depth, .. } = record.component;
            if depth.unsigned_abs() > MAX_DEPTH || !self.depths.union(node, first, depth - base) {
                return None;
            }
            if record.is_at_hull && !self.depths.union(node, OUTSIDE, depth) {
                return None;
            }
            for &link in &record.links {
                if self.is_fresh(link.tile) {
                    continue;
                }
                let other = self.known_node(link)?;
                self.regions.union(node, other);
                if !self.depths.union(node, other, 0) {
                    return None;
                }
            }
        }
        Some(())
    }

    /// Returns the node that a link in a table leads to, if there is one.
    fn known_node(&self, link: ComponentId) -> Option<u32> {
        let place = link.tile.0 as usize;
        let first = self.first.get(place).copied().filter(|&first| first != OUTSIDE)?;
        let count = self.counts[place];
        (link.number < count).then(|| first + link.number)
    }

    /// Adds a fresh tile.
    ///
    /// # Errors
    /// Returns an error if a ring does not close, with the line of one of its edges.
    pub(crate) fn take(&mut self, survey: TileSurvey) -> Result<(), EditError> {
        let TileSurvey { tile, parts, .. } = survey;
        self.add_nodes(tile, parts, survey.table)?;
        let first = self.first[tile.0 as usize];
        for link in survey.linked {
            let [part, other] = link.map(|part| first + part);
            self.regions.union(part, other);
            self.depths.union(part, other, 0);
            self.links.add([part, other]);
        }
        let known = survey.neighbours.into_iter().filter(|&other| !self.is_fresh(other));
        let known: Vec<TileId> = known.collect();
        self.neighbours.extend(known);
        for triangle in survey.shared {
            self.share(tile, triangle);
        }
        for (DepthChange { sides, change }, source) in survey.changes {
            let sides = sides.map(|part| part.map_or(OUTSIDE, |part| first + part));
            self.deepen(sides, change, source)?;
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

    /// Returns the tiles that share triangles with fresh tiles and are as they were.
    pub(crate) fn neighbours(&self) -> Vec<TileId> {
        self.neighbours.iter().copied().collect()
    }

    /// Adds the triangles that a neighbour of fresh tiles shares with these.
    pub(crate) fn meet(&mut self, tile: &Tile) {
        for triangle in tile.border_triangle_ids() {
            let corners = tile.vertices(triangle);
            if corners.iter().any(|vertex| self.is_fresh(vertex.id.tile)) {
                let corners = corners.map(|vertex| (vertex.id, vertex.point));
                self.share(tile.id(), SharedTriangle::of(corners, tile.component_number(triangle)));
            }
        }
    }

    /// Adds a triangle that may be in several tiles. The last of these joins their components.
    fn share(&mut self, tile: TileId, triangle: SharedTriangle) {
        for [other, at_owner] in self.shared.take(tile, triangle) {
            let nodes = [self.node(other), self.node(at_owner)];
            self.regions.union(nodes[0], nodes[1]);
            // Both are parts of one region.
            self.depths.union(nodes[0], nodes[1], 0);
            // Tables between tiles that are as they were have these links.
            if self.is_fresh(other.tile) || self.is_fresh(at_owner.tile) {
                self.links.add(nodes);
            }
        }
    }

    /// Numbers the regions. `metadata` has the former number of regions that might extend over
    /// several tiles.
    ///
    /// # Errors
    /// Returns a tile that lacks a triangle of another one.
    pub(crate) fn finish(mut self, metadata: &Metadata) -> Result<RegionLabels, TileId> {
        if let Some(tile) = self.shared.incomplete() {
            return Err(tile);
        }
        self.links.finish();
        let regions = self.joined();
        let to_number: Vec<ToNumber> = regions.all.iter().map(|region| region.to_number).collect();
        let numbers = number_regions(&to_number, metadata);
        let (_, outside) = self.depths.find(OUTSIDE);
        let mut components = Vec::with_capacity(regions.all.len());
        for (region, &number) in regions.all.iter().zip(&numbers.all) {
            let depth = self.depths.find(region.node).1.wrapping_sub(outside);
            components.push(Component {
                region: number,
                depth,
                is_hole: self.rules.is_hole(depth, region.is_seeded, region.is_open),
            });
        }
        let mut holes = DigestSum::default();
        let mut of_nodes = regions.of_nodes.iter();
        let with_components = self.order.iter().filter(|tile| self.counts[tile.0 as usize] > 0);
        for &tile in with_components {
            let mut records = self.records(tile).ok_or(tile)?;
            for (record, number) in records.iter_mut().zip(0..) {
                let Some(&region) = of_nodes.next() else { break };
                record.component = components[region as usize];
                if record.component.is_hole {
                    holes += record.triangles;
                }
                record.links.retain(|link| !self.is_fresh(link.tile));
                let node = self.first[tile.0 as usize] + number;
                record.links.extend(self.links.of(node).map(|to| self.component(to)));
                record.links.sort_unstable();
            }
            self.tables[tile.0 as usize] = component_table::encode(tile, &records);
        }
        Ok(RegionLabels {
            tables: self.tables,
            regions: components.len() as u64,
            spanning: numbers.spanning,
            hole_regions: components.iter().filter(|component| component.is_hole).count() as u64,
            holes,
        })
    }

    /// Returns the regions, in the order of their nodes.
    fn joined(&mut self) -> JoinedRegions {
        let mut regions = JoinedRegions {
            all: Vec::new(),
            of_nodes: Vec::with_capacity(self.nodes as usize),
        };
        let mut of_roots = vec![NONE; self.nodes as usize];
        let mut node = OUTSIDE;
        for &tile in &self.order {
            for record in self.records(tile).into_iter().flatten() {
                node += 1;
                let of_root = &mut of_roots[self.regions.find(node) as usize];
                if *of_root == NONE {
                    *of_root = regions.all.len() as u32;
                    regions.all.push(JoinedRegion::new(node));
                }
                regions.of_nodes.push(*of_root);
                let region = &mut regions.all[*of_root as usize];
                region.is_seeded |= record.is_seeded;
                region.is_open |= record.is_open;
                let ToNumber { previous, is_spanning } = &mut region.to_number;
                if !self.is_fresh(tile) {
                    *previous = record.component.region.min(*previous);
                }
                *is_spanning |= record.links.iter().any(|link| link.tile != tile);
            }
        }
        for &[from, to] in self.links.all() {
            if self.component(from).tile != self.component(to).tile {
                let region = of_roots[self.regions.find(from) as usize];
                regions.all[region as usize].to_number.is_spanning = true;
            }
        }
        regions
    }
}

/// No region yet.
const NONE: u32 = u32::MAX;

/// The regions that components are joined to.
struct JoinedRegions {
    all: Vec<JoinedRegion>,
    /// The region of each node after the outside.
    of_nodes: Vec<u32>,
}

/// A region, and what is known of it.
struct JoinedRegion {
    /// One of its nodes.
    node: u32,
    to_number: ToNumber,
    is_seeded: bool,
    is_open: bool,
}

impl JoinedRegion {
    fn new(node: u32) -> Self {
        Self {
            node,
            to_number: ToNumber {
                previous: NEW,
                is_spanning: false,
            },
            is_seeded: false,
            is_open: false,
        }
    }
}

/// The regions of all triangles. By default, nothing is known of them.
#[derive(Default)]
pub(crate) struct RegionLabels {
    /// The component table of each tile, by its number.
    pub(crate) tables: Vec<Vec<u8>>,
    pub(crate) regions: u64,
    pub(crate) spanning: u64,
    pub(crate) hole_regions: u64,
    /// The triangles in holes.
    pub(crate) holes: DigestSum,
}
