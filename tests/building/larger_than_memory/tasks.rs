//! The promise: a file whose blocks were conquered by tasks, in any order, more than once, killed or not,
//! is right by itself and has the triangles of one that was built at once.

use std::fs;
use std::path::{Path, PathBuf};

use delaunay_tiles::store::Digest;
use delaunay_tiles::{BlockTasks, BuildError, BuildOptions, BuildSummary, Builder, Planned, TaskOptions};
use distributions::Kind;

use crate::larger_than_memory::inputs::{Input, city, islands, long_lines, valley};
use crate::support::{Random, Scratch, points_of, runtime};

/// Returns the digest of a file, after it proved that the file is right by itself.
pub(super) async fn digest(scratch: &Scratch) -> Digest {
    let reader = scratch.open().await;
    reader.verify(true).await.unwrap();
    reader.recompute_digest().await.unwrap()
}

/// Plans the tasks of a build.
async fn planned(input: &Input, path: &Path, options: BuildOptions) -> Result<Planned, BuildError> {
    let mut builder = Builder::new(path, options)?;
    if builder.needs_points() {
        input.push(&mut builder).await?;
    }
    builder.plan_tasks().await
}

/// Plans the tasks of a build, of which there are several.
async fn tasks(input: &Input, path: &Path) -> BlockTasks {
    match planned(input, path, input.options.clone()).await {
        Ok(Planned::Tasks(tasks)) if tasks.blocks() > 2 => *tasks,
        other => panic!("{}: {other:?}", input.name),
    }
}

pub(super) async fn finished(input: &Input, path: &Path, options: BuildOptions) -> Result<BuildSummary, BuildError> {
    let builder = Builder::new(path, options.resume(true))?;
    assert!(!builder.needs_points());
    assert_eq!(builder.description().memo, input.name);
    builder.finish().await
}

pub(super) fn options_of(input: &Input, threads: usize) -> TaskOptions {
    TaskOptions {
        memory: input.options.memory,
        threads,
    }
}

/// Returns a file of the work folder.
pub(super) fn in_folder(scratch: &Scratch, name: &str) -> PathBuf {
    let mut folder = scratch.path.clone().into_os_string();
    folder.push(".partial");
    Path::new(&folder).join(name)
}

fn block_file(scratch: &Scratch, block: u32) -> PathBuf {
    in_folder(scratch, &format!("block-{block}"))
}

fn cores_file(scratch: &Scratch, block: u32) -> PathBuf {
    in_folder(scratch, &format!("cores-{block}"))
}

/// Puts what a power cut left of a file in its place: less, or other bytes. Bytes of cores that stay in
/// their file are synced.
fn cut_power(file: &Path, random: &mut Random, is_synced: bool) {
    let bytes = fs::read(file).unwrap();
    let mut left = bytes.clone();
    if is_synced || random.below(2) == 0 {
        left.truncate(random.below(bytes.len()));
    } else {
        left[random.below(bytes.len())] ^= 1;
    }
    fs::write(file, left).unwrap();
    fs::write(file.with_extension("x3Yz"), &bytes[..bytes.len().min(9)]).unwrap();
}

/// Conquers all blocks in a random order but the last one, which is left to the build. Returns the
/// summary of the build.
pub(super) async fn conquer_and_finish(input: &Input, scratch: &Scratch, seed: u64) -> BuildSummary {
    let mut random = Random(seed);
    let blocks = tasks(input, &scratch.path).await.blocks();
    let mut left: Vec<u32> = (0..blocks).collect();
    while left.len() > 1 {
        let block = left.swap_remove(random.below(left.len()));
        // Each by another process.
        let tasks = BlockTasks::open(&scratch.path).unwrap();
        let options = options_of(input, 1 + random.below(3));
        let done = tasks.conquer(block, options).await.unwrap();
        assert_eq!(
            (done.block, done.was_done, done.points),
            (block, false, tasks.points(block))
        );
        assert!(tasks.is_done(block));
        let files = [block_file(scratch, block), cores_file(scratch, block)];
        let lengths = files.each_ref().map(|file| file.metadata().unwrap().len());
        assert_eq!(done.bytes_written, lengths.iter().sum::<u64>());
        match random.below(5) {
            0 => assert!(tasks.conquer(block, options).await.unwrap().was_done),
            // Another process did not know of this one.
            1 => {
                fs::remove_file(&files[random.below(2)]).unwrap();
                let again = tasks.conquer(block, options_of(input, 2)).await.unwrap();
                assert_eq!((again.was_done, again.bytes_written), (false, done.bytes_written));
            }
            2 => cut_power(&files[0], &mut random, false),
            3 if lengths[1] > 0 => {
                let is_in_parts = scratch.path.extension().is_some_and(|name| name == "parts");
                cut_power(&files[1], &mut random, is_in_parts);
            }
            _ => {}
        }
    }
    let summary = finished(input, &scratch.path, input.options.clone()).await.unwrap();
    assert_eq!(summary.resumed_blocks, u64::from(blocks));
    summary
}

