//! What the wave has still to do, nearest first.

use std::collections::HashMap;
use std::hash::BuildHasher;
use std::hash::BuildHasherDefault;

use crate::collections::mix::Mix;
use crate::geometry::Point;
use crate::store::{TileId, VertexId};

/// Tiles that are looked at for what comes soon: three levels of the heap.
const TOP: usize = 21;
/// The part by which something may be longer than another and be done before it, and one. Much less, and more has to wait; much more, and
/// more is done in vain.
const AHEAD: f64 = 1.0 + 1.0 / 128.0;
/// Items for which there is room from the start.
const ROOM: usize = 32;

/// A mark in place of a tile.
pub(crate) const NOWHERE: TileId = TileId(u32::MAX);

/// What an item is about, and what its numbers mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// The cone of `root` between `right` and `left` enters a triangle by side `index`; or, unless `other` is
    /// nowhere, by the side that comes from vertex `other` to vertex `index` of the tile.
    Cone,
    /// Vertex `index` of the tile, at `right`, is reached from `root` over `left.x` in all, by way of a [`Via`] that `other` tells.
    Vertex,
    /// The source lies in the triangle of side `index`, or of the side from `other` to vertex `index` of the tile.
    Start,
    /// The source is vertex `index` of the tile.
    StartVertex,
    /// The source lies outside and sees the hull edge that leaves vertex `index` of the tile, forward along the hull.
    Hull,
    /// The source lies outside and sees the hull edge that comes in at vertex `index` of the tile.
    HullBack,
    /// Goal `index` is reached from `root`.
    Goal,
    /// Nothing: it was done, or became part of another one.
    Nothing,
}

/// A thing to do in a tile.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Item {
    pub(crate) kind: Kind,
    pub(crate) tile: TileId,
    pub(crate) index: u32,
    pub(crate) other: VertexId,
    pub(crate) root: u32,
    pub(crate) right: Point,
    pub(crate) left: Point,
    /// Of a cone that comes from another tile: [`seam_between`] the ends of the side, as they are there. Of others that may be joined: the
    /// bits of its length in the queue.
    pub(crate) seam: u64,
}

/// What two tiles agree in that have the same ends of a side.
pub(crate) fn seam_between(ends: [Point; 2]) -> u64 {
    let bits = ends.map(|end| [end.x.to_bits(), end.y.to_bits()]);
    foldhash::quality::FixedState::default().hash_one(bits)
}

/// In which wedge a vertex is reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Via {
    /// That of the triangle of this side of the vertex's tile, which leaves the vertex.
    Side(u32),
    /// That of the triangle on the right of the edge to this vertex.
    RightOf(VertexId),
    /// Outside.
    Outside,
}

impl Via {
    const SIDE: TileId = TileId(u32::MAX - 1);

    pub(crate) fn to_vertex(self) -> VertexId {
        match self {
            Self::Side(index) => VertexId {
                tile: Self::SIDE,
                index,
            },
            Self::RightOf(vertex) => vertex,
            Self::Outside => VertexId {
                tile: NOWHERE,
                index: 0,
            },
        }
    }

    pub(crate) fn from_vertex(vertex: VertexId) -> Self {
        match vertex.tile {
            Self::SIDE => Self::Side(vertex.index),
            NOWHERE => Self::Outside,
            _ => Self::RightOf(vertex),
        }
    }
}

/// Items by what they promise, those of each tile by themselves: no way that goes on from one is shorter. Of equal ones any may be first.
///
/// They are done in order, more or less: something may be done before others that are nearer. That is right as well, for what is found waits
/// until nothing nearer can be found. Whatever is at hand may be ahead by a small part of its length, which saves much going in and
/// out of the queue, and from tile to tile. Where the wave's front goes through more tiles than the cache holds, what lies in the tile at
/// hand may besides be ahead by `lead`, which saves reading the tile again for each item.
#[derive(Debug)]
pub(crate) struct Queue {
    /// What there is to do in the tile at hand.
    here: Heap,
    here_is: TileId,
    /// What there is to do in others, and these by the first thing of each. What is not the first one any more may stand there still, but
    /// not on top.
    elsewhere: HashMap<TileId, Heap, BuildHasherDefault<Mix>>,
    tiles: Heap,
    /// What needs no tile.
    anywhere: Heap,
    items: Vec<Item>,
    unused: Vec<u32>,
    /// By how much the tile at hand may be ahead, besides.
    lead: f64,
    /// [`AHEAD`], or 1 if nothing may be done before what is nearer in the same tile.
    slack: f64,
}

