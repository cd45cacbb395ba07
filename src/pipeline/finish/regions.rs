//! Regions: triangles that are connected without passing a constraint, and which of them are holes.
//!
//! In: of each tile its late triangles, the open sides of its core, its constraint edges and the anchors of its components. Out:
//! the region of every triangle, by how many obstacles it is covered, and whether it is a hole.
//!
//! Nothing is searched: a union-find joins what lies side by side. Its *nodes* are late triangles, by their number in the border
//! log, and the open [components](crate::pipeline::conquer::components) of cores; closed ones are regions of their own. A second one, weighted,
//! joins them across constraints too, with the change of depth there, and with the outside, whose depth is 0. Each edge is
//! looked at in the tile that owns it, which has the triangles on both of its sides.
//!
//! Regions are numbered in the order in which they are met, tile by tile, so that their numbers do not depend on who was
//! faster; closed components come behind all others.

use std::ops::Range;

use crate::collections::union_find::{UnionFind, WeightedUnionFind};
use crate::constraints::seeds::{HoleRules, Seeds};
use crate::pipeline::finish::border_mesh::BorderMesh;
use crate::pipeline::output::border_log::GroupBorders;
use crate::pipeline::records::{Anchor, TileState};
use crate::store::{Component, EdgeSource, TileId};

/// Which nodes are those of a tile.
#[derive(Clone, Debug)]
struct Nodes {
    late: u32,
    /// For each tile its first open component among all.
    first_open: Vec<u32>,
    outside: u32,
}

/// Two nodes side by side.
#[derive(Clone, Copy, Debug)]
struct Link {
    /// On the left and on the right of an edge.
    nodes: [u32; 2],
    is_constraint: bool,
    /// By how much the left is deeper.
    change: i32,
    source: Option<EdgeSource>,
}

/// What the regions of a tile have to do with others.
#[derive(Debug, Default)]
pub(crate) struct TileLinks {
    /// Late triangles, in an order that depends on their corners alone; and whether a seed lies in each.
    late: Vec<(u32, bool)>,
    links: Vec<Link>,
    anchors: Vec<Anchor>,
}

impl Nodes {
    fn new(late: u64, tiles: &[TileState]) -> Option<Self> {
        let mut next = u32::try_from(late).ok()?;
        let late = next;
        let mut first_open = Vec::with_capacity(tiles.len());
        for tile in tiles {
            first_open.push(next);
            next = next.checked_add(tile.open_components)?;
        }
        next.checked_add(1)?;
        Some(Self {
            late,
            first_open,
            outside: next,
        })
    }

    fn of_component(&self, tile: TileId, component: u32) -> u32 {
        self.first_open[tile.0 as usize] + component
    }
}

/// Finds regions: takes the links of all tiles in order.
#[derive(Debug)]
pub(crate) struct RegionFinder {
    nodes: Nodes,
    rules: HoleRules,
    regions: UnionFind,
    depths: Option<WeightedUnionFind>,
    /// When each node was met first.
    met: Vec<u32>,
    next: u32,
    /// Whether each node reaches the hull without a constraint, and whether a seed lies in it.
    reaches_hull: Vec<bool>,
    seeded: Vec<bool>,
}

impl RegionFinder {
    /// Bytes for each late triangle and each open component.
    pub(crate) const BYTES: u64 = 24;

    /// Of so many late triangles, and of tiles that are all conquered. None: there are more than can be numbered.
    pub(crate) fn new(late: u64, tiles: &[TileState], rules: HoleRules) -> Option<Self> {
        let nodes = Nodes::new(late, tiles)?;
        let count = nodes.outside + 1;
        let none = || vec![false; if rules.has_holes { count as usize } else { 0 }];
        Some(Self {
            rules,
            regions: UnionFind::new(count),
            depths: rules.has_holes.then(|| WeightedUnionFind::new(count)),
            met: vec![u32::MAX; count as usize],
            next: 0,
            reaches_hull: none(),
            seeded: none(),
            nodes,
        })
    }

