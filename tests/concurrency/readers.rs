//! Readers of files: many tasks, cancelled callers, scans, replaced files, shared caches.

use std::sync::Arc;
use std::time::Duration;

use delaunay_tiles::geometry::{Point, Rect};
use delaunay_tiles::input::SegmentBatch;
use delaunay_tiles::query::Location;
use delaunay_tiles::store::{Cache, CacheStatistics, LineKind, OpenOptions, ReadError, TileId, TileReader, VertexId};
use delaunay_tiles::{BuildOptions, EditOptions, Editor};
use distributions::Kind;
use futures::future::{FutureExt, join_all};
use futures::stream::TryStreamExt;

use crate::support::{Random, Scratch, batches, build_batches, points_of, runtime};

fn options() -> BuildOptions {
    BuildOptions::default().tile_vertices(64).threads(2)
}

/// Returns the bytes that all tiles of a file have in memory.
async fn weight(reader: &TileReader) -> usize {
    let tiles: Vec<_> = reader.tiles().try_collect().await.unwrap();
    tiles.iter().map(|tile| tile.byte_size()).sum()
}

async fn ids(reader: &TileReader) -> impl Iterator<Item = TileId> + use<> {
    let directory = reader.directory().await.unwrap();
    (0..directory.tiles.len() as u32).map(TileId)
}

async fn triangles(reader: &TileReader, rect: Rect) -> Result<Vec<[VertexId; 3]>, ReadError> {
    let found = reader.triangles_in(rect);
    found.map_ok(|t| t.vertices.map(|v| v.id)).try_collect().await
}

/// Questions, with the answers of a reader that nothing disturbs.
struct Answers {
    locations: Vec<(Point, Location)>,
    rects: Vec<(Rect, Vec<[VertexId; 3]>)>,
    tiles: Vec<(TileId, Vec<Point>)>,
}

impl Answers {
    async fn of(reader: &TileReader) -> Self {
        let bounds = reader.metadata().bounds;
        let mut random = Random(7);
        let mut point = || {
            let (width, height) = bounds.size();
            Point::new(
                bounds.min_x + width * (1.1 * random.unit() - 0.05),
                bounds.min_y + height * (1.1 * random.unit() - 0.05),
            )
        };
        let mut answers = Self {
            locations: Vec::new(),
            rects: Vec::new(),
            tiles: Vec::new(),
        };
        for _ in 0..100 {
            let p = point();
            answers.locations.push((p, reader.locate(p.x, p.y).await.unwrap()));
        }
        for _ in 0..10 {
            let rect = Rect::around([point(), point()]);
            answers.rects.push((rect, triangles(reader, rect).await.unwrap()));
        }
        for id in ids(reader).await {
            answers
                .tiles
                .push((id, reader.tile(id).await.unwrap().points().collect()));
        }
        assert!(answers.rects.iter().any(|(_, found)| found.len() > 100));
        answers
    }

    /// Asks one of the questions, chosen at random, and compares the answer.
    async fn check(&self, reader: &TileReader, random: &mut Random) {
        match random.below(8) {
            0 => {
                let (rect, expected) = &self.rects[random.below(self.rects.len())];
                assert_eq!(triangles(reader, *rect).await.unwrap(), *expected);
            }
            1..4 => {
                let (id, points) = &self.tiles[random.below(self.tiles.len())];
                let tile = reader.tile(*id).await.unwrap();
                assert!(tile.id() == *id && tile.points().eq(points.iter().copied()));
            }
            4 => {
                let (id, points) = &self.tiles[random.below(self.tiles.len())];
                let tile = reader.pin(*id).await.unwrap();
                tokio::task::yield_now().await;
                assert!(tile.id() == *id && tile.points().eq(points.iter().copied()));
            }
            _ => {
                let (p, expected) = &self.locations[random.below(self.locations.len())];
                assert_eq!(reader.locate(p.x, p.y).await.unwrap(), *expected);
            }
        }
    }
}

async fn file(scratch: &Scratch, points: &[Point]) {
    let options = options().force(true);
    build_batches(&scratch.path, &batches(points, &[]), options)
        .await
        .unwrap();
}

async fn open(scratch: &Scratch, cache: &Cache) -> TileReader {
    TileReader::open(&scratch.path, OpenOptions::default().cache(cache))
        .await
        .unwrap()
}

fn asked(statistics: CacheStatistics) -> u64 {
    statistics.hits + statistics.misses + statistics.shared_loads
}

