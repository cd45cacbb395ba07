//! Builds with lines, sites, holes and ponds.

use std::fs;
use std::sync::Arc;
use std::time::Duration;

use crate::larger_than_memory::inputs::{Input, city, islands, long_lines, valley};
use crate::support::cases::cases;
use crate::support::{Random, Scratch, runtime};
use delaunay_tiles::{BuildError, BuildOptions, BuildSummary, Builder, Crossings, MissingZ, Phase};

impl Input {
    /// Builds, or resumes a build, with these options. Cancels it once `until` points were
    /// conquered.
    async fn build(&self, scratch: &Scratch, options: BuildOptions, until: u64) -> Result<BuildSummary, BuildError> {
        let options = options.progress(Arc::default());
        let progress = Arc::clone(&options.progress);
        // Where the points are triangulated alone before, most builds are stopped later.
        let plan = scratch.folder.path().join("test.tiles.partial/plan");
        let watch = tokio::spawn(async move {
            let is_far = |(phase, done, _): (Phase, u64, u64)| phase == Phase::Conquer && done >= until;
            while !is_far(progress.state()) || !(until.is_multiple_of(4) || plan.exists()) {
                tokio::time::sleep(Duration::from_micros(100)).await;
            }
            progress.cancel();
        });
        let mut builder = Builder::new(&scratch.path, options)?;
        if builder.needs_points() {
            self.push(&mut builder).await?;
        }
        assert_eq!(builder.description().memo, self.name);
        let built = builder.finish().await;
        watch.abort();
        built
    }

    /// Builds without and with interruptions. Returns the summary of the build without any.
    async fn check(&self) -> BuildSummary {
        let name = self.name;
        let whole = Scratch::new();
        let summary = self.build(&whole, self.options.clone(), u64::MAX).await;
        let summary = summary.unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(summary.blocks > 2, "{name}: {} blocks", summary.blocks);
        let expected = fs::read(&whole.path).unwrap();
        let mut resumed_blocks = 0;
        let mut random = Random(5);
        for _ in 0..cases(40) {
            let scratch = Scratch::new();
            let mut until = random.below(summary.points as usize) as u64;
            let mut built = self.build(&scratch, self.options.clone(), until).await;
            while built.is_err() {
                assert!(matches!(built, Err(BuildError::Cancelled)), "{name}: {built:?}");
                until += 1 + random.below(summary.points as usize / 2) as u64;
                let mut again = self.options.clone().resume(true);
                // Without a plan, it begins again, and its blocks depend on the threads.
                if scratch.folder.path().join("test.tiles.partial/plan").exists() {
                    again = again.threads(1 + random.below(3));
                }
                built = self.build(&scratch, again, until).await;
            }
            let built = built.unwrap();
            resumed_blocks += built.resumed_blocks;
            assert_eq!(comparable(&built), comparable(&summary), "{name}");
            assert!(fs::read(&scratch.path).unwrap() == expected, "{name}: the file differs");
        }
        assert!(resumed_blocks > 0, "{name}: no build went on from a finished block");
        summary
    }
}

/// Returns the part of a summary that is the same whatever was interrupted.
fn comparable(summary: &BuildSummary) -> String {
    let part = BuildSummary {
        resumed_blocks: 0,
        waits: Default::default(),
        phases: Default::default(),
        peak_memory: Default::default(),
        ..summary.clone()
    };
    format!("{part:?}")
}

#[test]
fn builds_with_lines_resume_and_give_the_same_bytes() {
    runtime().block_on(async {
        let city = city().check().await;
        assert!(city.hole_triangles > 0 && city.sites_in_holes > 0, "{city:?}");
        let valley = valley().check().await;
        assert!(
            valley.ponds == 9 && valley.draped > 0 && valley.flattened > 0,
            "{valley:?}"
        );
        assert!(valley.crossings > 0, "{valley:?}");
        let islands = islands().check().await;
        assert!(islands.split_points > 0, "{islands:?}");
    });
}

#[test]
fn builds_that_defer_lines_resume_and_give_the_same_bytes() {
    runtime().block_on(async {
        let summary = long_lines().check().await;
        assert!(summary.deferred_segments > 0, "nothing was deferred");
    });
}

/// Threads do their work at other moments in each build.
#[test]
fn repeated_builds_give_the_same_bytes() {
    runtime().block_on(async {
        for input in [city(), long_lines(), valley(), islands()] {
            let mut expected = None;
            for _ in 0..cases(40) {
                let scratch = Scratch::new();
                input.build(&scratch, input.options.clone(), u64::MAX).await.unwrap();
                let bytes = fs::read(&scratch.path).unwrap();
                assert!(
                    *expected.get_or_insert_with(|| bytes.clone()) == bytes,
                    "{}",
                    input.name
                );
            }
        }
    });
}

