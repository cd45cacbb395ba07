//! Changes a file on disk: lines become constraints of a triangulation that is there already.
//!
//! In: a tile file, and segments within its hull. Out: the same file in its next state, or as it was.
//!
//! ```text
//!   segments ─▶ new vertices at ends (vertices) ─▶ pieces, in the order of a curve ─▶ strips   (strip, patch)
//!                                                                              │  ▲
//!   file ──── tiles that are needed, the least recently used go ◀──────────────▼──┘   (tiles, tile)
//!     ▲                                                                        │
//!     └── new tiles, directory, superblock ◀── regions, numbered anew ◀────────┘      (regions)
//! ```
//!
//! Inserting a piece changes exactly the triangles that it crosses, and the result does not depend on when it is inserted (Wu,
//! Lemma 3.3.6). So a file that was edited has the triangles that it would have been built with. New tiles and a new directory are
//! appended; then one superblock is replaced, which makes all of it the file, at once. Whoever has it open sees what it was.

pub(crate) mod error;
mod exchange;
mod patch;
mod regions;
mod strip;
mod tile;
pub(crate) mod tiles;
mod vertices;

use std::num::NonZero;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Instant;

use tokio::runtime::Handle;
use tokio::sync::oneshot;

use crate::constraints::error::ConstraintError;
use crate::constraints::polygons::check::{InvertedPolygons, PolygonCheck};
use crate::constraints::segment::Segment;
use crate::constraints::without_z::NO_Z;
use crate::geometry::{MortonSquare, Point, Rect};
use crate::input::{MissingZ, SegmentBatch};
use crate::io::start_thread;
use crate::memory::EditShares;
use crate::mesh::vertex_index::VertexIndex;
use crate::store::{EdgeSource, LineKind, LineSource, Metadata, TileId, Vertex, VertexId, hull_edges};
pub use error::EditError;
use regions::{Joining, Labels, Parts};
use strip::{Inserting, Piece};
use tile::{EditTile, NewVertex};
pub(crate) use tiles::Target;
use tiles::{PartedTile, Tiles};

/// What an edit did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EditSummary {
    /// Segments that came in.
    pub segments: u64,
    /// Vertices that their ends became, where there were none.
    pub vertices: u64,
    /// Edges along them, those that were constraints before included.
    pub edges: u64,
    /// Constraint edges of the file.
    pub constraint_edges: u64,
    /// Tiles that had to be written again.
    pub tiles: u64,
    /// Tiles that were read for the lines, as often as that was.
    pub tile_reads: u64,
    /// Triangles that were looked at to follow the lines.
    pub triangles_looked_at: u64,
    /// Regions, those that are holes, and the triangles in these.
    pub regions: u64,
    /// Regions that are holes.
    pub hole_regions: u64,
    /// Triangles in holes.
    pub hole_triangles: u64,
    /// Bytes by which the file has grown.
    pub bytes_appended: u64,
    /// Bytes of the file.
    pub file_bytes: u64,
    /// Seconds that it took.
    pub seconds: f64,
}

/// Makes lines constraints of a file on disk.
///
/// Ends that are no vertices of it become some, within its hull. The file is locked against other editors; readers may have it open and
/// see it as it was when they opened it.
pub struct Editor {
    target: Target,
    memory: u64,
    /// The lines that there were before.
    first_line: u64,
    /// The number of this edit, from 1 on.
    number: u32,
    lines: Vec<LineSource>,
    segments: Vec<Segment>,
    /// z at their ends, as far as any have one.
    z: Vec<[f64; 2]>,
    missing_z: MissingZ,
    polygons: PolygonCheck,
}

