//! What several tests share: points of every distribution, builds in a scratch folder, the in-core reference.
#![allow(dead_code, reason = "each test uses its part")]

use std::path::{Path, PathBuf};

use delaunay_tiles::build::{BuildError, BuildOptions, BuildSummary, Builder};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::PointBatch;
use delaunay_tiles::mesh::{EngineKind, Triangulation};
use delaunay_tiles::store::{Digest, OpenOptions, TileReader};
use distributions::Kind;

/// Points of a distribution.
pub fn points_of(kind: Kind, n: u64, seed: u64) -> Vec<Point> {
    distributions::points(kind, n, seed)
        .map(|[x, y]| Point::new(x, y))
        .collect()
}

/// Batches of points, with their places as record numbers, and z if there is any.
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

/// A tile file in a folder that goes away with it.
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

/// Builds a file from points and opens it.
pub async fn built(points: &[Point], options: BuildOptions) -> (Scratch, TileReader) {
    let scratch = Scratch::new();
    build_batches(&scratch.path, &batches(points, &[]), options)
        .await
        .unwrap();
    let reader = scratch.open().await;
    (scratch, reader)
}

/// Each place once.
pub fn distinct(points: &[Point]) -> Vec<Point> {
    let mut distinct: Vec<Point> = points.iter().map(|p| p.normalized()).collect();
    distinct.sort_unstable_by(|a, b| a.lex_cmp(*b));
    distinct.dedup();
    distinct
}

/// The digest of an in-core triangulation of all points at once.
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

/// A runtime of several threads.
pub fn runtime() -> tokio::runtime::Runtime {
    tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()
        .unwrap()
}
