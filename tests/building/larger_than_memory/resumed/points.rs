//! Builds of points alone.

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use crate::larger_than_memory::{digest_of, left, options};
use crate::support::{Random, Scratch, batches, build_batches, points_of, reference, runtime};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::mesh::EngineKind;
use delaunay_tiles::{
    BuildError, BuildOptions, BuildSummary, Builder, Description, Duplicates, MemoryShortage, MemoryUse, Phase,
};
use distributions::Kind;

/// Returns options of a build that can be resumed; with `resume`, of one that resumes.
fn resumable(resume: bool) -> BuildOptions {
    options(2_500_000, 2)
        .resumable(Some("points: 1\nothers: 2".to_owned()))
        .resume(resume)
}

/// Builds, and cancels the build once `until` points were conquered. Points are pushed only if they
/// are needed.
async fn build_until(
    scratch: &Scratch,
    points: &[Point],
    options: BuildOptions,
    until: u64,
) -> Result<BuildSummary, BuildError> {
    let progress = Arc::clone(&options.progress);
    let watch = tokio::spawn(async move {
        loop {
            let (phase, done, _) = progress.state();
            if phase == Phase::Conquer && done >= until {
                return progress.cancel();
            }
            tokio::time::sleep(Duration::from_micros(200)).await;
        }
    });
    let mut builder = Builder::new(&scratch.path, options)?;
    if builder.needs_points() {
        for batch in batches(points, &[]) {
            builder.push(&batch).await?;
        }
        builder.describe(Description {
            memo: "note".to_owned(),
            ..Description::default()
        });
    }
    assert_eq!(builder.description().memo, "note");
    let built = builder.finish().await;
    watch.abort();
    built
}

#[test]
fn a_cancelled_build_resumes_and_gives_the_same_bytes() {
    let points = points_of(Kind::Kuzmin, 200_000, 2);
    let expected = reference(EngineKind::Native, &points);
    runtime().block_on(async {
        let whole = Scratch::new();
        build_batches(&whole.path, &batches(&points, &[]), resumable(false))
            .await
            .unwrap();
        let mut resumed_blocks = 0;
        for until in [0, 50_000, 100_000, 150_000, 195_000] {
            let scratch = Scratch::new();
            let cancelled = build_until(&scratch, &points, resumable(false), until).await;
            if cancelled.is_ok() {
                continue;
            }
            assert!(matches!(cancelled, Err(BuildError::Cancelled)), "{cancelled:?}");
            assert_eq!(left(&scratch), ["test.tiles.partial"]);
            // Interrupted for the second time.
            let again = resumable(true).threads(1);
            let _ = build_until(&scratch, &points, again, until + 20_000).await;
            if !scratch.path.exists() {
                let summary = build_until(&scratch, &points, resumable(true), u64::MAX).await.unwrap();
                resumed_blocks += summary.resumed_blocks;
            }
            assert_eq!(digest_of(&scratch).await, expected);
            assert!(
                fs::read(&scratch.path).unwrap() == fs::read(&whole.path).unwrap(),
                "the file differs"
            );
            assert_eq!(left(&scratch), ["test.tiles"]);
        }
        assert!(resumed_blocks > 0, "no build went on from a finished block");
    });
}

/// A caller that drops its future, as a service does at shutdown, loses no work.
#[test]
fn a_dropped_build_resumes() {
    let points = points_of(Kind::Uniform, 200_000, 5);
    let expected = reference(EngineKind::Native, &points);
    runtime().block_on(async {
        let scratch = Scratch::new();
        let options = resumable(false);
        let progress = Arc::clone(&options.progress);
        let mut builder = Builder::new(&scratch.path, options).unwrap();
        for batch in batches(&points, &[]) {
            builder.push(&batch).await.unwrap();
        }
        let far = async {
            while !matches!(progress.state(), (Phase::Conquer, done, _) if done >= 100_000) {
                tokio::time::sleep(Duration::from_micros(200)).await;
            }
        };
        tokio::select! {
            built = builder.finish() => panic!("it was not stopped: {built:?}"),
            () = far => {}
        }
        assert_eq!(left(&scratch), ["test.tiles.partial"]);
        // The threads of the build hold the lock until they have ended.
        let mut again = Builder::new(&scratch.path, resumable(true));
        for _ in 0..500 {
            if !matches!(again, Err(BuildError::Locked(_))) {
                break;
            }
            tokio::time::sleep(Duration::from_millis(10)).await;
            again = Builder::new(&scratch.path, resumable(true));
        }
        let again = again.unwrap();
        assert!(!again.needs_points(), "the work is gone");
        again.finish().await.unwrap();
        assert_eq!(digest_of(&scratch).await, expected);
        assert_eq!(left(&scratch), ["test.tiles"]);
    });
}