impl Editor {
    /// Begins to edit a file within so many bytes of memory.
    ///
    /// # Errors
    /// If it cannot be opened, or somebody else edits it.
    pub async fn open(path: impl AsRef<Path>, memory: u64) -> Result<Self, EditError> {
        let target = Target::lock(path.as_ref())?;
        let opened = target.read().await?;
        let metadata = &opened.directory().metadata;
        if metadata.vertices > 0 && metadata.triangles == 0 {
            return Err(EditError::NoTriangles(target.path));
        }
        Ok(Self {
            first_line: metadata.lines.last().map_or(0, |last| last.first + last.lines),
            number: metadata.lines.last().map_or(0, |last| last.edit).saturating_add(1),
            // All segments are in memory, and a polygon takes no more than what they are counted for.
            polygons: PolygonCheck::new(&target.path, u64::MAX),
            target,
            memory,
            lines: Vec::new(),
            segments: Vec::new(),
            z: Vec::new(),
            missing_z: MissingZ::default(),
        })
    }

    /// Says what to do with ends of lines that become vertices and have no z, in a file whose
    /// vertices have z.
    pub fn missing_z(&mut self, missing_z: MissingZ) {
        self.missing_z = missing_z;
    }

    /// The number that the first new line gets in the file.
    #[must_use]
    pub fn first_line(&self) -> u64 {
        self.first_line
    }

    /// Says which files the lines come from, in the order of their numbers from 0 on.
    pub fn add_sources(&mut self, sources: Vec<LineSource>) {
        let (first_line, edit) = (self.first_line, self.number);
        let numbered = sources.into_iter().map(|source| LineSource {
            name: source.name,
            kind: source.kind,
            first: first_line + source.first,
            lines: source.lines,
            edit,
        });
        self.lines.extend(numbered);
    }

    /// Takes segments; their lines are numbered from `first_line` on, among those that are new.
    ///
    /// # Errors
    /// If they are given by record numbers, do not all tell of which polygon they are, or take more than half of the memory.
    pub fn push(&mut self, kind: LineKind, first_line: u64, batch: &SegmentBatch) -> Result<(), EditError> {
        if !batch.records.is_empty() {
            return Err(EditError::Records);
        }
        let (segments, polygons) = (batch.ends.len(), batch.polygons.len());
        if polygons != 0 && polygons != segments {
            return Err(ConstraintError::PolygonNumbers { segments, polygons }.into());
        }
        let first = self.first_line + first_line;
        let segments = batch.ends.iter().zip(&batch.lines).map(|(&ends, &line)| Segment {
            ends: ends.map(Point::normalized),
            source: EdgeSource::new(kind, first + line),
        });
        if !batch.z.is_empty() {
            self.z.resize(self.segments.len(), [NO_Z; 2]);
            self.z.extend_from_slice(&batch.z);
        }
        self.segments.extend(segments);
        EditShares::check_segments(self.memory, self.segments.len() as u64)?;
        if kind == LineKind::Obstacle {
            self.polygons.push(first, batch)?;
        }
        Ok(())
    }

    /// Makes the lines constraints. The file is as before until the very end.
    ///
    /// # Errors
    /// If an end lies outside the hull or lacks a z ([`missing_z`](Self::missing_z)), a line
    /// crosses a constraint, a ring does not close, a polygon is inside out, or the system refuses.
    pub async fn finish(self) -> Result<EditSummary, EditError> {
        let Self {
            target,
            memory,
            lines,
            mut segments,
            mut z,
            missing_z,
            mut polygons,
            ..
        } = self;
        let faults = polygons.finish()?;
        if let Some(line) = faults.open {
            return Err(EditError::OpenRing { line });
        }
        if let Some(inverted) = faults.inverted {
            return Err(EditError::Inverted(inverted));
        }
        drop(polygons);
        segments.shrink_to_fit();
        z.shrink_to_fit();
        let work = Work {
            new_records: 2 * segments.len() as u64,
            segments,
            z,
            missing_z,
            lines,
            inverted: faults.inverted_if_uncrossed,
            is_draft: false,
            threads: thread::available_parallelism().map_or(1, NonZero::get),
        };
        edit(target, work, memory, || false).await
    }
}

