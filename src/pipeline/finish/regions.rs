//! Regions: maximal sets of triangles that are connected without passing a constraint, and which of
//! them are holes.
//!
//! In: for each tile its late triangles, the boundary half-edges of its core, its constraint edges
//! and the anchors of its components. Out: for every triangle its region, the number of obstacles
//! that cover it, and whether it is a hole.
//!
//! Nothing is searched: a union-find joins neighbours. Its *nodes* are the late triangles, by their
//! number in the border log, and the open [components](crate::pipeline::conquer::components) of
//! cores. Closed components are regions of their own. A second, weighted union-find joins the nodes
//! across constraints too, with the change of depth there, and joins them with the outside, whose
//! depth is 0. Each edge is examined in the tile that owns it, which has the triangles of both
//! half-edges.
//!
//! Regions are numbered in the order in which they are first visited, tile by tile, so that the
//! numbers do not depend on the timing of threads. Closed components come after all others.

use std::ops::Range;

use crate::collections::union_find::{UnionFind, WeightedUnionFind};
use crate::constraints::seeds::{HoleRules, Seeds};
use crate::pipeline::finish::border_mesh::BorderMesh;
use crate::pipeline::finish::tile_components::TileComponents;
use crate::pipeline::output::border_log::GroupBorders;
use crate::pipeline::records::{Anchor, LoggedEdge, TileState};
use crate::store::{Component, EdgeSource, TileId};

/// The numbers of the nodes of each tile.
#[derive(Clone, Debug)]
struct NodeNumbers {
    late: u32,
    /// For each tile, the node of its first open component.
    first_open: Vec<u32>,
    outside: u32,
}

/// Two nodes that share an edge.
#[derive(Clone, Copy, Debug)]
struct NodeLink {
    /// The nodes on the left and on the right of the edge.
    nodes: [u32; 2],
    is_constraint: bool,
    /// Depth of the left node less that of the right one.
    change: i32,
    source: Option<EdgeSource>,
}

/// The links between the nodes of a tile.
#[derive(Debug, Default)]
pub(crate) struct TileLinks {
    /// The late triangles, in an order that depends on their corners alone, and whether each
    /// contains a seed.
    late: Vec<(u32, bool)>,
    links: Vec<NodeLink>,
    anchors: Vec<Anchor>,
    /// For each late triangle that belongs to the tile, its component in the tile.
    components: Vec<(u32, u32)>,
}

impl NodeNumbers {
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

/// Finds regions. It takes the links of all tiles in order.
#[derive(Debug)]
pub(crate) struct RegionFinder {
    nodes: NodeNumbers,
    rules: HoleRules,
    regions: UnionFind,
    depths: Option<WeightedUnionFind>,
    /// For each node, when it was first visited.
    met: Vec<u32>,
    next: u32,
    /// For each node, whether it reaches the hull without passing a constraint, and whether it
    /// contains a seed.
    reaches_hull: Vec<bool>,
    seeded: Vec<bool>,
    /// For each late triangle, its component in the tile that it belongs to.
    at_owner: Vec<u32>,
}

impl RegionFinder {
    /// Bytes for each late triangle and each open component.
    pub(crate) const BYTES: u64 = 28;

