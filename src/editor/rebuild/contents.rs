//! The lines and sites of a file.

use futures::TryStreamExt;

use crate::constraints::segment::Segment;
use crate::edit::EditError;
use crate::editor::rebuild::error::edit_error;
use crate::geometry::Point;
use crate::input::{SiteBatch, SiteId};
use crate::pipeline::Builder;
use crate::store::{Tile, TileReader};

/// Pushes the lines and sites of a file to a builder.
pub(super) async fn push_contents(reader: &TileReader, builder: &mut Builder) -> Result<(), EditError> {
    let (lines, sites) = (reader.metadata().constraint_edges, reader.metadata().sites);
    if lines == 0 && sites == 0 {
        return Ok(());
    }
    let mut sites: Vec<(u64, Point, SiteId)> = Vec::new();
    let mut tiles = reader.tiles();
    while let Some(tile) = tiles.try_next().await? {
        builder.push_parts(parts(&tile)).map_err(edit_error)?;
        for site in tile.sites() {
            let id = site
                .id
                .map_or(SiteId::Number(site.number), |id| SiteId::Text(id.to_owned()));
            sites.push((site.number, tile.point(site.vertex), id));
        }
    }
    // Builds count sites that have text as their id.
    sites.sort_by_key(|(number, ..)| *number);
    let (points, ids) = sites.into_iter().map(|(_, point, id)| (point, id)).unzip();
    let batch = SiteBatch {
        points,
        ids,
        z: Vec::new(),
    };
    builder.push_sites(&batch).map_err(edit_error)
}

/// Returns the constraint edges of a tile, one for each line along them.
fn parts(tile: &Tile) -> Vec<Segment> {
    let edges = tile.owned_constraints();
    let parts = edges.flat_map(|edge| {
        let ends = tile.ends(edge).map(|end| end.point);
        tile.edge_parts(edge).map(move |source| Segment { ends, source })
    });
    parts.collect()
}
