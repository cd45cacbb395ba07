//! The search along edges: Dijkstra's algorithm, or A* towards a single goal.

use foldhash::{HashMap, HashSet};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::corner::{Corner, GraphVertex, Within};
use super::node::Node;
use super::overlay::{Link, Overlay};
use super::sector::{sector, wedge};
use crate::geometry::{Point, VertexIndex};
use crate::query::answer::distance;
use crate::query::free_space::{FreeSpace, Mark, Wedge};
use crate::query::request::Contradiction;
use crate::store::{Tile, TileId, VertexId};

/// The outcome of a step.
#[derive(Debug)]
pub(crate) enum EdgeSearchStep {
    /// The search continues in this tile.
    Need(TileId),
    /// The number of the next nearest node.
    Found(u32),
    /// There are no more nodes.
    Done,
}

/// A waiting vertex. The nearest comes first; equally near ones are ordered by coordinates, then by
/// the previous node.
#[derive(Clone, Copy, Debug, PartialEq)]
struct QueueEntry {
    length: f64,
    /// The length plus the heuristic, if there is a goal.
    lower_bound: f64,
    vertex: GraphVertex,
    point: Point,
    parent: Option<u32>,
    /// The order of entries that are otherwise equal.
    rank: u32,
    /// The wedge; `None` for all sectors of the source.
    within: Option<Within>,
}

impl QueueEntry {
    fn order(&self, other: &Self) -> Ordering {
        let by_length = self.lower_bound.total_cmp(&other.lower_bound);
        let by_point = by_length.then_with(|| self.point.lex_cmp(other.point));
        // Entries of the source come last.
        let number = |entry: &Self| entry.parent.unwrap_or(u32::MAX);
        let by_parent = by_point.then(number(self).cmp(&number(other)));
        by_parent.then(self.rank.cmp(&other.rank))
    }
}

impl Eq for QueueEntry {}

impl Ord for QueueEntry {
    fn cmp(&self, other: &Self) -> Ordering {
        other.order(self)
    }
}

impl PartialOrd for QueueEntry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The goal of an A* search, and the weight of the heuristic.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Heuristic {
    pub(crate) point: Point,
    /// The factor of the straight-line distance to the goal. With 1 the search finds a shortest
    /// path. With more it finds a path that is longer by at most this factor, usually much sooner,
    /// although each node is settled once (Ebendt and Drechsler, "Weighted A* search: unifying view
    /// and application", Artificial Intelligence 173, 2009).
    pub(crate) weight: f64,
}

impl Heuristic {
    /// Returns the weighted distance from a point to the goal.
    fn ahead(self, point: Point) -> f64 {
        self.weight * distance(point, self.point)
    }
}

/// The state of a search.
#[derive(Debug)]
pub(crate) struct EdgeSearch {
    outside_is_free: bool,
    overlay: Overlay,
    links: HashMap<GraphVertex, Vec<Link>>,
    /// Nodes that are farther away are not wanted.
    limit: f64,
    /// The goal, if it is a single vertex.
    towards: Option<Heuristic>,
    queue: BinaryHeap<QueueEntry>,
    nodes: Vec<Node>,
    settled: HashSet<[GraphVertex; 2]>,
    /// For each vertex with one free sector that waits, the length of the path to it.
    waiting: HashMap<GraphVertex, f64>,
    /// The disc outside which nothing is wanted, if there is one.
    disc: Option<(Point, f64)>,
}

impl EdgeSearch {
    /// Creates a search from a vertex or an inserted point to all nodes.
    pub(crate) fn new(
        (source, point): (GraphVertex, Point),
        overlay: Overlay,
        towards: Option<Heuristic>,
        outside_is_free: bool,
    ) -> Self {
        let mut this = Self {
            outside_is_free,
            links: overlay.links(),
            overlay,
            limit: f64::INFINITY,
            towards,
            queue: BinaryHeap::new(),
            nodes: Vec::new(),
            settled: HashSet::default(),
            waiting: HashMap::default(),
            disc: None,
        };
        let start = |within| QueueEntry {
            length: 0.0,
            lower_bound: towards.map_or(0.0, |goal| goal.ahead(point)),
            vertex: source,
            point,
            parent: None,
            rank: if let Some(Within::Sector(sector)) = within {
                sector
            } else {
                0
            },
            within,
        };
        match this.overlay.point(source) {
            Some((_, sectors)) => this
                .queue
                .extend((0..sectors).map(|sector| start(Some(Within::Sector(sector))))),
            None => this.queue.push(start(None)),
        }
        this
    }

