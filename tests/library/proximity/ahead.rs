//! Tiles that are asked for ahead: the same answers, few tiles more, and none where the cache or the options have no room.

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

/// Where the front of a wave goes through more tiles than the cache holds, each tile is read a few times, and not once for each thing in it.
#[test]
fn a_front_that_the_cache_does_not_hold() {
    let mut random = Random(8);
    let mut scene = Scene::town_with_sites(6, 120, &mut random);
    scene
        .points
        .extend((0..3000).map(|_| Point::new(32.0 * random.unit(), 32.0 * random.unit())));
    runtime().block_on(async {
        let (scratch, reader) = scene.build(60).await;
        let tiles = reader.directory().tiles.len() as u64;
        assert!(tiles > 60, "{tiles}");
        let from = Point::new(5.25, 15.25);
        let all = |reader: TileReader| async move {
            let sites = reader.nearest_sites(from, QueryOptions::default());
            let found: Vec<_> = sites.try_collect().await.unwrap();
            let told = found.into_iter().map(|site| (site.number, site.distance.value));
            (told.collect::<Vec<_>>(), reader.cache().statistics().misses)
        };
        let (expected, once) = all(open(&scratch, 1 << 26).await).await;
        assert!(once <= tiles && expected.len() > 100);
        let (found, several) = all(open(&scratch, 0).await).await;
        assert_eq!(found, expected);
        assert!(several < 25 * tiles, "{several} for {tiles}");
    });
}

#[test]
fn the_same_answers_and_few_tiles_more() {
    let mut random = Random(3);
    let scene = Scene::town_with_sites(8, 200, &mut random);
    runtime().block_on(async {
        let (scratch, _) = scene.build(40).await;
        let (mut ahead, mut alone) = (0, 0);
        for _ in 0..30 {
            let from = Point::new(5.0 * random.below(9) as f64 + 0.25, 42.0 * random.unit());
            // Cold each: with room in the cache, without, and with a limit, which is never passed.
            let roomy = open(&scratch, 1 << 24).await;
            let found = nearest(&roomy, from, QueryOptions::default()).await;
            let poor = open(&scratch, 0).await;
            assert_eq!(nearest(&poor, from, QueryOptions::default()).await, found);
            let limited = open(&scratch, 1 << 24).await;
            let tiles = roomy.directory().tiles.len() as u64;
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
