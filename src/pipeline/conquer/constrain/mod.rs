//! Constrain: pieces of segments go in as soon as all triangles that they cross are final.
//!
//! In: the triangles of a node with what has become of them, and the segments of its cell. Out: triangles that pieces went
//! into, which are final too, the constraint edges that came of it, and what goes up.
//!
//! ```text
//!   leaf     segments ──▶ vertices on them ──▶ pieces, and runs that go on elsewhere ─┐
//!   above    children's pieces, and those between one child's run and the next's ─────┤  lines
//!                                                                                     ▼
//!            insert what crosses settled triangles alone;  mark what is an edge already   ground
//!                                                                                     ▼
//!            hold the settled triangles that others cross ──▶ up, with pieces and runs
//! ```
//!
//! Inserting a piece changes exactly the triangles that it crosses (Wu, Lemma 3.3.6), and the result does not depend on the
//! order. So a triangle that is final and that no piece crosses any more can go to its tile; one that a piece crosses which
//! cannot go in yet is **held**: it goes up with its piece. A piece cannot go in if it crosses an unsettled triangle, or
//! leaves the cell. Held triangles' vertices need not be triangulated again; the node above glues held triangles to its own
//! by their edges.
//!
//! An edge that is a piece is marked on both sides as soon as one is final. If the other is not, the piece goes up all the
//! same, so that whichever triangle comes to lie there is marked too. Once both are, the edge is done, and so is the piece:
//! its source is noted with the edge, in one node only.
//!
//! Walking along pieces takes time with the edges that come of them. Where that gets more than there are vertices and pieces,
//! since many run along each other, the rest are cut at each other's ends first (`overlaps`).

mod ground;
mod lines;
mod overlaps;
pub(crate) mod refusal;

use crate::collections::bucket_sort::bucket_sort;
use crate::constraints::segment::Segment;
use crate::geometry::{HalfEdge, PackedHalfEdge, Point, VertexIndex};
use crate::mesh::Triangulation;
use crate::pipeline::conquer::constrain::ground::Outcome;
use crate::pipeline::conquer::constrain::refusal::Refusal;
use crate::pipeline::conquer::node::{Fate, Workspace};
use crate::pipeline::records::{DoneEdge, LateTriangle, Open, Pending, Piece, SeamVertex};
use crate::store::{TileId, VertexId};
use ground::Ground;
use lines::Lines;

/// Constrains the triangles of a leaf, which are in the workspace. Those that are held, the bits of sides and the edges that
/// are done stay there.
pub(crate) fn constrain_leaf(
    workspace: &mut Workspace,
    points: &[Point],
    segments: &[Segment],
    its: &[u32],
    tile: TileId,
    is_root: bool,
) -> Result<Pending, Refusal> {
    let mesh = std::mem::take(&mut workspace.mesh);
    let settled = workspace.fates.iter().map(|fate| *fate == Fate::Settled).collect();
    let fixed = vec![0; mesh.triangles.len()];
    let is_on_line = mesh.triangles.is_empty();
    let mut ground = Ground::new(
        points,
        mesh,
        fixed,
        settled,
        is_root,
        is_on_line,
        workspace.most_sources,
    );
    let vertex = |index: u32| SeamVertex {
        id: VertexId {
            tile,
            index: VertexIndex(index),
        },
        point: points[index as usize],
    };
    let Workspace { inserter, deferral, .. } = workspace;
    let limit = if is_root { usize::MAX } else { deferral.leaf_limit() };
    let its = its.iter().map(|&segment| segments[segment as usize]);
    let its = its.filter(|segment| !deferral.has(segment)).collect();
    let lines = Lines::of_leaf(&ground, inserter, its);
    let outcome = lines.and_then(|lines| {
        let lines = (lines.pieces, lines.open);
        ground.constrain(inserter, lines, (deferral, limit), vertex)
    });
    for (fate, held) in workspace.fates.iter_mut().zip(&ground.held) {
        if *held {
            *fate = Fate::Held;
        }
    }
    (workspace.mesh, workspace.side_bits) = ground.mesh.into_parts();
    let Outcome { done, pending } = outcome?;
    workspace.edges = done;
    Ok(pending)
}

/// What a node above the leaves has that is final.
#[derive(Debug, Default)]
pub(crate) struct Final {
    /// Triangles that are not held.
    pub(crate) triangles: Vec<LateTriangle>,
    /// Constraint edges.
    pub(crate) edges: Vec<DoneEdge>,
}

/// The triangles of a node above the leaves, those of its mesh and those that its children hold, and the lines that its
/// children sent up.
struct Joined {
    vertices: Vec<SeamVertex>,
    triangles: Vec<[u32; 3]>,
    /// Whether each triangle is final, and the bits of its constrained sides.
    settled: Vec<bool>,
    fixed: Vec<u8>,
    pieces: Vec<Piece>,
    runs: Vec<Open>,
}

