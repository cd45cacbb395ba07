//! What the wave has still to do, nearest first.

use std::hash::BuildHasher;

use crate::geometry::Point;
use crate::store::{TileId, VertexId};

/// Items that are looked at for what comes soon: three levels of the heap.
const TOP: usize = 21;
/// Items for which there is room from the start.
const ROOM: usize = 32;

/// A mark in place of a tile.
pub(super) const NOWHERE: TileId = TileId(u32::MAX);

/// What an item is about, and what its numbers mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
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
pub(super) struct Item {
    pub(super) kind: Kind,
    pub(super) tile: TileId,
    pub(super) index: u32,
    pub(super) other: VertexId,
    pub(super) root: u32,
    pub(super) right: Point,
    pub(super) left: Point,
    /// Of a cone that comes from another tile: [`seam_between`] the ends of the side, as they are there. Of others that may be joined: the
    /// bits of its length in the queue.
    pub(super) seam: u64,
}

/// What two tiles agree in that have the same ends of a side.
pub(super) fn seam_between(ends: [Point; 2]) -> u64 {
    let bits = ends.map(|end| [end.x.to_bits(), end.y.to_bits()]);
    foldhash::quality::FixedState::default().hash_one(bits)
}

/// In which wedge a vertex is reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Via {
    /// That of the triangle of this side of the vertex's tile, which leaves the vertex.
    Side(u32),
    /// That of the triangle on the right of the edge to this vertex.
    RightOf(VertexId),
    /// Outside.
    Outside,
}

impl Via {
    const SIDE: TileId = TileId(u32::MAX - 1);

    pub(super) fn to_vertex(self) -> VertexId {
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

    pub(super) fn from_vertex(vertex: VertexId) -> Self {
        match vertex.tile {
            Self::SIDE => Self::Side(vertex.index),
            NOWHERE => Self::Outside,
            _ => Self::RightOf(vertex),
        }
    }
}

/// Items by what they promise: no way that goes on from one is shorter. Of equal ones any may be first.
#[derive(Debug)]
pub(super) struct Queue {
    heap: Heap,
    items: Vec<Item>,
    unused: Vec<u32>,
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
    fn peek(&self) -> Option<&Entry> {
        self.0.first()
    }

    fn push(&mut self, entry: Entry) {
        let mut at = self.0.len();
        self.0.push(entry);
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

    fn pop(&mut self) -> Option<Entry> {
        let last = self.0.pop()?;
        let Some(&least) = self.0.first() else {
            return Some(last);
        };
        let mut at = 0;
        loop {
            let first = 4 * at + 1;
            let end = (first + 4).min(self.0.len());
            let Some((&head, rest)) = self.0.get(first..end).and_then(<[Entry]>::split_first) else {
                break;
            };
            let (mut below, mut best) = (first, head);
            for (&entry, place) in rest.iter().zip(first + 1..) {
                if entry.length < best.length {
                    (below, best) = (place, entry);
                }
            }
            if best.length >= last.length {
                break;
            }
            self.0[at] = best;
            at = below;
        }
        self.0[at] = last;
        Some(least)
    }
}

impl Queue {
    pub(super) fn new() -> Self {
        Self {
            heap: Heap(Vec::with_capacity(ROOM)),
            items: Vec::with_capacity(ROOM),
            unused: Vec::with_capacity(ROOM),
        }
    }

    /// Returns the item's place while it is in the queue.
    pub(super) fn push(&mut self, length: f64, item: Item) -> u32 {
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
        self.heap.push(Entry { length, place });
        place
    }

    /// How many items there are.
    pub(super) fn len(&self) -> usize {
        self.heap.0.len()
    }

    /// An item by its place, or another one if it is not in the queue any more.
    pub(super) fn at(&mut self, place: u32) -> Option<&mut Item> {
        self.items.get_mut(place as usize)
    }

    /// The least length, if there is anything to do.
    pub(super) fn front(&self) -> Option<f64> {
        self.heap.peek().map(|entry| f64::from_bits(entry.length))
    }

    pub(super) fn peek(&self) -> Option<&Item> {
        self.heap.peek().map(|entry| &self.items[entry.place as usize])
    }

    /// Some of the nearest items, in no order, with their lengths: the top of the heap.
    pub(super) fn top(&self) -> impl Iterator<Item = (f64, &Item)> {
        let entries = self.heap.0.iter().take(TOP);
        entries.map(|entry| (f64::from_bits(entry.length), &self.items[entry.place as usize]))
    }

    pub(super) fn pop(&mut self) -> Option<Item> {
        let entry = self.heap.pop()?;
        self.unused.push(entry.place);
        let item = self.items[entry.place as usize];
        self.items[entry.place as usize].kind = Kind::Nothing;
        Some(item)
    }
}
