//! Answers questions of clients while the file is edited: a fence comes and goes on disk, and each
//! answer is that of one state or of the other.
//!
//! `cargo run --release --example live`

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, PoisonError, RwLock};

use delaunay_tiles::input::{PointBatch, SegmentBatch};
use delaunay_tiles::store::{LineKind, LineSource};
use delaunay_tiles::{
    BuildOptions, Builder, EditOptions, Editor, OpenOptions, PathOutcome, Point, QueryOptions, TileReader,
};

type Error = Box<dyn std::error::Error + Send + Sync>;

const CLIENTS: usize = 4;
const EDITS: usize = 20;
const SIDE: u64 = 200;

/// The reader that clients share. A client clones it for each question, so that it keeps one state
/// of the file until it has the answer.
type Shared = Arc<RwLock<TileReader>>;

fn current(field: &Shared) -> TileReader {
    field.read().unwrap_or_else(PoisonError::into_inner).clone()
}

/// Asks until the edits are done. Returns how many answers went straight, and how many round the
/// fence.
async fn ask(field: Shared, is_done: Arc<AtomicBool>) -> Result<[u64; 2], Error> {
    let mut answers = [0; 2];
    while !is_done.load(Ordering::Relaxed) {
        let reader = current(&field);
        let [from, to] = [90.25, 110.75].map(|x| Point::new(x, 100.5));
        let found = reader.shortest_path(from, to, QueryOptions::default()).await?;
        let PathOutcome::Found(path) = found else {
            return Err(format!("no path: {found:?}").into());
        };
        answers[usize::from(path.distance.value > 21.0)] += 1;
        // Answers from the cache are ready at once; other tasks want to run, too.
        tokio::task::yield_now().await;
    }
    Ok(answers)
}

#[tokio::main]
async fn main() -> Result<(), Error> {
    let file = std::env::temp_dir().join("live.tiles");
    let mut builder = Builder::new(&file, BuildOptions::default().tile_vertices(2000).force(true))?;
    let places = (0..SIDE * SIDE).map(|i| Point::new((i % SIDE) as f64, (i / SIDE) as f64));
    let grid = PointBatch {
        records: (0..SIDE * SIDE).collect(),
        points: places.collect(),
        z: Vec::new(),
    };
    builder.push(&grid).await?;
    builder.finish().await?;

    let reader = TileReader::open(&file, OpenOptions::default()).await?;
    let field: Shared = Arc::new(RwLock::new(reader));
    let is_done = Arc::new(AtomicBool::new(false));
    let clients: Vec<_> = (0..CLIENTS)
        .map(|_| tokio::spawn(ask(Arc::clone(&field), Arc::clone(&is_done))))
        .collect();

    let fence = SegmentBatch {
        ends: vec![[Point::new(100.0, 60.0), Point::new(100.0, 140.0)]],
        lines: vec![0],
        ..SegmentBatch::default()
    };
    for edit in 0..EDITS {
        let mut transaction = Editor::open(&file, EditOptions::default().memory(256 << 20))
            .await?
            .begin()
            .await?;
        if edit % 2 == 0 {
            transaction.constrain(LineKind::Wall, 0, &fence)?;
            transaction.add_sources(vec![LineSource {
                name: "fence".to_owned(),
                kind: LineKind::Wall,
                first: 0,
                lines: 1,
                edit: 0,
            }]);
        } else {
            transaction.unconstrain(LineKind::Wall, 0, &fence)?;
        }
        transaction.commit().await?;
        // Questions that are under way keep the reader that they began with.
        let mut newer = current(&field);
        newer.refresh().await?;
        *field.write().unwrap_or_else(PoisonError::into_inner) = newer;
    }
    is_done.store(true, Ordering::Relaxed);

    let mut total = [0; 2];
    for client in clients {
        let [straight, round] = client.await??;
        total = [total[0] + straight, total[1] + round];
    }
    println!("{EDITS} edits, while {CLIENTS} clients asked");
    println!("{} answers without the fence, {} round it", total[0], total[1]);
    Ok(())
}
