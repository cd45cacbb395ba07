//! A tile that can be changed: all triangles with a vertex in it, side by side in arrays.
//!
//! Read from a [`Tile`], and turned into the drafts (`drafts`) of a core and a border again.

mod drafts;
pub(crate) mod hubs;
mod sources;

use foldhash::{HashMap, HashMapExt};

use crate::edit::patch::{Beside, New, Patch, Seats, Share};
use crate::geometry::{HalfEdge, Point};
use crate::mesh::{NONE, Twin, WALLS, next_side, prev_side};
use crate::store::{EdgeSource, Tile, TileId, Vertex, VertexId};
use hubs::Hubs;

/// Across a side: the hull.
const ON_HULL: u32 = NONE;
/// Across a side whose ends are other tiles': a triangle without a vertex in this tile, or the hull.
const BEYOND: u32 = NONE - 1;
/// In the bits of a triangle: it is being replaced.
const REMOVED: u8 = 1 << 7;

/// A tile in memory, to be changed. Corners and sides are numbered as in a [`Tile`], but triangles come in any order.
#[derive(Clone, Debug)]
pub(crate) struct EditTile {
    pub(crate) id: TileId,
    points: Vec<Point>,
    z: Vec<f64>,
    records: Vec<u64>,
    sites: Vec<(u32, u64)>,
    site_ids: Vec<String>,
    foreign: Vec<Vertex>,
    foreign_places: HashMap<VertexId, u32>,
    triangles: Vec<[u32; 3]>,
    across: Vec<[u32; 3]>,
    bits: Vec<u8>,
    /// Places of triangles that are no more.
    free: Vec<u32>,
    /// A side that starts at each vertex of the tile.
    leaving: Vec<u32>,
    hubs: Hubs,
    /// Those of each constraint edge that belongs to the tile, by its corners, the smaller first, as seen from that.
    sources: HashMap<[u32; 2], Vec<EdgeSource>>,
    /// How many these are.
    source_count: usize,
}

/// A vertex on its way into a tile.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NewVertex {
    pub(crate) point: Point,
    pub(crate) z: f64,
    pub(crate) record: u64,
    /// The number of a line that ends here.
    pub(crate) line: u64,
}

/// A new triangle whose first side runs between two vertices of other tiles: what lies across must be looked for elsewhere.
pub(crate) type Unlinked = [VertexId; 3];

impl EditTile {
    /// Takes over what a tile has.
    pub(crate) fn of(tile: &Tile) -> Self {
        let vertices = tile.vertex_count();
        let triangles: Vec<[u32; 3]> = (0..tile.triangle_count()).map(|t| tile.corners(t)).collect();
        let corners = triangles.as_flattened().iter().map(|&corner| corner + 1).max();
        let foreign: Vec<Vertex> = (vertices..corners.unwrap_or(0))
            .map(|corner| tile.vertex(corner))
            .collect();
        let across = |side: u32| match tile.twin(HalfEdge(side)) {
            Twin::HalfEdge(HalfEdge(other)) => other,
            Twin::Hull => ON_HULL,
            Twin::Elsewhere => BEYOND,
        };
        let bits =
            |side: u32, s: u32| u8::from(tile.is_constraint(side)) << s | u8::from(tile.is_wall(side)) << (s + WALLS);
        let mut this = Self {
            id: tile.id(),
            points: tile.points().collect(),
            z: (0..vertices).filter_map(|v| tile.z(v)).collect(),
            records: (0..vertices).map(|v| tile.record(v)).collect(),
            sites: tile.sites().map(|site| (site.vertex, site.number)).collect(),
            site_ids: Vec::new(),
            foreign_places: foreign
                .iter()
                .zip(vertices..)
                .map(|(vertex, place)| (vertex.id, place))
                .collect(),
            foreign,
            across: (0..tile.triangle_count())
                .map(|t| [0, 1, 2].map(|s| across(3 * t + s)))
                .collect(),
            bits: (0..tile.triangle_count())
                .map(|t| (0..3).map(|s| bits(3 * t + s, s)).sum())
                .collect(),
            hubs: Hubs::of(vertices as usize, &triangles),
            triangles,
            free: Vec::new(),
            leaving: (0..vertices)
                .map(|v| tile.leaving(v).map_or(NONE, |side| side.0))
                .collect(),
            sources: HashMap::new(),
            source_count: 0,
        };
        if tile.sites().any(|site| site.id.is_some()) {
            this.site_ids = tile
                .sites()
                .map(|site| site.id.unwrap_or_default().to_owned())
                .collect();
        }
        this.load_sources(tile);
        this
    }