    /// Creates a search from a vertex in some of its wedges.
    #[cfg(feature = "baselines")]
    pub(crate) fn from_corners(corners: &[Corner], outside_is_free: bool) -> Self {
        let source = corners
            .first()
            .map_or((GraphVertex::inserted(0), Point::default()), |corner| {
                (corner.vertex, corner.point)
            });
        let mut this = Self::new(source, Overlay::default(), None, outside_is_free);
        this.queue.clear();
        this.queue
            .extend(corners.iter().zip(0..).map(|(corner, rank)| QueueEntry {
                length: 0.0,
                lower_bound: 0.0,
                vertex: corner.vertex,
                point: corner.point,
                parent: None,
                rank,
                within: Some(corner.within),
            }));
        this
    }

    /// From now on wants only vertices in a disc, with paths of at most `limit`. The search still
    /// finds other vertices on the way to them.
    #[cfg(feature = "baselines")]
    pub(crate) fn narrow(&mut self, limit: f64, center: Point, radius: f64) {
        self.limit = limit;
        self.disc = Some((center, radius));
    }

    /// Returns a lower bound of the lengths of all nodes that were not found yet.
    pub(crate) fn front(&self) -> f64 {
        let front = self.queue.peek().map_or(f64::INFINITY, |entry| entry.lower_bound);
        self.towards.map_or(front, |goal| front / goal.weight)
    }

    /// Returns a node that was found.
    pub(crate) fn node(&self, number: u32) -> &Node {
        &self.nodes[number as usize]
    }

    /// Returns the nodes on the path to a node, the source first.
    pub(crate) fn way(&self, number: u32) -> Vec<Node> {
        let mut way = Vec::new();
        let mut at = Some(number);
        while let Some(node) = at.map(|at| &self.nodes[at as usize]) {
            way.push(*node);
            at = node.parent;
        }
        way.reverse();
        way
    }

    /// Continues in a tile until a node is found or another tile is needed. Fails if the tile
    /// contradicts itself or others.
    pub(crate) fn step(&mut self, tile: &Tile) -> Result<EdgeSearchStep, Contradiction> {
        let space = FreeSpace {
            tile,
            outside_is_free: self.outside_is_free,
        };
        while let Some(entry) = self.queue.peek() {
            let vertex = entry.vertex.vertex();
            if let Some(VertexId { tile: needed, .. }) = vertex
                && needed != tile.id()
            {
                return Ok(EdgeSearchStep::Need(needed));
            }
            let Some(entry) = self.queue.pop() else { break };
            let found = match (vertex, entry.within) {
                (None, _) => self.settle_inserted(&entry),
                (Some(vertex), Some(within)) => self.settle(space, &entry, vertex, within)?,
                (Some(vertex), None) => self.settle_source(space, &entry, vertex.index)?,
            };
            if let Some(found) = found {
                return Ok(EdgeSearchStep::Found(found));
            }
        }
        Ok(EdgeSearchStep::Done)
    }

    /// Adds the node of an entry, unless it was settled already.
    fn add(&mut self, entry: &QueueEntry, sector: GraphVertex) -> Option<u32> {
        if !self.settled.insert([entry.vertex, sector]) {
            return None;
        }
        self.nodes.push(Node {
            vertex: entry.vertex,
            point: entry.point,
            sector,
            length: entry.length,
            parent: entry.parent,
            within: entry.within,
        });
        Some(self.nodes.len() as u32 - 1)
    }

    fn settle_inserted(&mut self, entry: &QueueEntry) -> Option<u32> {
        let within = entry.within?;
        let Within::Sector(index) = within else { return None };
        let node = self.add(entry, GraphVertex::inserted(index))?;
        for link in self.links.get(&entry.vertex).cloned().into_iter().flatten() {
            if link.within == within {
                self.reach(None, node, link.to, 0);
            }
        }
        Some(node)
    }

