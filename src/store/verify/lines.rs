//! Compares the file with its lines: every segment of the input is a chain of constraint edges with
//! its source, and nothing else is a constraint.
//!
//! The input consists of segments, each with the source that the edges along it must have. The
//! first pass over the file counts its *entries*: an entry is a constraint edge with one of its
//! sources. One more pass follows for each part of the segments that fits into memory. A segment is
//! looked up in the tiles whose cells it meets, since an edge belongs to the tile of its smaller
//! end, which is on the segment.
//!
//! ```text
//!   a ●────●──────●───● b      entries of the segment's source on its line whose start is
//!        tile 3 │ tile 4        at a or after it, and before b:
//!                               Σ hash(end) − hash(start) = hash(b) − hash(a)
//! ```
//!
//! All entries are taken in lexicographic direction. If the sum has this value, and no hashes
//! collide, then ends and starts cancel out except for `a` and `b`. As all entries run in the same
//! direction, they cover the segment once from `a` to `b`, and nothing beyond: they are a chain. In
//! a tile, the entries are sorted by source, line and start, so those of a segment are consecutive:
//! two searches and a difference of sums find them, however many entries and segments there are.
//!
//! Each entry that some segment covers gets a bit. A break line or a wall is a source of an edge
//! once, however often it runs along the edge. After lines were removed, lines are told apart by
//! their kind only, and an entry has a copy for each of them. Rings of obstacles count each time: the number of
//! segments that cover such an entry must equal the number of its copies, each in its direction. At
//! the end, all bits must be set.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering as Memory};

use futures::stream::StreamExt;
use xxhash_rust::xxh3::xxh3_128;

use crate::geometry::Point;
use crate::store::error::ReadError;
use crate::store::format::edge_source::{EdgeSource, LineKind};
use crate::store::format::ids::TileId;
use crate::store::format::line_part::LinePart;
use crate::store::format::tile::Tile;
use crate::store::pass::{Needs, PassPlan, PassReader, Workspaces, by_tile, list_for, spawn};
use crate::store::reader::TileReader;
use crate::store::verify::edge_entry::{self, EdgeEntry, LineNames, count, forward};
use crate::store::verify::error::{Fault, VerifyError, VerifyReport};
use crate::store::verify::tile_bits::TileBits;

/// The minimum number of segments that are looked up at once.
const LEAST_SEGMENTS: u64 = 1 << 15;
/// Room for pairs of a tile and a segment, per segment. Most segments meet one tile.
const TILES_PER_SEGMENT: u64 = 2;
/// Bytes that a lookup takes per entry of its tile.
const BYTES_PER_ENTRY: u64 = (size_of::<EdgeEntry>() + size_of::<HashSum>() + size_of::<u32>()) as u64;

/// A batch of segments of the input, each with the source that it gives to the edges along it, as
/// seen from its first end to its second.
#[derive(Clone, Debug, Default)]
pub struct LineBatch {
    /// The ends of each segment. Segments of length 0 are ignored.
    pub ends: Vec<[Point; 2]>,
    /// The source of each segment, and which of its ends are ends of a segment of the input; as
    /// long as `ends`. The ends at which a segment was split are not. Other segments are
    /// [whole](LinePart::whole).
    pub sources: Vec<LinePart>,
}

impl LineBatch {
    /// Removes all segments and keeps the memory.
    pub fn clear(&mut self) {
        self.ends.clear();
        self.sources.clear();
    }
}

/// A sum of hashes, modulo 2⁶⁴ in each half.
type HashSum = [u64; 2];

/// A segment of the input, from its smaller end to its larger one, and the sum of the entries found
/// along it.
struct SoughtSegment {
    ends: [Point; 2],
    part: LinePart,
    sum: [AtomicU64; 2],
}

/// A tile, and the index in the part of a segment that meets its cell.
type TileSegment = (u32, u32);

/// The segments that are looked up at once.
struct SegmentPart {
    names: LineNames,
    segments: Vec<SoughtSegment>,
    tile_segments: Vec<TileSegment>,
}

/// The workspace of a thread.
#[derive(Default)]
struct Workspace {
    entries: Vec<EdgeEntry>,
    /// For each entry, the sum over all entries before it; at the end, the sum over all entries.
    sums: Vec<HashSum>,
    /// For each entry, the number of segments that cover it less the number that cover the entry
    /// before it.
    cover_changes: Vec<u32>,
}

/// How an entry contradicts the segments that cover it. Those that say more come first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Contradiction {
    TooMany,
    HiddenEnd,
}

