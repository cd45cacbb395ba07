//! The way of contours from tiles to features.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::pin::pin;
use std::sync::Arc;

use futures::stream::{self, Stream, StreamExt};

use super::clipped::{Clipped, Whole};
use super::features::{Contour, Encoding, FeatureSink, Features};
use crate::export::error::{Contradiction, ExportError};
use crate::export::spool::Spool;
use crate::geometry::Point;
use crate::memory::FileShares;
use crate::store::{Needs, PassReader, ReadError, TileId, TileInPass, spawn};
use crate::terrain::{CUT_PER_EDGE, Clip, complete, level_ranges, push, trace};
use crate::terrain::{Ends, FileSurface, Levels, Run, Side, Strand, Strands, TerrainError, TileChains, Traced};

/// The number of bytes of a point in the temporary file.
const POINT_BYTES: u64 = size_of::<Point>() as u64;
/// Contours of more points are read and formatted one by one.
const LONG: u64 = 1 << 13;
/// The number of bytes that are read at once.
const READ: u64 = 1 << 20;

/// Some levels in a tile.
struct Slice {
    tile: Arc<TileInPass>,
    traced: Arc<Traced>,
    levels: Range<i64>,
    /// Whether these are the last levels of the tile.
    is_last: bool,
}

/// What was found in a slice.
struct Drawn {
    /// The complete contours.
    features: Features,
    /// The other chains, and their points as they are stored.
    chains: TileChains,
    stored: Vec<u8>,
    is_last: bool,
    tile: TileId,
}

/// What becomes of a chain.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Fate {
    /// It is a contour.
    Written,
    /// Others continue it, or polygons cut it.
    Stored,
    /// No polygon has any of it.
    Dropped,
}

fn fate(clip: Option<&Clip>, ends: Ends, points: &[Point]) -> Fate {
    if !matches!(ends, Ends::Closed | Ends::Open([None, None])) {
        return Fate::Stored;
    }
    match clip.map_or(Side::Inside, |clip| clip.side_of_line(points)) {
        Side::Inside => Fate::Written,
        Side::Both => Fate::Stored,
        Side::Outside => Fate::Dropped,
    }
}

impl Slice {
    /// Traces the contours, and formats those that are complete.
    fn draw(self, reader: &PassReader, levels: &Levels, encoding: Encoding) -> Result<Drawn, ExportError> {
        let tile = self.tile.id();
        let mut drawn = Drawn {
            features: Features::new(encoding),
            chains: TileChains::default(),
            stored: Vec::new(),
            is_last: self.is_last,
            tile,
        };
        if self.levels.is_empty() {
            return Ok(drawn);
        }
        let traced = trace(&self.tile, &self.traced, levels, self.levels);
        let mut traced = traced.map_err(|fault| reader.damaged(tile, fault.to_string()))?;
        let points = std::mem::take(&mut traced.points);
        for chain in std::mem::take(&mut traced.chains) {
            let points = &points[chain.points.clone()];
            match fate(self.traced.clip(), chain.ends, points) {
                Fate::Written => drawn.features.add(Contour {
                    z: levels.height(chain.level),
                    points,
                    is_closed: chain.ends == Ends::Closed,
                })?,
                Fate::Stored => {
                    for number in points.iter().flat_map(|point| [point.x, point.y]) {
                        drawn.stored.extend_from_slice(&number.to_le_bytes());
                    }
                    traced.chains.push(chain);
                }
                Fate::Dropped => {}
            }
        }
        drawn.chains = traced;
        Ok(drawn)
    }
}

/// Returns the slices of a tile, at least one.
fn slices(
    reader: &PassReader,
    (surface, clip): (&FileSurface, Option<Arc<Clip>>),
    levels: &Levels,
    tile: TileInPass,
) -> Result<Vec<Slice>, ExportError> {
    if !tile.has_z() {
        return Err(reader.damaged(tile.id(), Contradiction::HasZ.to_string()).into());
    }
    let traced = Arc::new(Traced::new(surface.in_tile(&tile), clip));
    let mut ranges = level_ranges(&tile, &traced, levels).map_err(TerrainError::from)?;
    if ranges.is_empty() {
        ranges.push(0..0);
    }
    let tile = Arc::new(tile);
    let count = ranges.len();
    let numbered = (1..).zip(ranges);
    Ok(numbered
        .map(|(number, levels)| Slice {
            tile: Arc::clone(&tile),
            traced: Arc::clone(&traced),
            levels,
            is_last: number == count,
        })
        .collect())
}

