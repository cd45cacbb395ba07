//! The wave: from a source over free triangles, to sites, vertices or places, nearest first; exact.
//!
//! After Cui, Harabor and Grastien, "Compromise-free pathfinding on a navigation mesh" (IJCAI 2017), which looks for one goal,
//! and Zhao, Taniar and Harabor, "Fast k-nearest neighbor on a navigation mesh" (SoCS 2018), which has many: a root sees
//! intervals of sides; an interval is pushed through the triangle behind it and falls into what is seen of the two other sides.
//! Where a corner is in the way, it becomes a root in its turn. However:
//!
//! - The end of an interval is kept as the vertex that bounds the ray there, so every turn is one of three input points, and exact.
//! - A vertex becomes a root when it is the nearest thing to do, not where it is seen, and by way of its star, which knows its
//!   sectors ([`ground`](super::ground)): nothing leaks where obstacles touch.
//! - The outside of the hull is no triangle. A shortest way between two points of the closed hull stays in it, for the way to
//!   the nearest point of a convex set lengthens nothing; so the outside is walked through along hull edges only, and besides
//!   from a source and to places that lie there.
//!
//! ```text
//!        c               the cone of root r between the rays through R and L enters the triangle a b c by side b a;
//!       ╱ ╲              c is in it, so it falls into the cone from R to c, over side b c, and that from c to L, over side c a
//!    a ╱───╲ b
//!     L│   ╱R            side s of the triangle runs from a, seen on the left, to b, seen on the right
//!       ╲ ╱
//!        r
//! ```
//!
//! It has no I/O: [`Wave::step`] is given a tile, and tells when it needs another.

mod cone;
mod goal;
mod parts;
mod queue;
mod reached;
mod roots;
mod spread;
mod start;
mod waiting;

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap, HashSet};
use std::hash::BuildHasherDefault;

use super::ground::{Ground, SINGLE, SITE, TURNING, Wedge};
use super::passages::{Passage, Passages};
use super::place::Place;
use super::star::{next, previous, side_towards};
use crate::geometry::{Orientation, Point, orient2d};
use crate::store::{Tile, TileId, Vertex, VertexId};
pub(super) use cone::distance;
use cone::{Cone, minus};
pub(super) use goal::{Goal, Places};
pub(super) use parts::{Part, Shape, Side};
use queue::{Item, Kind, NOWHERE, Next, Queue, Via, seam_between};
use reached::Reached;
pub(super) use roots::Mix;
use roots::{NO_ROOT, Root, SeenVertices, TIE};
use waiting::{JOINED_AFTER, ORDERED_AFTER, Waiting};

/// Triangles that one step passes through at most, more or less.
const PAUSE: u32 = 1 << 12;

/// What a step of the wave comes to.
#[derive(Debug)]
pub(super) enum Step {
    /// It goes on in this tile.
    Need(TileId),
    /// It can go on in this tile, but has been at it for a while.
    Pause,
    /// The next nearest thing.
    Found(Found),
    /// There is nothing more to find.
    Done,
}

/// A thing that was found.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Found {
    pub(super) what: What,
    /// The way to it.
    pub(super) length: f64,
    /// The root that it is seen from.
    pub(super) root: u32,
}

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum What {
    /// A site: its number, its id if it has one, and where it is.
    Site {
        number: u64,
        id: Option<String>,
        vertex: Vertex,
    },
    /// A vertex.
    Vertex(Vertex),
    /// The place of this number.
    Place(u32),
}

/// A found thing that waits until nothing can be nearer: by length, then by number.
#[derive(Debug)]
struct Ready {
    length: u64,
    number: u64,
    found: Found,
}

impl PartialEq for Ready {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Ready {}

impl Ord for Ready {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        (self.length, self.number).cmp(&(other.length, other.number))
    }
}