    /// What lies side by side along the edges that belong to a tile.
    pub(crate) fn links_of(&self, tile: TileId, mesh: &BorderMesh, group: &GroupBorders, seeds: &Seeds) -> TileLinks {
        let mut seeded: Vec<u32> = Vec::new();
        if self.rules.has_holes {
            let late = group.triangles_of(tile);
            let in_seeded = late.filter(|late| seeds.any_in(late.corners.map(|v| v.point)));
            seeded.extend(in_seeded.map(|late| late.number));
            seeded.sort_unstable();
        }
        let is_seeded = |number: u32| seeded.binary_search(&number).is_ok();
        let mut changes = self.changes(tile, group, mesh).into_iter().peekable();
        let mut links = Vec::with_capacity(mesh.sides.len() / 2);
        for on_edge in mesh.edges().filter(|on_edge| mesh.is_own_edge(&on_edge[0])) {
            let edge = on_edge[0].edge;
            while changes.next_if(|(other, ..)| *other < edge).is_some() {}
            let (change, source) = match changes.next_if(|(other, ..)| *other == edge) {
                Some((_, change, source)) => (change, Some(source)),
                None => (0, None),
            };
            let mut nodes = [self.nodes.outside; 2];
            for side in on_edge {
                let is_backward = mesh.from(side) != edge[0];
                nodes[usize::from(is_backward)] = match mesh.within(side) {
                    Ok(late) => late,
                    Err(component) => self.nodes.of_component(tile, component),
                };
            }
            links.push(Link {
                nodes,
                is_constraint: mesh.is_constraint(&on_edge[0]),
                change,
                source,
            });
        }
        TileLinks {
            late: mesh
                .late
                .iter()
                .map(|late| (late.number, is_seeded(late.number)))
                .collect(),
            links,
            anchors: group.anchors_of(tile).collect(),
        }
    }

    /// The changes of depth along the constraint edges of a tile, from the smaller corner to the other, in order; with a source.
    fn changes(&self, tile: TileId, group: &GroupBorders, mesh: &BorderMesh) -> Vec<([u32; 2], i32, EdgeSource)> {
        if !self.rules.has_holes {
            return Vec::new();
        }
        let edges = group.edges_of(tile).map(|(ends, source)| {
            let [from, to] = ends.map(|id| mesh.corner(id));
            match from < to {
                true => ([from, to], source.depth_change(), source),
                false => ([to, from], source.reversed().depth_change(), source.reversed()),
            }
        });
        let mut edges: Vec<_> = edges.collect();
        edges.sort_unstable();
        edges.dedup_by(|next, kept| {
            let is_same = next.0 == kept.0;
            if is_same {
                kept.1 += next.1;
            }
            is_same
        });
        edges
    }

    /// Takes the links of the next tile. The components that seeds lie in are among its `seeded` ones.
    ///
    /// An error is a ring that does not close.
    pub(crate) fn take(
        &mut self,
        tile: TileId,
        state: &TileState,
        links: &TileLinks,
        seeded: &[u32],
    ) -> Result<(), Option<EdgeSource>> {
        let open = (0..state.open_components).map(|component| (self.nodes.of_component(tile, component), false));
        for (node, is_seeded) in open.chain(links.late.iter().copied()) {
            if self.met[node as usize] == u32::MAX {
                self.met[node as usize] = self.next;
                self.next += 1;
            }
            if is_seeded {
                self.seeded[node as usize] = true;
            }
        }
        for &component in seeded.iter().filter(|&&component| component < state.open_components) {
            let node = self.nodes.of_component(tile, component);
            self.seeded[node as usize] = true;
        }
        for (anchor, component) in links.anchors.iter().zip(0..state.open_components) {
            let [node, other] = [component, anchor.component].map(|c| self.nodes.of_component(tile, c));
            if let Some(depths) = &mut self.depths {
                depths.union(node, other, anchor.deeper);
            }
        }
        for link in &links.links {
            let [left, right] = link.nodes;
            let is_hull = left == self.nodes.outside || right == self.nodes.outside;
            if is_hull && !link.is_constraint && self.rules.has_holes {
                let inside = if left == self.nodes.outside { right } else { left };
                self.reaches_hull[inside as usize] = true;
            }
            if !is_hull && !link.is_constraint {
                self.regions.union(left, right);
            }
            if let Some(depths) = &mut self.depths
                && !depths.union(left, right, link.change)
            {
                return Err(link.source);
            }
        }
        Ok(())
    }

