//! The range of the heights of a file.
//!
//! Files do not store it. It is found once, from the coarsest level, which is small. Of a large
//! file without overviews, some tiles must do.

use futures::stream;
use futures::stream::{StreamExt, TryStreamExt};

use crate::store::{ReadError, TileId, TileReader};

/// The maximum number of tiles that are read.
const TILES: u32 = 64;
/// The number of tiles that are read at once.
const AT_ONCE: usize = 4;
/// The share of vertices at each end that may lie outside of the colours.
const TAIL: f64 = 0.02;
/// If all heights span more than this multiple of the heights without the tails, the tails are cut.
const LONG_TAILS: f64 = 1.25;

/// The range of the heights of a file, in its unit of z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HeightRange {
    /// All heights are in this range, if all tiles of the level were read; else nearly all.
    pub(super) all: [f64; 2],
    /// The heights that the first and the last colour mean.
    pub(super) coloured: [f64; 2],
}

impl HeightRange {
    /// Finds the range of a level whose heights are up to `error` away from those of the file.
    /// `None` if it has no vertices.
    pub(super) async fn of(level: &TileReader, error: f64) -> Result<Option<Self>, ReadError> {
        let all = level.metadata().tiles;
        let used = level.tiles_in(level.metadata().bounds, TILES as usize).await?;
        let is_complete = used.len() <= TILES as usize;
        let read: Vec<TileId> = match is_complete {
            true => used,
            false => (0..TILES)
                .map(|i| TileId((u64::from(i) * u64::from(all) / u64::from(TILES)) as u32))
                .collect(),
        };
        let tiles = stream::iter(read).map(|id| async move {
            match level.tile(id).await {
                // A number that no tile has any more, among those that stand for all.
                Err(ReadError::NoSuchTile { .. }) if !is_complete => Ok(None),
                tile => tile.map(Some),
            }
        });
        let mut tiles = tiles.buffered(AT_ONCE);
        let mut heights: Vec<f64> = Vec::new();
        while let Some(tile) = tiles.try_next().await? {
            heights.extend(
                tile.iter()
                    .flat_map(|tile| tile.vertex_indices().filter_map(|vertex| tile.z(vertex))),
            );
        }
        let found = crate::store::spawn(move || Self::of_heights(heights)).await?;
        Ok(found.map(|found| {
            let [low, high] = found.all;
            // Half of the range more at both ends, if there may be higher ones.
            let more = if is_complete {
                error
            } else {
                error.max((high - low) / 2.0)
            };
            Self {
                all: [low - more, high + more],
                ..found
            }
        }))
    }

    fn of_heights(mut heights: Vec<f64>) -> Option<Self> {
        heights.retain(|z| z.is_finite());
        let count = heights.len();
        let mut quantile = |share: f64| {
            let index = ((count.checked_sub(1)?) as f64 * share).round() as usize;
            Some(*heights.select_nth_unstable_by(index, f64::total_cmp).1)
        };
        let [min, low, high, max] = [quantile(0.0)?, quantile(TAIL)?, quantile(1.0 - TAIL)?, quantile(1.0)?];
        let is_cut = max - min > LONG_TAILS * (high - low) && low < high;
        Some(Self {
            all: [min, max],
            coloured: if is_cut { [low, high] } else { [min, max] },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_outliers_do_not_take_the_colours() {
        let mut heights: Vec<f64> = (0..1000).map(f64::from).collect();
        let plain = HeightRange::of_heights(heights.clone()).unwrap();
        assert_eq!((plain.all, plain.coloured), ([0.0, 999.0], [0.0, 999.0]));
        heights.push(1e6);
        let range = HeightRange::of_heights(heights).unwrap();
        assert_eq!((range.all, range.coloured), ([0.0, 1e6], [20.0, 980.0]));
        assert_eq!(HeightRange::of_heights(vec![f64::NAN]), None);
    }
}