/// With other options a build does not go on, and its work stays.
#[test]
fn a_build_with_lines_goes_on_only_as_what_it_was() {
    let input = city();
    runtime().block_on(async {
        let scratch = Scratch::new();
        let cancelled = input.build(&scratch, input.options.clone(), 30_000).await;
        assert!(matches!(cancelled, Err(BuildError::Cancelled)), "{cancelled:?}");
        let again = || input.options.clone().resume(true);
        for other in [
            again().crossings(Crossings::Split),
            again().exterior_is_hole(true),
            again().missing_z(MissingZ::Zero),
            again().resumable(Some("points: 2".to_owned())),
        ] {
            let refused = input.build(&scratch, other, u64::MAX).await;
            assert!(matches!(refused, Err(BuildError::OtherBuild { .. })), "{refused:?}");
        }
        // With less memory, it has the same triangles.
        let less = input
            .build(&scratch, again().memory(1_400_000), u64::MAX)
            .await
            .unwrap();
        let whole = Scratch::new();
        input.build(&whole, input.options.clone(), u64::MAX).await.unwrap();
        let digest = async |scratch: &Scratch| scratch.open().await.recompute_digest().await.unwrap();
        assert_eq!(digest(&scratch).await, digest(&whole).await);
        assert!(less.resumed_blocks > 0);
    });
}

/// After a power cut, files whose content was not synced may be gone or cut short. The build begins
/// again by itself, and gives the same file.
#[test]
fn a_build_whose_work_lost_a_file_begins_again() {
    let input = valley();
    runtime().block_on(async {
        let whole = Scratch::new();
        input.build(&whole, input.options.clone(), u64::MAX).await.unwrap();
        for (lost, is_cut_short) in [("run-", false), ("run-", true), ("lines", false), ("surface", false)] {
            let scratch = Scratch::new();
            // Once the plan is there, and no block is finished.
            let cancelled = input.build(&scratch, input.options.clone(), 1).await;
            assert!(matches!(cancelled, Err(BuildError::Cancelled)), "{cancelled:?}");
            let entries = fs::read_dir(scratch.folder.path().join("test.tiles.partial")).unwrap();
            let mut paths = entries.map(|entry| entry.unwrap().path());
            let path = paths.find(|path| path.file_name().unwrap().to_str().unwrap().starts_with(lost));
            let path = path.unwrap_or_else(|| panic!("there is no {lost}"));
            match is_cut_short {
                true => {
                    let file = fs::File::options().write(true).open(&path).unwrap();
                    file.set_len(path.metadata().unwrap().len() - 1).unwrap();
                }
                false => fs::remove_file(&path).unwrap(),
            }
            let again = Builder::new(&scratch.path, input.options.clone().resume(true)).unwrap();
            assert!(again.needs_points(), "it goes on without {lost}");
            drop(again);
            let again = input.options.clone().resume(true);
            let built = input.build(&scratch, again, u64::MAX).await.unwrap();
            assert_eq!(built.resumed_blocks, 0);
            let [built, expected] = [&scratch, &whole].map(|scratch| fs::read(&scratch.path).unwrap());
            assert!(built == expected, "the file differs: {lost}");
        }
    });
}

/// Segments that were damaged meanwhile are noticed.
#[test]
fn damaged_segments_are_no_build() {
    let input = city();
    runtime().block_on(async {
        let scratch = Scratch::new();
        let cancelled = input.build(&scratch, input.options.clone(), 30_000).await;
        assert!(matches!(cancelled, Err(BuildError::Cancelled)), "{cancelled:?}");
        let path = scratch.folder.path().join("test.tiles.partial/lines");
        let bytes = fs::read(&path).unwrap();
        let mut damaged = bytes.clone();
        damaged[bytes.len() / 2] ^= 1;
        for wrong in [&damaged[..], &bytes[..bytes.len() - 1], &bytes[..4]] {
            fs::write(&path, wrong).unwrap();
            let refused = input
                .build(&scratch, input.options.clone().resume(true), u64::MAX)
                .await;
            let error = refused.unwrap_err().to_string();
            assert!(error.contains("test.tiles.partial/lines"), "{error}");
        }
        fs::write(&path, bytes).unwrap();
        input
            .build(&scratch, input.options.clone().resume(true), u64::MAX)
            .await
            .unwrap();
    });
}
