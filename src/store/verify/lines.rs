//! The file against its lines: every segment of the input is a chain of constraint edges that know it, and nothing else is a
//! constraint.
//!
//! In: segments, each with the source that it makes of the edges along it. The file is passed over once to count its
//! *entries*, which are constraint edges with one of their sources each, and once for each part of the segments that fits in
//! memory. A segment is looked for in the tiles whose cells it meets, since an edge belongs to the tile of its smaller
//! end, which lies on the segment.
//!
//! ```text
//!   a ●────●──────●───● b      entries of the segment's source on its line that start from a on and before b:
//!        tile 3 │ tile 4        Σ hash(end) − hash(start) = hash(b) − hash(a)
//! ```
//!
//! All entries are taken in lexicographic direction. If the sum comes out so, and no hashes collide, then ends and starts
//! cancel but for `a` and `b`; as all entries run in the same direction, they cover the segment once from `a` to `b`, and
//! nothing beyond: they are a chain. In a tile the entries are in order of source, line and start, so those of a segment are
//! neighbours, which two searches and a difference of sums find, however many of either there are.
//!
//! Each entry that some segment covers gets a bit. A break line or a wall is an edge's source once, however often it runs along
//! it; rings of obstacles count each time, so as many segments must cover such an entry as there are of the same kind, each
//! in its direction. At the end no bit may be left.

use std::cmp::Ordering;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering as Memory};

use futures::stream::StreamExt;
use xxhash_rust::xxh3::xxh3_128;

use crate::geometry::{Point, compare_lines};
use crate::store::error::ReadError;
use crate::store::format::edge_source::{EdgeSource, LineKind};
use crate::store::format::ids::TileId;
use crate::store::format::tile::Tile;
use crate::store::pass::{Needs, PassPlan, Workspaces, by_tile, list_for, spawn};
use crate::store::reader::TileReader;
use crate::store::verify::error::{Fault, VerifyError, VerifyReport};
use crate::store::verify::marks::Marks;

/// Segments that are looked for at once, at least.
const LEAST_SEGMENTS: u64 = 1 << 15;
/// Places among tiles for each segment. Most meet one tile.
const PLACES: u64 = 2;
/// Bytes that a look-up takes for each entry of its tile.
const BYTES_PER_ENTRY: u64 = (size_of::<Entry>() + size_of::<Sum>() + size_of::<u32>()) as u64;

/// Segments of the input, with what each makes of the edges along it, seen from its first end to its second.
#[derive(Clone, Debug, Default)]
pub struct LineBatch {
    /// The segments by their ends. Those of no length are no edges.
    pub ends: Vec<[Point; 2]>,
    /// The source of each, as long as `ends`.
    pub sources: Vec<EdgeSource>,
}

impl LineBatch {
    /// Removes all segments and keeps the memory.
    pub fn clear(&mut self) {
        self.ends.clear();
        self.sources.clear();
    }
}

/// A sum of hashes, modulo 2⁶⁴ in each half.
type Sum = [u64; 2];

/// A segment of the input, from its smaller end to its larger one, and the sum of what was found along it.
struct Sought {
    ends: [Point; 2],
    source: EdgeSource,
    sum: [AtomicU64; 2],
}

/// A tile, and a segment that meets its cell, by its place in the part.
type Place = (u32, u32);

/// As many segments as are looked for at once.
#[derive(Default)]
struct Part {
    segments: Vec<Sought>,
    places: Vec<Place>,
}

/// A constraint edge of a tile and one of its sources, seen from its smaller end to its larger one.
#[derive(Clone, Copy)]
struct Entry {
    ends: [Point; 2],
    source: EdgeSource,
    /// Its number in the tile, and how many there are of it, which are numbered one behind the other.
    number: u32,
    copies: u32,
}

/// What a thread computes in.
#[derive(Default)]
struct Workspace {
    entries: Vec<Entry>,
    /// The sum over all entries before each.
    sums: Vec<Sum>,
    /// By how many segments more each is covered than the one before it.
    more: Vec<u32>,
}

/// An entry that more segments run along than there should be.
type Surplus = (TileId, Entry);

