//! One node of the merge tree, a leaf or an inner node: triangulates, keeps, settles and passes up.
//!
//! In: the points X of the node and its cell. Out: its settled triangles, and its seam: the
//! unsettled triangles and the vertices that the levels above need. A triangle is settled if its
//! closed circumdisc is strictly inside the cell, so that no vertex of another cell can remove it.
//! (Wu, section 3.3, calls it safe.)

use crate::geometry::{Point, Rect, disc_strictly_inside};
use crate::io::Buffers;
use crate::mesh::{Engine, Inserter, Triangulation, smallest_first};
use crate::pipeline::plan::HeldLimits;
use crate::pipeline::records::Subsegment;
use crate::store::CoreDraft;

/// The data structures of a thread, reused from node to node to keep their memory.
pub(crate) struct Workspace {
    pub(crate) engine: Box<dyn Engine>,
    pub(crate) mesh: Triangulation,
    /// The fate of each triangle of the mesh.
    pub(crate) fates: Vec<Fate>,
    /// For each point its index in the seam, or [`u32::MAX`].
    in_seam: Vec<u32>,
    pub(crate) inserter: Inserter,
    pub(crate) held_limits: HeldLimits,
    /// The constraint and wall bits of each triangle of a leaf's mesh, or empty.
    pub(crate) edge_bits: Vec<u8>,
    /// The constraint edges of a leaf that are done, sorted, once for each source.
    pub(crate) edges: Vec<Subsegment>,
    /// Most sources of the edges of a node, summed over its edges.
    pub(crate) most_sources: usize,
    /// The core of the leaf that was conquered last.
    pub(crate) core: CoreDraft,
    /// Buffers in which cores are encoded.
    pub(crate) buffers: Buffers,
}

/// The fate of a triangle of DT(X).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fate {
    /// Covered by triangles that a child settled already.
    Dropped,
    /// Final.
    Settled,
    /// Passed to the levels above.
    Unsettled,
    /// Final, but crossed by a pending subsegment, so it is passed up too.
    Held,
}

impl Workspace {
    pub(crate) fn new(engine: Box<dyn Engine>, buffers: Buffers, held_limits: HeldLimits, most_sources: usize) -> Self {
        Self {
            engine,
            mesh: Triangulation::default(),
            fates: Vec::new(),
            in_seam: Vec::new(),
            inserter: Inserter::default(),
            held_limits,
            edge_bits: Vec::new(),
            edges: Vec::new(),
            most_sources,
            core: CoreDraft::empty(),
            buffers,
        }
    }

    /// Triangulates a node and determines the fate of each triangle. `keep` returns whether a
    /// triangle is outside the area that a child settled.
    ///
    /// Fills `mesh` and `fates`. Returns the points of the seam, and its triangles as indices into
    /// these.
    pub(crate) fn run(
        &mut self,
        points: &[Point],
        cell: Rect,
        keep: impl Fn([u32; 3]) -> bool,
    ) -> (Vec<u32>, Vec<[u32; 3]>) {
        const ABSENT: u32 = u32::MAX;
        self.engine.triangulate(points, &mut self.mesh);
        self.fates.clear();
        let point = |v: u32| points[v as usize];
        self.fates.extend(self.mesh.triangles.iter().map(|&t| {
            let [a, b, c] = t.map(point);
            if !keep(t) {
                Fate::Dropped
            } else if disc_strictly_inside(a, b, c, cell) {
                Fate::Settled
            } else {
                Fate::Unsettled
            }
        }));
        if cell == Rect::PLANE {
            // The root: everything is settled, and no level above needs the hull.
            debug_assert!(!self.fates.contains(&Fate::Unsettled));
            return (Vec::new(), Vec::new());
        }
        self.in_seam.clear();
        self.in_seam.resize(points.len(), ABSENT);
        for &vertex in &self.mesh.hull {
            self.in_seam[vertex as usize] = 0;
        }
        let unsettled = || {
            let fates = self.mesh.triangles.iter().zip(&self.fates);
            fates.filter(|(_, fate)| **fate == Fate::Unsettled).map(|(&t, _)| t)
        };
        for vertex in unsettled().flatten() {
            self.in_seam[vertex as usize] = 0;
        }
        let mut vertices = Vec::new();
        for (index, vertex) in self.in_seam.iter_mut().zip(0..) {
            if *index != ABSENT {
                *index = vertices.len() as u32;
                vertices.push(vertex);
            }
        }
        let mut triangles: Vec<_> = unsettled()
            .map(|t| smallest_first(t.map(|v| self.in_seam[v as usize])))
            .collect();
        triangles.sort_unstable();
        (vertices, triangles)
    }
}