    /// Bytes that it takes in memory, about: with the room that lists have to grow.
    pub(crate) fn byte_size(&self) -> usize {
        /// Of an entry of a hash table, beside what it holds: tables are seven eighths full at most, and half of that at least.
        const OF_ENTRY: usize = 8;
        /// Of a list of one source, which is an allocation of its own.
        const OF_SOURCES: usize = 48;
        bytes_of(&self.points)
            + bytes_of(&self.z)
            + bytes_of(&self.records)
            + bytes_of(&self.leaving)
            + bytes_of(&self.triangles)
            + bytes_of(&self.across)
            + bytes_of(&self.bits)
            + bytes_of(&self.free)
            + bytes_of(&self.foreign)
            + (size_of::<(VertexId, u32)>() + OF_ENTRY) * self.foreign_places.capacity()
            + (size_of::<([u32; 2], Vec<EdgeSource>)>() + OF_ENTRY) * self.sources.capacity()
            + OF_SOURCES * self.sources.len()
            + 8 * self.source_count
            + 32 * self.sites.len()
            + self.hubs.byte_size()
    }

    pub(crate) fn points(&self) -> &[Point] {
        &self.points
    }

    /// A corner, the tile's own or another's.
    pub(crate) fn vertex(&self, corner: u32) -> Vertex {
        match self.points.get(corner as usize) {
            Some(&point) => Vertex {
                id: VertexId {
                    tile: self.id,
                    index: corner,
                },
                point,
            },
            None => self.foreign[corner as usize - self.points.len()],
        }
    }

    pub(crate) fn origin(&self, side: u32) -> u32 {
        self.triangles[(side / 3) as usize][(side % 3) as usize]
    }

    /// The vertex that a side starts from.
    pub(crate) fn from(&self, side: u32) -> Vertex {
        self.vertex(self.origin(side))
    }

    /// The corners of a side's triangle, from the side's origin on, and the bits of its sides, from that side on.
    pub(crate) fn triangle(&self, side: u32) -> ([Vertex; 3], u8) {
        let sides = [side, next_side(side), prev_side(side)];
        (sides.map(|side| self.from(side)), self.bits_from(side))
    }

    /// The bits of the sides of a side's triangle, from that side on.
    pub(crate) fn bits_from(&self, side: u32) -> u8 {
        let bits = self.bits[(side / 3) as usize];
        let turned = |bits: u8| {
            let (bits, first) = (bits & 0b111, side % 3);
            (bits >> first | bits << (3 - first)) & 0b111
        };
        turned(bits) | turned(bits >> WALLS) << WALLS
    }

    /// The bits of a side alone, in the places of a first one.
    fn side_bits(&self, side: u32) -> u8 {
        self.bits[(side / 3) as usize] >> (side % 3) & (1 | 1 << WALLS)
    }

    pub(crate) fn is_constraint(&self, side: u32) -> bool {
        self.side_bits(side) & 1 == 1
    }

    /// What lies across a side.
    pub(crate) fn across(&self, side: u32) -> Twin {
        match self.across[(side / 3) as usize][(side % 3) as usize] {
            ON_HULL => Twin::Hull,
            BEYOND => Twin::Elsewhere,
            other => Twin::HalfEdge(HalfEdge(other)),
        }
    }

    /// The corner that a vertex is here, if it is one.
    fn corner(&self, id: VertexId) -> Option<u32> {
        if id.tile == self.id {
            ((id.index as usize) < self.points.len()).then_some(id.index)
        } else {
            self.foreign_places.get(&id).copied()
        }
    }

