//! Builds with lines, sites, holes and ponds.

use std::fs;
use std::sync::Arc;
use std::time::Duration;

use crate::support::cases::cases;
use crate::support::{Random, Scratch, batches, points_of, runtime};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::{PointBatch, SegmentBatch, SiteBatch, SiteId};
use delaunay_tiles::store::LineKind;
use delaunay_tiles::{
    BuildError, BuildOptions, BuildSummary, Builder, Crossings, Description, MissingZ, Phase, Steiner,
};
use distributions::{Kind, LongSegments};

/// The input of a build that outgrows its memory.
#[derive(Clone, Default)]
struct Input {
    name: &'static str,
    options: BuildOptions,
    points: Vec<PointBatch>,
    lines: Vec<(LineKind, SegmentBatch)>,
    ponds: SegmentBatch,
    seeds: Vec<Point>,
    sites: SiteBatch,
}

impl Input {
    fn new(name: &'static str, points: &[Point], z: &[f64], memory: u64) -> Self {
        Self {
            name,
            options: BuildOptions::default()
                .tile_vertices(500)
                .memory(memory)
                .threads(2)
                .resumable(Some("points: 1".to_owned())),
            points: batches(points, z),
            ..Self::default()
        }
    }

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

    async fn push(&self, builder: &mut Builder) -> Result<(), BuildError> {
        let ponds = self.ponds.lines.iter().copied().max().map_or(0, |last| last + 1);
        if ponds > 0 {
            builder.push_ponds(0, &self.ponds)?;
        }
        let mut first = ponds;
        for (kind, lines) in &self.lines {
            builder.push_lines(*kind, first, lines)?;
            first += lines.lines.iter().copied().max().map_or(0, |last| last + 1);
        }
        builder.push_seeds(&self.seeds)?;
        builder.push_sites(&self.sites)?;
        for batch in &self.points {
            builder.push(batch).await?;
        }
        builder.describe(Description {
            memo: self.name.to_owned(),
            ..Description::default()
        });
        Ok(())
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

/// Returns a batch of chains of segments, each a line.
fn chains(chains: &[Vec<Point>], is_closed: bool) -> SegmentBatch {
    let mut batch = SegmentBatch::default();
    for (line, chain) in chains.iter().enumerate() {
        let next = chain.iter().cycle().skip(1);
        let count = if is_closed { chain.len() } else { chain.len() - 1 };
        for (&from, &to) in chain.iter().zip(next).take(count) {
            batch.ends.push([from, to]);
            batch.lines.push(line as u64);
        }
    }
    batch
}

/// Returns regular polygons around points of a grid with this many cells along each side of the unit
/// square, counter-clockwise.
fn rings(side: u32, radius: f64, corners: u32) -> Vec<Vec<Point>> {
    let cells = (0..side).flat_map(|i| (0..side).map(move |j| (i, j)));
    let ring = |(i, j): (u32, u32)| {
        let at = |cell: u32| (f64::from(cell) + 0.5) / f64::from(side);
        let corner = |corner: u32| {
            let angle = std::f64::consts::TAU * f64::from(corner) / f64::from(corners);
            Point::new(at(i) + radius * angle.cos(), at(j) + radius * angle.sin())
        };
        (0..corners).map(corner).collect()
    };
    cells.map(ring).collect()
}

/// Walls and break lines across many blocks, obstacles, hole points, and sites with names.
fn city() -> Input {
    let points = points_of(Kind::Uniform, 60_000, 7);
    let mut input = Input::new("city", &points, &[], 1_500_000);
    let along = |y: f64| (0..40u32).map(|i| Point::new(0.01 + f64::from(i) / 41.0, y)).collect();
    let streets: Vec<Vec<Point>> = [0.2, 0.4, 0.6].map(along).into();
    let houses = rings(6, 0.01, 7);
    let sites: Vec<Point> = houses
        .iter()
        .map(|house| Point::new(house[0].x - 0.005, house[0].y))
        .collect();
    input.sites = SiteBatch {
        ids: (0..sites.len())
            .map(|site| match site % 3 {
                0 => SiteId::Text(format!("house {site}")),
                _ => SiteId::Number(1000 + site as u64),
            })
            .collect(),
        points: sites,
        ..SiteBatch::default()
    };
    input.lines = vec![
        (LineKind::BreakLine, chains(&streets[..2], false)),
        (LineKind::Wall, chains(&streets[2..], false)),
        (LineKind::Wall, chains(&rings(3, 0.03, 24), true)),
        (LineKind::Obstacle, chains(&houses, true)),
    ];
    input.seeds = vec![Point::new(0.5, 0.5), Point::new(5.0, 5.0)];
    input
}

/// Lines that hold more triangles than fit, so that some are deferred.
fn long_lines() -> Input {
    let long = LongSegments::new(60_000, 100, 3).unwrap();
    let points: Vec<Point> = long.points().map(|[x, y]| Point::new(x, y)).collect();
    let ends: Vec<Vec<Point>> = long
        .segments()
        .map(|ends| ends.map(|end| points[end as usize]).to_vec())
        .collect();
    let mut input = Input::new("long lines", &points, &[], 1_600_000);
    input.lines = vec![
        (LineKind::BreakLine, chains(&ends[..50], false)),
        (LineKind::Wall, chains(&ends[50..], false)),
    ];
    input
}

/// Lines and sites without z on points with z, and ponds.
fn valley() -> Input {
    let points = points_of(Kind::Kuzmin, 60_000, 2);
    let z: Vec<f64> = points.iter().map(|p| 100.0 * p.x * p.x + 30.0 * p.y).collect();
    let mut input = Input::new("valley", &points, &z, 2_400_000);
    input.options = input.options.missing_z(MissingZ::Drape).crossings(Crossings::Split);
    let path: Vec<Point> = (0..30u32)
        .map(|i| Point::new(f64::from(i) / 15.0 - 1.0, 0.013))
        .collect();
    let other: Vec<Point> = (0..30u32)
        .map(|i| Point::new(0.017, f64::from(i) / 15.0 - 1.0))
        .collect();
    input.lines = vec![(LineKind::BreakLine, chains(&[path, other], false))];
    input.ponds = chains(&rings(3, 0.04, 9), true);
    input.sites = SiteBatch {
        points: vec![Point::new(0.4, 0.3), Point::new(-7.0, 12.0)],
        ids: vec![SiteId::Number(1), SiteId::Text("far".to_owned())],
        ..SiteBatch::default()
    };
    input
}

/// Islands, whose outside is a hole, with lines that are split at the borders of cells.
fn islands() -> Input {
    let points = points_of(Kind::Uniform, 60_000, 11);
    let mut input = Input::new("islands", &points, &[], 1_500_000);
    input.options = input.options.exterior_is_hole(true).compress(true);
    input.options = input.options.steiner(Steiner::Borders);
    input.lines = vec![
        (LineKind::Obstacle, chains(&rings(2, 0.2, 60), true)),
        (
            LineKind::BreakLine,
            chains(&[vec![Point::new(0.001, 0.499), Point::new(0.999, 0.501)]], false),
        ),
    ];
    input
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