/// As if the build was killed after it gave the file its name: there is nothing to resume.
#[test]
fn a_resume_clears_what_a_published_build_left() {
    let points = points_of(Kind::Uniform, 200_000, 6);
    runtime().block_on(async {
        let scratch = Scratch::new();
        let cancelled = build_until(&scratch, &points, resumable(false), 100_000).await;
        assert!(matches!(cancelled, Err(BuildError::Cancelled)), "{cancelled:?}");
        let mut partial = scratch.path.clone().into_os_string();
        partial.push(".partial");
        fs::remove_file(Path::new(&partial).join("tiles")).unwrap();
        let mut builder = Builder::new(&scratch.path, resumable(true)).unwrap();
        assert!(builder.needs_points());
        for batch in batches(&points, &[]) {
            builder.push(&batch).await.unwrap();
        }
        builder.finish().await.unwrap();
        assert_eq!(digest_of(&scratch).await, reference(EngineKind::Native, &points));
        assert_eq!(left(&scratch), ["test.tiles"]);
    });
}

#[test]
fn other_options_other_inputs_or_too_little_memory_cannot_resume_a_build() {
    let points = points_of(Kind::Uniform, 200_000, 2);
    runtime().block_on(async {
        let scratch = Scratch::new();
        let cancelled = build_until(&scratch, &points, resumable(false), 100_000).await;
        assert!(matches!(cancelled, Err(BuildError::Cancelled)), "{cancelled:?}");
        let others = [
            resumable(true).tile_vertices(1001),
            resumable(true).duplicates(Duplicates::Lowest),
            resumable(true).resumable(Some("points: 1\nothers: 3".to_owned())),
        ];
        for other in others {
            let result = Builder::new(&scratch.path, other).map(|_| ());
            assert!(matches!(result, Err(BuildError::OtherBuild { .. })), "{result:?}");
            assert_eq!(left(&scratch), ["test.tiles.partial"]);
        }
        let nothing = resumable(true).resumable(None);
        let result = Builder::new(&scratch.path, nothing).map(|_| ());
        assert!(matches!(result, Err(BuildError::NotResumable)), "{result:?}");
        let little = resumable(true).memory(500_000);
        let result = build_until(&scratch, &points, little, u64::MAX).await;
        assert!(
            matches!(
                result,
                Err(BuildError::Memory(MemoryShortage {
                    of: MemoryUse::Tile,
                    ..
                }))
            ),
            "{result:?}"
        );

        // A resumed build does not accept points again.
        let scratch = Scratch::new();
        let cancelled = build_until(&scratch, &points, resumable(false), 100_000).await;
        assert!(matches!(cancelled, Err(BuildError::Cancelled)), "{cancelled:?}");
        let mut builder = Builder::new(&scratch.path, resumable(true)).unwrap();
        let pushed = builder.push(&batches(&points, &[])[0]).await;
        assert!(matches!(pushed, Err(BuildError::PointsComplete)), "{pushed:?}");
        drop(builder);
        // A build without `resume` removes the old work only by force.
        let refused = Builder::new(&scratch.path, resumable(false)).map(|_| ());
        assert!(
            matches!(refused, Err(BuildError::WorkKept { bytes, .. }) if bytes > 0),
            "{refused:?}"
        );
        assert_eq!(left(&scratch), ["test.tiles.partial"]);
        build_batches(&scratch.path, &batches(&points, &[]), resumable(false).force(true))
            .await
            .unwrap();
        assert_eq!(left(&scratch), ["test.tiles"]);
    });
}

/// Changed bits in runs, log and journal give an error or the same file.
#[test]
fn damaged_work_gives_an_error_or_the_same_file() {
    let points = points_of(Kind::Uniform, 200_000, 2);
    let expected = reference(EngineKind::Native, &points);
    let mut random = Random(1);
    let mut errors = 0;
    runtime().block_on(async {
        let scratch = Scratch::new();
        let cancelled = build_until(&scratch, &points, resumable(false), 100_000).await;
        assert!(matches!(cancelled, Err(BuildError::Cancelled)), "{cancelled:?}");
        let folder = scratch.folder.path().join("test.tiles.partial");
        let names: Vec<_> = fs::read_dir(&folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name())
            .collect();
        for round in 0..40 {
            let name = &names[round % names.len()];
            let copy = Scratch::new();
            let work = copy.folder.path().join("test.tiles.partial");
            fs::create_dir(&work).unwrap();
            for name in &names {
                fs::copy(folder.join(name), work.join(name)).unwrap();
            }
            // Readers check the finished file as a whole; its extents have checksums of their own.
            let mut bytes = fs::read(folder.join(name)).unwrap();
            if name == "tiles" || bytes.is_empty() {
                continue;
            }
            let bit = random.below(bytes.len() * 8);
            bytes[bit / 8] ^= 1 << (bit % 8);
            fs::write(work.join(name), bytes).unwrap();
            let built = tokio::time::timeout(Duration::from_secs(60), resume(&copy.path, &points)).await;
            match built.expect("it hangs") {
                Ok(()) => assert_eq!(digest_of(&copy).await, expected, "{name:?}"),
                Err(error) => {
                    errors += 1;
                    println!("{name:?}: {error}");
                }
            }
        }
    });
    assert!(errors > 0);
}

async fn resume(path: &Path, points: &[Point]) -> Result<(), BuildError> {
    let mut builder = Builder::new(path, resumable(true))?;
    if builder.needs_points() {
        for batch in batches(points, &[]) {
            builder.push(&batch).await?;
        }
    }
    builder.finish().await.map(|_| ())
}