impl TileReader {
    /// Checks that every segment of the input is a chain of constraint edges that have its source, and that no edge has a
    /// source, and none is a constraint, otherwise. `next` fills batches and says whether there was one.
    ///
    /// It is proven by sums of hashes of 128 bits: what is wrong could pass by a collision only. That the file has no edge twice and
    /// agrees with itself is for [`verify`](Self::verify) to prove. Of a file whose lines were split where they cross, edges are beside
    /// their lines: it is to be compared with the pieces that [`LinesToSplit`](crate::LinesToSplit) makes of these.
    ///
    /// The segments are looked for in parts, as many at once as fit in the memory that the reader may use, or in 512 MiB; each
    /// part passes over the tiles that it meets. Beside them there is a bit for each source of an edge. Must be awaited within a tokio runtime.
    ///
    /// # Errors
    /// The first segment, in the order of the input, that is no such chain; the first constraint that is not of the input; or what `next`
    /// says; or if the memory does not suffice for the bits and a tile.
    pub async fn verify_lines<E: std::fmt::Display>(
        &self,
        next: impl FnMut(&mut LineBatch) -> Result<bool, E>,
    ) -> Result<VerifyReport, VerifyError> {
        let counts = self.count_in_tiles(count).await?;
        let (plan, at_once) = self.plan_lines(&counts)?;
        self.verify_in_parts(next, counts, plan, at_once).await
    }

    /// How to pass over the tiles, and how many segments to look for at once.
    fn plan_lines(&self, counts: &[u32]) -> Result<(PassPlan, usize), ReadError> {
        const BYTES: u64 = size_of::<Sought>() as u64 + PLACES * size_of::<Place>() as u64;
        let entries = counts.iter().map(|&count| u64::from(count));
        let (total, most) = (entries.clone().sum(), entries.max().unwrap_or(0));
        let needs = |segments: u64| Needs {
            // One segment may meet all tiles.
            fixed: Marks::byte_size(total) + segments * BYTES + (counts.len() * size_of::<Place>()) as u64,
            per_thread: (most + 1) * BYTES_PER_ENTRY,
            ..Needs::default()
        };
        // There are not many more segments than entries, as a rule.
        self.plan_lookups(needs, LEAST_SEGMENTS..total.min(u32::MAX.into()), BYTES)
    }

    /// Looks for the segments, so many at once.
    pub(super) async fn verify_in_parts<E: std::fmt::Display>(
        &self,
        mut next: impl FnMut(&mut LineBatch) -> Result<bool, E>,
        counts: Vec<u32>,
        plan: PassPlan,
        at_once: usize,
    ) -> Result<VerifyReport, VerifyError> {
        let directory = self.directory();
        let marks = Arc::new(Marks::new(counts));
        let workspaces = Arc::new(Workspaces::default());
        let mut part = Part::with_room(at_once, directory.tiles.len());
        let mut batch = LineBatch::default();
        let (mut segments, mut surplus, mut end) = (0, None, None);
        while end.is_none() {
            batch.clear();
            match next(&mut batch) {
                Ok(true) if batch.ends.len() == batch.sources.len() => {}
                Ok(true) => end = Some(Err(VerifyError::Input(unequal(&batch)))),
                Ok(false) => end = Some(Ok(())),
                Err(error) => end = Some(Err(VerifyError::Input(error.to_string()))),
            }
            for (&ends, &source) in batch.ends.iter().zip(&batch.sources) {
                if !ends.iter().all(|end| end.is_valid()) {
                    end = Some(Err(wrong(ends, source, "has an end that is no valid point")));
                    break;
                }
                let place = part.push(ends, source);
                let [from, to] = part.segments[place as usize].ends;
                if from != to {
                    let take = |tile: TileId| part.places.push((tile.0, place));
                    directory.tree.tiles_along(directory.metadata.bounds, [from, to], take);
                }
                segments += 1;
                if part.segments.len() == at_once || part.places.len() > at_once * PLACES as usize {
                    part = self.find_lines(part, &mut surplus, plan, &marks, &workspaces).await?;
                }
            }
        }
        // Whatever ends the input, what came before it is reported first, however the segments were parted.
        self.find_lines(part, &mut surplus, plan, &marks, &workspaces).await?;
        end.unwrap_or(Ok(()))?;
        if let Some((_, entry)) = surplus {
            let reason = "is run along more often than the file says";
            return Err(wrong(entry.ends, entry.source, reason));
        }
        if let Some((tile, number)) = marks.first_unset() {
            return Err(self.not_of_the_input(tile, number).await?);
        }
        Ok(VerifyReport {
            tiles: directory.tiles.len() as u64,
            constraint_edges: directory.metadata.constraint_edges,
            segments,
            ..VerifyReport::default()
        })
    }

