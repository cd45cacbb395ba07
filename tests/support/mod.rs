//! What several tests share: points of every distribution, builds in a scratch folder, the in-core
//! reference.
#![allow(dead_code, reason = "each test uses its part")]

pub mod cases;
pub mod errors;
pub mod faults;
pub mod flat;
pub mod oracle;
pub mod peeling;
pub mod test_data;

use std::path::{Path, PathBuf};
use std::pin::{Pin, pin};
use std::time::Duration;

use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::PointBatch;
use delaunay_tiles::io::MemoryFile;
use delaunay_tiles::mesh::{EngineKind, Triangulation};
use delaunay_tiles::store::{
    Digest, LineBatch, LinePart, OpenOptions, ReadError, TileReader, VerifyError, VerifyReport,
};
use delaunay_tiles::{BuildError, BuildOptions, BuildSummary, Builder};
use distributions::Kind;

/// Returns `n` points of a distribution.
pub fn points_of(kind: Kind, n: u64, seed: u64) -> Vec<Point> {
    distributions::points(kind, n, seed)
        .map(|[x, y]| Point::new(x, y))
        .collect()
}

/// Returns batches of points, with their indices as record numbers, and with z if there is any.
pub fn batches(points: &[Point], z: &[f64]) -> Vec<PointBatch> {
    let size = 1000;
    let chunks = points.chunks(size).zip((0u64..).step_by(size));
    chunks
        .map(|(chunk, first)| PointBatch {
            points: chunk.to_vec(),
            z: z.iter().skip(first as usize).take(chunk.len()).copied().collect(),
            records: (first..first + chunk.len() as u64).collect(),
        })
        .collect()
}

/// Builds a file.
pub async fn build_batches(
    output: &Path,
    batches: &[PointBatch],
    options: BuildOptions,
) -> Result<BuildSummary, BuildError> {
    let mut builder = Builder::new(output, options)?;
    for batch in batches {
        builder.push(batch).await?;
    }
    builder.finish().await
}

/// A tile file in a temporary folder, which is removed on drop.
pub struct Scratch {
    pub folder: tempfile::TempDir,
    pub path: PathBuf,
}

impl Scratch {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("test.tiles");
        Self { folder, path }
    }

    pub async fn open(&self) -> TileReader {
        TileReader::open(&self.path, OpenOptions::default()).await.unwrap()
    }
}

/// Builds a file from points, and opens it.
pub async fn built(points: &[Point], options: BuildOptions) -> (Scratch, TileReader) {
    let scratch = Scratch::new();
    build_batches(&scratch.path, &batches(points, &[]), options)
        .await
        .unwrap();
    let reader = scratch.open().await;
    (scratch, reader)
}

/// Returns each distinct point once, sorted.
pub fn distinct(points: &[Point]) -> Vec<Point> {
    let mut distinct: Vec<Point> = points.iter().map(|p| p.normalized()).collect();
    distinct.sort_unstable_by(|a, b| a.lex_cmp(*b));
    distinct.dedup();
    distinct
}

/// Returns the digest of an in-core triangulation of all points at once.
pub fn reference(engine: EngineKind, points: &[Point]) -> Digest {
    let points = distinct(points);
    let mut mesh = Triangulation::default();
    engine.create().triangulate(&points, &mut mesh);
    let mut digest = Digest::default();
    points.iter().for_each(|&p| digest.add_vertex(p));
    for triangle in &mesh.triangles {
        digest.add_triangle(triangle.map(|v| points[v as usize]));
    }
    digest
}

/// Compares a file with lines; their segments are reversed at random and in another order than they
/// were built in.
pub async fn verify_lines(
    reader: &TileReader,
    lines: Vec<([Point; 2], impl Into<LinePart>)>,
) -> Result<VerifyReport, VerifyError> {
    let mut random = Random(lines.len() as u64);
    let mut lines: Vec<([Point; 2], LinePart)> = lines.into_iter().map(|(ends, part)| (ends, part.into())).collect();
    random.shuffle(&mut lines);
    for (ends, source) in &mut lines {
        if random.below(2) == 0 {
            ends.reverse();
            *source = source.reversed();
        }
    }
    let mut chunks = lines.chunks(50);
    let next = |batch: &mut LineBatch| -> Result<bool, String> {
        let Some(chunk) = chunks.next() else { return Ok(false) };
        (batch.ends, batch.sources) = chunk.iter().copied().unzip();
        Ok(true)
    };
    reader.verify_lines(next).await
}

/// A runtime of tokio.
pub struct Runtime(tokio::runtime::Runtime);

impl Runtime {
    /// Runs a future to its end, as tokio's `block_on` does. That is generic: compiled for the future
    /// of each test, it was a fifth of the code of all tests.
    pub fn block_on<T>(&self, work: impl Future<Output = T>) -> T {
        let work: Pin<&mut dyn Future<Output = T>> = pin!(work);
        self.0.block_on(work)
    }

    pub fn spawn<F: Future<Output: Send> + Send + 'static>(&self, task: F) -> tokio::task::JoinHandle<F::Output> {
        self.0.spawn(task)
    }

    pub fn shutdown_timeout(self, time: Duration) {
        self.0.shutdown_timeout(time);
    }
}

/// Creates a runtime of several threads.
pub fn runtime() -> Runtime {
    let mut builder = tokio::runtime::Builder::new_multi_thread();
    Runtime(builder.worker_threads(2).enable_all().build().unwrap())
}

/// Creates a runtime for a build with this number of threads. With one, the runtime has none of its
/// own: tasks run on the thread of the caller.
pub fn runtime_for(threads: usize) -> Runtime {
    match threads {
        1 => {
            let mut builder = tokio::runtime::Builder::new_current_thread();
            Runtime(builder.enable_all().build().unwrap())
        }
        _ => runtime(),
    }
}

/// Builds a file and returns its bytes.
pub async fn file_bytes(batches: &[PointBatch], options: BuildOptions) -> Vec<u8> {
    let scratch = Scratch::new();
    build_batches(&scratch.path, batches, options).await.unwrap();
    std::fs::read(&scratch.path).unwrap()
}

/// Opens a file whose bytes are in memory.
pub async fn open_bytes(bytes: Vec<u8>) -> Result<TileReader, ReadError> {
    TileReader::open_source(MemoryFile::new(bytes), "bytes", OpenOptions::default()).await
}

/// Random numbers from a seed (SplitMix64).
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        distributions::mix(self.0)
    }

    pub fn below(&mut self, limit: usize) -> usize {
        (self.bits() % limit as u64) as usize
    }

    /// Returns a number of at least 0 and below 1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }
}