impl Joined {
    /// Takes what the mesh in the workspace did not drop.
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
            pieces: Vec::new(),
            runs: Vec::new(),
        }
    }

    /// Adds what a child sent up. The first `in_seams` vertices are those of the mesh, sorted by id.
    fn add(&mut self, child: Pending, in_seams: usize) {
        let mut places = Vec::with_capacity(child.vertices.len());
        for vertex in child.vertices {
            let in_seam = self.vertices[..in_seams].binary_search_by_key(&vertex.id, |v| v.id);
            let place = in_seam.unwrap_or(self.vertices.len());
            if place == self.vertices.len() {
                self.vertices.push(vertex);
            }
            places.push(place as u32);
        }
        let place = |v: u32| places[v as usize];
        for (corners, bits) in child.held {
            self.triangles.push(corners.map(place));
            self.settled.push(true);
            self.fixed.push(bits);
        }
        self.pieces
            .extend(child.pieces.iter().map(|piece| piece.renumbered(place)));
        self.runs.extend(child.open.iter().map(|open| open.renumbered(place)));
    }
}

/// Constrains the triangles of a node above the leaves: those in the workspace, of these vertices, and those that its children
/// hold.
pub(crate) fn constrain_node(
    workspace: &mut Workspace,
    vertices: &[SeamVertex],
    children: Vec<Pending>,
    is_root: bool,
) -> Result<(Final, Pending), Refusal> {
    let mut joined = Joined::of_mesh(workspace, vertices);
    for child in children {
        joined.add(child, vertices.len());
    }
    let vertices = joined.vertices;
    let points: Vec<Point> = vertices.iter().map(|v| v.point).collect();
    let rules = (&*workspace.deferral, workspace.most_sources);
    let lines = Lines::of_children(joined.pieces, joined.runs, &points, rules);
    let hull = std::mem::take(&mut workspace.mesh.hull);
    let is_on_line = workspace.mesh.triangles.is_empty();
    let mesh = Triangulation {
        hull,
        ..glued(joined.triangles, points.len())
    };
    let mut ground = Ground::new(
        &points,
        mesh,
        joined.fixed,
        joined.settled,
        is_root,
        is_on_line,
        workspace.most_sources,
    );
    let vertex = |index: u32| vertices[index as usize];
    let Workspace { inserter, deferral, .. } = workspace;
    let limit = if is_root { usize::MAX } else { deferral.node_limit() };
    let Outcome { done, pending } =
        ground.constrain(inserter, (lines.pieces, lines.open), (deferral, limit), vertex)?;
    let edges = done.into_iter().map(|piece| DoneEdge {
        ends: piece.ends.map(vertex),
        source: piece.source,
    });
    let found = Final {
        edges: edges.collect(),
        triangles: final_triangles(ground, vertex),
    };
    Ok((found, pending))
}

/// The triangles that are settled and not held.
fn final_triangles(ground: Ground<'_>, vertex: impl Fn(u32) -> SeamVertex) -> Vec<LateTriangle> {
    let (mesh, fixed) = ground.mesh.into_parts();
    let states = ground.settled.iter().zip(&ground.held);
    let all = mesh.triangles.iter().zip(fixed).zip(states);
    let is_final = all.filter(|(_, (settled, held))| **settled && !**held);
    let late = is_final.map(|((corners, side_bits), _)| LateTriangle {
        corners: corners.map(&vertex),
        side_bits,
        number: 0,
    });
    late.collect()
}

/// Triangles with their adjacency, found by their edges, between so many vertices.
pub(crate) fn glued(triangles: Vec<[u32; 3]>, vertices: usize) -> Triangulation {
    let origins = triangles.as_flattened();
    let ends = |side: HalfEdge| {
        let (from, to) = (origins[side.index()], origins[side.next().index()]);
        [from.min(to), from.max(to)]
    };
    let sides = (0..origins.len() as u32).map(HalfEdge);
    let sides: Vec<([u32; 2], HalfEdge)> = sides.map(|side| (ends(side), side)).collect();
    let sides = bucket_sort(&sides, vertices, |(ends, _)| ends[0], |&(ends, side)| (ends[1], side));
    let mut neighbours = vec![[PackedHalfEdge::NONE; 3]; triangles.len()];
    for pair in sides.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        for (side, other) in [(pair[0].1, pair[1].1), (pair[1].1, pair[0].1)] {
            neighbours.as_flattened_mut()[side.index()] = other.into();
        }
    }
    Triangulation {
        triangles,
        neighbours,
        hull: Vec::new(),
    }
}
