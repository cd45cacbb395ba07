//! Tiles that are requested ahead: the answers stay the same, few more tiles are read, and none
//! ahead if the cache or the options have no room.

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::QueryOptions;
use delaunay_tiles::store::TileReader;
use futures::{StreamExt, TryStreamExt};

use crate::proximity::scene::{Scene, open};
use crate::support::{Random, runtime};

async fn nearest(reader: &TileReader, from: Point, options: QueryOptions) -> Vec<(u64, f64)> {
    let sites = reader.nearest_sites(from, options).take(8);
    sites
        .map_ok(|site| (site.number, site.distance.value))
        .try_collect()
        .await
        .unwrap()
}

/// If the front of a wavefront passes through more tiles than the cache holds, each tile is read a
/// few times, and not once for each thing in it.
#[test]
fn a_front_larger_than_the_cache_reads_each_tile_a_few_times() {
    let mut random = Random(8);
    let mut scene = Scene::town_with_sites(6, 120, &mut random);
    scene
        .points
        .extend((0..3000).map(|_| Point::new(32.0 * random.unit(), 32.0 * random.unit())));
    runtime().block_on(async {
        let (scratch, reader) = scene.build(60).await;
        let tiles = reader.directory().await.unwrap().tiles.len() as u64;
        assert!(tiles > 60, "{tiles}");
        let from = Point::new(5.25, 15.25);
        let all = |reader: TileReader| async move {
            let sites = reader.nearest_sites(from, QueryOptions::default());
            let found: Vec<_> = sites.try_collect().await.unwrap();
            let answer = found.into_iter().map(|site| (site.number, site.distance.value));
            (answer.collect::<Vec<_>>(), reader.cache().statistics().misses)
        };
        let (expected, once) = all(open(&scratch, 1 << 26).await).await;
        assert!(once <= tiles && expected.len() > 100);
        let (found, several) = all(open(&scratch, 0).await).await;
        assert_eq!(found, expected);
        assert!(several < 25 * tiles, "{several} for {tiles}");
    });
}

#[test]
fn reading_ahead_gives_the_same_answers_with_few_more_tiles() {
    let mut random = Random(3);
    let scene = Scene::town_with_sites(8, 200, &mut random);
    runtime().block_on(async {
        let (scratch, _) = scene.build(40).await;
        let (mut ahead, mut alone) = (0, 0);
        for _ in 0..30 {
            let from = Point::new(5.0 * random.below(9) as f64 + 0.25, 42.0 * random.unit());
            // Each query starts with an empty cache: one with room, one without, and one with a
            // limit of tiles, which is never exceeded.
            let roomy = open(&scratch, 1 << 24).await;
            let found = nearest(&roomy, from, QueryOptions::default()).await;
            let poor = open(&scratch, 0).await;
            assert_eq!(nearest(&poor, from, QueryOptions::default()).await, found);
            let limited = open(&scratch, 1 << 24).await;
            let tiles = roomy.directory().await.unwrap().tiles.len() as u64;
            assert_eq!(
                nearest(&limited, from, QueryOptions::default().max_tiles(tiles)).await,
                found
            );
            ahead += roomy.cache().statistics().misses;
            alone += limited.cache().statistics().misses;
        }
        assert!(alone <= ahead && ahead <= alone + 2 * 30, "{ahead}, not {alone}");
    });
}

/// A cache of the size that the directory names holds all tiles of a town, with the notes that
/// searches make in them.
#[test]
fn a_cache_of_the_named_size_holds_all_tiles_of_a_town() {
    let mut random = Random(9);
    let scene = Scene::town_with_sites(16, 300, &mut random);
    runtime().block_on(async {
        for tile_vertices in [40, 300, 1 << 16] {
            let (scratch, reader) = scene.build(tile_vertices).await;
            let tiles = reader.directory().await.unwrap().tiles.clone();
            let used = tiles.iter().filter(|entry| !entry.is_unused());
            let named: u64 = used.map(|entry| entry.cached_bytes()).sum();
            let reader = open(&scratch, named as usize).await;
            for _ in 0..40 {
                // In a lane between two columns of blocks.
                let mut free = || Point::new((5 * random.below(17) + 1) as f64, 82.0 * random.unit());
                let [from, to] = [free(), free()];
                nearest(&reader, from, QueryOptions::default()).await;
                reader.shortest_path(from, to, QueryOptions::default()).await.unwrap();
            }
            let statistics = reader.cache().statistics();
            assert_eq!(statistics.evictions, 0, "{tile_vertices}: {statistics:?}");
        }
    });
}
