//! The search along edges: Dijkstra, or A* towards one goal.

use foldhash::{HashMap, HashSet};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::corner::{Corner, End, Within};
use super::node::Node;
use super::overlay::{Link, Overlay};
use super::sector::{sector, wedge};
use crate::geometry::{Point, VertexIndex};
use crate::query::answer::distance;
use crate::query::free_space::{Ground, Mark, Wedge};
use crate::query::request::Contradiction;
use crate::store::{Tile, TileId, VertexId};

/// What a step of the search comes to.
#[derive(Debug)]
pub(crate) enum Step {
    /// It goes on in this tile.
    Need(TileId),
    /// The next nearest node, by number.
    Found(u32),
    /// There is nothing more to find.
    Done,
}

/// A vertex that waits, nearest first; of equally near ones the first by coordinates, and by the node before it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Entry {
    length: f64,
    /// The same with what is ahead of it, if there is a goal.
    at_least: f64,
    vertex: End,
    point: Point,
    parent: Option<u32>,
    /// Of those that differ in nothing else, which is first.
    turn: u32,
    /// None: all sectors of the source.
    within: Option<Within>,
}

impl Entry {
    fn order(&self, other: &Self) -> Ordering {
        let by_length = self.at_least.total_cmp(&other.at_least);
        let by_point = by_length.then_with(|| self.point.lex_cmp(other.point));
        // Those of the source come last.
        let number = |entry: &Self| entry.parent.unwrap_or(u32::MAX);
        let by_parent = by_point.then(number(self).cmp(&number(other)));
        by_parent.then(self.turn.cmp(&other.turn))
    }
}

impl Eq for Entry {}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> Ordering {
        other.order(self)
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// A goal of a search (A*), and how it hurries there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Towards {
    pub(crate) point: Point,
    /// What the straight way to the goal counts: with 1 a shortest way is found; with more, a way that is longer by no more than this factor,
    /// mostly far sooner, although each node is settled once (Ebendt and Drechsler, "Weighted A* search: unifying view and application",
    /// Artificial Intelligence 173, 2009).
    pub(crate) haste: f64,
}

impl Towards {
    /// What is still ahead of a point, hurrying.
    fn ahead(self, point: Point) -> f64 {
        self.haste * distance(point, self.point)
    }
}

/// A search on its way.
#[derive(Debug)]
pub(crate) struct EdgeSearch {
    outside_is_free: bool,
    overlay: Overlay,
    links: HashMap<End, Vec<Link>>,
    /// Nothing farther away is wanted.
    limit: f64,
    /// The only vertex to be found, which the search hurries to.
    towards: Option<Towards>,
    queue: BinaryHeap<Entry>,
    nodes: Vec<Node>,
    settled: HashSet<[End; 2]>,
    /// Lengths over which vertices with one free sector wait.
    waiting: HashMap<End, f64>,
    /// A disc, if nothing else is wanted than what lies in it.
    disc: Option<(Point, f64)>,
}

