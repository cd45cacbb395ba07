//! Answers many queries at once from one file, with one cache, as a service does.
//!
//! `cargo run --release --example serve --features geojson`

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use delaunay_tiles::input::{SegmentBatch, SegmentSource};
use delaunay_tiles::store::LineKind;
use delaunay_tiles::{
    BuildOptions, Builder, Cache, OpenOptions, PathOutcome, Point, QueryError, QueryOptions, TileReader,
};

type Error = Box<dyn std::error::Error>;

const ISLANDS: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/tests/data/indonesia/indonesia_ne10m.geojson"
);
const CLIENTS: u64 = 8;
const REQUESTS: u64 = 50;

#[tokio::main]
async fn main() -> Result<(), Error> {
    let path = std::env::temp_dir().join("served.tiles");
    let mut builder = Builder::new(&path, BuildOptions::default().tile_vertices(2000).force(true))?;
    let mut source = SegmentSource::open_obstacles(&[ISLANDS.into()])?;
    let mut batch = SegmentBatch::default();
    while source.next_batch(&mut batch)? {
        builder.push_lines(LineKind::Obstacle, 0, &batch)?;
    }
    builder.finish().await?;

    // Readers are cheap to clone. The cache holds at most 64 MiB of tiles, and may serve many files.
    let cache = Cache::new(64 << 20);
    let islands = TileReader::open(&path, OpenOptions::default().cache(&cache)).await?;
    let found = Arc::new(AtomicU64::new(0));
    let start = Instant::now();
    let clients = (0..CLIENTS).map(|client| {
        let (islands, found) = (islands.clone(), Arc::clone(&found));
        tokio::spawn(async move {
            for request in 0..REQUESTS {
                let step = (client * REQUESTS + request) as f64;
                let [from, to] = [(96.0 + step / 20.0, 4.0), (140.0 - step / 20.0, -9.5)];
                let [from, to] = [from, to].map(|(x, y)| Point::new(x, y));
                // A service bounds what one request may cost.
                let options = QueryOptions::default().max_tiles(1000);
                match islands.shortest_path(from, to, options).await {
                    Ok(PathOutcome::Found(_)) => _ = found.fetch_add(1, Ordering::Relaxed),
                    Ok(_) | Err(QueryError::OutOfBudget { .. }) => {}
                    Err(error) => return Err(error),
                }
            }
            Ok(())
        })
    });
    for client in clients.collect::<Vec<_>>() {
        client.await??;
    }
    let (requests, seconds) = (CLIENTS * REQUESTS, start.elapsed().as_secs_f64());
    println!(
        "{requests} requests by {CLIENTS} clients, {} paths",
        found.load(Ordering::Relaxed)
    );
    println!("{:.0} requests a second", requests as f64 / seconds);
    Ok(())
}
