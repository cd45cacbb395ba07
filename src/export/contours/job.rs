//! The way of contours from tiles to features.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::pin::pin;
use std::sync::Arc;

use futures::stream::{self, Stream, StreamExt};

use super::features::{Contour, Encoding, FeatureSink, Features};
use crate::export::error::{Contradiction, ExportError};
use crate::export::spool::Spool;
use crate::geometry::Point;
use crate::memory::FileShares;
use crate::store::{Needs, PassReader, ReadError, TileInPass, spawn};
use crate::terrain::{Ends, FileSurface, Levels, Run, Strand, Strands, TerrainError, TileChains, TileSurface};
use crate::terrain::{complete, level_ranges, push, trace};

/// The number of bytes of a point in the temporary file.
const POINT_BYTES: u64 = size_of::<Point>() as u64;
/// Contours of more points are read and formatted one by one.
const LONG: u64 = 1 << 13;
/// The number of bytes that are read at once.
const READ: u64 = 1 << 20;

/// Some levels in a tile.
struct Slice {
    tile: Arc<TileInPass>,
    surface: Arc<TileSurface>,
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
    tile: crate::store::TileId,
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
        let traced = trace(&self.tile, &self.surface, levels, self.levels);
        let mut traced = traced.map_err(|fault| reader.damaged(tile, fault.to_string()))?;
        for chain in &traced.chains {
            let points = &traced.points[chain.points.clone()];
            match chain.ends {
                Ends::Closed | Ends::Open([None, None]) => drawn.features.add(Contour {
                    z: levels.height(chain.level),
                    points,
                    is_closed: chain.ends == Ends::Closed,
                })?,
                Ends::Open(_) => {
                    for number in points.iter().flat_map(|point| [point.x, point.y]) {
                        drawn.stored.extend_from_slice(&number.to_le_bytes());
                    }
                }
            }
        }
        let continues = |ends: &Ends| matches!(ends, Ends::Open([start, end]) if start.is_some() || end.is_some());
        traced.chains.retain(|chain| continues(&chain.ends));
        traced.points = Vec::new();
        drawn.chains = traced;
        Ok(drawn)
    }
}

/// Returns the slices of a tile, at least one.
fn slices(
    reader: &PassReader,
    surface: &FileSurface,
    levels: &Levels,
    tile: TileInPass,
) -> Result<Vec<Slice>, ExportError> {
    if !tile.has_z() {
        return Err(reader.damaged(tile.id(), Contradiction::HasZ.to_string()).into());
    }
    let surface = Arc::new(surface.in_tile(&tile));
    let mut ranges = level_ranges(&tile, &surface, levels).map_err(TerrainError::from)?;
    if ranges.is_empty() {
        ranges.push(0..0);
    }
    let tile = Arc::new(tile);
    let count = ranges.len();
    let numbered = (1..).zip(ranges);
    Ok(numbered
        .map(|(number, levels)| Slice {
            tile: Arc::clone(&tile),
            surface: Arc::clone(&surface),
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

    pub(super) fn new(
        reader: PassReader,
        (surface, levels): (FileSurface, Levels),
        encoding: Encoding,
        sink: FeatureSink<W>,
        spool: Spool,
    ) -> Self {
        let mut job = Self {
            reader,
            surface,
            levels,
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
            fixed: self.most + (4 << 20) + 2 * LONG * Self::PER_CROSSING + per_vertex * largest,
            per_thread: (1 << 20) + Levels::MAX * size_of::<i64>() as u64,
            per_vertex,
        };
        needs.and(self.surface.needs())
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

    /// Writes all contours. Calls `advance` after each tile.
    pub(super) async fn run(mut self, mut advance: impl FnMut() + Send) -> Result<FeatureSink<W>, ExportError> {
        let threads = self.reader.plan(self.needs())?.threads;
        let (reader, levels, encoding) = (self.reader.clone(), self.levels, self.encoding);
        let drawn = self.slices()?.map(move |slice| {
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
                advance();
            }
        }
        let strands = std::mem::replace(&mut self.strands, Strands::new());
        for strand in strands.into_rest() {
            self.complete(strand).await?;
        }
        self.write_waiting().await?;
        Ok(self.sink)
    }

    /// Returns the slices of all tiles, in order.
    fn slices(&self) -> Result<impl Stream<Item = Result<Slice, ExportError>> + Send + use<W>, ExportError> {
        let plan = self.reader.plan(self.needs())?;
        let (reader, surface, levels) = (self.reader.clone(), self.surface.clone(), self.levels);
        let tiles = self.reader.pass(self.reader.tile_ids(), plan).boxed();
        let tiles = tiles.map(move |tile| {
            let (reader, surface) = (reader.clone(), surface.clone());
            async move {
                let tile = tile?;
                spawn(move || slices(&reader, &surface, &levels, tile)).await?
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
            let Ends::Open(ends) = chain.ends else { continue };
            let points = chain.points.len() as u64;
            let run = Run { start, points };
            start += points;
            let added = self.strands.add(chain.level, run, ends);
            let complete = added.map_err(|fault| self.reader.damaged(drawn.tile, fault.to_string()))?;
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
            return self.write_long(strand).await;
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
