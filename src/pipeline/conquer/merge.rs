//! Merges the seams of several nodes into that of their parent.
//!
//! Lemmas 3.3.1 to 3.3.4 of Wu's thesis: a vertex outside the seam has only settled triangles
//! around it, so the crossing triangles of the whole and of the seams alone are the same.

use crate::geometry::{Point, Rect};
use crate::mesh::smallest_first;
use crate::pipeline::conquer::constrain::refusal::Refusal;
use crate::pipeline::conquer::constrain::{FinalOutput, constrain_node};
use crate::pipeline::conquer::node::{Fate, Workspace};
use crate::pipeline::records::{LateTriangle, Pending, Seam, SeamVertex};

/// Triangulates the seams together. Returns the triangles and edges that are now final, and the
/// seam of the merged node.
pub(crate) fn merge(
    workspace: &mut Workspace,
    mut seams: Vec<Seam>,
    cell: Rect,
) -> Result<(FinalOutput, Seam), Refusal> {
    let mut pending: Vec<Pending> = Vec::new();
    for seam in &mut seams {
        pending.push(std::mem::take(&mut seam.pending));
    }
    let vertices: Vec<SeamVertex> = seams.iter().flat_map(|seam| &seam.vertices).copied().collect();
    let points: Vec<Point> = vertices.iter().map(|v| v.point).collect();
    let mut child_of = Vec::with_capacity(points.len());
    let mut unsettled = Vec::new();
    let below = seams.iter().map(|seam| seam.below).sum();
    let level = 1 + seams.iter().map(|seam| seam.level).max().unwrap_or(0);
    for (seam, child) in seams.iter().zip(0u32..) {
        let first = child_of.len() as u32;
        unsettled.extend(seam.unsettled.iter().map(|t| t.map(|v| v + first)));
        child_of.resize(child_of.len() + seam.vertices.len(), child);
    }
    // Large seams take as much memory as the merge itself.
    drop(seams);
    // The children are in order and so are the triangles of each, so all triangles are sorted.
    debug_assert!(unsettled.is_sorted());
    let crosses = |t: [u32; 3]| {
        let [a, b, c] = t.map(|v| child_of[v as usize]);
        a != b || b != c
    };
    let (seam_vertices, triangles) = workspace.run(&points, cell, |t| {
        crosses(t) || unsettled.binary_search(&smallest_first(t)).is_ok()
    });
    let (output, pending) = if pending.iter().all(|pending| *pending == Pending::default()) {
        let fates = workspace.mesh.triangles.iter().zip(&workspace.fates);
        let settled = fates.filter(|(_, fate)| **fate == Fate::Settled);
        let late = settled.map(|(t, _)| LateTriangle {
            corners: t.map(|v| vertices[v as usize]),
            edge_bits: 0,
            number: 0,
        });
        let output = FinalOutput {
            triangles: late.collect(),
            edges: Vec::new(),
        };
        (output, Pending::default())
    } else {
        constrain_node(workspace, &vertices, pending, cell == Rect::PLANE)?
    };
    let seam = Seam {
        pending,
        vertices: seam_vertices.iter().map(|&v| vertices[v as usize]).collect(),
        unsettled: triangles,
        below,
        level,
    };
    Ok((output, seam))
}
