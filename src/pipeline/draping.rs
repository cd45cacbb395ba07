//! The surface of a build: its points are triangulated alone, and read back from that file.
//!
//! In: all points, in memory or in runs, and shores of ponds. Out: a [`PointSurface`] in the work
//! folder, which has the z of the ponds, and the points once more, without duplicates, for the build
//! with lines and sites. Neither the input is read again nor are all points in memory at once.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use futures::TryStreamExt;

use crate::edit::EditError;
use crate::geometry::{Point, Rect};
use crate::input::{MissingZ, PointBatch};
use crate::io::Backend;
use crate::pipeline::assembly::Assembly;
use crate::pipeline::context::{BuildContext, Given};
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::drape::{Draping, PointSurface};
use crate::pipeline::ingest::intake::Intake;
use crate::pipeline::options::{BuildOptions, Crossings, Steiner};
use crate::store::{OpenOptions, Tile, TileReader};
use crate::terrain::{Outline, OutlineParts, Ponds, ShoreLevels, Shores};

/// The first number of runs of points that were read back. Runs of the surface have lower numbers:
/// they may still be in the course of being removed.
const FIRST_RUN: u32 = 1 << 31;

/// Triangulates all points of a build alone, and finds the z of ponds on them. `given` says how many points there are and which
/// record number comes next. Returns the surface, and an intake with the points. From now on, the
/// surface has its share of the memory in `context`.
pub(crate) async fn surface_of(
    (intake, shores): (Intake, Shores),
    context: &mut BuildContext,
    output: &Path,
    given: Given,
    began: Instant,
) -> Result<(PointSurface, Intake), BuildError> {
    let (points, first_end) = (given.points, given.next_record);
    context.first_end.store(first_end, Ordering::Relaxed);
    let all = intake.finish().await?;
    let alone = BuildContext {
        options: Arc::new(options_alone(&context.options)),
        ..context.clone()
    };
    let path = Assembly::new(&alone, output, given, began).build_surface(all).await?;
    drop(alone);
    context.first_run = FIRST_RUN;
    context.memory = context.memory.with_surface();
    let options = OpenOptions::default()
        .memory(context.memory.for_reading_back(points))
        .backend(Backend::Threads);
    let reader = TileReader::open(&path, options).await.map_err(EditError::Read)?;
    let (intake, outline, ponds) = read_back(&reader, points, shores, context).await?;
    drop(reader);
    let (memory, progress) = (context.memory.for_surface(), Arc::clone(&context.options.progress));
    let rules = Draping {
        first_lacking: (context.options.missing_z == MissingZ::Drape).then_some(first_end),
        first_end,
        outline,
        ponds,
    };
    let surface = PointSurface::open(&path, rules, memory, progress).await;
    Ok((surface.map_err(EditError::Read)?, intake))
}

/// Returns the options of the triangulation of the points alone.
fn options_alone(options: &BuildOptions) -> BuildOptions {
    BuildOptions {
        // Points without z have no surface to take it from.
        missing_z: MissingZ::Error,
        crossings: Crossings::Error,
        steiner: Steiner::Never,
        exterior_is_hole: false,
        compress: false,
        resumable: None,
        ..options.clone()
    }
}

/// Reads the vertices of the surface into an intake, its outline, and the z of ponds.
async fn read_back(
    reader: &TileReader,
    points: u64,
    shores: Shores,
    context: &BuildContext,
) -> Result<(Intake, Outline, Ponds), BuildError> {
    let mut intake = Intake::new();
    let directory = reader.directory().await.map_err(EditError::Read)?;
    let sample = sample(directory.tiles.iter().map(|tile| tile.bounds));
    intake.expect(points, sample, context)?;
    let (mut outline, mut levels) = (OutlineParts::default(), ShoreLevels::new(shores));
    let has_triangles = reader.metadata().triangles > 0;
    let mut tiles = reader.tiles();
    while let Some(tile) = tiles.try_next().await.map_err(EditError::Read)? {
        if context.options.progress.is_cancelled() {
            return Err(BuildError::Cancelled);
        }
        outline.add(&tile, has_triangles);
        levels.add(&tile);
        intake.push(&vertices(&tile), context).await?;
    }
    let outline = outline.finish();
    let ponds = levels.finish(&outline);
    Ok((intake, outline, ponds))
}

/// Returns a sample of the points: tiles have about equally many of them.
pub(crate) fn sample(tiles: impl ExactSizeIterator<Item = Rect>) -> Vec<Point> {
    let side: u32 = if tiles.len() > 4096 { 1 } else { 4 };
    let share = move |at: u32| (f64::from(at) + 0.5) / f64::from(side);
    let in_tile = move |bounds: Rect| {
        let (width, height) = bounds.size();
        let cells = (0..side).flat_map(move |i| (0..side).map(move |j| (i, j)));
        cells.map(move |(i, j)| Point::new(bounds.min_x + share(i) * width, bounds.min_y + share(j) * height))
    };
    tiles.flat_map(in_tile).map(Point::normalized).collect()
}

/// Returns the vertices of a tile as the points that they were.
fn vertices(tile: &Tile) -> PointBatch {
    let vertices = || tile.vertex_indices();
    PointBatch {
        points: vertices().map(|vertex| tile.point(vertex)).collect(),
        z: vertices().filter_map(|vertex| tile.z(vertex)).collect(),
        records: vertices().map(|vertex| tile.record(vertex)).collect(),
    }
}