#[test]
fn blocks_that_tasks_conquered_give_the_triangles_of_one_build() {
    let curve = Input::new("points", &points_of(Kind::Kuzmin, 100_000, 5), &[], 1_500_000);
    runtime().block_on(async {
        for input in [curve, city(), valley(), long_lines()] {
            let whole = Scratch::new();
            let at_once = input.build_at_once(&whole.path).await;
            let mut files = Vec::new();
            for seed in [1, 2] {
                let scratch = Scratch::new();
                let summary = conquer_and_finish(&input, &scratch, seed).await;
                assert_eq!(digest(&scratch).await, digest(&whole).await, "{}", input.name);
                let counts = |of: &BuildSummary| {
                    [
                        of.points,
                        of.vertices,
                        of.triangles,
                        of.duplicates,
                        of.regions,
                        of.hole_regions,
                        of.draped,
                        of.blocks,
                    ]
                };
                assert_eq!(counts(&summary), counts(&at_once), "{}", input.name);
                assert_eq!(fs::read_dir(scratch.folder.path()).unwrap().count(), 1, "work is left");
                files.push(fs::read(&scratch.path).unwrap());
            }
            assert!(files[0] == files[1], "{}: one plan gave two files", input.name);
        }
    });
}

/// With Steiner points the triangles depend on the cells, and tasks have the same.
#[test]
fn tasks_split_lines_at_the_borders_of_the_same_cells() {
    let input = islands();
    runtime().block_on(async {
        let [whole, scratch] = [Scratch::new(), Scratch::new()];
        input.build_at_once(&whole.path).await;
        conquer_and_finish(&input, &scratch, 3).await;
        assert_eq!(digest(&scratch).await, digest(&whole).await);
    });
}

/// The build that gathers the blocks is stopped again and again.
#[test]
fn gathering_goes_on_from_where_it_was_stopped() {
    let input = city();
    runtime().block_on(async {
        let [undisturbed, scratch] = [Scratch::new(), Scratch::new()];
        conquer_and_finish(&input, &undisturbed, 4).await;
        tasks(&input, &scratch.path).await;
        let mut stops = 0;
        loop {
            let progress = std::sync::Arc::<delaunay_tiles::Progress>::default();
            let options = input.options.clone().progress(std::sync::Arc::clone(&progress));
            // It grows with each block.
            let borders = scratch.folder.path().join("test.tiles.partial/borders");
            let length = move || borders.metadata().map_or(0, |metadata| metadata.len());
            let before = length();
            let watch = tokio::spawn(async move {
                while length() <= before {
                    tokio::time::sleep(std::time::Duration::from_micros(100)).await;
                }
                progress.cancel();
            });
            let done = finished(&input, &scratch.path, options).await;
            watch.abort();
            match done {
                Err(BuildError::Cancelled) => stops += 1,
                done => break assert!(done.is_ok() && stops > 2, "{done:?} after {stops}"),
            }
        }
        let [stopped, expected] = [&scratch, &undisturbed].map(|scratch| fs::read(&scratch.path).unwrap());
        assert!(stopped == expected, "the file differs");
    });
}