    /// The sides that start at a vertex of the tile, each once: counter-clockwise from one on, and if that ends at the hull, the
    /// others clockwise.
    pub(crate) fn around(&self, vertex: u32) -> impl Iterator<Item = u32> {
        let first = self.leaving[vertex as usize];
        let (mut next, mut is_back) = ((first != NONE).then_some(first), false);
        // A damaged file may have a star that does not close.
        let mut steps = self.triangles.len();
        std::iter::from_fn(move || {
            let side = next?;
            steps = steps.checked_sub(1)?;
            if !is_back {
                next = match self.across(prev_side(side)) {
                    Twin::HalfEdge(HalfEdge(other)) if other == first => None,
                    Twin::HalfEdge(HalfEdge(other)) => Some(other),
                    Twin::Hull | Twin::Elsewhere => {
                        is_back = true;
                        self.clockwise(first)
                    }
                };
            } else {
                next = self.clockwise(side);
            }
            Some(side)
        })
    }

    /// The side that starts where this one does, next in clockwise order.
    fn clockwise(&self, side: u32) -> Option<u32> {
        match self.across(side) {
            Twin::HalfEdge(HalfEdge(other)) => Some(next_side(other)),
            Twin::Hull | Twin::Elsewhere => None,
        }
    }

    /// The number of triangles at a vertex of the tile.
    pub(crate) fn degree(&self, vertex: u32) -> u32 {
        self.hubs.degree(vertex)
    }

    /// The side from one vertex to another, one of which is the tile's own.
    pub(crate) fn side_between(&self, from: VertexId, to: VertexId) -> Option<u32> {
        self.side_along([self.corner(from)?, self.corner(to)?])
    }

    /// The side from one corner to another, one of which is the tile's own.
    fn side_along(&self, [from, to]: [u32; 2]) -> Option<u32> {
        if self.hubs.has(from) || self.hubs.has(to) {
            self.hubs.side([from, to])
        } else if (from as usize) < self.points.len() {
            self.around(from).find(|&side| self.origin(next_side(side)) == to)
        } else {
            let arriving = self.around(to).map(prev_side);
            { arriving }.find(|&side| self.origin(side) == from)
        }
    }

    /// The first side of the triangle with these corners, one of which is the tile's own.
    pub(crate) fn side_of(&self, corners: [VertexId; 3]) -> Option<u32> {
        let own = corners.iter().position(|id| id.tile == self.id)?;
        let at = |place: usize| corners[(own + place) % 3];
        let side = self.side_between(at(0), at(1))?;
        (self.from(prev_side(side)).id == at(2)).then(|| match own {
            0 => side,
            1 => prev_side(side),
            _ => next_side(side),
        })
    }

    /// Makes the first side of a triangle with these corners a constraint, or even a wall. The tile must have it.
    pub(crate) fn fix(&mut self, corners: [VertexId; 3], bits: u8) -> bool {
        let side = self.side_of(corners);
        if let Some(side) = side {
            self.bits[(side / 3) as usize] |= bits << (side % 3);
        }
        side.is_some()
    }

    /// Takes new vertices, which no triangle has yet. The first one gets the number that is returned.
    pub(crate) fn add_vertices(&mut self, new: &[NewVertex], has_z: bool) -> u32 {
        let own = self.points.len() as u32;
        let more = new.len() as u32;
        make_room(&mut self.points, new.len());
        self.points.extend(new.iter().map(|vertex| vertex.point));
        make_room(&mut self.records, new.len());
        self.records.extend(new.iter().map(|vertex| vertex.record));
        make_room(&mut self.leaving, new.len());
        if has_z {
            make_room(&mut self.z, new.len());
            self.z.extend(new.iter().map(|vertex| vertex.z));
        }
        self.leaving.resize(self.points.len(), NONE);
        // The corners of others come behind the tile's own.
        let behind = |corner: &mut u32| {
            if *corner >= own && *corner != NONE {
                *corner += more;
            }
        };
        self.triangles.as_flattened_mut().iter_mut().for_each(behind);
        self.foreign_places.values_mut().for_each(behind);
        let sources = std::mem::take(&mut self.sources);
        self.sources = sources
            .into_iter()
            .map(|(mut ends, sources)| {
                ends.iter_mut().for_each(behind);
                (ends, sources)
            })
            .collect();
        self.hubs = Hubs::of(self.points.len(), &self.triangles);
        own
    }

    /// Changes nothing; but whoever borrows a tile from the cache to change it has it written again.
    pub(crate) fn touch(&mut self) {}