impl Contradiction {
    fn text(self) -> &'static str {
        match self {
            Self::TooMany => "is covered by more segments than the file says",
            Self::HiddenEnd => "has an end of a segment of its line, but the file does not say so",
        }
    }
}

/// An entry that contradicts the segments that cover it.
type Surplus = (Contradiction, TileId, EdgeEntry);

const FALSE_END: &str = "has no end of a segment of its line where the file says so";

impl TileReader {
    /// Checks that every segment of the input is a chain of constraint edges that have its source,
    /// and that the file has no other sources and no other constraints. `next` fills a batch and
    /// returns whether there was one.
    ///
    /// The proof uses sums of hashes of 128 bits: a fault could pass by a collision only. It
    /// assumes that no edge is stored twice and that the file is consistent, which
    /// [`verify`](Self::verify) proves. In a file whose lines were split where they cross, edges
    /// deviate from their lines. Compare such a file with the subsegments that
    /// [`LinesToSplit`](crate::LinesToSplit) makes of the lines. Builds and edits normalise obstacles
    /// that cover a point more than once; a [`PolygonNormalizer`](crate::PolygonNormalizer) makes the
    /// same segments.
    ///
    /// The segments are looked up in parts, with as many segments as fit into the memory that the
    /// reader may use, or into 512 MiB. Each part passes over the tiles that it meets. The check
    /// also keeps one bit per source of an edge. Must be awaited within a tokio runtime.
    ///
    /// # Errors
    ///
    /// Returns an error for the first segment, in the order of the input, that is no such chain;
    /// for the first constraint that is not in the input; if `next` fails; or if the memory does
    /// not suffice for the bits and a tile.
    pub async fn verify_lines<E: std::fmt::Display>(
        &self,
        next: impl FnMut(&mut LineBatch) -> Result<bool, E>,
    ) -> Result<VerifyReport, VerifyError> {
        let passes = self.for_passes().await?;
        let names = LineNames::of(&passes.directory().metadata);
        let counts = passes.count_in_tiles(move |tile| count(tile, names)).await?;
        let (plan, at_once) = passes.plan_lines(&counts)?;
        passes.verify_in_parts(next, counts, plan, at_once).await
    }
}

impl PassReader {
    /// Returns the plan of a pass, and the number of segments to look up at once.
    fn plan_lines(&self, counts: &[u32]) -> Result<(PassPlan, usize), ReadError> {
        const BYTES: u64 = size_of::<SoughtSegment>() as u64 + TILES_PER_SEGMENT * size_of::<TileSegment>() as u64;
        let entries = counts.iter().map(|&count| u64::from(count));
        let (total, most) = (entries.clone().sum(), entries.max().unwrap_or(0));
        let needs = |segments: u64| Needs {
            // One segment may meet all tiles.
            fixed: TileBits::byte_size(total) + segments * BYTES + (counts.len() * size_of::<TileSegment>()) as u64,
            per_thread: (most + 1) * BYTES_PER_ENTRY,
            ..Needs::default()
        };
        // As a rule, there are not many more segments than entries.
        self.plan_lookups(needs, LEAST_SEGMENTS..total.min(u32::MAX.into()), BYTES)
    }