#[test]
fn sixty_four_tasks_get_right_answers_with_a_cache_of_a_tenth_of_the_file() {
    runtime().block_on(async {
        let scratch = Scratch::new();
        file(&scratch, &points_of(Kind::Clusters, 6000, 3)).await;
        let undisturbed = scratch.open().await;
        let answers = Arc::new(Answers::of(&undisturbed).await);
        let capacity = weight(&undisturbed).await / 10;
        let cache = Cache::new(capacity);
        let reader = open(&scratch, &cache).await;
        let tasks = (0..64).map(|seed| {
            let (reader, answers) = (reader.clone(), Arc::clone(&answers));
            tokio::spawn(async move {
                let mut random = Random(seed);
                for _ in 0..40 {
                    // Callers that time out, at some moment or at once, and callers whose task is
                    // aborted.
                    let patience = Duration::from_micros(random.bits() % 300);
                    let _ = tokio::time::timeout(patience, answers.check(&reader, &mut Random(random.bits()))).await;
                    let _ = answers.check(&reader, &mut Random(random.bits())).now_or_never();
                    let stopped = {
                        let (reader, answers, seed) = (reader.clone(), Arc::clone(&answers), random.bits());
                        tokio::spawn(async move { answers.check(&reader, &mut Random(seed)).await })
                    };
                    answers.check(&reader, &mut random).await;
                    stopped.abort();
                    assert!(stopped.await.err().is_none_or(|error| error.is_cancelled()));
                }
            })
        });
        let tasks: Vec<_> = tasks.collect();
        for task in tasks {
            tokio::time::timeout(Duration::from_secs(120), task)
                .await
                .expect("nobody waits for ever")
                .unwrap();
        }
        let statistics = cache.statistics();
        assert!(
            statistics.bytes <= capacity && statistics.evictions > 1000,
            "{statistics}"
        );
        assert!(statistics.hits > 0 && statistics.misses > 0, "{statistics}");
    });
}

#[test]
fn an_open_reader_keeps_reading_its_file_after_another_file_takes_its_name() {
    runtime().block_on(async {
        let scratch = Scratch::new();
        file(&scratch, &points_of(Kind::Uniform, 3000, 1)).await;
        // The cache keeps nothing, so everything is read from the file.
        let cache = Cache::new(0);
        let old = open(&scratch, &cache).await;
        let answers = Answers::of(&old).await;
        let digest = old.recompute_digest().await.unwrap();
        file(&scratch, &points_of(Kind::Grid, 3000, 2)).await;
        let new = open(&scratch, &cache).await;
        assert_ne!(old.file_id(), new.file_id());
        let new_answers = Answers::of(&new).await;
        std::fs::remove_file(&scratch.path).unwrap();
        let mut random = Random(1);
        for _ in 0..200 {
            answers.check(&old, &mut random).await;
            new_answers.check(&new, &mut random).await;
        }
        assert_eq!(old.recompute_digest().await.unwrap(), digest);
        assert_ne!(new.recompute_digest().await.unwrap(), digest);
        old.verify(true).await.unwrap();
    });
}

#[test]
fn readers_of_several_files_get_right_answers_from_a_shared_cache() {
    runtime().block_on(async {
        let scratches = [Scratch::new(), Scratch::new(), Scratch::new()];
        let mut bytes = 0;
        let mut answers = Vec::new();
        for (scratch, (kind, seed)) in scratches
            .iter()
            .zip([(Kind::Uniform, 1), (Kind::Uniform, 2), (Kind::Grid, 3)])
        {
            file(scratch, &points_of(kind, 2000, seed)).await;
            let reader = scratch.open().await;
            bytes += weight(&reader).await;
            answers.push(Arc::new(Answers::of(&reader).await));
        }
        let cache = Cache::new(bytes / 4);
        let mut tasks = Vec::new();
        for (scratch, answers) in scratches.iter().zip(&answers) {
            let reader = open(scratch, &cache).await;
            for seed in 0..8 {
                let (reader, answers) = (reader.clone(), Arc::clone(answers));
                tasks.push(tokio::spawn(async move {
                    let mut random = Random(seed);
                    for _ in 0..60 {
                        answers.check(&reader, &mut random).await;
                    }
                }));
            }
        }
        for task in join_all(tasks).await {
            task.unwrap();
        }
        let statistics = cache.statistics();
        assert!(
            statistics.bytes <= bytes / 4 && statistics.pinned_bytes == 0,
            "{statistics}"
        );
        assert!(statistics.hits > 0 && statistics.evictions > 0, "{statistics}");
    });
}

/// A file that is edited in place keeps its id and its tiles' numbers. A reader of one generation
/// must not get a tile that another generation changed; what did not change, they share.
#[test]
fn generations_of_a_file_share_the_cached_tiles_that_did_not_change_and_no_others() {
    runtime().block_on(async {
        let scratch = Scratch::new();
        file(&scratch, &points_of(Kind::Uniform, 2000, 1)).await;
        let cache = Cache::new(1 << 30);
        let old = open(&scratch, &cache).await;
        let mut tiles = Vec::new();
        for id in ids(&old).await {
            tiles.push((id, old.entry(id).await.unwrap(), old.tile(id).await.unwrap()));
        }
        let mut transaction = Editor::open(&scratch.path, EditOptions::default().memory(1 << 30))
            .await
            .unwrap()
            .begin()
            .await
            .unwrap();
        let bounds = old.metadata().bounds;
        let at = |share: f64| {
            let (width, height) = bounds.size();
            Point::new(bounds.min_x + share * width, bounds.min_y + share * height)
        };
        let line = SegmentBatch {
            ends: vec![[at(0.4), at(0.5)]],
            lines: vec![0],
            ..SegmentBatch::default()
        };
        transaction.constrain(LineKind::BreakLine, 0, &line).unwrap();
        transaction.commit().await.unwrap();
        let new = open(&scratch, &cache).await;
        assert_eq!(old.file_id(), new.file_id());
        assert_eq!(old.generation() + 1, new.generation());
        let mut shared = [0; 2];
        for (id, entry, before) in tiles {
            let is_same = new.entry(id).await.unwrap() == entry;
            assert_eq!(Arc::ptr_eq(&before, &new.tile(id).await.unwrap()), is_same);
            assert!(Arc::ptr_eq(&before, &old.tile(id).await.unwrap()));
            shared[usize::from(is_same)] += 1;
        }
        assert!(shared.iter().all(|&n| n > 2), "{shared:?}");
    });
}