    /// Takes the old triangles of its share of a patch out, which it must have, and puts the new ones in their place. Returns those that
    /// have a side, their first, across which another triangle of the tile may lie that only other tiles can tell.
    ///
    /// ```text
    ///      u ─── v            u ─── v        edges around stay, and what lies across them;
    ///    ╱  ╲   ╱  ╲    →   ╱    ╱    ╲      what is outside the tile on one side is so marked
    ///   a ──── w ── b      a ════════ b
    /// ```
    pub(crate) fn replace(&mut self, patch: &Patch, share: &Share, at: &mut Seats) -> Result<Vec<Unlinked>, String> {
        let Share { old, new, .. } = share;
        self.take_out(patch, old, at)?;
        let more = new.len().saturating_sub(self.free.len());
        make_room(&mut self.triangles, more);
        make_room(&mut self.across, more);
        make_room(&mut self.bits, more);
        for &number in new {
            let New { corners, bits, .. } = patch.new[number as usize];
            let corners = corners.map(|corner| self.corner_for(patch.vertices[corner as usize]));
            let place = self.free.pop().unwrap_or(self.triangles.len() as u32);
            if place as usize == self.triangles.len() {
                self.triangles.push(corners);
                self.across.push([ON_HULL; 3]);
                self.bits.push(bits);
            } else {
                self.triangles[place as usize] = corners;
                self.bits[place as usize] = bits;
            }
            at.new[number as usize] = 3 * place;
            self.hubs.add(corners, 3 * place);
            for (side, &corner) in (3 * place..).zip(&corners) {
                if let Some(leaving) = self.leaving.get_mut(corner as usize) {
                    *leaving = side;
                }
            }
        }
        let own = self.points.len() as u32;
        let here = |seats: &[u32], side: u32| seats[(side / 3) as usize] != NONE;
        let mut unlinked = Vec::new();
        for &number in new {
            for (s, &beside) in (0..).zip(&patch.new[number as usize].across) {
                let side = at.new[number as usize] + s;
                let value = match beside {
                    Beside::New(twin) if here(&at.new, twin) => at.new[(twin / 3) as usize] + twin % 3,
                    Beside::Old(old) if here(&at.old, old) => at.across[(old / 3) as usize][(old % 3) as usize],
                    Beside::Old(_) => {
                        unlinked.push(self.triangle(side).0.map(|vertex| vertex.id));
                        BEYOND
                    }
                    Beside::Hull if self.origin(side).min(self.origin(next_side(side))) < own => ON_HULL,
                    Beside::New(_) | Beside::Hull => BEYOND,
                };
                self.set_across(side, value);
                if value < BEYOND {
                    self.set_across(value, side);
                }
            }
        }
        // What lay across old triangles of the tile may lie across new ones that have no vertex here.
        for &number in old {
            for (&follower, &value) in patch.old[number as usize]
                .follower
                .iter()
                .zip(&at.across[number as usize])
            {
                if follower != NONE && value < BEYOND && !here(&at.new, follower) {
                    self.set_across(value, BEYOND);
                }
            }
        }
        self.make_hubs(at, new);
        Ok(unlinked)
    }

    /// Makes those corners of new triangles hubs that have become so.
    fn make_hubs(&mut self, at: &Seats, new: &[u32]) {
        for &number in new {
            for corner in self.triangles[(at.new[number as usize] / 3) as usize] {
                if !self.hubs.is_new(corner) {
                    continue;
                }
                self.hubs.make(corner);
                let places: Vec<u32> = self.around(corner).map(|side| side / 3).collect();
                for place in places {
                    self.hubs.enter(self.triangles[place as usize], 3 * place);
                }
            }
        }
    }

