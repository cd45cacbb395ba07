//! The promise: opening a file and reading one tile takes few requests and few bytes beside the
//! tile, however large the directory is.

use std::io;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use bytes::Bytes;
use delaunay_tiles::geometry::Point;
use delaunay_tiles::io::{MemoryFile, ReadAt};
use delaunay_tiles::store::{OpenOptions, TileId, TileReader};
use delaunay_tiles::{BuildOptions, Builder, Location};
use distributions::Kind;
use futures::future::BoxFuture;

use crate::support::{Random, Scratch, batches, file_bytes, points_of, runtime};

/// A file that counts what is read from it. Each range is a request.
#[derive(Clone)]
struct Counting {
    file: MemoryFile,
    requests: Arc<AtomicU64>,
    bytes: Arc<AtomicU64>,
}

impl Counting {
    fn new(bytes: Vec<u8>) -> Self {
        Self {
            file: MemoryFile::new(bytes),
            requests: Arc::default(),
            bytes: Arc::default(),
        }
    }

    /// Returns the requests and bytes since the last call.
    fn take(&self) -> [u64; 2] {
        [&self.requests, &self.bytes].map(|count| count.swap(0, Ordering::Relaxed))
    }

    async fn open(&self) -> TileReader {
        TileReader::open_source(self.clone(), "counting", OpenOptions::default())
            .await
            .unwrap()
    }
}

impl ReadAt for Counting {
    fn length(&self) -> u64 {
        self.file.length()
    }

    fn backend(&self) -> &'static str {
        "counting"
    }

    fn read_at(&self, range: Range<u64>) -> BoxFuture<'static, io::Result<Bytes>> {
        self.requests.fetch_add(1, Ordering::Relaxed);
        self.bytes.fetch_add(range.end - range.start, Ordering::Relaxed);
        self.file.read_at(range)
    }
}

/// Opens the file again and again, and reads one tile at a random place. Returns the most requests
/// and the most bytes beside the tile.
async fn most(file: &Counting, bounds: [f64; 2]) -> [u64; 2] {
    let mut random = Random(22);
    let mut most = [0; 2];
    for _ in 0..20 {
        file.take();
        let reader = file.open().await;
        let mut at = || (random.below(1 << 20) as f64 / f64::from(1 << 20)) * (bounds[1] - bounds[0]) + bounds[0];
        let id = reader.tile_at(Point::new(at(), at())).await.unwrap().unwrap();
        reader.tile(id).await.unwrap();
        let [requests, bytes] = file.take();
        let entry = reader.entry(id).await.unwrap();
        let tile = u64::from(entry.core.length) + u64::from(entry.border.length);
        assert_eq!(file.take(), [0, 0], "what was read is in memory");
        most = [most[0].max(requests), most[1].max(bytes - tile)];
    }
    most
}

#[test]
fn opening_and_one_tile_of_thousands_take_four_requests_and_64_kib() {
    runtime().block_on(async {
        let points = points_of(Kind::Uniform, 250_000, 7);
        let options = BuildOptions::default().tile_vertices(8).threads(2);
        let file = Counting::new(file_bytes(&batches(&points, &[]), options).await);
        let reader = file.open().await;
        let tiles = reader.metadata().tiles;
        assert!(tiles >= 31_250, "{tiles}");
        let bounds = reader.metadata().bounds;
        let [requests, bytes] = most(&file, [bounds.min_x, bounds.max_x]).await;
        println!("{tiles} tiles: {requests} requests, {bytes} bytes beside the tile");
        assert!(requests <= 4, "{requests}");
        assert!(bytes <= 64 << 10, "{bytes}");

        // By its number, a tile is found without the tree.
        file.take();
        let reader = file.open().await;
        reader.tile(TileId(tiles - 1)).await.unwrap();
        assert!(file.take()[0] <= 4);

        // Questions do not read what lies elsewhere.
        file.take();
        let (width, _) = bounds.size();
        let reader = file.open().await;
        let middle = [bounds.min_x, bounds.min_y].map(|low| low + width / 2.0);
        let found = reader.locate(middle[0], middle[1]).await.unwrap();
        assert!(!matches!(found, Location::Outside), "{found:?}");
        assert!(file.take()[0] <= 8);
    });
}

#[test]
fn long_lists_are_not_read_with_the_tiles() {
    const SEEDS: usize = 180_159;
    runtime().block_on(async {
        let points = points_of(Kind::Uniform, 20_000, 3);
        let scratch = Scratch::new();
        let mut builder = Builder::new(&scratch.path, BuildOptions::default().tile_vertices(500)).unwrap();
        let seeds: Vec<Point> = (0..SEEDS).map(|i| Point::new(1e6 + i as f64, 1e6)).collect();
        builder.push_seeds(&seeds).unwrap();
        for batch in batches(&points, &[]) {
            builder.push(&batch).await.unwrap();
        }
        builder.finish().await.unwrap();
        let file = Counting::new(std::fs::read(&scratch.path).unwrap());
        let bounds = file.open().await.metadata().bounds;
        let [requests, bytes] = most(&file, [bounds.min_x, bounds.max_x]).await;
        println!("{SEEDS} hole points: {requests} requests, {bytes} bytes beside the tile");
        assert!(requests <= 4, "{requests}");
        assert!(bytes <= 64 << 10, "{bytes}");
        let reader = file.open().await;
        assert_eq!(reader.lists().await.unwrap().hole_points, seeds);
    });
}
