//! Computes the [digest](Digest) of a file from its tiles.

use futures::future::FutureExt;
use futures::stream::TryStreamExt;

use crate::store::error::ReadError;
use crate::store::format::digest::Digest;
use crate::store::format::tile::Tile;
use crate::store::pass::Needs;
use crate::store::reader::TileReader;

impl Digest {
    /// Returns the digest of all elements that belong to a tile.
    pub(crate) fn of_tile(tile: &Tile) -> Self {
        let mut this = Self::default();
        for (p, vertex) in tile.points().zip(tile.vertex_indices()) {
            this.add_vertex(p);
            if let Some(z) = tile.z(vertex) {
                this.add_z(p, z);
            }
        }
        for triangle in tile.owned_triangles() {
            this.add_triangle(tile.triangle_points(triangle));
            if tile.is_hole(triangle) {
                this.add_hole(tile.triangle_points(triangle));
            }
        }
        for edge in tile.owned_constraints() {
            let ends = tile.ends(edge).map(|end| end.point);
            this.add_constraint_edge(ends);
            for source in tile.edge_sources(edge) {
                this.add_edge_source(ends, source);
            }
        }
        for site in tile.sites() {
            this.add_site(tile.point(site.vertex), site.number, site.id);
        }
        this
    }
}

impl TileReader {
    /// Computes the digest of the whole file from its tiles, in one pass. Must be awaited within a
    /// tokio runtime.
    ///
    /// The file stores its digest too, as [`Metadata::digest`](crate::store::Metadata::digest).
    /// [`verify`](Self::verify) compares both.
    ///
    /// # Errors
    ///
    /// Returns an error if a tile cannot be read, or does not fit into the memory that the reader
    /// may use.
    pub fn recompute_digest(&self) -> impl Future<Output = Result<Digest, ReadError>> + Send {
        async move {
            let passes = self.for_passes().await?;
            let digests = passes.for_each_tile(Needs::default(), |tile| Digest::of_tile(&tile))?;
            let sum = |mut sum: Digest, digest| async move {
                sum += digest;
                Ok(sum)
            };
            digests.try_fold(Digest::default(), sum).await
        }
        .boxed()
    }
}