/// What an edit is to do.
pub(crate) struct Work {
    /// To become constraints.
    pub(crate) segments: Vec<Segment>,
    /// z at the ends of some, or [`NO_Z`].
    pub(crate) z: Vec<[f64; 2]>,
    /// What to do with those that have none and become vertices, if the file has z.
    pub(crate) missing_z: MissingZ,
    /// Lines that are new, to be entered in the directory.
    pub(crate) lines: Vec<LineSource>,
    /// Record numbers for the ends of the segments, in order; 0 if their ends were vertices before.
    pub(crate) new_records: u64,
    /// Obstacles that are inside out, if their rings cross at vertices only. The file stays as it was if they do.
    pub(crate) inverted: Option<InvertedPolygons>,
    /// Whether nobody relies on the file yet, so that it need not be on the medium when this is done.
    pub(crate) is_draft: bool,
    /// Threads that put tiles together, if the memory lets them.
    pub(crate) threads: usize,
}

impl Work {
    /// z at an end, by its number among all ends, or [`NO_Z`].
    fn z_of(&self, end: u32) -> f64 {
        self.z.get(end as usize / 2).map_or(NO_Z, |z| z[end as usize % 2])
    }
}

/// Makes segments constraints of a file, on a thread of its own.
pub(crate) async fn edit(
    target: Target,
    work: Work,
    memory: u64,
    is_cancelled: impl Fn() -> bool + Send + 'static,
) -> Result<EditSummary, EditError> {
    let stop = StopOnDrop(Arc::new(AtomicBool::new(false)));
    let stopped = Arc::clone(&stop.0);
    let (reply, done) = oneshot::channel();
    let runtime = Handle::current();
    let path = target.path.clone();
    let task = move || {
        let is_stopped = || stopped.load(Ordering::Relaxed) || is_cancelled();
        // If nobody waits for the answer any more, nobody needs it.
        let _ = reply.send(edit_here(target, &work, memory, &is_stopped, runtime));
    };
    start_thread("tile-edit", task).map_err(|error| tiles::cannot(&path, "start a thread to edit", error))?;
    let gone = |_| EditError::Internal("the editing thread is gone".to_owned());
    done.await.map_err(gone)?
}

/// Stops the thread when nobody waits for it any more.
struct StopOnDrop(Arc<AtomicBool>);

