//! The input of the builds that are drawn: islands, points around them, and lines in the sea.

use std::cmp::Ordering;
use std::fs;
use std::path::Path;

use anyhow::{Context, ensure};
use delaunay_tiles::geometry::{Point, Rect, area_sign};
use delaunay_tiles::input::{PointBatch, SegmentBatch};
use delaunay_tiles::store::{LineKind, OpenOptions, TileReader};
use delaunay_tiles::{BuildOptions, Builder};
use distributions::{Kind, points};
use serde_json::Value;

/// The part of the world that is drawn, in degrees: Bali, Lombok and Sumbawa.
pub const WINDOW: Rect = Rect::new(114.2, -9.7, 119.45, -7.4);
/// The number of points, those of the coast lines included.
pub const POINTS: usize = 1600;
/// The seed of the points that are not on coast lines.
const SEED: u64 = 7;
/// Break lines that cross no island.
const LINES: [&[[f64; 2]]; 2] = [
    &[[114.42, -7.62], [116.35, -7.95], [119.18, -7.72]],
    &[[114.95, -9.42], [117.05, -9.22], [119.3, -9.52]],
];

/// Islands, points and lines. Every end of a line is a point.
pub struct Ground {
    pub points: Vec<Point>,
    /// The coast of each island, counter-clockwise.
    pub islands: Vec<Vec<Point>>,
    /// The segments of the break lines.
    pub lines: Vec<[Point; 2]>,
}

impl Ground {
    /// Reads the islands that lie in the window, and adds random points.
    ///
    /// # Errors
    /// Fails if the file is no GeoJSON, or has no islands there, or too many.
    pub fn read(file: &Path) -> anyhow::Result<Self> {
        let shown = file.display();
        let text = fs::read(file).with_context(|| format!("cannot read {shown}"))?;
        let whole: Value = serde_json::from_slice(&text).with_context(|| format!("{shown} is no GeoJSON"))?;
        let features = whole["features"].as_array().map_or(&[][..], Vec::as_slice);
        let polygons = features.iter().map(|feature| &feature["geometry"]["coordinates"]);
        let islands: Vec<_> = polygons.filter_map(island).collect();
        let lines: Vec<Vec<Point>> = LINES
            .iter()
            .map(|line| line.iter().map(|&[x, y]| Point::new(x, y)).collect())
            .collect();
        let ends: Vec<Point> = islands.iter().chain(&lines).flatten().copied().collect();
        ensure!(
            !islands.is_empty() && ends.len() < POINTS,
            "{shown}: {} islands with {} vertices lie in the window; these pictures need less than {POINTS}",
            islands.len(),
            ends.len()
        );
        let (width, height) = WINDOW.size();
        // As precise as the coast lines.
        let rounded = |degrees: f64| (degrees * 1e5).round() / 1e5;
        let others = points(Kind::Uniform, (POINTS - ends.len()) as u64, SEED)
            .map(|[x, y]| Point::new(rounded(WINDOW.min_x + x * width), rounded(WINDOW.min_y + y * height)));
        Ok(Self {
            points: ends.iter().copied().chain(others).collect(),
            islands,
            lines: lines.iter().flat_map(|line| segments(line)).collect(),
        })
    }

    /// Builds a tile file, with the islands and lines as constraints or of the points alone.
    ///
    /// # Errors
    /// Fails if the build fails.
    pub async fn build(&self, path: &Path, tile_vertices: usize, is_constrained: bool) -> anyhow::Result<TileReader> {
        let mut builder = Builder::new(path, BuildOptions::default().tile_vertices(tile_vertices))?;
        if is_constrained {
            builder.push_segments(&self.lines)?;
            builder.push_lines(LineKind::Obstacle, self.lines.len() as u64, &self.coasts())?;
        }
        let batch = PointBatch {
            records: (0..self.points.len() as u64).collect(),
            points: self.points.clone(),
            z: Vec::new(),
        };
        builder.push(&batch).await?;
        builder.finish().await?;
        Ok(TileReader::open(path, OpenOptions::default()).await?)
    }

    /// Returns the segments of the coasts, each coast a line.
    fn coasts(&self) -> SegmentBatch {
        let mut batch = SegmentBatch::default();
        for (coast, number) in self.islands.iter().zip(0..) {
            let last = [coast[coast.len() - 1], coast[0]];
            batch.ends.extend(segments(coast).chain([last]));
            batch.lines.resize(batch.ends.len(), number);
        }
        batch
    }
}

/// Returns the outer ring of a polygon, counter-clockwise and without its repeated end, if it lies
/// in the window.
fn island(polygon: &Value) -> Option<Vec<Point>> {
    let corners = polygon[0].as_array()?.iter();
    let corners = corners.map(|corner| Some(Point::new(corner[0].as_f64()?, corner[1].as_f64()?)));
    let mut ring: Vec<Point> = corners.collect::<Option<_>>()?;
    ring.dedup();
    if ring.first() == ring.last() {
        ring.pop();
    }
    match area_sign(ring.iter().copied()) {
        Ordering::Less => ring.reverse(),
        Ordering::Equal => return None,
        Ordering::Greater => {}
    }
    ring.iter().all(|&corner| WINDOW.contains(corner)).then_some(ring)
}

/// Returns the segments of a line.
fn segments(line: &[Point]) -> impl Iterator<Item = [Point; 2]> {
    line.windows(2).map(|ends| [ends[0], ends[1]])
}