/// What comes next.
pub(crate) enum Next {
    /// This, which is not in the queue any more.
    Item(Item),
    /// Something in this tile.
    In(TileId),
    Nothing,
}

/// A place in `items`, with the bits of a length that is not negative, which are ordered as it is.
#[derive(Clone, Copy, Debug)]
struct Entry {
    length: u64,
    place: u32,
}

/// The least entry first. Each has up to four below it, which lie together, so that there are half as many steps as in a binary heap.
#[derive(Debug)]
struct Heap(Vec<Entry>);

impl Heap {
    /// The least length; infinite if there is none.
    #[inline]
    fn front(&self) -> f64 {
        self.0
            .first()
            .map_or(f64::INFINITY, |entry| f64::from_bits(entry.length))
    }

    fn push(&mut self, entry: Entry) {
        self.0.push(entry);
        self.rise(self.0.len() - 1, entry);
    }

    fn pop(&mut self) -> Option<Entry> {
        let last = self.0.pop()?;
        let Some(&least) = self.0.first() else {
            return Some(last);
        };
        // The gap goes down to where nothing is below it, for the last one most likely belongs there.
        let mut at = 0;
        loop {
            let first = 4 * at + 1;
            let below = match self.0.get(first..) {
                Some(&[a, b, c, d, ..]) => first + least_of([a, b, c, d]),
                Some(rest) if !rest.is_empty() => {
                    let lengths = rest.iter().map(|entry| entry.length);
                    lengths.zip(first..).min().map_or(first, |(_, place)| place)
                }
                _ => break,
            };
            self.0[at] = self.0[below];
            at = below;
        }
        self.rise(at, last);
        Some(least)
    }

    /// Puts an entry in a gap, or above it.
    #[inline]
    fn rise(&mut self, gap: usize, entry: Entry) {
        let mut at = gap;
        while at > 0 {
            let above = (at - 1) / 4;
            if self.0[above].length <= entry.length {
                break;
            }
            self.0[at] = self.0[above];
            at = above;
        }
        self.0[at] = entry;
    }
}

/// The place of the least of four, without branches that nobody can foresee.
#[inline]
fn least_of(entries: [Entry; 4]) -> usize {
    let [a, b, c, d] = entries.map(|entry| entry.length);
    let (one, other) = (usize::from(b < a), 2 + usize::from(d < c));
    let is_other = usize::from(c.min(d) < a.min(b));
    one + (other - one) * is_other
}

impl Queue {
    pub(crate) fn new() -> Self {
        Self {
            here: Heap(Vec::with_capacity(ROOM)),
            here_is: NOWHERE,
            elsewhere: HashMap::default(),
            tiles: Heap(Vec::new()),
            anywhere: Heap(Vec::new()),
            items: Vec::with_capacity(ROOM),
            unused: Vec::with_capacity(ROOM),
            lead: 0.0,
            slack: AHEAD,
        }
    }

    /// Lets the tile at hand be further ahead, but not by more than `most`.
    pub(crate) fn lead(&mut self, most: f64) {
        self.lead = (2.0 * self.lead).max(most / 64.0).min(most);
    }

    /// Lets nothing more be done before what is nearer in the same tile.
    pub(crate) fn keep_order(&mut self) {
        self.slack = 1.0;
    }

    /// Turns to a tile.
    pub(crate) fn come_to(&mut self, tile: TileId) {
        if self.here_is == tile {
            return;
        }
        let here = self.elsewhere.remove(&tile).unwrap_or(Heap(Vec::new()));
        let there = std::mem::replace(&mut self.here, here);
        let was = std::mem::replace(&mut self.here_is, tile);
        if let Some(&Entry { length, .. }) = there.0.first() {
            self.tiles.push(Entry { length, place: was.0 });
            self.elsewhere.insert(was, there);
        }
        self.settle();
    }