    /// Takes old triangles out, and notes where they were and what lay across.
    fn take_out(&mut self, patch: &Patch, old: &[u32], at: &mut Seats) -> Result<(), String> {
        let absent = || "a triangle is missing that another tile has".to_owned();
        for &number in old {
            let triangle = &patch.old[number as usize];
            let corners = patch.ids(triangle.corners);
            let (tile, found) = triangle.found;
            let found = (tile == self.id && self.is_at(found, corners)).then_some(found);
            let side = found.or_else(|| self.side_of(corners)).ok_or_else(absent)?;
            self.bits[(side / 3) as usize] |= REMOVED;
            at.old[number as usize] = side;
            at.across[number as usize] = [side, next_side(side), prev_side(side)]
                .map(|side| self.across[(side / 3) as usize][(side % 3) as usize]);
        }
        for &number in old {
            for (&follower, &value) in patch.old[number as usize]
                .follower
                .iter()
                .zip(&at.across[number as usize])
            {
                if follower != NONE && value < BEYOND && self.bits[(value / 3) as usize] & REMOVED != 0 {
                    return Err("triangles around a line do not fit together".to_owned());
                }
            }
        }
        for &number in old.iter().rev() {
            let place = at.old[number as usize] / 3;
            self.free.push(place);
            let corners = std::mem::replace(&mut self.triangles[place as usize], [NONE; 3]);
            self.hubs.remove(corners);
        }
        Ok(())
    }

    /// Whether a triangle with these corners has its first side there.
    fn is_at(&self, side: u32, corners: [VertexId; 3]) -> bool {
        let Some(triangle) = self
            .triangles
            .get((side / 3) as usize)
            .filter(|triangle| triangle[0] != NONE)
        else {
            return false;
        };
        let own = self.points.len();
        corners.iter().zip(side % 3..).all(|(&id, at)| {
            let corner = triangle[(at % 3) as usize];
            match (corner as usize).checked_sub(own) {
                None => id.index == corner && id.tile == self.id,
                Some(place) => self.foreign[place].id == id,
            }
        })
    }

    /// Puts two triangles of the tile side by side: one by its first side, and the one across that has this apex.
    pub(crate) fn link(&mut self, corners: Unlinked, apex: VertexId) -> Result<(), String> {
        let [from, to, _] = corners;
        let sides = [self.side_of(corners), self.side_of([to, from, apex])];
        let [Some(side), Some(other)] = sides else {
            return Err("a triangle is missing that another tile has".to_owned());
        };
        self.set_across(side, other);
        self.set_across(other, side);
        Ok(())
    }

    fn set_across(&mut self, side: u32, value: u32) {
        self.across[(side / 3) as usize][(side % 3) as usize] = value;
    }

    /// The corner that a vertex is here, and is to be if it is none yet.
    fn corner_for(&mut self, vertex: Vertex) -> u32 {
        if let Some(corner) = self.corner(vertex.id) {
            return corner;
        }
        let corner = (self.points.len() + self.foreign.len()) as u32;
        make_room(&mut self.foreign, 1);
        self.foreign.push(vertex);
        self.foreign_places.insert(vertex.id, corner);
        corner
    }

    /// The places of its triangles, those whose corners are all its own first.
    pub(crate) fn in_order(&self) -> (Vec<u32>, usize) {
        let own = self.points.len() as u32;
        let all = (0u32..).zip(&self.triangles).filter(|(_, corners)| corners[0] != NONE);
        let (core, border): (Vec<_>, Vec<_>) = all.partition(|(_, corners)| corners.iter().all(|&corner| corner < own));
        let core_count = core.len();
        let places = core.into_iter().chain(border).map(|(place, _)| place);
        (places.collect(), core_count)
    }

    /// How many triangles there are places for.
    pub(crate) fn places(&self) -> usize {
        self.triangles.len()
    }

    /// Whether a triangle belongs to the tile.
    pub(crate) fn owns(&self, place: u32) -> bool {
        let corners = self.triangles[place as usize].map(|corner| self.vertex(corner));
        let smallest = corners.iter().min_by(|a, b| a.point.lex_cmp(b.point));
        smallest.is_some_and(|vertex| vertex.id.tile == self.id)
    }
}

/// Bytes of a list, with the room that it has to grow.
fn bytes_of<T>(list: &Vec<T>) -> usize {
    list.capacity() * size_of::<T>()
}

/// Makes room in a list for so many more, and for an eighth of what is there: tiles grow little, and a cache is full of them.
fn make_room<T>(list: &mut Vec<T>, more: usize) {
    if list.capacity() - list.len() < more {
        list.reserve_exact(more.max(list.len() / 8));
    }
}
