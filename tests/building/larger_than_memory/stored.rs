//! The promise: workers that share an object store alone give the triangles of one build.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use delaunay_tiles::store::{Digest, OpenOptions};
use delaunay_tiles::{BuildError, Builder, Planned, TaskOptions, TaskStore};
use distributions::Kind;
use futures::TryStreamExt;
use object_store::memory::InMemory;
use object_store::path::Path as Key;
use object_store::{ObjectStore, ObjectStoreExt};

use crate::larger_than_memory::inputs::{Input, city, long_lines, valley};
use crate::larger_than_memory::tasks::digest;
use crate::support::errors::whole;
use crate::support::{Random, Scratch, points_of, runtime};

const NAME: &str = "surveys/test.tiles.parts";

async fn keys(store: &InMemory) -> Vec<String> {
    let all: Vec<_> = store.list(None).try_collect().await.unwrap();
    let mut keys: Vec<String> = all.into_iter().map(|meta| meta.location.to_string()).collect();
    keys.sort_unstable();
    keys
}

fn is_empty(folder: &Path) -> bool {
    fs::read_dir(folder).unwrap().next().is_none()
}

/// Conquers all blocks but the last one, in a random order, each in a folder of its own.
async fn conquer(input: &Input, store: &TaskStore, objects: &InMemory, blocks: u32, seed: u64) {
    let (mut random, mut left) = (Random(seed), (0..blocks).collect::<Vec<_>>());
    while left.len() > 1 {
        let block = left.swap_remove(random.below(left.len()));
        let worker = tempfile::tempdir().unwrap();
        let options = TaskOptions {
            memory: input.options.memory,
            threads: 1 + random.below(2),
        };
        let done = store.conquer(block, options, worker.path()).await.unwrap();
        assert_eq!((done.block, done.was_done), (block, false));
        match random.below(3) {
            0 => assert!(store.conquer(block, options, worker.path()).await.unwrap().was_done),
            // Another worker did not know of this one.
            1 => {
                let all = keys(objects).await;
                let key = all
                    .iter()
                    .find(|key| key.ends_with(&format!("/block-{block}")))
                    .unwrap();
                let key = Key::from(key.as_str());
                let cores = all
                    .iter()
                    .find(|key| key.ends_with(&format!("/cores-{block}")))
                    .unwrap();
                let cores = Key::from(cores.as_str());
                let before = objects.get(&cores).await.unwrap().bytes().await.unwrap();
                objects.delete(&key).await.unwrap();
                assert!(!store.conquer(block, options, worker.path()).await.unwrap().was_done);
                let again = objects.get(&cores).await.unwrap().bytes().await.unwrap();
                assert!(before == again, "{}: the tiles of block {block} differ", input.name);
            }
            _ => {}
        }
        assert!(is_empty(worker.path()), "a worker left files");
    }
}

async fn digest_in(store: &TaskStore) -> Digest {
    let reader = store.open(OpenOptions::default()).await.unwrap();
    reader.verify(true).await.unwrap();
    reader.recompute_digest().await.unwrap()
}

