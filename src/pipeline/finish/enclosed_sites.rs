//! The sites in holes: no path ever reaches them, which is mostly a mistake in the input.
//!
//! In: the complete file, before it gets its name, and its tiles with sites. Out: the number of
//! sites at vertices with no free space around them. A site on the ring of an obstacle is not among
//! them, since paths may run along the ring.
//!
//! A core is written long before the regions of its triangles are known, and deferred segments
//! change them once more. So the tiles are read again, but only those with sites, and only if the
//! file has holes.

use futures::TryStreamExt;

use crate::geometry::VertexIndex;
use crate::mesh::{StarEnd, Topology};
use crate::store::{Needs, ReadError, Tile, TileId, TileReader};

/// Returns the number of sites in holes. `with_sites` are the tiles with sites, in any order.
pub(crate) async fn sites_in_holes(reader: &TileReader, mut with_sites: Vec<u32>) -> Result<u64, ReadError> {
    with_sites.sort_unstable();
    let outside_is_free = !reader.metadata().exterior_is_hole;
    let tiles = with_sites.into_iter().map(|tile| (TileId(tile), ())).collect();
    let reader = reader.for_passes().await?;
    let plan = reader.plan(Needs::default())?;
    let counts = reader.for_some_tiles(tiles, plan, move |tile, ()| {
        let in_hole = |vertex| is_enclosed(&tile, vertex, outside_is_free);
        tile.sites().filter(|site| in_hole(site.vertex)).count() as u64
    });
    counts.try_fold(0, |sum, count| async move { Ok(sum + count) }).await
}

/// Returns whether all the space around a vertex of a tile is in holes.
fn is_enclosed(tile: &Tile, vertex: VertexIndex, outside_is_free: bool) -> bool {
    let Some(leaving) = tile.leaving(vertex) else {
        return false;
    };
    let (first, end) = tile.rewind(leaving);
    let touches_outside = matches!(end, StarEnd::Hull(_));
    let mut star = tile.star(first);
    star.all(|half_edge| tile.is_hole(half_edge.triangle())) && !(touches_outside && outside_is_free)
}
