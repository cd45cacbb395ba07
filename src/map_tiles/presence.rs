//! Whether the file has anything in a map tile, without drawing it.

use futures::future::FutureExt;

use crate::map_tiles::coord::{GridKind, TileCoord};
use crate::map_tiles::drawn::DrawError;
use crate::map_tiles::grid::fractions_of;
use crate::map_tiles::layer::Layer;
use crate::map_tiles::mesh::BUFFER;
use crate::map_tiles::paint::REACH;
use crate::map_tiles::source::{FILE, MapSource};
use crate::map_tiles::window::Window;

impl MapSource {
    /// Returns whether a map tile may have content. If not, [drawing](Self::draw) it gives nothing, and
    /// neither do the deeper tiles within it. Reads the directory alone, so this is much faster.
    ///
    /// # Errors
    /// If the file has no tiles in the grid, or if the directory cannot be read.
    pub fn may_have(
        &self,
        grid: GridKind,
        layer: Layer,
        at: TileCoord,
    ) -> impl Future<Output = Result<bool, DrawError>> + Send {
        async move {
            let grid = self.grid(grid)?;
            if !fractions_of(at, 0.0).intersects(grid.extent()) {
                return Ok(false);
            }
            // The cells of the layer `mesh` cover all of the bounds. Of overviews, no triangle is outside of
            // the file's.
            if layer == Layer::Mesh {
                let rect = Window::new(grid, at, BUFFER).rect();
                return Ok(rect.intersects(self.reader().metadata().bounds));
            }
            let rect = Window::new(grid, at, REACH).rect();
            Ok(!self.level(FILE).tiles_in(rect, 0).await?.is_empty())
        }
        .boxed()
    }
}