impl EdgeSearch {
    /// A search from a vertex, of the file or put in, to all that is not farther away than `limit`.
    pub(crate) fn new(
        (source, point): (End, Point),
        overlay: Overlay,
        limit: f64,
        towards: Option<Towards>,
        outside_is_free: bool,
    ) -> Self {
        let mut this = Self {
            outside_is_free,
            links: overlay.links(),
            overlay,
            limit,
            towards,
            queue: BinaryHeap::new(),
            nodes: Vec::new(),
            settled: HashSet::default(),
            waiting: HashMap::default(),
            disc: None,
        };
        let start = |within| Entry {
            length: 0.0,
            at_least: towards.map_or(0.0, |goal| goal.ahead(point)),
            vertex: source,
            point,
            parent: None,
            turn: if let Some(Within::Sector(sector)) = within {
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

    /// A search from a vertex in some of its wedges.
    #[cfg(feature = "baselines")]
    pub(crate) fn from_corners(corners: &[Corner], outside_is_free: bool) -> Self {
        let source = corners.first().map_or((End::put_in(0), Point::default()), |corner| {
            (corner.vertex, corner.point)
        });
        let mut this = Self::new(source, Overlay::default(), f64::INFINITY, None, outside_is_free);
        this.queue.clear();
        this.queue.extend(corners.iter().zip(0..).map(|(corner, turn)| Entry {
            length: 0.0,
            at_least: 0.0,
            vertex: corner.vertex,
            point: corner.point,
            parent: None,
            turn,
            within: Some(corner.within),
        }));
        this
    }

    /// From now on only vertices in a disc are wanted, and none over a longer way than this. Others are still found on the way there.
    #[cfg(feature = "baselines")]
    pub(crate) fn narrow(&mut self, limit: f64, center: Point, radius: f64) {
        self.limit = limit;
        self.disc = Some((center, radius));
    }

    /// A length that all ways to what was not found yet have at least.
    pub(crate) fn front(&self) -> f64 {
        let front = self.queue.peek().map_or(f64::INFINITY, |entry| entry.at_least);
        self.towards.map_or(front, |goal| front / goal.haste)
    }

    /// A node that was found.
    pub(crate) fn node(&self, number: u32) -> &Node {
        &self.nodes[number as usize]
    }

    /// The nodes on the way to one, the source first.
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

    /// Goes on in a tile, or says which it needs; an error says how the tile contradicts itself or others.
    pub(crate) fn step(&mut self, tile: &Tile) -> Result<Step, Contradiction> {
        let ground = Ground {
            tile,
            outside_is_free: self.outside_is_free,
        };
        while let Some(entry) = self.queue.peek() {
            let vertex = entry.vertex.vertex();
            if let Some(VertexId { tile: needed, .. }) = vertex
                && needed != tile.id()
            {
                return Ok(Step::Need(needed));
            }
            let Some(entry) = self.queue.pop() else { break };
            let found = match (vertex, entry.within) {
                (None, _) => self.settle_put_in(&entry),
                (Some(vertex), Some(within)) => self.settle(ground, &entry, vertex, within)?,
                (Some(vertex), None) => self.settle_source(ground, &entry, vertex.index)?,
            };
            if let Some(found) = found {
                return Ok(Step::Found(found));
            }
        }
        Ok(Step::Done)
    }

    /// Makes a node of an entry, unless it was one already.
    fn add(&mut self, entry: &Entry, sector: End) -> Option<u32> {
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

    fn settle_put_in(&mut self, entry: &Entry) -> Option<u32> {
        let within = entry.within?;
        let Within::Sector(index) = within else { return None };
        let node = self.add(entry, End::put_in(index))?;
        for link in self.links.get(&entry.vertex).cloned().into_iter().flatten() {
            if link.within == within {
                self.reach(None, node, link.to, 0);
            }
        }
        Some(node)
    }

    /// All free sectors of the source, which is a vertex of the tile: one now, and the others by way of the queue.
    fn settle_source(
        &mut self,
        ground: Ground<'_>,
        entry: &Entry,
        vertex: VertexIndex,
    ) -> Result<Option<u32>, Contradiction> {
        let mut wedges = Vec::new();
        for wedge in ground.free_wedges(vertex)? {
            wedges.push((ground.point(ground.neighbours(vertex, wedge)?[0]), wedge));
        }
        // In the same order in every file.
        wedges.sort_by(|a, b| a.0.lex_cmp(b.0));
        for ((_, wedge), turn) in wedges.into_iter().zip(0..) {
            let within = match wedge {
                Wedge::Triangle(side) => Within::RightOf(ground.tile.vertex(ground.tile.origin(side.prev())).id),
                Wedge::Outside => Within::Outside,
            };
            self.queue.push(Entry {
                within: Some(within),
                turn,
                ..*entry
            });
        }
        Ok(None)
    }

    fn settle(
        &mut self,
        ground: Ground<'_>,
        entry: &Entry,
        at: VertexId,
        within: Within,
    ) -> Result<Option<u32>, Contradiction> {
        let (id, vertex) = (entry.vertex, at.index);
        let mark = ground.mark(vertex).ok_or(Contradiction::NoVertex(vertex))?;
        if mark.is_single() && self.settled.contains(&[id, id]) {
            return Ok(None);
        }
        let (sector, wedges) = if mark.is_single() {
            (id, ground.free_wedges(vertex)?)
        } else {
            sector(ground, vertex, wedge(ground, vertex, within)?)?
        };
        let Some(node) = self.add(entry, sector) else {
            return Ok(None);
        };
        for wedge in wedges {
            let [on_right, on_left] = self.edges(ground, at, wedge)?;
            // An open edge is walked along in one of the wedges beside it, and not in the outside: that has no triangles.
            if wedge != Wedge::Outside || ground.left_of(vertex, wedge)?.is_none() {
                self.walk(ground, node, on_left, 0);
            }
            if matches!(ground.right_of(vertex, wedge)?, None | Some(Wedge::Outside)) {
                self.walk(ground, node, on_right, 1);
            }
        }
        for link in self.links.get(&id).cloned().into_iter().flatten() {
            let is_here = mark.is_single()
                || self::sector(ground, vertex, self::wedge(ground, vertex, link.within)?)?.0 == sector;
            if is_here {
                let turn = if let Within::Sector(sector) = link.to.within {
                    sector
                } else {
                    0
                };
                self.reach(Some(ground), node, link.to, turn);
            }
        }
        Ok(Some(node))
    }

    /// Where the edges on the right and on the left of a wedge lead.
    fn edges(&self, ground: Ground<'_>, at: VertexId, wedge: Wedge) -> Result<[Corner; 2], Contradiction> {
        let ends = ground.neighbours(at.index, wedge)?.map(|end| ground.tile.vertex(end));
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

    /// Walks along an edge of the file, if it is still there.
    fn walk(&mut self, ground: Ground<'_>, node: u32, to: Corner, turn: u32) {
        if !self.overlay.is_gone([self.nodes[node as usize].vertex, to.vertex]) {
            self.reach(Some(ground), node, to, turn);
        }
    }

    fn reach(&mut self, ground: Option<Ground<'_>>, node: u32, to: Corner, turn: u32) {
        let from = &self.nodes[node as usize];
        let length = from.length + distance(from.point, to.point);
        let at_least = length + self.towards.map_or(0.0, |goal| goal.ahead(to.point));
        let to_disc = self
            .disc
            .map_or(0.0, |(center, radius)| (distance(to.point, center) - radius).max(0.0));
        let is_wanted = at_least + to_disc <= self.limit;
        if !is_wanted {
            return;
        }
        let here = ground.zip(to.vertex.vertex());
        let here = here.filter(|(ground, vertex)| ground.tile.id() == vertex.tile);
        let mark = here.and_then(|(ground, vertex)| ground.mark(vertex.index));
        if mark.is_some_and(Mark::is_single) {
            let waiting = self.waiting.entry(to.vertex).or_insert(f64::INFINITY);
            if *waiting <= length {
                return;
            }
            *waiting = length;
        }
        self.queue.push(Entry {
            length,
            at_least,
            vertex: to.vertex,
            point: to.point,
            parent: Some(node),
            turn,
            within: Some(to.within),
        });
    }
}