#[test]
fn what_tasks_cannot_do_is_an_error() {
    let input = city();
    let options = || input.options.clone();
    runtime().block_on(async {
        let scratch = Scratch::new();
        let none = BlockTasks::open(&scratch.path).map(|_| ());
        assert!(matches!(none, Err(BuildError::NoTasks(_))), "{none:?}");
        let fresh = planned(&input, &scratch.path, options().resumable(None)).await;
        assert!(matches!(fresh, Err(BuildError::NotResumable)), "{fresh:?}");
        let tasks = tasks(&input, &scratch.path).await;
        let beyond = tasks.conquer(tasks.blocks(), options_of(&input, 1)).await;
        let text = beyond.unwrap_err().to_string();
        assert_eq!(
            text,
            format!(
                "there is no block {0}; the build has {0}, numbered from 0",
                tasks.blocks()
            )
        );
        let memory = input.options.memory - 1;
        let less = tasks.conquer(0, TaskOptions { memory, threads: 1 }).await;
        assert!(
            matches!(less, Err(BuildError::TaskMemory { given, .. }) if given == memory),
            "{less:?}"
        );
        assert!(!tasks.is_done(0));
        tasks.conquer(0, options_of(&input, 1)).await.unwrap();
        let done = tasks.conquer(0, TaskOptions { memory, threads: 1 }).await.unwrap();
        assert!(done.was_done, "it needs no memory");
        // Neither another build of the file, nor a plan with other options.
        let other = planned(&input, &scratch.path, options()).await;
        assert!(matches!(other, Err(BuildError::WorkKept { .. })), "{other:?}");
        let other = planned(&input, &scratch.path, options().tile_vertices(400).resume(true)).await;
        assert!(matches!(other, Err(BuildError::OtherBuild { .. })), "{other:?}");
        let again = planned(&input, &scratch.path, options().resume(true)).await;
        assert!(
            matches!(&again, Ok(Planned::Tasks(again)) if again.blocks() == tasks.blocks()),
            "{again:?}"
        );
        // Damaged tasks are no tasks.
        let path = scratch.folder.path().join("test.tiles.partial/tasks");
        let mut bytes = fs::read(&path).unwrap();
        *bytes.last_mut().unwrap() ^= 1;
        fs::write(&path, bytes).unwrap();
        let none = BlockTasks::open(&scratch.path).map(|_| ());
        assert!(matches!(none, Err(BuildError::NoTasks(_))), "{none:?}");
    });
}

/// A task of an earlier build of the same name ends after a new one was planned.
#[test]
fn a_block_of_another_plan_counts_for_nothing() {
    let [before, now] =
        [Kind::Uniform, Kind::Kuzmin].map(|kind| Input::new("points", &points_of(kind, 100_000, 5), &[], 1_500_000));
    runtime().block_on(async {
        let [whole, scratch] = [Scratch::new(), Scratch::new()];
        let earlier = tasks(&before, &scratch.path).await;
        earlier.conquer(0, options_of(&before, 1)).await.unwrap();
        let stale = fs::read(block_file(&scratch, 0)).unwrap();
        drop(earlier);
        let again = planned(&now, &scratch.path, now.options.clone().force(true)).await;
        let Ok(Planned::Tasks(tasks)) = again else {
            panic!("{again:?}")
        };
        fs::write(block_file(&scratch, 0), &stale).unwrap();
        assert!(!tasks.is_done(0));
        assert!(!tasks.conquer(0, options_of(&now, 1)).await.unwrap().was_done);
        fs::write(block_file(&scratch, 1), &stale).unwrap();
        finished(&now, &scratch.path, now.options.clone()).await.unwrap();
        now.build_at_once(&whole.path).await;
        assert_eq!(digest(&scratch).await, digest(&whole).await);
    });
}

/// Points that fit into memory make no blocks.
#[test]
fn a_build_in_memory_leaves_no_tasks() {
    let input = Input::new("few points", &points_of(Kind::Uniform, 1000, 1), &[], 64 << 20);
    runtime().block_on(async {
        let scratch = Scratch::new();
        let built = planned(&input, &scratch.path, input.options.clone()).await;
        assert!(
            matches!(&built, Ok(Planned::Built(summary)) if summary.vertices == 1000),
            "{built:?}"
        );
        assert_eq!(scratch.open().await.metadata().vertices, 1000);
    });
}

/// Lines that cross are found by the task of their block, and by the build that goes on.
#[test]
fn tasks_find_lines_that_cross() {
    let mut input = valley();
    input.options = input.options.crossings(delaunay_tiles::Crossings::Error);
    runtime().block_on(async {
        let scratch = Scratch::new();
        let tasks = tasks(&input, &scratch.path).await;
        let mut found = 0;
        for block in 0..tasks.blocks() {
            match tasks.conquer(block, options_of(&input, 2)).await {
                Ok(_) => {}
                Err(BuildError::Crossings { .. }) => found += 1,
                Err(error) => panic!("{error}"),
            }
        }
        let finished = finished(&input, &scratch.path, input.options.clone()).await;
        assert!(matches!(finished, Err(BuildError::Crossings { .. })), "{finished:?}");
        assert!(found > 0, "they cross between blocks alone");
    });
}
