//! The map tiles of a zoom, in the order of an archive.

use pmtiles::{PYRAMID_SIZE_BY_ZOOM, TileId};

use crate::map_archive::error::ArchiveError;
use crate::map_tiles::{GridKind, Layer, MapSource, TileCoord};

/// The map tiles of a zoom that may have content, along the Hilbert curve.
pub(super) struct Descent {
    source: MapSource,
    grid: GridKind,
    layer: Layer,
    zoom: u8,
    /// Tiles that are yet to be looked at, the next one last.
    open: Vec<(u8, u64)>,
}

impl Descent {
    pub(super) fn new(source: &MapSource, grid: GridKind, layer: Layer, zoom: u8) -> Self {
        Self {
            source: source.clone(),
            grid,
            layer,
            zoom,
            open: vec![(0, 0)],
        }
    }

    /// Returns the next tile.
    pub(super) async fn next(&mut self) -> Result<Option<TileCoord>, ArchiveError> {
        while let Some((zoom, number)) = self.open.pop() {
            let at = coord(zoom, number)?;
            if !self.source.may_have(self.grid, self.layer, at).await? {
                continue;
            }
            if zoom == self.zoom {
                return Ok(Some(at));
            }
            // The quarters of a tile follow each other on the curve of the next zoom.
            let quarters = (0..4).rev().map(|quarter| (zoom + 1, 4 * number + quarter));
            self.open.extend(quarters);
        }
        Ok(None)
    }
}

/// Returns the tile with this number on the Hilbert curve of a zoom.
fn coord(zoom: u8, number: u64) -> Result<TileCoord, ArchiveError> {
    let id = TileId::new(PYRAMID_SIZE_BY_ZOOM[usize::from(zoom)] + number)?;
    let at = pmtiles::TileCoord::from(id);
    TileCoord::new(at.z(), at.x(), at.y()).ok_or(ArchiveError::Deep)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quarters_of_a_tile_follow_each_other_on_the_curve() {
        for (zoom, number) in [(0, 0), (1, 2), (5, 777), (12, 9_999_999)] {
            let parent = coord(zoom, number).unwrap();
            for quarter in 0..4 {
                let at = coord(zoom + 1, 4 * number + quarter).unwrap();
                assert_eq!((at.z(), at.x() / 2, at.y() / 2), (zoom + 1, parent.x(), parent.y()));
            }
        }
    }
}