    /// Looks for the segments of a part, tile by tile. Keeps the first entry that too many run along. Returns the memory.
    async fn find_lines(
        &self,
        mut part: Part,
        surplus: &mut Option<Surplus>,
        plan: PassPlan,
        marks: &Arc<Marks>,
        workspaces: &Arc<Workspaces<Workspace>>,
    ) -> Result<Part, VerifyError> {
        let sorted = spawn(move || {
            part.places.sort_unstable();
            Arc::new(part)
        });
        let mut part = sorted.await?;
        let groups = by_tile(&part.places, |place| place.0);
        let (of_all, marks, workspaces) = (Arc::clone(&part), Arc::clone(marks), Arc::clone(workspaces));
        let mut tiles = self.for_some_tiles(groups, plan, move |tile, group| {
            let found = workspaces.with(|workspace| workspace.find(&tile, &of_all, group, &marks));
            found.map(|entry| (tile.id(), entry))
        });
        while let Some(found) = tiles.next().await {
            // Tiles come in order, so that it is the same however the segments are parted.
            if let Some(found) = found?
                && surplus.is_none_or(|(tile, entry)| (found.0, found.1.number) < (tile, entry.number))
            {
                *surplus = Some(found);
            }
        }
        drop(tiles);
        if let Some(segment) = part.segments.iter().find(|segment| !segment.is_chain()) {
            let reason = "is no chain of edges that come from it";
            return Err(wrong(segment.ends, segment.source, reason));
        }
        // Tasks that are done hold it no more.
        Ok(Arc::get_mut(&mut part)
            .map(std::mem::take)
            .map_or_else(Part::default, Part::emptied))
    }

    /// Names an entry that no segment runs along.
    async fn not_of_the_input(&self, tile: TileId, number: u32) -> Result<VerifyError, ReadError> {
        let tile = self.tile(tile).await?;
        let entry = entries(&tile).find(|entry| (entry.number..entry.number + entry.copies).contains(&number));
        Ok(match entry {
            Some(entry) => wrong(
                entry.ends,
                entry.source,
                "is an edge of the file, but not so in the input",
            ),
            None => Fault::new("it has another number of sources than before").of(tile.id()),
        })
    }
}

fn wrong(ends: [Point; 2], line: EdgeSource, reason: &'static str) -> VerifyError {
    VerifyError::Line { line, ends, reason }
}

fn unequal(batch: &LineBatch) -> String {
    format!(
        "a batch has {} segments and {} sources",
        batch.ends.len(),
        batch.sources.len()
    )
}

/// From the smaller end to the larger one.
fn in_order([from, to]: [Point; 2], source: EdgeSource) -> ([Point; 2], EdgeSource) {
    match from.lex_cmp(to).is_le() {
        true => ([from, to], source),
        false => ([to, from], source.reversed()),
    }
}

impl Part {
    /// For so many segments, the last of which may meet all tiles.
    fn with_room(segments: usize, tiles: usize) -> Self {
        Self {
            segments: list_for(segments),
            places: list_for(segments * PLACES as usize + tiles),
        }
    }

    fn emptied(mut self) -> Self {
        self.segments.clear();
        self.places.clear();
        self
    }

    /// Takes a segment, and tells its place.
    fn push(&mut self, ends: [Point; 2], source: EdgeSource) -> u32 {
        let (ends, source) = in_order(ends.map(Point::normalized), source);
        self.segments.push(Sought {
            ends,
            source,
            sum: Default::default(),
        });
        self.segments.len() as u32 - 1
    }
}

impl Sought {
    fn is_chain(&self) -> bool {
        let [sum, expected] = [
            self.sum.each_ref().map(|half| half.load(Memory::Relaxed)),
            change(self.ends),
        ];
        sum == expected
    }
}

impl Entry {
    /// The order among entries of a line of the plane with a source, from a point on it on.
    fn compare(&self, ends: [Point; 2], source: EdgeSource, from: Point) -> Ordering {
        let line = || compare_lines(self.ends, ends);
        let sources = self.source.cmp(&source);
        sources.then_with(line).then_with(|| self.ends[0].lex_cmp(from))
    }
}

