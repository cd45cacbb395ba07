//! From points to a tile file: divide, conquer, merge, borders.
//!
//! ```text
//! push ──▶ point_store ──▶ divide ──▶ leaf ──▶ merge ──▶ border_log ──▶ border ──▶ work_folder ──▶ OUT
//!          all points      k-d tree   cores    late       spilled       the rest   publish
//!                          and cells  seams    triangles  by bucket     of tiles
//!                                       └─ node ─┘
//! ```
//!
//! [`Builder`] takes batches and starts `pipeline` on computing threads, which share a board of tasks (`schedule`). What
//! they finish comes in the order of the file (`ordered`) through a channel to the task that writes.

mod border;
mod border_log;
mod budget;
mod divide;
mod error;
mod leaf;
mod merge;
mod node;
mod options;
mod ordered;
mod pipeline;
mod point_store;
mod schedule;
mod summary;
mod work_folder;

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::Instant;

use tokio::sync::{mpsc, oneshot};

use crate::geometry::Rect;
use crate::input::PointBatch;
use crate::io::ThreadsFile;
use crate::store::{Directory, Extent, Metadata, Source, TileEntry, TileWriter};

pub use budget::{default_memory, peak_memory};
pub use error::BuildError;
pub use options::{BuildOptions, Duplicates, Phase, Progress, UnknownDuplicates};
pub use summary::{BuildSummary, LevelSummary, PhaseSummary};

use pipeline::Computed;
use point_store::PointStore;
use work_folder::WorkFolder;

/// The generation that a new file starts with.
const GENERATION: u32 = 1;

/// Builds a tile file from batches of points.
///
/// Until [`finish`](Self::finish) has succeeded, nothing stands under the output's name; work lies in `OUT.partial/`,
/// which goes away with the builder.
#[derive(Debug)]
pub struct Builder {
    options: Arc<BuildOptions>,
    folder: WorkFolder,
    output: PathBuf,
    points: PointStore,
    has_z: bool,
    sources: Vec<Source>,
    crs: Option<String>,
    began: Instant,
}

impl Builder {
    /// Starts a build.
    ///
    /// # Errors
    /// If an option is out of range, the output exists and is not to be replaced, or its folder cannot be written.
    pub fn new(output: impl AsRef<Path>, options: BuildOptions) -> Result<Self, BuildError> {
        for (option, found, min, max) in [
            (
                "tile vertices",
                options.tile_vertices,
                BuildOptions::MIN_TILE_VERTICES,
                BuildOptions::MAX_TILE_VERTICES,
            ),
            ("threads", options.threads, 1, 1024),
        ] {
            if !(min..=max).contains(&found) {
                return Err(BuildError::Option {
                    option,
                    min,
                    max,
                    found,
                });
            }
        }
        let output = output.as_ref().to_owned();
        let folder = WorkFolder::create(&output, options.force)?;
        options.progress.start(Phase::Read, 0);
        Ok(Self {
            options: Arc::new(options),
            folder,
            output,
            points: PointStore::default(),
            has_z: false,
            sources: Vec::new(),
            crs: None,
            began: Instant::now(),
        })
    }

    /// Notes where the points come from and in which coordinate reference system, as metadata.
    pub fn describe(&mut self, sources: Vec<Source>, crs: Option<String>) {
        self.sources = sources;
        self.crs = crs;
    }

    /// Takes a batch of points.
    ///
    /// # Errors
    /// If a point is [not valid](crate::geometry::Point::is_valid) or a z not finite, the batch's arrays are not equally
    /// long, the points outgrow the memory, or the build was cancelled.
    pub async fn push(&mut self, batch: &PointBatch) -> Result<(), BuildError> {
        if self.options.progress.is_cancelled() {
            return Err(BuildError::Cancelled);
        }
        let (points, z, records) = (batch.points.len(), batch.z.len(), batch.records.len());
        if records != points || !(z == points || z == 0) {
            return Err(BuildError::Batch { points, z, records });
        }
        if let Some((&z, &record)) = batch.z.iter().zip(&batch.records).find(|(z, _)| !z.is_finite()) {
            return Err(BuildError::InvalidZ { record, z });
        }
        let invalid = batch.points.iter().zip(&batch.records).find(|(p, _)| !p.is_valid());
        if let Some((&point, &record)) = invalid {
            return Err(BuildError::InvalidPoint { record, point });
        }
        if batch.points.len() > PointStore::MAX_POINTS - self.points.items.len() {
            return Err(BuildError::TooManyPoints(PointStore::MAX_POINTS));
        }
        self.has_z |= !batch.z.is_empty();
        self.points.push(batch);
        self.check_memory()?;
        let points = batch.points.len() as u64;
        self.options.progress.advance(points, points);
        Ok(())
    }

    /// Fails if the points, and the tiles that are worked on at once, need more memory than is allowed.
    fn check_memory(&self) -> Result<(), BuildError> {
        /// Of a point in work: kernel, mesh, draft and FlatBuffer of its tile.
        const WORK_BYTES: u64 = 400;
        let options = &self.options;
        let points = self.points.items.len() as u64;
        let in_work = points.min((options.tile_vertices * options.threads) as u64);
        let needed = self.points.byte_size() + in_work * WORK_BYTES;
        if needed > options.memory {
            return Err(BuildError::Memory {
                points,
                needed,
                budget: options.memory,
            });
        }
        Ok(())
    }

