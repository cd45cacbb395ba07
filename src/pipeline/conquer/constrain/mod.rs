//! Constrain: inserts subsegments as soon as all triangles that they cross are final.
//!
//! In: the triangles of a node with their fates, and the segments of its cell. Out: triangles that
//! subsegments were inserted into, which are final too, the resulting constraint edges, and the
//! constraints that are passed up.
//!
//! ```text
//!   leaf   segments ─▶ vertices on them ─▶ subsegments, and runs that go on elsewhere ─┐
//!   above  children's subsegments, and those from one child's run to the next one's ───┤ lines
//!                                                                                      ▼
//!          insert those that cross only settled triangles; mark those that are edges     node_mesh
//!                                                                                      ▼
//!          hold the settled triangles that others cross ─▶ up, with subsegments and runs
//! ```
//!
//! Inserting a subsegment changes exactly the triangles that it crosses (Wu, Lemma 3.3.6), and the
//! result does not depend on the order. So a final triangle that no pending subsegment crosses can
//! go to its tile. A final triangle that a pending subsegment crosses is **held**: it is passed up
//! with the subsegment. A subsegment cannot be inserted if it crosses an unsettled triangle or
//! leaves the cell. The vertices of held triangles need not be triangulated again; the node above
//! glues held triangles to its own by their edges.
//!
//! An edge that is a subsegment is marked on both half-edges as soon as one is final. If the other
//! is not, the subsegment is passed up nevertheless, so that the triangle that is made there is
//! marked too. Once both are final, the edge is done, and so is the subsegment: its source is
//! recorded with the edge, in one node only.
//!
//! Following subsegments takes time proportional to the number of resulting edges. If overlaps make
//! that exceed the number of vertices and subsegments, the remaining subsegments are first cut at
//! each other's ends (`overlaps`).

mod lines;
mod node_mesh;
mod overlaps;
pub(crate) mod refusal;

use crate::collections::bucket_sort::bucket_sort;
use crate::constraints::segment::Segment;
use crate::geometry::{HalfEdge, PackedHalfEdge, Point};
use crate::mesh::Triangulation;
use crate::pipeline::conquer::constrain::node_mesh::ConstrainOutcome;
use crate::pipeline::conquer::constrain::refusal::Refusal;
use crate::pipeline::conquer::node::{Fate, Workspace};
use crate::pipeline::records::{Deferred, DoneEdge, LateTriangle, OpenSegment, Pending, SeamVertex, Subsegment};
use lines::NodeLines;
use node_mesh::NodeMesh;

/// Constrains the triangles of a leaf, which are in the workspace. The fates of held triangles, the
/// constraint bits and the edges that are done stay there.
pub(crate) fn constrain_leaf(
    workspace: &mut Workspace,
    points: &[Point],
    segments: &[Segment],
    segment_indices: &[u32],
    vertex: impl Fn(u32) -> SeamVertex,
    is_root: bool,
) -> Result<Pending, Refusal> {
    let mesh = std::mem::take(&mut workspace.mesh);
    let settled = workspace.fates.iter().map(|fate| *fate == Fate::Settled).collect();
    let fixed = vec![0; mesh.triangles.len()];
    let is_on_line = mesh.triangles.is_empty();
    let mut node = NodeMesh::new(
        points,
        mesh,
        fixed,
        settled,
        is_root,
        is_on_line,
        workspace.most_sources,
    );
    let limit = match is_root {
        true => usize::MAX,
        false => workspace.held_limits.in_leaf,
    };
    let inserter = &mut workspace.inserter;
    let meeting = segment_indices.iter().map(|&segment| segments[segment as usize]);
    let lines = NodeLines::of_leaf(&node, inserter, meeting.collect());
    let outcome = lines.and_then(|lines| {
        let lines = (lines.subsegments, lines.open);
        node.constrain(inserter, lines, (Deferred::default(), limit), vertex)
    });
    for (fate, held) in workspace.fates.iter_mut().zip(&node.held) {
        if *held {
            *fate = Fate::Held;
        }
    }
    (workspace.mesh, workspace.edge_bits) = node.constrained.into_parts();
    let ConstrainOutcome { done, pending } = outcome?;
    workspace.edges = done;
    Ok(pending)
}

/// The final triangles and edges of a node above the leaves.
#[derive(Debug, Default)]
pub(crate) struct FinalOutput {
    /// Final triangles that are not held.
    pub(crate) triangles: Vec<LateTriangle>,
    /// Constraint edges that are done.
    pub(crate) edges: Vec<DoneEdge>,
}

/// The triangles of a node above the leaves, both those of its mesh and those that its children
/// hold, and the lines that its children passed up.
struct JoinedChildren {
    vertices: Vec<SeamVertex>,
    triangles: Vec<[u32; 3]>,
    /// Whether each triangle is final, and its constraint and wall bits.
    settled: Vec<bool>,
    fixed: Vec<u8>,
    subsegments: Vec<Subsegment>,
    runs: Vec<OpenSegment>,
    deferred: Deferred,
}