    /// Takes away what is on top of the tiles without being the first thing of one that there is still.
    fn settle(&mut self) {
        while let Some(&Entry { length, place }) = self.tiles.0.first() {
            let tile = TileId(place);
            if let Some(there) = self.elsewhere.get_mut(&tile)
                && let Some(&first) = there.0.first()
                && first.length == length
            {
                if self.items[first.place as usize].kind != Kind::Nothing {
                    return;
                }
                there.pop();
                self.unused.push(first.place);
                match there.0.first() {
                    Some(&Entry { length, .. }) => self.tiles.push(Entry { length, place }),
                    None => drop(self.elsewhere.remove(&tile)),
                }
            }
            self.tiles.pop();
        }
    }

    /// Returns the item's place while it is in the queue.
    pub(crate) fn push(&mut self, length: f64, item: Item) -> u32 {
        let place = match self.unused.pop() {
            Some(place) => {
                self.items[place as usize] = item;
                place
            }
            None => {
                self.items.push(item);
                self.items.len() as u32 - 1
            }
        };
        let length = length.max(0.0).to_bits();
        let entry = Entry { length, place };
        if item.tile == NOWHERE {
            self.anywhere.push(entry);
        } else if item.tile == self.here_is {
            self.here.push(entry);
        } else {
            let there = self.elsewhere.entry(item.tile).or_insert(Heap(Vec::new()));
            if there.0.first().is_none_or(|front| length < front.length) {
                let place = item.tile.0;
                self.tiles.push(Entry { length, place });
            }
            there.push(entry);
        }
        place
    }

    /// How many items there may be.
    pub(crate) fn len(&self) -> usize {
        self.items.len() - self.unused.len()
    }

    /// An item by its place, or another one if it is not in the queue any more.
    pub(crate) fn at(&mut self, place: u32) -> Option<&mut Item> {
        self.items.get_mut(place as usize)
    }

    /// The least length of all; infinite if there is nothing to do.
    #[inline]
    pub(crate) fn front(&self) -> f64 {
        self.here.front().min(self.tiles.front()).min(self.anywhere.front())
    }

    /// The length up to which something in the tile at hand comes before what is out of it.
    #[inline]
    fn ahead(&self) -> f64 {
        // Nobody gains by being ahead of what needs no tile.
        (self.tiles.front() * AHEAD + self.lead).min(self.anywhere.front())
    }

    /// Whether something of such a length in the tile at hand may come next.
    #[inline]
    pub(crate) fn would_be_next(&self, length: f64) -> bool {
        length <= self.here.front() * self.slack && length <= self.ahead()
    }

    /// The tiles where something is to be done soon, in no order, each with the length of it: the top of the heap.
    pub(crate) fn top(&self) -> impl Iterator<Item = (f64, TileId)> {
        let is_first = |entry: &&Entry| {
            let there = self.elsewhere.get(&TileId(entry.place));
            there.is_some_and(|heap| heap.0.first().is_some_and(|first| first.length == entry.length))
        };
        let entries = self.tiles.0.iter().take(TOP).filter(is_first);
        entries.map(|entry| (f64::from_bits(entry.length), TileId(entry.place)))
    }

    /// What is to be done next; an item of the tile at hand, or one that needs none, is taken.
    pub(crate) fn next(&mut self) -> Next {
        loop {
            let (here, anywhere, tiles) = (self.here.front(), self.anywhere.front(), self.tiles.front());
            let from = if here < f64::INFINITY && here <= self.ahead() {
                &mut self.here
            } else if anywhere <= tiles {
                &mut self.anywhere
            } else {
                self.settle();
                match self.tiles.0.first() {
                    Some(top) if f64::from_bits(top.length) > tiles => continue,
                    Some(top) => return Next::In(TileId(top.place)),
                    None if tiles < f64::INFINITY => continue,
                    None => return Next::Nothing,
                }
            };
            let Some(entry) = from.pop() else {
                return Next::Nothing;
            };
            self.unused.push(entry.place);
            let there = &mut self.items[entry.place as usize];
            let item = *there;
            there.kind = Kind::Nothing;
            if item.kind != Kind::Nothing {
                return Next::Item(item);
            }
        }
    }
}
