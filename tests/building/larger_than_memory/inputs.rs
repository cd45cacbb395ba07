//! Inputs of builds that outgrow their memory: with lines, sites, holes and ponds.

use std::path::Path;

use crate::support::{batches, points_of};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::{PointBatch, SegmentBatch, SiteBatch, SiteId};
use delaunay_tiles::store::LineKind;
use delaunay_tiles::{BuildError, BuildOptions, BuildSummary, Builder, Crossings, Description, MissingZ, Steiner};
use distributions::{Kind, LongSegments};

/// The input of a build that outgrows its memory.
#[derive(Clone, Default)]
pub struct Input {
    pub name: &'static str,
    pub options: BuildOptions,
    points: Vec<PointBatch>,
    lines: Vec<(LineKind, SegmentBatch)>,
    ponds: SegmentBatch,
    seeds: Vec<Point>,
    sites: SiteBatch,
}

impl Input {
    pub fn new(name: &'static str, points: &[Point], z: &[f64], memory: u64) -> Self {
        Self {
            name,
            options: BuildOptions::default()
                .tile_vertices(1000)
                .memory(memory)
                .threads(2)
                .resumable(Some("points: 1".to_owned())),
            points: batches(points, z),
            ..Self::default()
        }
    }

    /// Pushes all of it to a builder.
    pub async fn push(&self, builder: &mut Builder) -> Result<(), BuildError> {
        self.push_beside(builder)?;
        for batch in &self.points {
            builder.push(batch).await?;
        }
        self.describe(builder);
        Ok(())
    }

    /// Builds it at once.
    pub async fn build_at_once(&self, path: &Path) -> BuildSummary {
        let mut builder = Builder::new(path, self.options.clone()).unwrap();
        self.push(&mut builder).await.unwrap();
        builder.finish().await.unwrap()
    }

    /// Returns the batches of the points.
    pub fn points(&self) -> &[PointBatch] {
        &self.points
    }

    /// Describes the input to a builder.
    pub fn describe(&self, builder: &mut Builder) {
        builder.describe(Description {
            memo: self.name.to_owned(),
            ..Description::default()
        });
    }

    /// Pushes all but the points.
    pub fn push_beside(&self, builder: &mut Builder) -> Result<(), BuildError> {
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
        builder.push_sites(&self.sites)
    }
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
pub fn city() -> Input {
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
pub fn long_lines() -> Input {
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
pub fn valley() -> Input {
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
pub fn islands() -> Input {
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