/// The hash of the end less that of the start.
fn change([from, to]: [Point; 2]) -> Sum {
    let [from, to] = [from, to].map(|p| {
        let mut bytes = [0; 16];
        bytes[..8].copy_from_slice(&p.x.to_le_bytes());
        bytes[8..].copy_from_slice(&p.y.to_le_bytes());
        let hash = xxh3_128(&bytes);
        [hash as u64, (hash >> 64) as u64]
    });
    [to[0].wrapping_sub(from[0]), to[1].wrapping_sub(from[1])]
}

/// The entries of a tile, numbered in the order in which they stand there.
fn entries(tile: &Tile) -> impl Iterator<Item = Entry> {
    let mut number = 0;
    tile.owned_constraints()
        .flat_map(move |edge| {
            let ends = tile.ends(edge).map(|vertex| vertex.point);
            let mut sources = tile.edge_sources(edge).peekable();
            // The same ones are neighbours.
            std::iter::from_fn(move || {
                let source = sources.next()?;
                let mut copies = 1;
                while sources.next_if_eq(&source).is_some() {
                    copies += 1;
                }
                Some((ends, source, copies))
            })
        })
        .map(move |(ends, source, copies)| {
            let (ends, source) = in_order(ends, source);
            number += copies;
            Entry {
                ends,
                source,
                number: number - copies,
                copies,
            }
        })
}

/// How many entries a tile has, copies counted.
pub(super) fn count(tile: &Tile) -> Result<u32, Fault> {
    let mut edges = 0;
    for edge in tile.owned_constraints() {
        let [from, to] = tile.ends(edge).map(|vertex| vertex.point);
        if from == to {
            return Err(Fault::on(edge, "one of its edges has no length"));
        }
        if tile.edge_sources(edge).next().is_none() {
            return Err(Fault::on(edge, "one of its edges is a constraint without a source"));
        }
        edges += 1;
    }
    if edges != tile.edges_with_sources() {
        let reason = "it has sources for edges that are no constraints of its own";
        return Err(Fault::new(reason));
    }
    let mut total = 0;
    for entry in entries(tile) {
        if entry.copies > 1 && entry.source.kind() != LineKind::Obstacle {
            let [from, to] = entry.ends;
            return Err(Fault::new(format!(
                "its edge from ({}, {}) to ({}, {}) comes from {:?} more than once",
                from.x, from.y, to.x, to.y, entry.source
            )));
        }
        total += entry.copies;
    }
    Ok(total)
}

impl Workspace {
    /// Looks for a group of the part's segments in a tile: adds what is found to their sums, and marks it. Returns the first entry that
    /// more segments run along than there are copies of it.
    fn find(&mut self, tile: &Tile, part: &Part, group: Range<usize>, marks: &Marks) -> Option<Entry> {
        let Self { entries, sums, more } = self;
        entries.clear();
        entries.extend(self::entries(tile));
        entries.sort_unstable_by(|a, b| a.compare(b.ends, b.source, b.ends[0]));
        sums.clear();
        let mut sum = Sum::default();
        for entry in &*entries {
            sums.push(sum);
            sum = plus(sum, change(entry.ends));
        }
        sums.push(sum);
        more.clear();
        more.resize(sums.len(), 0);
        for &(_, place) in &part.places[group] {
            let Sought { ends, source, sum } = &part.segments[place as usize];
            let [start, end] = ends.map(|from| entries.partition_point(|e| e.compare(*ends, *source, from).is_lt()));
            for half in 0..2 {
                sum[half].fetch_add(sums[end][half].wrapping_sub(sums[start][half]), Memory::Relaxed);
            }
            more[start] = more[start].wrapping_add(1);
            more[end] = more[end].wrapping_sub(1);
        }
        let (mut covers, mut surplus) = (0u32, None::<Entry>);
        for (entry, more) in entries.iter().zip(more) {
            covers = covers.wrapping_add(*more);
            let is_enough = match entry.source.kind() {
                LineKind::Obstacle => {
                    let copies = entry.number..entry.number + entry.copies;
                    marks.set_more(tile.id(), copies, covers as usize) == covers as usize
                }
                LineKind::BreakLine | LineKind::Wall => {
                    if covers > 0 {
                        marks.set(tile.id(), entry.number);
                    }
                    true
                }
            };
            if !is_enough && surplus.is_none_or(|first| entry.number < first.number) {
                surplus = Some(*entry);
            }
        }
        surplus
    }
}

fn plus(one: Sum, other: Sum) -> Sum {
    [one[0].wrapping_add(other[0]), one[1].wrapping_add(other[1])]
}