    /// Puts an entry for each free sector of the source, a vertex of the tile, in the queue.
    fn settle_source(
        &mut self,
        space: FreeSpace<'_>,
        entry: &QueueEntry,
        vertex: VertexIndex,
    ) -> Result<Option<u32>, Contradiction> {
        let mut wedges = Vec::new();
        for wedge in space.free_wedges(vertex)? {
            wedges.push((space.point(space.neighbours(vertex, wedge)?[0]), wedge));
        }
        // The order is the same in every file.
        wedges.sort_by(|a, b| a.0.lex_cmp(b.0));
        for ((_, wedge), rank) in wedges.into_iter().zip(0..) {
            let within = match wedge {
                Wedge::Triangle(half_edge) => {
                    Within::RightOf(space.tile.vertex(space.tile.origin(half_edge.prev())).id)
                }
                Wedge::Outside => Within::Outside,
            };
            self.queue.push(QueueEntry {
                within: Some(within),
                rank,
                ..*entry
            });
        }
        Ok(None)
    }

    fn settle(
        &mut self,
        space: FreeSpace<'_>,
        entry: &QueueEntry,
        at: VertexId,
        within: Within,
    ) -> Result<Option<u32>, Contradiction> {
        let (id, vertex) = (entry.vertex, at.index);
        let mark = space.mark(vertex).ok_or(Contradiction::NoVertex(vertex))?;
        if mark.is_single() && self.settled.contains(&[id, id]) {
            return Ok(None);
        }
        let (sector, wedges) = if mark.is_single() {
            (id, space.free_wedges(vertex)?)
        } else {
            sector(space, vertex, wedge(space, vertex, within)?)?
        };
        let Some(node) = self.add(entry, sector) else {
            return Ok(None);
        };
        for wedge in wedges {
            let [on_right, on_left] = self.edges(space, at, wedge)?;
            // An edge that does not block has a wedge on both sides. It is used in one of them
            // only, and not in the outside, which has no triangles.
            if wedge != Wedge::Outside || space.left_of(vertex, wedge)?.is_none() {
                self.walk(space, node, on_left, 0);
            }
            if matches!(space.right_of(vertex, wedge)?, None | Some(Wedge::Outside)) {
                self.walk(space, node, on_right, 1);
            }
        }
        for link in self.links.get(&id).cloned().into_iter().flatten() {
            let is_here =
                mark.is_single() || self::sector(space, vertex, self::wedge(space, vertex, link.within)?)?.0 == sector;
            if is_here {
                let rank = if let Within::Sector(sector) = link.to.within {
                    sector
                } else {
                    0
                };
                self.reach(Some(space), node, link.to, rank);
            }
        }
        Ok(Some(node))
    }

    /// Returns the other ends of the edges on the right and on the left of a wedge.
    fn edges(&self, space: FreeSpace<'_>, at: VertexId, wedge: Wedge) -> Result<[Corner; 2], Contradiction> {
        let ends = space.neighbours(at.index, wedge)?.map(|end| space.tile.vertex(end));
        let withins = match wedge {
            Wedge::Triangle(_) => [Within::RightOf(at), Within::RightOf(ends[0].id)],
            Wedge::Outside => [Within::Outside; 2],
        };
        Ok([0, 1].map(|i| Corner {
            vertex: ends[i].id.into(),
            point: ends[i].point,
            within: withins[i],
        }))
    }

    /// Walks along an edge of the file, unless it was removed.
    fn walk(&mut self, space: FreeSpace<'_>, node: u32, to: Corner, rank: u32) {
        if !self.overlay.is_gone([self.nodes[node as usize].vertex, to.vertex]) {
            self.reach(Some(space), node, to, rank);
        }
    }

    fn reach(&mut self, space: Option<FreeSpace<'_>>, node: u32, to: Corner, rank: u32) {
        let from = &self.nodes[node as usize];
        let length = from.length + distance(from.point, to.point);
        let lower_bound = length + self.towards.map_or(0.0, |goal| goal.ahead(to.point));
        let to_disc = self
            .disc
            .map_or(0.0, |(center, radius)| (distance(to.point, center) - radius).max(0.0));
        let is_wanted = lower_bound + to_disc <= self.limit;
        if !is_wanted {
            return;
        }
        let here = space.zip(to.vertex.vertex());
        let here = here.filter(|(space, vertex)| space.tile.id() == vertex.tile);
        let mark = here.and_then(|(space, vertex)| space.mark(vertex.index));
        if mark.is_some_and(Mark::is_single) {
            let waiting = self.waiting.entry(to.vertex).or_insert(f64::INFINITY);
            if *waiting <= length {
                return;
            }
            *waiting = length;
        }
        self.queue.push(QueueEntry {
            length,
            lower_bound,
            vertex: to.vertex,
            point: to.point,
            parent: Some(node),
            rank,
            within: Some(to.within),
        });
    }
}