impl JoinedChildren {
    /// Takes the triangles of the workspace's mesh that were not dropped.
    fn of_mesh(workspace: &Workspace, vertices: &[SeamVertex]) -> Self {
        let kept = workspace.mesh.triangles.iter().zip(&workspace.fates);
        let kept = kept.filter(|(_, fate)| **fate != Fate::Dropped);
        let (triangles, settled): (Vec<_>, Vec<_>) =
            kept.map(|(corners, fate)| (*corners, *fate == Fate::Settled)).unzip();
        Self {
            vertices: vertices.to_vec(),
            fixed: vec![0; triangles.len()],
            triangles,
            settled,
            subsegments: Vec::new(),
            runs: Vec::new(),
            deferred: Deferred::default(),
        }
    }

    /// Adds the constraints that a child passed up. The first `in_seams` vertices are those of the
    /// mesh, sorted by id.
    fn add(&mut self, child: Pending, in_seams: usize) {
        let mut indices = Vec::with_capacity(child.vertices.len());
        for vertex in child.vertices {
            let in_seam = self.vertices[..in_seams].binary_search_by_key(&vertex.id, |v| v.id);
            let index = in_seam.unwrap_or(self.vertices.len());
            if index == self.vertices.len() {
                self.vertices.push(vertex);
            }
            indices.push(index as u32);
        }
        let index = |v: u32| indices[v as usize];
        for (corners, bits) in child.held {
            self.triangles.push(corners.map(index));
            self.settled.push(true);
            self.fixed.push(bits);
        }
        self.subsegments
            .extend(child.subsegments.iter().map(|subsegment| subsegment.renumbered(index)));
        self.runs.extend(child.open.iter().map(|open| open.renumbered(index)));
        self.deferred.extend(child.deferred.0);
    }
}

/// Constrains the triangles of a node above the leaves: those in the workspace, whose corners are
/// `vertices`, and those that its children hold.
pub(crate) fn constrain_node(
    workspace: &mut Workspace,
    vertices: &[SeamVertex],
    children: Vec<Pending>,
    is_root: bool,
) -> Result<(FinalOutput, Pending), Refusal> {
    let mut joined = JoinedChildren::of_mesh(workspace, vertices);
    for child in children {
        joined.add(child, vertices.len());
    }
    let vertices = joined.vertices;
    let points: Vec<Point> = vertices.iter().map(|v| v.point).collect();
    let rules = (&joined.deferred, workspace.most_sources);
    let lines = NodeLines::of_children(joined.subsegments, joined.runs, &points, rules);
    let hull = std::mem::take(&mut workspace.mesh.hull);
    let is_on_line = workspace.mesh.triangles.is_empty();
    let mesh = Triangulation {
        hull,
        ..glued(joined.triangles, points.len())
    };
    let mut node = NodeMesh::new(
        &points,
        mesh,
        joined.fixed,
        joined.settled,
        is_root,
        is_on_line,
        workspace.most_sources,
    );
    let vertex = |index: u32| vertices[index as usize];
    let limit = match is_root {
        true => usize::MAX,
        false => workspace.held_limits.in_node,
    };
    let (lines, deferral) = ((lines.subsegments, lines.open), (joined.deferred, limit));
    let ConstrainOutcome { done, pending } = node.constrain(&mut workspace.inserter, lines, deferral, vertex)?;
    let edges = done.into_iter().map(|subsegment| DoneEdge {
        ends: subsegment.ends.map(vertex),
        source: subsegment.source,
    });
    let output = FinalOutput {
        edges: edges.collect(),
        triangles: final_triangles(node, vertex),
    };
    Ok((output, pending))
}

/// Returns the triangles that are settled and not held.
fn final_triangles(node: NodeMesh<'_>, vertex: impl Fn(u32) -> SeamVertex) -> Vec<LateTriangle> {
    let (mesh, fixed) = node.constrained.into_parts();
    let states = node.settled.iter().zip(&node.held);
    let all = mesh.triangles.iter().zip(fixed).zip(states);
    let is_final = all.filter(|(_, (settled, held))| **settled && !**held);
    let late = is_final.map(|((corners, edge_bits), _)| LateTriangle {
        corners: corners.map(&vertex),
        edge_bits,
        number: 0,
    });
    late.collect()
}

/// Returns triangles with their adjacency, found by their edges. `vertices` is the number of
/// vertices.
pub(crate) fn glued(triangles: Vec<[u32; 3]>, vertices: usize) -> Triangulation {
    let origins = triangles.as_flattened();
    let ends = |half_edge: HalfEdge| {
        let (from, to) = (origins[half_edge.index()], origins[half_edge.next().index()]);
        [from.min(to), from.max(to)]
    };
    let half_edges = (0..origins.len() as u32).map(HalfEdge);
    let half_edges: Vec<([u32; 2], HalfEdge)> = half_edges.map(|half_edge| (ends(half_edge), half_edge)).collect();
    let half_edges = bucket_sort(
        &half_edges,
        vertices,
        |(ends, _)| ends[0],
        |&(ends, half_edge)| (ends[1], half_edge),
    );
    let mut neighbours = vec![[PackedHalfEdge::NONE; 3]; triangles.len()];
    for pair in half_edges.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        for (half_edge, other) in [(pair[0].1, pair[1].1), (pair[1].1, pair[0].1)] {
            neighbours.as_flattened_mut()[half_edge.index()] = other.into();
        }
    }
    Triangulation {
        triangles,
        neighbours,
        hull: Vec::new(),
    }
}