impl Drop for StopOnDrop {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

fn edit_here(
    target: Target,
    work: &Work,
    memory: u64,
    is_stopped: &dyn Fn() -> bool,
    runtime: Handle,
) -> Result<EditSummary, EditError> {
    let began = Instant::now();
    let shares = |largest| EditShares::new(memory, work.segments.len() as u64, work.threads, largest);
    let mut tiles = Tiles::open(target, &shares, work.is_draft, runtime)?;
    let Work { segments, lines, .. } = work;
    let (ends, vertices) = find_ends(&mut tiles, work, is_stopped)?;
    let mut inserting = Inserting::default();
    for piece in pieces(segments, &ends) {
        if is_stopped() {
            return Err(EditError::Cancelled);
        }
        inserting.insert(&mut tiles, piece)?;
    }
    drop(ends);
    let tile_reads = tiles.reads();
    let (labels, constraint_edges) = join(&mut tiles, memory, is_stopped)?;
    let (regions, spanning, hole_regions) = (labels.regions, labels.spanning, labels.hole_regions);
    if let Some(inverted) = work.inverted {
        return Err(EditError::Inverted(inverted));
    }
    let hole_triangles = label(&mut tiles, labels, is_stopped)?;
    let (tiles_written, length_before) = (
        tiles.is_changed.iter().filter(|changed| **changed).count(),
        tiles.length(),
    );
    let file_bytes = tiles.publish(|directory| {
        let entries = &directory.tiles;
        let before = std::mem::take(&mut directory.metadata);
        let most = entries.iter().map(|tile| tile.vertices).max();
        let all_vertices = entries.iter().map(|tile| u64::from(tile.vertices)).sum();
        let triangles = entries.iter().map(|tile| u64::from(tile.owned_triangles)).sum();
        let mut all_lines = before.lines;
        all_lines.extend_from_slice(lines);
        directory.metadata = Metadata {
            tile_vertices: before.tile_vertices.max(most.unwrap_or(0)),
            vertices: all_vertices,
            triangles,
            hull_edges: hull_edges(all_vertices, triangles),
            points: before.points,
            duplicates: before.duplicates,
            ends: before.ends + vertices,
            constraint_edges,
            has_z: before.has_z,
            bounds: before.bounds,
            sources: before.sources,
            crs: before.crs,
            producer: before.producer,
            regions,
            spanning_regions: spanning,
            hole_regions,
            hole_triangles,
            sites: before.sites,
            crossings: before.crossings,
            lines: all_lines,
            exterior_is_hole: before.exterior_is_hole,
            seeds: before.seeds,
            borders: before.borders,
            next_record: before.next_record.saturating_add(work.new_records),
        };
    })?;
    Ok(EditSummary {
        segments: segments.len() as u64,
        vertices,
        edges: inserting.edges,
        constraint_edges,
        tiles: tiles_written as u64,
        tile_reads,
        triangles_looked_at: inserting.looked_at,
        regions,
        hole_regions,
        hole_triangles,
        bytes_appended: file_bytes - length_before,
        file_bytes,
        seconds: began.elapsed().as_secs_f64(),
    })
}

/// The end of a segment: its tile, its place, and its number among all ends.
type End = (TileId, Point, u32);

/// Finds the vertices at the ends of segments, and makes some where there are none. Returns all, in order, and how many are new.
fn find_ends(tiles: &mut Tiles, work: &Work, is_stopped: &dyn Fn() -> bool) -> Result<(Vec<Vertex>, u64), EditError> {
    let metadata = &tiles.directory().metadata;
    let (first_record, metadata_has_z) = (metadata.next_record, metadata.has_z);
    let tree = tiles.directory().tree.clone();
    let no_vertex = |place: Point| EditError::Internal(format!("there is no vertex at ({}, {})", place.x, place.y));
    let mut ends: Vec<End> = Vec::with_capacity(2 * work.segments.len());
    for (&place, end) in work.segments.iter().flat_map(|segment| &segment.ends).zip(0u32..) {
        let tile = tree.tile_at(place).ok_or_else(|| no_vertex(place))?;
        ends.push((tile, place, end));
    }
    ends.sort_unstable_by(|a, b| a.0.cmp(&b.0).then_with(|| a.1.lex_cmp(b.1)).then_with(|| a.2.cmp(&b.2)));
    // All of them are replaced.
    let nowhere = Vertex {
        id: VertexId {
            tile: TileId(u32::MAX),
            index: 0,
        },
        point: Point::new(0.0, 0.0),
    };
    let mut found = vec![nowhere; ends.len()];
    let mut added = 0;
    let needs_z = metadata_has_z && work.missing_z == MissingZ::Error;
    let mut without_z: Vec<u32> = Vec::new();
    let mut groups = ends.chunk_by(|a, b| a.0 == b.0);
    while let Some(group) = groups.next() {
        if is_stopped() {
            return Err(EditError::Cancelled);
        }
        tiles.read_ahead(groups.clone().map(|group| group[0].0));
        let id = group[0].0;
        let numbers_in = |tile: &EditTile| -> Vec<Option<u32>> {
            let index = VertexIndex::new(tile.points());
            group.iter().map(|&(_, place, _)| index.at(place)).collect()
        };
        let mut tile = tiles.get(id)?;
        let mut numbers = numbers_in(&tile);
        let missing = group.iter().zip(&numbers).filter(|(_, number)| number.is_none());
        let mut missing: Vec<End> = missing.map(|(end, _)| *end).collect();
        // Of several at one place the first that has z says how high it lies.
        missing.dedup_by(|next, kept| {
            let equal = next.1 == kept.1;
            if equal && work.z_of(kept.2).is_nan() && !work.z_of(next.2).is_nan() {
                *kept = *next;
            }
            equal
        });
        if needs_z {
            without_z.extend(missing.iter().map(|end| end.2).filter(|&end| work.z_of(end).is_nan()));
        }
        if !missing.is_empty() {
            drop(tile);
            add_vertices(tiles, work, &missing, first_record)?;
            added += missing.len() as u64;
            tile = tiles.get(id)?;
            numbers = numbers_in(&tile);
        }
        for (&(_, place, end), number) in group.iter().zip(numbers) {
            found[end as usize] = tile.vertex(number.ok_or_else(|| no_vertex(place))?);
        }
    }
    if let Some(&first) = without_z.iter().min() {
        let segment = &work.segments[first as usize / 2];
        return Err(EditError::NoZ {
            line: segment.source.number(),
            point: segment.ends[first as usize % 2],
            count: without_z.len() as u64,
        });
    }
    Ok((found, added))
}

/// Makes vertices of ends in one tile, each at another place. The ends of all segments have the record numbers from
/// `first_record` on, in order.
fn add_vertices(tiles: &mut Tiles, work: &Work, ends: &[End], first_record: u64) -> Result<(), EditError> {
    let z_or_zero = |end: u32| {
        let z = work.z_of(end);
        if z.is_nan() { 0.0 } else { z }
    };
    let new = ends.iter().map(|&(_, point, end)| NewVertex {
        point,
        z: z_or_zero(end),
        record: first_record.saturating_add(end.into()),
        line: work.segments[end as usize / 2].source.number(),
    });
    vertices::add(tiles, ends[0].0, new.collect())
}

/// Puts segments in the order of a space-filling curve, so that those that cross the same tiles come together; these are the vertices at
/// their ends.
fn pieces(segments: &[Segment], ends: &[Vertex]) -> impl Iterator<Item = Piece> {
    let middle = |Segment { ends: [a, b], .. }: &Segment| Point::new((a.x + b.x) / 2.0, (a.y + b.y) / 2.0);
    let square = MortonSquare::around(Rect::around(segments.iter().map(middle)));
    let (ends, _) = ends.as_chunks();
    let keys = segments.iter().map(|segment| square.key(middle(segment)));
    let mut order: Vec<(u64, u32)> = keys.zip(0..).collect();
    order.sort_unstable();
    order.into_iter().map(move |(_, number)| Piece {
        ends: ends[number as usize],
        source: segments[number as usize].source,
    })
}

/// Joins what lies side by side in all tiles. Returns also how many constraint edges there are.
fn join(tiles: &mut Tiles, memory: u64, is_stopped: &dyn Fn() -> bool) -> Result<(Labels, u64), EditError> {
    let metadata = tiles.directory().metadata.clone();
    let mut joining = Joining::new(&metadata);
    let mut parted = tiles.parted();
    while let Some(PartedTile { tile, parts, before }) = parted.next()? {
        if is_stopped() {
            return Err(EditError::Cancelled);
        }
        joining.take(&tile, &parts, before.as_ref())?;
        EditShares::check_regions(memory, joining.byte_size())?;
    }
    let constraint_edges = joining.constraint_edges;
    Ok((joining.finish(&metadata)?, constraint_edges))
}

/// Writes all tiles that were changed, and those in which a region changed. Returns how many triangles are in holes.
fn label(tiles: &mut Tiles, labels: Labels, is_stopped: &dyn Fn() -> bool) -> Result<u64, EditError> {
    tiles.label(labels)?;
    let mut in_holes = 0;
    for id in (0..tiles.is_changed.len() as u32).map(TileId) {
        if is_stopped() {
            return Err(EditError::Cancelled);
        }
        if let Some(known) = tiles.in_holes(id) {
            in_holes += u64::from(known);
            continue;
        }
        let mut tile = tiles.read(id)?;
        if !tiles.is_changed[id.0 as usize] {
            let edit = EditTile::of(&tile);
            let parts = Parts::of(&edit);
            // The places of a tile that is not changed are its triangles.
            let is_same = tiles.labels().is_none_or(|labels| {
                let label = |triangle| labels.of(id, &parts, triangle);
                (0..tile.triangle_count()).all(|triangle| tile.component(triangle) == label(triangle))
            });
            if !is_same {
                tiles.write(edit)?;
                tile = tiles.read(id)?;
            }
        }
        let holes = tile.owned_triangles().filter(|&triangle| tile.is_hole(triangle));
        in_holes += holes.count() as u64;
    }
    Ok(in_holes)
}
