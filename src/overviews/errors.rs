//! The errors of all levels, measured at every vertex of the file in one pass; and what a pass over these
//! vertices proves.

use std::sync::Arc;

use futures::stream::{StreamExt, TryStreamExt};

use crate::geometry::{Point, Rect, VertexIndex};
use crate::overviews::hull::corners;
use crate::query::{OnSurface, SurfacePart};
use crate::store::{Needs, PassReader, ReadError, TileId, TileInPass, TileReader, spawn};
use crate::terrain::ExactSum;

/// Bytes of memory for each vertex of a tile.
const BYTES_PER_VERTEX: u64 = 96;

/// What a pass over the vertices of a file finds out about a level.
#[derive(Clone, Debug, Default)]
pub(super) struct Measured {
    largest: f64,
    squares: ExactSum,
    /// How many vertices there are.
    pub(super) count: u64,
    /// How many of them are vertices of the level, with the same z.
    pub(super) shared: u64,
    /// A tile with a vertex that is outside the level, or that is one of the level but has another z, or
    /// is a corner of the hull but no vertex of the level.
    pub(super) wrong: Option<(TileId, &'static str)>,
    /// A tile with a vertex of the level that is none of the level before it.
    pub(super) not_nested: Option<TileId>,
}

impl Measured {
    fn add(&mut self, other: Self) {
        self.largest = self.largest.max(other.largest);
        self.squares.merge(other.squares);
        self.count += other.count;
        self.shared += other.shared;
        self.wrong = self.wrong.or(other.wrong);
        self.not_nested = self.not_nested.or(other.not_nested);
    }

    /// Returns the largest error and the root of the mean square of all. They do not depend on the order.
    pub(super) fn errors(&self) -> [f64; 2] {
        let largest = self.largest.min(f64::MAX);
        // The squares of numbers from 10¹⁵⁴ on are too large for a number.
        let mean = self.squares.total().map(|sum| sum / self.count.max(1) as f64);
        let rms = mean.map_or(largest, f64::sqrt);
        [largest, rms.min(largest)]
    }
}

/// Compares all vertices of a file with its levels, from the finest to the coarsest. `advance` is called
/// after each tile, and may stop it.
pub(super) async fn measure<E: From<ReadError>>(
    base: &TileReader,
    levels: &[TileReader],
    threads: usize,
    mut advance: impl FnMut() -> Result<(), E>,
) -> Result<Vec<Measured>, E> {
    let passes = base.for_passes().await?;
    let plan = passes.plan(Needs {
        per_vertex: BYTES_PER_VERTEX,
        ..Needs::default()
    })?;
    let mut of_levels = Vec::with_capacity(levels.len());
    for level in levels {
        of_levels.push(level.for_passes().await?);
    }
    let levels: Arc<[PassReader]> = of_levels.into();
    let mut all = vec![Measured::default(); levels.len()];
    let tiles = passes.pass(passes.tile_ids(), plan);
    let measured = tiles.map(|tile| {
        let levels = Arc::clone(&levels);
        async move { measure_tile(tile?, &levels).await }
    });
    let mut measured = measured.buffered(threads.min(plan.threads));
    while let Some(of_tile) = measured.try_next().await? {
        advance()?;
        for (all, of_tile) in all.iter_mut().zip(of_tile) {
            all.add(of_tile);
        }
    }
    Ok(all)
}

async fn measure_tile(tile: TileInPass, levels: &[PassReader]) -> Result<Vec<Measured>, ReadError> {
    let points: Arc<[Point]> = tile.points().collect();
    let bounds = Rect::around(points.iter().copied());
    let mut measured = Vec::with_capacity(levels.len());
    let tile = Arc::new(tile);
    let mut is_finer: Vec<bool> = vec![true; points.len()];
    for level in levels {
        let found = SurfacePart::within(level, bounds)
            .await?
            .at(Arc::clone(&points))
            .await?;
        let tile = Arc::clone(&tile);
        let of_level = spawn(move || {
            let of_level = compare(&tile, &found, &mut is_finer);
            (of_level, is_finer)
        });
        let (of_level, is_of_level) = of_level.await?;
        is_finer = is_of_level;
        measured.push(of_level);
    }
    Ok(measured)
}

/// Compares the vertices of a tile with a level. `is_finer` says which of them are vertices of the level
/// before, and then which are of this one.
fn compare(tile: &TileInPass, found: &[OnSurface], is_finer: &mut [bool]) -> Measured {
    let mut measured = Measured::default();
    for ((vertex, at), is_finer) in tile.vertex_indices().zip(found).zip(is_finer.iter_mut()) {
        let z = tile.z(vertex).unwrap_or(0.0);
        let (is_vertex, difference) = match *at {
            OnSurface::Vertex(other) => {
                if tile.has_z() && other.to_bits() != z.to_bits() {
                    measured.wrong = Some((tile.id(), "a vertex has another z in the overview"));
                }
                (true, 0.0)
            }
            OnSurface::Between { z: other, .. } if tile.has_z() => (false, (z - other).abs()),
            OnSurface::Between { .. } => (false, 0.0),
            OnSurface::Outside => {
                measured.wrong = Some((tile.id(), "a vertex is outside the overview"));
                (false, 0.0)
            }
        };
        measured.count += 1;
        measured.shared += u64::from(is_vertex);
        if is_vertex && !*is_finer {
            measured.not_nested = Some(tile.id());
        }
        *is_finer = is_vertex;
        if difference > 0.0 {
            measured.largest = measured.largest.max(difference);
            measured.squares.add(difference * difference);
        }
    }
    let lacks = |corner: &VertexIndex| !is_finer[corner.index()];
    if corners(tile).iter().any(lacks) {
        measured.wrong = measured
            .wrong
            .or(Some((tile.id(), "a corner of the hull is no vertex of the overview")));
    }
    measured
}