/// The state of an export.
pub(super) struct ContourJob<W> {
    reader: PassReader,
    surface: FileSurface,
    levels: Levels,
    /// The polygons in which the contours are.
    clip: Option<Arc<Clip>>,
    encoding: Encoding,
    sink: FeatureSink<W>,
    spool: Spool,
    strands: Strands,
    /// Complete contours that are not read yet, and the number of their points.
    waiting: (Vec<Strand>, u64),
    /// The memory that `strands` and a contour that is read may take.
    most: u64,
}

impl<W: Write + Send + 'static> ContourJob<W> {
    /// The memory that tracing takes for each crossing of a level and a triangle: points, in lists that
    /// grow, the texts of complete contours and the bytes of the others.
    const PER_CROSSING: u64 = 3 * POINT_BYTES + 2 * Encoding::POINT_BYTES + POINT_BYTES + 1;
    /// The memory that a contour that is cut takes for each of its points: itself, and parts of it, which
    /// grow.
    const PER_CUT_POINT: u64 = (1 + 4) * POINT_BYTES;

    pub(super) fn new(
        reader: PassReader,
        (surface, levels, clip): (FileSurface, Levels, Option<Arc<Clip>>),
        encoding: Encoding,
        sink: FeatureSink<W>,
        spool: Spool,
    ) -> Self {
        let mut job = Self {
            reader,
            surface,
            levels,
            clip,
            encoding,
            sink,
            spool,
            strands: Strands::new(),
            waiting: (Vec::new(), 0),
            most: 0,
        };
        if let Some(share) = FileShares(job.reader.memory()).pass() {
            // The other half of what is left is for further tiles.
            job.most = share.saturating_sub(job.least()) / 2;
        }
        job
    }

    /// Returns the memory that a pass needs.
    fn needs(&self) -> Needs {
        // A vertex has two triangles. The slices of a tile have about as many crossings.
        let per_vertex = 2 * (Self::PER_CROSSING + size_of::<u32>() as u64);
        let tiles = self.reader.directory().tiles.iter();
        let largest = tiles.map(|tile| u64::from(tile.vertices)).max().unwrap_or(0);
        let needs = Needs {
            // What is written, and a slice that waits for it.
            fixed: self.most + (4 << 20) + 2 * LONG * Self::PER_CROSSING + per_vertex * largest + self.per_cut(),
            per_thread: (1 << 20) + Levels::MAX * size_of::<i64>() as u64,
            per_vertex,
        };
        needs.and(self.surface.needs())
    }

    /// Returns the memory that cutting takes: all edges of polygons may be near a segment.
    fn per_cut(&self) -> u64 {
        self.clip.as_ref().map_or(0, |clip| CUT_PER_EDGE * clip.edge_count())
    }

    /// Returns the tiles that contours may be in.
    fn tiles(&self) -> Vec<TileId> {
        let directory = self.reader.directory();
        let bounds = |id: &TileId| directory.tiles[id.0 as usize].bounds;
        let reaches = |id: &TileId| self.clip.as_ref().is_none_or(|clip| clip.reaches(bounds(id)));
        let mut tiles = self.reader.tile_ids();
        tiles.retain(reaches);
        tiles
    }

    /// Returns the memory that the smallest pass needs.
    fn least(&self) -> u64 {
        self.needs().least(self.reader.directory())
    }

    /// Fails if `further` bytes beside those of `strands` are too many.
    fn check_memory(&self, further: u64) -> Result<(), ReadError> {
        let used = self.strands.bytes() + further;
        if self.reader.memory().is_none() || used <= self.most {
            return Ok(());
        }
        // Half of what is left is for this, and more may follow.
        let needed = self.least() - self.most + 2 * 2 * used;
        Err(self.reader.too_little_memory(needed + needed / 15))
    }

    /// Writes all contours. Calls `progress` with the number of tiles done and the total after each tile.
    pub(super) async fn run(
        mut self,
        mut progress: impl FnMut(u64, u64) + Send,
    ) -> Result<FeatureSink<W>, ExportError> {
        let threads = self.reader.plan(self.needs())?.threads;
        let (reader, levels, encoding) = (self.reader.clone(), self.levels, self.encoding);
        let tiles = self.tiles();
        let (mut done, total) = (0, tiles.len() as u64);
        let drawn = self.slices(tiles)?.map(move |slice| {
            let reader = reader.clone();
            let drawn = slice.map(|slice| spawn(move || slice.draw(&reader, &levels, encoding)));
            async move { drawn?.await? }
        });
        let mut drawn = pin!(drawn.buffered(threads));
        while let Some(drawn) = drawn.next().await {
            let drawn = drawn?;
            let is_last = drawn.is_last;
            self.take(drawn).await?;
            if is_last {
                done += 1;
                progress(done, total);
            }
        }
        let strands = std::mem::replace(&mut self.strands, Strands::new());
        for strand in strands.into_rest() {
            self.complete(strand).await?;
        }
        self.write_waiting().await?;
        Ok(self.sink)
    }

    /// Returns the slices of tiles, in order.
    fn slices(
        &self,
        tiles: Vec<TileId>,
    ) -> Result<impl Stream<Item = Result<Slice, ExportError>> + Send + use<W>, ExportError> {
        let plan = self.reader.plan(self.needs())?;
        let (reader, surface, levels) = (self.reader.clone(), self.surface.clone(), self.levels);
        let clip = self.clip.clone();
        let tiles = self.reader.pass(tiles, plan).boxed();
        let tiles = tiles.map(move |tile| {
            let (reader, surface, clip) = (reader.clone(), surface.clone(), clip.clone());
            async move {
                let tile = tile?;
                spawn(move || slices(&reader, (&surface, clip), &levels, tile)).await?
            }
        });
        let mut all: Option<Range<i64>> = None;
        let checked = tiles.buffered(plan.threads).map(move |slices| {
            let slices = slices?;
            for Range { start, end } in slices.iter().map(|slice| slice.levels.clone()) {
                if start < end {
                    let before = all.get_or_insert(start..end);
                    *before = before.start.min(start)..before.end.max(end);
                }
            }
            let all = all.clone().unwrap_or_default();
            levels.check_count(&all).map_err(TerrainError::from)?;
            Ok(slices)
        });
        Ok(checked.flat_map(|slices| match slices {
            Ok(slices) => stream::iter(slices).map(Ok).left_stream(),
            Err(error) => stream::iter([Err(error)]).right_stream(),
        }))
    }

    /// Writes the complete contours of a slice, and joins the other chains.
    async fn take(&mut self, drawn: Drawn) -> Result<(), ExportError> {
        self.sink.push(drawn.features).await?;
        if drawn.stored.is_empty() {
            return Ok(());
        }
        let mut start = self.spool.length() / POINT_BYTES;
        self.spool.append(drawn.stored).await?;
        for chain in drawn.chains.chains {
            let points = chain.points.len() as u64;
            let run = Run { start, points };
            start += points;
            let complete = match chain.ends {
                Ends::Closed => Ok(Some(Strand::closed(chain.level, run))),
                Ends::Open(ends) => self.strands.add(chain.level, run, ends),
            };
            let complete = complete.map_err(|fault| self.reader.damaged(drawn.tile, fault.to_string()))?;
            if let Some(strand) = complete {
                self.complete(strand).await?;
            }
        }
        Ok(self.check_memory(0)?)
    }

    /// Writes a complete contour, at once or with others.
    async fn complete(&mut self, strand: Strand) -> Result<(), ExportError> {
        let points = strand.points();
        if points > LONG {
            self.write_waiting().await?;
            return match &self.clip {
                None => self.write_long(strand).await,
                Some(clip) => {
                    let per_point = Self::PER_CUT_POINT + self.encoding.memory_per_point();
                    self.check_memory(points.saturating_mul(per_point))?;
                    self.write_parts(Arc::clone(clip), vec![strand]).await
                }
            };
        }
        self.waiting.0.push(strand);
        self.waiting.1 += points;
        match self.waiting.1 > LONG {
            true => self.write_waiting().await,
            false => Ok(()),
        }
    }

    /// Writes the contours that wait.
    async fn write_waiting(&mut self) -> Result<(), ExportError> {
        let (strands, _) = std::mem::take(&mut self.waiting);
        if strands.is_empty() {
            return Ok(());
        }
        if let Some(clip) = &self.clip {
            return self.write_parts(Arc::clone(clip), strands).await;
        }
        let (levels, encoding) = (self.levels, self.encoding);
        let read = self.spool.with(move |file| {
            let mut features = Features::new(encoding);
            for strand in strands {
                let points = read(file, &strand)?;
                if let Err(error) = points.map_or(Ok(()), |points| {
                    features.add(Contour {
                        z: levels.height(strand.level),
                        points: &points,
                        is_closed: strand.is_closed,
                    })
                }) {
                    return Ok(Err(error));
                }
            }
            Ok(Ok(features))
        });
        let features = read.await??;
        self.sink.push(features).await
    }

    /// Writes a contour part by part.
    async fn write_long(&mut self, strand: Strand) -> Result<(), ExportError> {
        self.check_memory(strand.points().saturating_mul(self.encoding.memory_per_point()))?;
        let (z, is_closed) = (self.levels.height(strand.level), strand.is_closed);
        let points = self.spool.with(move |file| read(file, &strand)).await?;
        let Some(points) = points else { return Ok(()) };
        let (points, encoding) = (Arc::new(points), self.encoding);
        for part in encoding.parts(points.len()) {
            let points = Arc::clone(&points);
            let features = spawn(move || {
                let mut features = Features::new(encoding);
                let contour = Contour {
                    z,
                    points: &points,
                    is_closed,
                };
                features.add_part(contour, part).map(|()| features)
            });
            self.sink.push(features.await??).await?;
        }
        Ok(())
    }

    /// Writes the parts of contours that are in polygons.
    async fn write_parts(&mut self, clip: Arc<Clip>, strands: Vec<Strand>) -> Result<(), ExportError> {
        let levels = self.levels;
        let wholes = self.spool.with(move |file| {
            let mut wholes = Vec::with_capacity(strands.len());
            for strand in strands {
                let (z, is_closed) = (levels.height(strand.level), strand.is_closed);
                wholes.extend(read(file, &strand)?.map(|points| Whole { z, points, is_closed }));
            }
            Ok(wholes)
        });
        let mut clipped = Clipped::new(clip, self.encoding, wholes.await?);
        loop {
            let (rest, features) = spawn(move || {
                let features = clipped.next();
                (clipped, features)
            })
            .await?;
            let Some(features) = features? else { return Ok(()) };
            self.sink.push(features).await?;
            clipped = rest;
        }
    }
}

/// Reads the points of a complete contour; `None` if it is not longer than a point.
fn read(file: &mut File, strand: &Strand) -> io::Result<Option<Vec<Point>>> {
    // A closed contour gets its first point again.
    let mut points = Vec::with_capacity(strand.points() as usize + 1);
    let mut bytes = Vec::new();
    for run in &strand.runs {
        file.seek(SeekFrom::Start(run.start * POINT_BYTES))?;
        let mut left = run.points * POINT_BYTES;
        while left > 0 {
            bytes.resize(left.min(READ) as usize, 0);
            file.read_exact(&mut bytes)?;
            left -= bytes.len() as u64;
            let mut numbers = bytes.as_chunks().0.iter().map(|&number| f64::from_le_bytes(number));
            while let (Some(x), Some(y)) = (numbers.next(), numbers.next()) {
                push(&mut points, Point::new(x, y));
            }
        }
    }
    Ok(complete(&mut points, strand.is_closed).then_some(points))
}