    /// Builds the file and gives it its name. Must be awaited within a tokio runtime; computing happens on threads of its
    /// own.
    ///
    /// # Errors
    /// If something cannot be written, duplicates were to be an error, or the build was cancelled.
    pub async fn finish(self) -> Result<BuildSummary, BuildError> {
        let path = self.folder.file();
        let cannot = |what| {
            let path = path.clone();
            move |error: io::Error| BuildError::io(&path, what, error)
        };
        let file = ThreadsFile::create(&path).map_err(cannot("make the file"))?;
        let mut writer = TileWriter::new(file);
        let count = self.points.items.len() as u64;
        let (sender, mut extents) = mpsc::channel(self.options.threads);
        let (reply, computed) = oneshot::channel();
        let (points, options) = (self.points, Arc::clone(&self.options));
        let spill_folder = options
            .work_folder
            .clone()
            .unwrap_or_else(|| self.folder.path().to_owned());
        thread::Builder::new()
            .name("tile-build".to_owned())
            .spawn(move || {
                // If nobody waits for the answer any more, nobody needs it.
                let _ = reply.send(pipeline::run(points, &options, &spill_folder, sender));
            })
            .map_err(cannot("start a thread to build"))?;

        let (mut cores, mut borders) = (Vec::new(), Vec::new());
        while let Some(extent) = extents.recv().await {
            // A failed write drops the channel, which stops the computing threads.
            let appended = match extent {
                pipeline::Extent::Core(bytes) => writer.append_core(&bytes).await.map(|extent| cores.push(extent)),
                pipeline::Extent::Border(bytes) => {
                    writer.append_border(&bytes).await.map(|extent| borders.push(extent))
                }
            };
            appended.map_err(cannot("write"))?;
        }
        let computed = computed
            .await
            .unwrap_or_else(|_| Err(BuildError::Internal("the building thread is gone".to_owned())))?;

        let metadata = Metadata {
            points: count,
            has_z: self.has_z,
            sources: self.sources,
            crs: self.crs,
            tile_vertices: self.options.tile_vertices as u32,
            ..Metadata::default()
        };
        let directory = directory(&computed, &cores, &borders, metadata);
        let written_before = writer.length();
        let file_bytes = writer.finish(&directory).await.map_err(cannot("finish"))?;
        if self.options.progress.is_cancelled() {
            return Err(BuildError::Cancelled);
        }
        if !self.options.force && self.output.exists() {
            return Err(BuildError::OutputExists(self.output));
        }
        self.folder.publish()?;
        let bytes = |extents: &[Extent]| extents.iter().map(|e| u64::from(e.length)).sum::<u64>();
        let spilled = computed.spilled_bytes;
        let read = [0, 0, 0, spilled, 0];
        let written = [
            0,
            0,
            bytes(&cores) + spilled,
            bytes(&borders),
            file_bytes - written_before,
        ];
        Ok(summary(&computed, &directory, self.began, [read, written], file_bytes))
    }
}

/// The directory of a file whose extents are all written.
fn directory(computed: &Computed, cores: &[Extent], borders: &[Extent], mut metadata: Metadata) -> Directory {
    let extents = cores.iter().zip(borders);
    let tiles: Vec<TileEntry> = computed
        .tiles
        .iter()
        .zip(extents)
        .map(|(tile, (&core, &border))| TileEntry {
            core,
            border,
            generation: GENERATION,
            vertices: tile.vertices,
            core_triangles: tile.core_triangles,
            border_triangles: tile.border_triangles,
            owned_triangles: tile.owned_triangles,
            bounds: tile.bounds.unwrap_or(Rect::EMPTY),
        })
        .collect();
    metadata.vertices = tiles.iter().map(|t| u64::from(t.vertices)).sum();
    metadata.triangles = tiles.iter().map(|t| u64::from(t.owned_triangles)).sum();
    metadata.bounds = tiles.iter().fold(Rect::EMPTY, |all, t| all.union(t.bounds));
    metadata.duplicates = computed.duplicates;
    // Euler's formula for a triangulated disc.
    metadata.hull_edges = match metadata.triangles {
        0 => 0,
        triangles => (2 * metadata.vertices - 2).saturating_sub(triangles),
    };
    Directory {
        metadata,
        tree: computed.tree.clone(),
        tiles,
    }
}

fn summary(
    computed: &Computed,
    directory: &Directory,
    began: Instant,
    [read, written]: [[u64; 5]; 2],
    file_bytes: u64,
) -> BuildSummary {
    let metadata = &directory.metadata;
    let mut starts = vec![(Phase::Read, began)];
    starts.extend_from_slice(&computed.began);
    let ends = starts.iter().skip(1).map(|s| s.1).chain([Instant::now()]);
    BuildSummary {
        points: metadata.points,
        duplicates: metadata.duplicates,
        vertices: metadata.vertices,
        triangles: metadata.triangles,
        border_triangles: computed.late_triangles,
        hull_edges: metadata.hull_edges,
        tiles: directory.tiles.len() as u64,
        file_bytes,
        phases: starts
            .iter()
            .zip(ends)
            .zip(read.into_iter().zip(written))
            .map(|((&(phase, start), end), (bytes_read, bytes_written))| PhaseSummary {
                phase,
                time: end - start,
                bytes_read,
                bytes_written,
            })
            .collect(),
        levels: computed.levels.clone(),
        peak_memory: peak_memory(),
    }
}