    /// Looks up the segments, `at_once` at a time.
    pub(super) async fn verify_in_parts<E: std::fmt::Display>(
        &self,
        mut next: impl FnMut(&mut LineBatch) -> Result<bool, E>,
        counts: Vec<u32>,
        plan: PassPlan,
        at_once: usize,
    ) -> Result<VerifyReport, VerifyError> {
        let directory = self.directory();
        let found_bits = Arc::new(TileBits::new(counts));
        let workspaces = Arc::new(Workspaces::default());
        let names = LineNames::of(&directory.metadata);
        let mut part = SegmentPart::with_room(names, at_once, directory.tiles.len());
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
            for (&ends, &along) in batch.ends.iter().zip(&batch.sources) {
                if !ends.iter().all(|end| end.is_valid()) {
                    end = Some(Err(wrong(ends, along.source(), "has an end that is no valid point")));
                    break;
                }
                let index = part.push(ends, along);
                let [from, to] = part.segments[index as usize].ends;
                if from != to {
                    let take = |tile: TileId| part.tile_segments.push((tile.0, index));
                    directory.tree.tiles_along(directory.metadata.bounds, [from, to], take);
                }
                segments += 1;
                if part.segments.len() == at_once || part.tile_segments.len() > at_once * TILES_PER_SEGMENT as usize {
                    part = self
                        .find_lines(part, &mut surplus, plan, &found_bits, &workspaces)
                        .await?;
                }
            }
        }
        // Whatever ends the input, a fault before the end is reported first, regardless of the
        // parts.
        self.find_lines(part, &mut surplus, plan, &found_bits, &workspaces)
            .await?;
        end.unwrap_or(Ok(()))?;
        // An edge that is not of the input says more than an end that the input has in its place.
        let unset = found_bits.first_unset();
        match (surplus, unset) {
            (Some((how, _, entry)), None) | (Some((how @ Contradiction::TooMany, _, entry)), _) => {
                return Err(wrong(entry.ends, entry.part.source(), how.text()));
            }
            (_, Some((tile, number))) => return Err(self.not_of_the_input(tile, number).await?),
            (None, None) => {}
        }
        Ok(VerifyReport {
            tiles: directory.tiles.len() as u64,
            constraint_edges: directory.metadata.constraint_edges,
            segments,
            ..VerifyReport::default()
        })
    }

    /// Looks up the segments of a part, tile by tile. Stores in `surplus` the first entry that
    /// contradicts the segments that cover it. Returns the memory of `part`.
    async fn find_lines(
        &self,
        mut part: SegmentPart,
        surplus: &mut Option<Surplus>,
        plan: PassPlan,
        found_bits: &Arc<TileBits>,
        workspaces: &Arc<Workspaces<Workspace>>,
    ) -> Result<SegmentPart, VerifyError> {
        let sorted = spawn(move || {
            part.tile_segments.sort_unstable();
            Arc::new(part)
        });
        let mut part = sorted.await?;
        let groups = by_tile(&part.tile_segments, |tile_segment| tile_segment.0);
        let (of_all, found_bits, workspaces) = (Arc::clone(&part), Arc::clone(found_bits), Arc::clone(workspaces));
        let mut tiles = self.for_some_tiles(groups, plan, move |tile, group| {
            let found = workspaces.with(|workspace| workspace.find(&tile, &of_all, group, &found_bits));
            found.map(|(how, entry)| (how, tile.id(), entry))
        });
        while let Some(found) = tiles.next().await {
            // The first by tile and number does not depend on the parts.
            let order = |(how, tile, entry): Surplus| (how, tile, entry.number);
            if let Some(found) = found?
                && surplus.is_none_or(|first| order(found) < order(first))
            {
                *surplus = Some(found);
            }
        }
        drop(tiles);
        if let Some(segment) = part.segments.iter().find(|segment| !segment.is_chain()) {
            let reason = "is not a chain of edges that come from it";
            return Err(wrong(segment.ends, segment.part.source(), reason));
        }
        // Finished tasks no longer hold a reference.
        let names = part.names;
        Ok(match Arc::get_mut(&mut part) {
            Some(part) => std::mem::replace(part, SegmentPart::with_room(names, 0, 0)).emptied(),
            None => SegmentPart::with_room(names, 0, 0),
        })
    }

    /// Returns the error for an entry that no segment covers.
    async fn not_of_the_input(&self, tile: TileId, number: u32) -> Result<VerifyError, ReadError> {
        let (tile, names) = (self.tile(tile).await?, LineNames::of(&self.directory().metadata));
        let mut entries = edge_entry::entries(&tile, names);
        let entry = entries.find(|entry| (entry.number..entry.number + entry.items()).contains(&number));
        Ok(match entry {
            Some(entry) if number - entry.number >= entry.copies => wrong(entry.ends, entry.part.source(), FALSE_END),
            Some(entry) => {
                let reason = "is an edge of the file, but not of the input";
                wrong(entry.ends, entry.part.source(), reason)
            }
            None => Fault::new("the number of its sources changed between two reads").of(tile.id()),
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

impl SegmentPart {
    /// Creates a part with room for `segments` segments, the last of which may meet all `tiles`
    /// tiles.
    fn with_room(names: LineNames, segments: usize, tiles: usize) -> Self {
        Self {
            names,
            segments: list_for(segments),
            tile_segments: list_for(segments * TILES_PER_SEGMENT as usize + tiles),
        }
    }

    fn emptied(mut self) -> Self {
        self.segments.clear();
        self.tile_segments.clear();
        self
    }

    /// Adds a segment and returns its index.
    fn push(&mut self, ends: [Point; 2], part: LinePart) -> u32 {
        let (ends, part) = forward(ends.map(Point::normalized), part);
        self.segments.push(SoughtSegment {
            ends,
            part,
            sum: Default::default(),
        });
        self.segments.len() as u32 - 1
    }
}

impl SoughtSegment {
    fn is_chain(&self) -> bool {
        let [sum, expected] = [
            self.sum.each_ref().map(|half| half.load(Memory::Relaxed)),
            hash_difference(self.ends),
        ];
        sum == expected
    }
}

/// Returns the hash of the end less the hash of the start.
fn hash_difference([from, to]: [Point; 2]) -> HashSum {
    let [from, to] = [from, to].map(|p| {
        let mut bytes = [0; 16];
        bytes[..8].copy_from_slice(&p.x.to_le_bytes());
        bytes[8..].copy_from_slice(&p.y.to_le_bytes());
        let hash = xxh3_128(&bytes);
        [hash as u64, (hash >> 64) as u64]
    });
    [to[0].wrapping_sub(from[0]), to[1].wrapping_sub(from[1])]
}

impl Workspace {
    /// Looks up a group of the part's segments in a tile: adds the entries found to the segments'
    /// sums, and sets their bits. Returns the first entry that contradicts the segments, and how.
    fn find(
        &mut self,
        tile: &Tile,
        segments: &SegmentPart,
        group: Range<usize>,
        found_bits: &TileBits,
    ) -> Option<(Contradiction, EdgeEntry)> {
        let Self {
            entries,
            sums,
            cover_changes,
        } = self;
        entries.clear();
        entries.extend(edge_entry::entries(tile, segments.names));
        entries.sort_unstable_by(|a, b| a.compare(b.ends, b.part.source(), b.ends[0]));
        sums.clear();
        let mut sum = HashSum::default();
        for entry in &*entries {
            sums.push(sum);
            sum = plus(sum, hash_difference(entry.ends));
        }
        sums.push(sum);
        cover_changes.clear();
        cover_changes.resize(sums.len(), 0);
        let mut surplus = None;
        for &(_, index) in &segments.tile_segments[group] {
            let SoughtSegment { ends, part, sum } = &segments.segments[index as usize];
            let source = segments.names.source(part.source());
            let [start, end] = ends.map(|from| entries.partition_point(|e| e.compare(*ends, source, from).is_lt()));
            for half in 0..2 {
                sum[half].fetch_add(sums[end][half].wrapping_sub(sums[start][half]), Memory::Relaxed);
            }
            cover_changes[start] = cover_changes[start].wrapping_add(1);
            cover_changes[end] = cover_changes[end].wrapping_sub(1);
            let fault = find_segment_ends(&entries[start..end], *ends, *part, |number| {
                found_bits.set(tile.id(), number)
            });
            surplus = earlier(surplus, fault.map(|entry| (Contradiction::HiddenEnd, entry)));
        }
        let mut covers = 0u32;
        for (entry, change) in entries.iter().zip(cover_changes) {
            covers = covers.wrapping_add(*change);
            let (copies, covers) = (entry.number..entry.number + entry.copies, covers as usize);
            let fits = match entry.part.kind() {
                LineKind::Obstacle => found_bits.set_more(tile.id(), copies, covers) == covers,
                LineKind::BreakLine | LineKind::Wall => {
                    let covered = covers.min(copies.len());
                    found_bits.set_more(tile.id(), copies, covered);
                    true
                }
            };
            surplus = earlier(surplus, (!fits).then_some((Contradiction::TooMany, *entry)));
        }
        surplus
    }
}

/// Passes the numbers of the ends that a segment has among the entries along it to `found`. Returns
/// an entry that lacks an end of the segment.
fn find_segment_ends(
    along: &[EdgeEntry],
    ends: [Point; 2],
    part: LinePart,
    mut found: impl FnMut(u32),
) -> Option<EdgeEntry> {
    let first = along.first().filter(|entry| part.begins() && entry.ends[0] == ends[0]);
    let last = along.last().filter(|entry| part.ends() && entry.ends[1] == ends[1]);
    let mut lacking = None;
    for (entry, which) in [(first, 0), (last, 1)] {
        let Some(entry) = entry else { continue };
        match entry.numbers_of_ends()[which] {
            Some(number) => found(number),
            None => lacking = lacking.or(Some(*entry)),
        }
    }
    lacking
}

/// Returns the contradiction that says more, or whose entry comes first.
fn earlier(
    one: Option<(Contradiction, EdgeEntry)>,
    other: Option<(Contradiction, EdgeEntry)>,
) -> Option<(Contradiction, EdgeEntry)> {
    match (one, other) {
        (Some(one), Some(other)) if (other.0, other.1.number) < (one.0, one.1.number) => Some(other),
        (one, other) => one.or(other),
    }
}

fn plus(one: HashSum, other: HashSum) -> HashSum {
    [one[0].wrapping_add(other[0]), one[1].wrapping_add(other[1])]
}