    /// Creates a finder for `late` late triangles and for `tiles`, which are all conquered. Returns
    /// `None` if there are more nodes than can be numbered.
    pub(crate) fn new(late: u64, tiles: &[TileState], rules: HoleRules) -> Option<Self> {
        let nodes = NodeNumbers::new(late, tiles)?;
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
            at_owner: vec![0; nodes.late as usize],
            nodes,
        })
    }

    /// Returns the links across the edges that belong to `tile`.
    pub(crate) fn links_of(
        &self,
        (tile, state): (TileId, &TileState),
        mesh: &BorderMesh,
        group: &GroupBorders,
        seeds: &Seeds,
    ) -> TileLinks {
        let mut seeded: Vec<u32> = Vec::new();
        if self.rules.has_holes {
            let late = group.triangles_of(tile);
            let in_seeded = late.filter(|late| seeds.any_in(late.corners.map(|v| v.point)));
            seeded.extend(in_seeded.map(|late| late.number));
            seeded.sort_unstable();
        }
        let is_seeded = |number: u32| seeded.binary_search(&number).is_ok();
        let mut changes = self.changes(tile, group, mesh).into_iter().peekable();
        let mut links = Vec::with_capacity(mesh.half_edges.len() / 2);
        for on_edge in mesh.edges().filter(|on_edge| mesh.is_own_edge(&on_edge[0])) {
            let edge = on_edge[0].ends;
            while changes.next_if(|(other, ..)| *other < edge).is_some() {}
            let (change, source) = match changes.next_if(|(other, ..)| *other == edge) {
                Some((_, change, source)) => (change, Some(source)),
                None => (0, None),
            };
            let mut nodes = [self.nodes.outside; 2];
            for keyed in on_edge {
                let is_backward = mesh.from(keyed) != edge[0];
                nodes[usize::from(is_backward)] = match mesh.within(keyed) {
                    Ok(late) => late,
                    Err(component) => self.nodes.of_component(tile, component),
                };
            }
            links.push(NodeLink {
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
            components: own_late_components(mesh, state),
        }
    }

    /// Returns the changes of depth across the constraint edges of `tile`, each seen from the
    /// smaller corner to the larger one, sorted, each with one of its sources.
    fn changes(&self, tile: TileId, group: &GroupBorders, mesh: &BorderMesh) -> Vec<([u32; 2], i32, EdgeSource)> {
        if !self.rules.has_holes {
            return Vec::new();
        }
        let edges = group.edges_of(tile).map(|LoggedEdge { ends, source: part, .. }| {
            let source = part.source();
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

    /// Takes the links of the next tile. `seeded` lists the components of its core that contain
    /// seeds.
    ///
    /// # Errors
    /// Returns a source of the edge at which a ring does not close.
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
        for &(late, component) in &links.components {
            self.at_owner[late as usize] = component;
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
        // A resumed build leaves out numbers of late triangles. No tile has these.
        let is_used = |node: u32| first_met[node as usize] != u32::MAX;
        let is_root = |&node: &u32| self.regions.find(node) == node;
        let mut roots: Vec<u32> = (0..nodes).filter(|&node| is_used(node)).filter(is_root).collect();
        roots.sort_unstable_by_key(|&root| first_met[root as usize]);
        let mut number = first_met;
        for (&root, region) in roots.iter().zip(0..) {
            number[root as usize] = region;
        }
        // The entries of roots hold their numbers already, and no root is visited twice.
        for node in 0..nodes {
            let root = self.regions.find(node);
            number[node as usize] = number[root as usize];
        }
        let mut of_regions = vec![Component::default(); roots.len()];
        if let Some(depths) = &mut self.depths {
            let (_, outside) = depths.find(self.nodes.outside);
            for node in (0..nodes).filter(|&node| number[node as usize] != u32::MAX) {
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
            seeded: self.seeded,
            at_owner: self.at_owner,
        }
    }
}

/// Returns the number of each late triangle that belongs to a tile, with its component.
fn own_late_components(mesh: &BorderMesh, state: &TileState) -> Vec<(u32, u32)> {
    let components = TileComponents::of(mesh, state);
    let late = mesh.late.iter().zip(components.of_late);
    late.filter(|(late, _)| mesh.owns(late))
        .map(|(late, component)| (late.number, component))
        .collect()
}

/// The regions of all triangles.
#[derive(Debug)]
pub(crate) struct Regions {
    nodes: NodeNumbers,
    /// For each node, the number of its region.
    number: Vec<u32>,
    of_regions: Vec<Component>,
    /// For each tile, the region of its first closed component.
    first_closed: Vec<u64>,
    pub(crate) count: u64,
    seeded: Vec<bool>,
    at_owner: Vec<u32>,
}

impl Regions {
    /// Returns the regions that may extend over several tiles, which are numbered first.
    pub(crate) fn spanning(&self) -> &[Component] {
        &self.of_regions
    }

    /// Returns the region of the late triangle `number`.
    pub(crate) fn of_late(&self, number: u32) -> Component {
        debug_assert!(number < self.nodes.late);
        self.of_regions[self.number[number as usize] as usize]
    }

    /// Returns whether a seed lies in the late triangle `number`.
    pub(crate) fn is_seeded(&self, number: u32) -> bool {
        self.seeded.get(number as usize).is_some_and(|&is_seeded| is_seeded)
    }

    /// Returns the component of the late triangle `number` in the tile that it belongs to.
    pub(crate) fn component_at_owner(&self, number: u32) -> u32 {
        self.at_owner[number as usize]
    }

    /// Returns the regions of the components of a tile's core.
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
