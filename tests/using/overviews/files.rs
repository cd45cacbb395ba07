//! Overviews as parts of a file: crashes, readers, locks, remains.

use std::fs;

use delaunay_tiles::overviews::{OverviewError, OverviewOptions, OverviewProgress, make};
use delaunay_tiles::store::OpenOptions;
use delaunay_tiles::{EditError, EditOptions, Editor, TileReader, overviews};
use distributions::Kind;
use futures::TryStreamExt;

use super::{digests, file, hills, make_small, with_overviews};
use crate::support::{Scratch, open_bytes, runtime};

async fn small() -> Scratch {
    let (points, z) = hills(Kind::Uniform, 1500);
    file(&points, &z, 100).await
}

#[test]
fn a_crash_leaves_a_file_without_overviews_or_with_all_of_them() {
    runtime().block_on(async {
        let scratch = small().await;
        let before = fs::read(&scratch.path).unwrap();
        make_small(&scratch.path).await.unwrap();
        let after = fs::read(&scratch.path).unwrap();
        assert!(
            before[8192..] == after[8192..before.len()],
            "what readers look at has changed"
        );
        assert!(before[..4096] == after[..4096], "the superblock in force has changed");
        let count = scratch.open().await.overviews().len();
        for end in (before.len()..after.len()).step_by(4999) {
            let mut bytes = after[..end].to_vec();
            bytes[..8192].copy_from_slice(&before[..8192]);
            let reader = open_bytes(bytes).await.unwrap();
            assert!(reader.overviews().is_empty());
            reader.verify(false).await.unwrap();
        }
        // A superblock that is only partly written.
        for written in (0..=4096).step_by(64) {
            let mut bytes = after.clone();
            bytes[4096 + written..8192].copy_from_slice(&before[4096 + written..8192]);
            let reader = open_bytes(bytes).await.unwrap();
            let found = reader.overviews().len();
            assert!(found == 0 || found == count, "{found}");
            assert_eq!(overviews::verify(&reader, true).await.unwrap(), found);
        }
    });
}

#[test]
fn readers_go_on_while_overviews_are_renewed() {
    runtime().block_on(async {
        let (points, z) = hills(Kind::Uniform, 4000);
        let scratch = with_overviews(&points, &z, 100).await;
        let expected = digests(&scratch).await;
        let reader = scratch.open().await;
        let path = scratch.path.clone();
        let renewing = tokio::spawn(async move {
            for _ in 0..3 {
                make(&path, OverviewOptions::default().memory(64 << 20).again(true))
                    .await
                    .unwrap();
            }
        });
        while !renewing.is_finished() {
            for level in 0..reader.overviews().len() {
                let opened = reader.overview(level).await.unwrap();
                assert_eq!(opened.recompute_digest().await.unwrap(), expected[level + 1]);
            }
            let opened = scratch.open().await;
            assert_eq!(opened.overviews(), reader.overviews());
            opened.overview(0).await.unwrap().verify(false).await.unwrap();
        }
        renewing.await.unwrap();
        assert_eq!(scratch.open().await.generation(), reader.generation() + 3);
    });
}

#[test]
fn the_cache_never_mixes_levels() {
    runtime().block_on(async {
        let (points, z) = hills(Kind::Uniform, 2000);
        let scratch = with_overviews(&points, &z, 100).await;
        let cache = delaunay_tiles::Cache::new(64 << 20);
        let reader = TileReader::open(&scratch.path, OpenOptions::default().cache(&cache))
            .await
            .unwrap();
        let mut levels = vec![reader.clone()];
        for level in 0..reader.overviews().len() {
            levels.push(reader.overview(level).await.unwrap());
        }
        for _ in 0..2 {
            for level in &levels {
                let mut count = 0;
                let all: Vec<_> = level.tiles().try_collect().await.unwrap();
                for tile in all {
                    let cached = level.tile(tile.id()).await.unwrap();
                    assert_eq!(cached.vertex_count(), tile.vertex_count());
                    assert!(cached.points().eq(tile.points()));
                    count += u64::from(cached.vertex_count());
                }
                assert_eq!(count, level.metadata().vertices);
            }
        }
    });
}

#[test]
fn a_locked_file_is_refused_and_a_cancelled_one_unchanged() {
    runtime().block_on(async {
        let scratch = small().await;
        let before = fs::read(&scratch.path).unwrap();
        let transaction = Editor::open(&scratch.path, EditOptions::default().memory(64 << 20))
            .await
            .unwrap()
            .begin()
            .await
            .unwrap();
        let refused = make_small(&scratch.path).await.unwrap_err();
        assert!(matches!(refused, OverviewError::Edit(EditError::Busy(_))), "{refused}");
        drop(transaction);
        let progress = std::sync::Arc::new(OverviewProgress::default());
        progress.cancel();
        let options = OverviewOptions::default().progress(progress);
        assert!(make(&scratch.path, options).await.is_err());
        assert!(fs::read(&scratch.path).unwrap() == before);
        let names: Vec<_> = fs::read_dir(scratch.folder.path()).unwrap().collect();
        assert_eq!(names.len(), 1, "{names:?}");
    });
}

#[test]
fn the_remains_of_a_killed_process_are_removed_and_those_of_others_are_not() {
    runtime().block_on(async {
        let scratch = small().await;
        let folder = scratch.folder.path().join("test.tiles.overviews.partial");
        fs::create_dir(&folder).unwrap();
        fs::write(folder.join("mine"), "precious").unwrap();
        let refused = make_small(&scratch.path).await.unwrap_err();
        assert!(matches!(refused, OverviewError::NotOurs(_)), "{refused}");
        assert_eq!(fs::read_to_string(folder.join("mine")).unwrap(), "precious");
        fs::remove_dir_all(&folder).unwrap();
        let leave_remains = || {
            fs::create_dir_all(folder.join("level-1-2.partial")).unwrap();
            fs::write(folder.join("level-1-1"), "unfinished").unwrap();
        };
        leave_remains();
        assert!(make_small(&scratch.path).await.unwrap().is_new);
        assert!(!folder.exists());
        // It was killed after it had published.
        leave_remains();
        assert!(!make_small(&scratch.path).await.unwrap().is_new);
        assert!(!folder.exists());
        // Those of others are no obstacle if there is nothing to make.
        fs::create_dir(&folder).unwrap();
        fs::write(folder.join("mine"), "precious").unwrap();
        assert!(!make_small(&scratch.path).await.unwrap().is_new);
        assert_eq!(fs::read_to_string(folder.join("mine")).unwrap(), "precious");
        fs::remove_dir_all(&folder).unwrap();
        leave_remains();
        overviews::remove(&scratch.path).await.unwrap();
        assert!(!folder.exists());
    });
}

#[test]
fn too_little_memory_is_an_error_and_leaves_the_file() {
    runtime().block_on(async {
        let scratch = small().await;
        let before = fs::read(&scratch.path).unwrap();
        let error = make(&scratch.path, OverviewOptions::default().memory(10_000)).await;
        assert!(error.is_err());
        assert!(fs::read(&scratch.path).unwrap() == before);
    });
}