/// Reading all tiles once, by any call, does not evict tiles that are read again and again.
#[test]
fn scans_do_not_evict_hot_tiles() {
    runtime().block_on(async {
        let scratch = Scratch::new();
        file(&scratch, &points_of(Kind::Uniform, 6000, 3)).await;
        let cache = Cache::new(weight(&scratch.open().await).await / 5);
        let reader = open(&scratch, &cache).await;
        // A tenth of the file.
        let hot: Vec<TileId> = ids(&reader).await.step_by(10).collect();
        for _ in 0..2 {
            for &id in &hot {
                reader.tile(id).await.unwrap();
            }
        }
        let before = cache.statistics();
        reader.recompute_digest().await.unwrap();
        assert_eq!(weight(&reader).await / 5, cache.capacity());
        assert_eq!(cache.statistics(), before, "scans bypass the cache");
        for scan in 0..2 {
            if scan == 0 {
                triangles(&reader, Rect::PLANE).await.unwrap();
            } else {
                for id in ids(&reader).await.filter(|id| !hot.contains(id)) {
                    reader.tile(id).await.unwrap();
                }
            }
            let before = cache.statistics();
            for &id in &hot {
                reader.tile(id).await.unwrap();
            }
            let after = cache.statistics();
            assert_eq!((after.hits - before.hits) as usize, hot.len(), "{before}; {after}");
        }
        assert!(cache.statistics().evictions > 100);
    });
}

#[test]
fn a_pinned_tile_is_not_evicted() {
    runtime().block_on(async {
        let scratch = Scratch::new();
        file(&scratch, &points_of(Kind::Uniform, 2000, 3)).await;
        let reader = open(&scratch, &Cache::new(20_000)).await;
        let pinned = reader.pin(TileId(5)).await.unwrap();
        for _ in 0..2 {
            triangles(&reader, Rect::PLANE).await.unwrap();
        }
        assert!(Arc::ptr_eq(&pinned.tile(), &reader.tile(TileId(5)).await.unwrap()));
        assert_eq!(reader.cache().statistics().pinned_bytes, pinned.byte_size());
        let missing = reader.pin(TileId(9999)).await.err();
        assert!(matches!(missing, Some(ReadError::NoSuchTile { .. })), "{missing:?}");
        drop(pinned);
        let statistics = reader.cache().statistics();
        assert_eq!(statistics.pinned_bytes, 0);
        assert!(statistics.bytes <= 20_000, "{statistics}");
    });
}

#[test]
fn dropping_a_runtime_during_loads_does_not_disturb_another_runtime() {
    let alive = runtime();
    let scratch = Scratch::new();
    let (answers, cache) = alive.block_on(async {
        file(&scratch, &points_of(Kind::Uniform, 3000, 1)).await;
        let reader = scratch.open().await;
        (
            Arc::new(Answers::of(&reader).await),
            Cache::new(weight(&reader).await / 10),
        )
    });
    let reader = alive.block_on(open(&scratch, &cache));
    for round in 0..20 {
        let dying = runtime();
        for seed in 0..16 {
            let (reader, answers) = (reader.clone(), Arc::clone(&answers));
            dying.spawn(async move {
                let mut random = Random(100 * round + seed);
                loop {
                    // The runtime is dropped during this loop, and its loads with it; their callers
                    // may get an error.
                    let id = answers.tiles[random.below(answers.tiles.len())].0;
                    if reader.tile(id).await.is_err() {
                        break;
                    }
                }
            });
        }
        let checks = (0..4).map(|seed| {
            let (reader, answers) = (reader.clone(), Arc::clone(&answers));
            alive.spawn(async move {
                let mut random = Random(seed);
                for _ in 0..20 {
                    answers.check(&reader, &mut random).await;
                }
            })
        });
        let checks: Vec<_> = checks.collect();
        std::thread::sleep(Duration::from_micros(500));
        dying.shutdown_timeout(Duration::from_secs(10));
        for check in alive.block_on(join_all(checks)) {
            check.unwrap();
        }
    }
    let statistics = cache.statistics();
    assert_eq!(statistics.pinned_bytes, 0);
    assert!(
        statistics.bytes <= cache.capacity() && statistics.evictions > 100,
        "{statistics}"
    );
    assert!(asked(statistics) > 1000);
}