    /// Numbers the regions.
    pub(crate) fn finish(mut self, tiles: &[TileState]) -> Regions {
        let nodes = self.nodes.outside;
        let mut first_met = vec![u32::MAX; nodes as usize];
        for node in 0..nodes {
            let root = self.regions.find(node) as usize;
            first_met[root] = first_met[root].min(self.met[node as usize]);
        }
        let mut roots: Vec<u32> = (0..nodes).filter(|&node| self.regions.find(node) == node).collect();
        roots.sort_unstable_by_key(|&root| first_met[root as usize]);
        let mut number = first_met;
        for (&root, region) in roots.iter().zip(0..) {
            number[root as usize] = region;
        }
        // The places of roots hold their numbers already, and no root is passed twice.
        for node in 0..nodes {
            let root = self.regions.find(node);
            number[node as usize] = number[root as usize];
        }
        let mut of_regions = vec![Component::default(); roots.len()];
        if let Some(depths) = &mut self.depths {
            let (_, outside) = depths.find(self.nodes.outside);
            for node in 0..nodes {
                let region = &mut of_regions[number[node as usize] as usize];
                region.depth = depths.find(node).1 - outside;
                let (is_seeded, reaches_hull) = (self.seeded[node as usize], self.reaches_hull[node as usize]);
                region.is_hole |= self.rules.is_hole(region.depth, is_seeded, reaches_hull);
            }
        }
        for (region, number) in of_regions.iter_mut().zip(0..) {
            region.region = number;
        }
        let mut first_closed = Vec::with_capacity(tiles.len());
        let mut next = of_regions.len() as u64;
        for tile in tiles {
            first_closed.push(next);
            next += u64::from(tile.components - tile.open_components);
        }
        Regions {
            nodes: self.nodes,
            number,
            of_regions,
            first_closed,
            count: next,
        }
    }
}

/// The regions of all triangles.
#[derive(Debug)]
pub(crate) struct Regions {
    nodes: Nodes,
    /// That of each node.
    number: Vec<u32>,
    of_regions: Vec<Component>,
    /// For each tile the region of its first closed component.
    first_closed: Vec<u64>,
    pub(crate) count: u64,
}

impl Regions {
    /// Those that may lie in several tiles, which are the first.
    pub(crate) fn spanning(&self) -> &[Component] {
        &self.of_regions
    }

    /// That of a late triangle.
    pub(crate) fn of_late(&self, number: u32) -> Component {
        debug_assert!(number < self.nodes.late);
        self.of_regions[self.number[number as usize] as usize]
    }

    /// Those of the components of a tile's core.
    pub(crate) fn of_core(
        &self,
        tile: TileId,
        state: &TileState,
        anchors: &[Anchor],
        seeded: &[u32],
    ) -> Vec<Component> {
        let of_open = |component: u32| {
            let node = self.nodes.of_component(tile, component);
            self.of_regions[self.number[node as usize] as usize]
        };
        let open: Range<u32> = 0..state.open_components;
        let closed = (open.end..state.components).zip(self.first_closed[tile.0 as usize]..);
        let closed = closed.map(|(component, region)| {
            let depth = anchors
                .get(component as usize)
                .map_or(0, |anchor| of_open(anchor.component).depth + anchor.deeper);
            Component {
                region,
                depth,
                is_hole: depth != 0 || seeded.binary_search(&component).is_ok(),
            }
        });
        open.map(of_open).chain(closed).collect()
    }
}