impl PartialOrd for Ready {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// A wave on its way.
#[derive(Debug)]
pub(super) struct Wave {
    source: Point,
    outside_is_free: bool,
    goal: Goal,
    /// The only place to be found, which the wave hurries to.
    towards: Option<Point>,
    /// Nothing farther away is wanted.
    limit: f64,
    queue: Queue,
    waiting: Waiting,
    /// Whether cones that wait next to each other are joined.
    joins: bool,
    /// Triangles that it went through before this step.
    passed: u64,
    roots: Vec<Root>,
    seen: SeenVertices,
    /// What it knows of the tile that it is in, and of those where it was.
    here: Reached,
    here_is: TileId,
    elsewhere: HashMap<TileId, Reached, BuildHasherDefault<Mix>>,
    ready: BinaryHeap<Reverse<Ready>>,
    /// The numbers of what was told.
    told: HashSet<u64, BuildHasherDefault<Mix>>,
    /// Triangles that this step may still pass.
    pause: u32,
    /// What was seen, if someone asks for it.
    parts: Option<Vec<Part>>,
    /// What of the outside the source was seen to see already.
    beside: Option<Side>,
}

impl Wave {
    /// A wave from a free place to all that is not farther away than `limit`.
    pub(super) fn new(source: &Place, goal: Goal, limit: f64, outside_is_free: bool) -> Box<Self> {
        let towards = match &goal {
            Goal::Places(places) => places.single(),
            Goal::Sites | Goal::Vertices => None,
        };
        // It is large, and moved with the futures that drive it.
        let mut this = Box::new(Self {
            source: source.point,
            outside_is_free,
            goal,
            towards,
            limit,
            queue: Queue::new(),
            waiting: Waiting::new(),
            joins: towards.is_none(),
            passed: 0,
            roots: Vec::with_capacity(8),
            seen: SeenVertices::default(),
            here: Reached::default(),
            here_is: NOWHERE,
            elsewhere: HashMap::default(),
            ready: BinaryHeap::new(),
            told: HashSet::default(),
            pause: PAUSE,
            parts: None,
            beside: None,
        });
        this.start(source);
        this
    }

    /// A length that all ways to what was not told yet have at least.
    pub(super) fn front(&self) -> f64 {
        let ready = self.ready.peek().map(|ready| f64::from_bits(ready.0.length));
        ready.map_or(self.queue.front(), |ready| ready.min(self.queue.front()))
    }

    /// How many points it spread from: no way has more legs than that and one.
    pub(super) fn root_count(&self) -> usize {
        self.roots.len()
    }

    /// The vertices and points on the way to a root, the source first.
    pub(super) fn way(&self, root: u32) -> Vec<(Point, Option<VertexId>)> {
        let mut way = Vec::new();
        let mut at = root;
        while let Some(root) = self.roots.get(at as usize) {
            way.push((root.point, root.vertex));
            at = root.parent;
        }
        way.reverse();
        way
    }

    /// The vertex that a root is, unless it is the source.
    pub(super) fn root_vertex(&self, root: u32) -> Option<VertexId> {
        self.roots.get(root as usize).and_then(|root| root.vertex)
    }

    /// The vertices that it came to.
    #[cfg(feature = "baselines")]
    pub(super) fn reached(&self) -> impl Iterator<Item = VertexId> {
        let reached = self.seen.iter().filter(|(_, seen)| seen.marks.is_some());
        reached.map(|(&vertex, _)| vertex)
    }

    /// Lets it stay in a tile for longer, up to where that is ahead of others by so much: it has come to a tile again that was read before.
    pub(super) fn lead(&mut self, most: f64) {
        self.queue.lead(most);
    }

    /// The tiles that it will most likely need after this one, the likeliest first.
    pub(super) fn ahead(&self, after: TileId) -> Vec<TileId> {
        let mut items: Vec<(f64, TileId)> = self.queue.top().filter(|&(_, tile)| tile != after).collect();
        items.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut tiles: Vec<TileId> = Vec::new();
        for (_, tile) in items {
            if !tiles.contains(&tile) {
                tiles.push(tile);
            }
        }
        tiles
    }

