//! Chooses the vertices of a level from those of the finer level below it, and builds it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use futures::stream::{StreamExt, TryStreamExt};

use crate::geometry::{Point, Rect, VertexIndex};
use crate::input::PointBatch;
use crate::overviews::candidates::{Candidate, candidates};
use crate::overviews::chosen::Candidates;
use crate::overviews::error::OverviewError;
use crate::overviews::hash::{hash, is_below};
use crate::overviews::hull::corners;
use crate::overviews::work::Work;
use crate::pipeline::Builder;
use crate::query::SurfacePart;
use crate::store::{Needs, PassReader, ReadError, Tile, TileInPass, TileReader, spawn};

/// The share of the vertices that stays. Somewhat below a quarter, so that all levels together are less
/// than a third of the file.
const SHARE: f64 = 0.24;
/// The share of the vertices that a hash chooses before the first round.
const SEEDS: f64 = 1.0 / 64.0;
/// The share of the candidates that a round chooses at most. The others may lie on the surface after it.
const OF_CANDIDATES: f64 = 0.7;
/// The share of the vertices to be chosen that suffices.
const ENOUGH: f64 = 0.97;
/// The most rounds.
const ROUNDS: u32 = 8;
/// Bytes of memory for each vertex of a tile while candidates are searched.
const BYTES_PER_VERTEX: u64 = 160;

/// Builds the level with this number, from 1, from the one before. Returns its file.
pub(super) async fn choose(fine: &TileReader, work: &Work, level: u32) -> Result<PathBuf, OverviewError> {
    let metadata = fine.metadata();
    let seed = u64::from(level);
    let share = if metadata.has_z { SEEDS } else { SHARE };
    let mut path = work.level(level, 0);
    seeds(fine, work, level, share, &path).await?;
    let want = (SHARE * metadata.vertices as f64) as u64;
    for round in 1..=ROUNDS {
        let coarse = work.open(&path, 1).await?;
        let chosen = coarse.metadata().vertices;
        if !metadata.has_z || chosen as f64 >= ENOUGH * want as f64 {
            break;
        }
        let found = search(fine, &coarse, work, level).await?;
        if found.len() == 0 {
            break;
        }
        let most = (OF_CANDIDATES * found.len() as f64).ceil() as u64;
        // Not the seed that has decided between candidates: of equal ones, their hashes are high.
        let threshold = found.threshold(most.min(want - chosen), !seed);
        let next = work.level(level, round);
        let mut builder = builder(work, &next)?;
        push_vertices(&coarse, work, &mut builder).await?;
        for batch in found.chosen(threshold, &work.spill(level))? {
            work.check()?;
            builder.push(&batch?).await?;
        }
        builder.finish().await?;
        drop(coarse);
        remove(&path)?;
        path = next;
    }
    Ok(path)
}

fn remove(path: &Path) -> Result<(), OverviewError> {
    std::fs::remove_file(path).map_err(OverviewError::io(path, "remove it"))
}

fn builder(work: &Work, path: &Path) -> Result<Builder, OverviewError> {
    Ok(Builder::new(path, work.build_options())?)
}

/// Builds a level of the corners of the hull and of `share` of all other vertices, by a hash.
async fn seeds(fine: &TileReader, work: &Work, level: u32, share: f64, path: &Path) -> Result<(), OverviewError> {
    let passes = fine.for_passes().await?;
    work.progress.start(level, fine.metadata().tiles.into());
    let seed = level.into();
    let mut batches = passes.for_each_tile(Needs::default(), move |tile| {
        let corners = corners(&tile);
        let is_corner = |vertex: VertexIndex| corners.binary_search_by_key(&vertex.0, |corner| corner.0).is_ok();
        let stays = |vertex: &VertexIndex| is_below(hash(tile.point(*vertex), seed), share) || is_corner(*vertex);
        batch(&tile, tile.vertex_indices().filter(stays))
    })?;
    let mut builder = builder(work, path)?;
    while let Some(batch) = batches.try_next().await? {
        work.check()?;
        work.progress.advance();
        builder.push(&batch).await?;
    }
    builder.finish().await?;
    Ok(())
}

/// Pushes all vertices of a file.
async fn push_vertices(reader: &TileReader, work: &Work, builder: &mut Builder) -> Result<(), OverviewError> {
    let mut tiles = reader.tiles();
    while let Some(tile) = tiles.try_next().await? {
        work.check()?;
        builder.push(&batch(&tile, tile.vertex_indices())).await?;
    }
    Ok(())
}

fn batch(tile: &Tile, vertices: impl Iterator<Item = VertexIndex>) -> PointBatch {
    let mut batch = PointBatch::default();
    for vertex in vertices {
        batch.points.push(tile.point(vertex));
        batch.z.extend(tile.z(vertex));
        batch.records.push(tile.record(vertex));
    }
    batch
}

/// Searches all candidates of a round.
async fn search(fine: &TileReader, coarse: &TileReader, work: &Work, level: u32) -> Result<Candidates, OverviewError> {
    let (passes, coarse) = (fine.for_passes().await?, coarse.for_passes().await?);
    work.progress.start(level, fine.metadata().tiles.into());
    let plan = passes.plan(Needs {
        per_vertex: BYTES_PER_VERTEX,
        ..Needs::default()
    })?;
    let seed = level.into();
    let tiles = passes.pass(passes.tile_ids(), plan);
    let found = tiles.map(|tile| {
        let coarse = coarse.clone();
        async move { search_tile(tile?, &coarse, seed).await }
    });
    let mut found = found.buffered(work.threads.min(plan.threads));
    let (mut all, spill) = (Candidates::new(work.shares.chosen()), work.spill(level));
    while let Some(candidates) = found.try_next().await? {
        work.check()?;
        work.progress.advance();
        all.add(&candidates, &spill)?;
    }
    Ok(all)
}

async fn search_tile(tile: TileInPass, coarse: &PassReader, seed: u64) -> Result<Vec<Candidate>, ReadError> {
    let corners = (0..tile.corner_count() as u32).map(VertexIndex);
    let points: Arc<[Point]> = corners.map(|corner| tile.point(corner)).collect();
    let part = SurfacePart::within(coarse, Rect::around(points.iter().copied())).await?;
    let found = part.at(points).await?;
    spawn(move || candidates(&tile, &found, seed)).await
}
