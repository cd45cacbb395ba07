//! The digest of a core: of all elements that belong to its tile and are known at the leaf.

use crate::geometry::HalfEdge;
use crate::store::{CoreDraft, Digest};

/// Returns the digest of a core without its triangles, which are summed by
/// [component](crate::pipeline::conquer::components) if regions are distinguished.
pub(crate) fn without_triangles(core: &CoreDraft) -> Digest {
    let mut digest = Digest::default();
    digest.add_vertices(&core.points, &core.z);
    digest.add_sites(&core.points, &core.sites, &core.site_ids);
    for of_edge in core.edge_sources.chunk_by(|a, b| a.0 == b.0) {
        let half_edge = HalfEdge(of_edge[0].0);
        let corners = [half_edge, half_edge.next()].map(|h| core.triangles.as_flattened()[h.index()]);
        let ends = corners.map(|corner| core.points[corner as usize]);
        digest.add_constraint_edge(ends);
        for (_, part) in of_edge {
            digest.add_edge_source(ends, part.source());
        }
    }
    digest
}

/// Adds the triangles of a core to its digest.
pub(crate) fn add_triangles(core: &CoreDraft, digest: &mut Digest) {
    for corners in &core.triangles {
        digest.add_triangle(corners.map(|corner| core.points[corner as usize]));
    }
}
