//! The digest of a tile during an edit.

use crate::edit::tile::{EditTile, TriangleOrder};
use crate::mesh::Topology;
use crate::store::{Digest, DigestSum, triangle_hash};

impl EditTile {
    /// Returns the digest of all elements that belong to the tile, without holes: a tile that can
    /// be changed knows no regions.
    pub(crate) fn digest(&self) -> Digest {
        self.digest_with(self.owned())
    }

    /// Returns the digest, given what [`owned`](Self::owned) returns.
    pub(crate) fn digest_with(&self, triangles: DigestSum) -> Digest {
        let mut digest = Digest {
            triangles,
            ..Digest::default()
        };
        digest.add_vertices(&self.points, &self.z);
        digest.add_sites(&self.points, &self.sites, &self.site_ids);
        // In a draft, edges of deferred segments may be marked, and have no sources yet.
        for (half_edge, sources) in self.owned_constraints().filter(|(_, sources)| !sources.is_empty()) {
            let mut corners = [self.origin(half_edge), self.destination(half_edge)];
            // Sources are kept as seen from the smaller corner.
            corners.sort_unstable();
            let ends = corners.map(|corner| self.vertex(corner).point);
            digest.add_constraint_edge(ends);
            for part in sources {
                digest.add_edge_source(ends, part.source());
            }
        }
        digest
    }

    /// Returns what [`owned`](Self::owned) must be, found anew.
    pub(super) fn hashed(&self) -> DigestSum {
        let mut sum = DigestSum::default();
        let TriangleOrder { core, border } = self.in_order();
        let of_border = border.into_iter().filter(|&triangle| self.owns(triangle));
        for triangle in core.into_iter().chain(of_border) {
            sum.add_hash(triangle_hash(self.corner_points(triangle)));
        }
        sum
    }
}