    /// Goes on in a tile, or says which it needs; an error says how the tile contradicts itself or others.
    pub(super) fn step(&mut self, tile: &Tile) -> Result<Step, String> {
        self.passed += u64::from(PAUSE - self.pause);
        self.joins |= self.passed >= JOINED_AFTER;
        if self.passed >= ORDERED_AFTER {
            self.queue.keep_order();
        }
        self.pause = PAUSE;
        let ground = Ground {
            tile,
            outside_is_free: self.outside_is_free,
        };
        self.come_to(ground);
        loop {
            let front = self.queue.front();
            let is_next = |ready: &Reverse<Ready>| f64::from_bits(ready.0.length) < front;
            if self.ready.peek().is_some_and(is_next)
                && let Some(Reverse(ready)) = self.ready.pop()
            {
                // A way that was found before may be longer.
                if self.told.insert(ready.number) {
                    return Ok(Step::Found(ready.found));
                }
                continue;
            }
            if self.pause == 0 {
                return Ok(Step::Pause);
            }
            let item = match self.queue.next() {
                Next::Item(item) => item,
                Next::In(tile) => return Ok(Step::Need(tile)),
                Next::Nothing => return Ok(Step::Done),
            };
            match item.kind {
                Kind::Cone => self.enter(ground, &item)?,
                Kind::Vertex => self.reach(ground, &item)?,
                Kind::Goal => self.tell_place(item.index, item.left.x, item.root),
                Kind::Start => self.start_in(ground, &item)?,
                Kind::StartVertex => self.start_at(ground, item.index)?,
                Kind::Hull | Kind::HullBack => self.start_along_hull(ground, &item)?,
                Kind::Nothing => {}
            }
        }
    }

    /// Turns to what is known of a tile.
    fn come_to(&mut self, ground: Ground<'_>) {
        let id = ground.tile.id();
        if self.here_is == id {
            return;
        }
        let here = self.elsewhere.remove(&id).unwrap_or_else(|| match &self.goal {
            Goal::Places(places) => Reached::new(ground, places.triangles_in(id)),
            Goal::Sites | Goal::Vertices => Reached::new(ground, std::iter::empty()),
        });
        self.queue.come_to(id);
        let there = std::mem::replace(&mut self.here, here);
        let was = std::mem::replace(&mut self.here_is, id);
        if was != NOWHERE {
            self.elsewhere.insert(was, there);
        }
    }

    fn push(&mut self, length: f64, item: Item) {
        if length <= self.limit {
            self.queue.push(length, item);
        }
    }

    fn tell(&mut self, what: What, number: u64, length: f64, root: u32) {
        if self.told.contains(&number) {
            return;
        }
        self.ready.push(Reverse(Ready {
            length: length.to_bits(),
            number,
            found: Found { what, length, root },
        }));
    }

    fn tell_place(&mut self, goal: u32, length: f64, root: u32) {
        self.tell(What::Place(goal), goal.into(), length, root);
    }

    /// A place is seen from a root.
    fn see_place(&mut self, goal: u32, point: Point, root: u32) {
        let from = &self.roots[root as usize];
        let length = from.length + distance(from.point, point);
        let nowhere = VertexId {
            tile: NOWHERE,
            index: 0,
        };
        let item = Item {
            kind: Kind::Goal,
            tile: NOWHERE,
            index: goal,
            other: nowhere,
            root,
            right: point,
            left: Point::new(length, 0.0),
            seam: 0,
        };
        self.push(length, item);
    }

    /// A vertex of the file was reached: tells of it, once.
    fn tell_vertex(&mut self, ground: Ground<'_>, index: u32, length: f64, root: u32) {
        let vertex = ground.tile.vertex(index);
        match self.goal {
            Goal::Sites => {
                for site in ground.tile.sites_at(index) {
                    let what = What::Site {
                        number: site.number,
                        id: site.id.map(str::to_owned),
                        vertex,
                    };
                    self.tell(what, site.number, length, root);
                }
            }
            Goal::Vertices => {
                let number = u64::from(vertex.id.tile.0) << 32 | u64::from(index);
                self.tell(What::Vertex(vertex), number, length, root);
            }
            Goal::Places(_) => {}
        }
    }

    /// Whether a vertex of these marks is one of those that are looked for.
    fn is_told_of(&self, marks: u8) -> bool {
        match self.goal {
            Goal::Sites => marks & SITE != 0,
            Goal::Places(_) => false,
            Goal::Vertices => true,
        }
    }
}
