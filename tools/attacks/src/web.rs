//! A web server that gives false answers, asked for the tiles of a random file: the reader must
//! return the file's answers or an error, soon and in little memory.

use std::fs;
use std::time::{Duration, Instant};

use anyhow::{Context as _, bail, ensure};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::PointBatch;
use delaunay_tiles::io::ObjectFile;
use delaunay_tiles::query::Location;
use delaunay_tiles::store::{Digest, OpenOptions, ReadError, TileReader};
use delaunay_tiles::{BuildOptions, Builder, peak_memory};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;

use crate::campaign::{Context, Counts};

#[path = "../../../tests/object_store/server.rs"]
mod server;

use server::{Fault, Lie, Server};

/// The time that a request may take.
const PATIENCE: Duration = Duration::from_millis(400);
/// The time that a round may take: several requests, each of them with retries.
const LONGEST: Duration = Duration::from_secs(20);
/// The additional memory that the process may use, in bytes.
const MOST_MEMORY: u64 = 64 << 20;

/// The answers of a file.
#[derive(Debug, PartialEq)]
struct Answers {
    digest: Digest,
    locations: Vec<Location>,
}

/// Asks one file all questions, through one lie.
pub fn round(_context: &Context, mut random: ChaCha8Rng) -> anyhow::Result<Counts> {
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .enable_all()
        .worker_threads(2)
        .build()?;
    let bytes = runtime.block_on(file(&mut random))?;
    let other = runtime.block_on(file(&mut random))?;
    let points: Vec<Point> = (0..8).map(|_| random_point(&mut random)).collect();
    let expected = runtime.block_on(async {
        let file = delaunay_tiles::io::MemoryFile::new(bytes.clone());
        answers(
            TileReader::open_source(file, "file", OpenOptions::default()).await?,
            &points,
        )
        .await
    })?;
    let lie = Lie::ALL[random.next_u32() as usize % Lie::ALL.len()];
    let from = random.next_u32() as usize % 8;
    let count = [1, 2, usize::MAX][random.next_u32() as usize % 3];
    // If every request is redirected to the other server, the file there is the right one.
    let from = if lie == Lie::Elsewhere { from.max(1) } else { from };
    let elsewhere = Server::start(other, Fault::ChangedAfter(0));
    let server = Server::start_before(bytes, Fault::Lies(lie, from, count), elsewhere.url.clone());
    let (began, memory) = (Instant::now(), peak_memory().unwrap_or(0));
    let asked = runtime.block_on(async { tokio::time::timeout(LONGEST, ask(&server.url, &points)).await });
    let context = format!(
        "{lie:?} from request {from} on, {count} times, of {}",
        server.requests()
    );
    let answered = asked.with_context(|| format!("{context}: no answer within {LONGEST:?}"))?;
    let more = peak_memory().unwrap_or(0).saturating_sub(memory);
    ensure!(
        more < MOST_MEMORY,
        "{context}: {more} bytes more memory, after {:?}",
        began.elapsed()
    );
    runtime.shutdown_background();
    match answered {
        Ok(answers) if answers == expected => Ok(vec![("right answers", 1)]),
        Ok(_) => bail!("{context}: a wrong answer"),
        Err(error) => {
            let text = format!("{:#}", anyhow::Error::new(error));
            ensure!(
                text.contains("town.tiles") && text.len() < 2000 && !text.contains(char::is_control),
                "{context}: what is said is {text:?}"
            );
            Ok(vec![("errors", 1)])
        }
    }
}

fn random_point(random: &mut ChaCha8Rng) -> Point {
    let mut next = || f64::from(random.next_u32()) / f64::from(u32::MAX);
    Point::new(next(), next())
}

/// Builds a tile file of random points.
async fn file(random: &mut ChaCha8Rng) -> anyhow::Result<Vec<u8>> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("file.tiles");
    let points: Vec<Point> = (0..1500).map(|_| random_point(random)).collect();
    let options = BuildOptions::default().tile_vertices(100).threads(1).memory(256 << 20);
    let mut builder = Builder::new(&path, options)?;
    let (records, z) = ((0..points.len() as u64).collect(), Vec::new());
    builder.push(&PointBatch { records, points, z }).await?;
    builder.finish().await?;
    Ok(fs::read(path)?)
}

async fn ask(url: &str, points: &[Point]) -> Result<Answers, ReadError> {
    let file = ObjectFile::open_within(url, PATIENCE)
        .await
        .map_err(|error| ReadError::Io {
            file: "opening".into(),
            what: "the file".to_owned(),
            source: std::sync::Arc::new(error),
        })?;
    answers(
        TileReader::open_source(file, url, OpenOptions::default()).await?,
        points,
    )
    .await
}

async fn answers(reader: TileReader, points: &[Point]) -> Result<Answers, ReadError> {
    let mut found = Vec::new();
    for point in points {
        found.push(reader.locate(point.x, point.y).await?);
    }
    Ok(Answers {
        digest: reader.recompute_digest().await?,
        locations: found,
    })
}