#[test]
fn workers_that_share_a_store_give_the_triangles_of_one_build() {
    let curve = Input::new("points", &points_of(Kind::Kuzmin, 100_000, 5), &[], 1_500_000);
    runtime().block_on(async {
        for (input, seed) in [curve, city(), valley(), long_lines()].into_iter().zip(1..) {
            let whole = Scratch::new();
            input.build_at_once(&whole.path).await;
            let objects = Arc::new(InMemory::new());
            let store = TaskStore::of(Arc::clone(&objects) as Arc<dyn ObjectStore>, NAME);
            // Twice: the second file replaces the first one.
            for round in 0..2 {
                let driver = tempfile::tempdir().unwrap();
                let path = driver.path().join(store.file_name());
                let options = input.options.clone().store(store.clone()).force(round > 0);
                let mut builder = Builder::new(&path, options.clone()).unwrap();
                input.push(&mut builder).await.unwrap();
                let blocks = match builder.plan_tasks().await.unwrap() {
                    Planned::Tasks(tasks) => tasks.blocks(),
                    other => panic!("{}: {other:?}", input.name),
                };
                conquer(&input, &store, &objects, blocks, 10 * seed + round).await;
                let worker = tempfile::tempdir().unwrap();
                let tasks = store.tasks(worker.path()).await.unwrap();
                let are_done = store.are_done(&tasks).await.unwrap();
                assert_eq!(are_done.iter().filter(|is_done| !**is_done).count(), 1);
                if round > 0 {
                    let builder = Builder::new(&path, options.clone().force(false).resume(true)).unwrap();
                    let exists = builder.finish().await;
                    assert!(matches!(exists, Err(BuildError::OutputExists(_))), "{exists:?}");
                }
                let without = Builder::new(&path, input.options.clone().resume(true))
                    .unwrap()
                    .finish()
                    .await;
                assert!(matches!(without, Err(BuildError::NoStore(_))), "{without:?}");
                let resumed = Builder::new(&path, options.resume(true))
                    .unwrap()
                    .finish()
                    .await
                    .unwrap();
                assert_eq!(resumed.resumed_blocks, u64::from(blocks));
                assert!(is_empty(driver.path()), "the build left files");
                assert_eq!(digest_in(&store).await, digest(&whole).await, "{}", input.name);
                let keys = keys(&objects).await;
                assert_eq!(keys[0], NAME);
                let folder = keys[1].rsplit_once('/').unwrap().0;
                assert!(keys[1..].iter().all(|key| key.starts_with(folder)), "{keys:?}");
                // Lines that were deferred, and sites in holes, need the tiles on the driver.
                let is_whole = resumed.deferred_segments > 0 || input.name == "city";
                let parts = if is_whole { 1 } else { u64::from(blocks) + 2 };
                assert_eq!(keys.len() as u64, 1 + parts, "{keys:?}");
            }
        }
    });
}

#[test]
fn what_a_store_does_not_have_is_an_error() {
    let points = Input::new("points", &points_of(Kind::Uniform, 100_000, 5), &[], 1_500_000);
    runtime().block_on(async {
        let objects = Arc::new(InMemory::new());
        let store = TaskStore::of(Arc::clone(&objects) as Arc<dyn ObjectStore>, NAME);
        let options = TaskOptions {
            memory: 1_500_000,
            threads: 1,
        };
        let scratch = Scratch::new();
        let none = store.conquer(0, options, scratch.folder.path()).await;
        assert!(matches!(none, Err(BuildError::NoTasks(_))), "{none:?}");
        let other_name = Builder::new(&scratch.path, points.options.clone().store(store.clone()));
        assert!(
            matches!(other_name, Err(BuildError::StoreName { .. })),
            "{other_name:?}"
        );
        let path = scratch.folder.path().join(store.file_name());
        let mut builder = Builder::new(&path, points.options.clone().store(store.clone())).unwrap();
        points.push(&mut builder).await.unwrap();
        builder.plan_tasks().await.unwrap();
        let beyond = store.conquer(1000, options, scratch.folder.path()).await;
        assert!(
            matches!(beyond, Err(BuildError::NoBlock { block: 1000, .. })),
            "{beyond:?}"
        );
        let little = TaskOptions {
            memory: 1000,
            ..options
        };
        let less = store.conquer(0, little, scratch.folder.path()).await;
        assert!(matches!(less, Err(BuildError::TaskMemory { .. })), "{less:?}");
        let run = keys(&objects)
            .await
            .into_iter()
            .find(|key| key.contains("/run-"))
            .unwrap();
        objects.delete(&Key::from(run.clone())).await.unwrap();
        let name = run.rsplit_once('/').unwrap().1;
        let mut lost = 0;
        let blocks = store.tasks(tempfile::tempdir().unwrap().path()).await.unwrap().blocks();
        for block in 0..blocks {
            if let Err(error) = store.conquer(block, options, scratch.folder.path()).await {
                assert!(whole(&error).contains(name), "{}", whole(&error));
                lost += 1;
            }
        }
        assert_eq!(lost, 1);
        // Cores that are lost are noticed before the file gets its name.
        let cores = keys(&objects)
            .await
            .into_iter()
            .find(|key| key.contains("/cores-"))
            .unwrap();
        objects.delete(&Key::from(cores.clone())).await.unwrap();
        let options = points.options.clone().store(store.clone()).resume(true);
        let finished = Builder::new(&path, options.clone()).unwrap().finish().await;
        let text = whole(&finished.map(|_| ()).unwrap_err());
        assert!(text.contains(cores.rsplit_once('/').unwrap().1), "{text}");
        assert!(!keys(&objects).await.contains(&NAME.to_owned()) && !path.exists());
    });
}
