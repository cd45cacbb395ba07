//! The mesh of a node, into which subsegments are inserted.

use foldhash::{HashMap, HashMapExt};

use crate::constraints::segment::Segment;
use crate::geometry::{HalfEdge, Point, TriangleId};
use crate::mesh::{Constrained, Inserter, LineStep, NONE, Stars, Topology, Triangulation};
use crate::pipeline::conquer::constrain::overlaps::{LimitedSubsegments, for_each_part};
use crate::pipeline::conquer::constrain::refusal::{Crossed, Refusal};
use crate::pipeline::conquer::deferral::choose_deferred;
use crate::pipeline::records::{Deferred, OpenSegment, Pending, SeamVertex, Subsegment};

/// The triangles of a node.
pub(crate) struct NodeMesh<'a> {
    pub(crate) points: &'a [Point],
    pub(crate) constrained: Constrained,
    /// Whether each triangle is final.
    pub(crate) settled: Vec<bool>,
    /// Whether each triangle is held, so that it must be passed up.
    pub(crate) held: Vec<bool>,
    /// The hull of the node, as a map from each vertex to the next one counter-clockwise. Empty at
    /// the root.
    hull: HashMap<u32, u32>,
    is_root: bool,
    /// Whether the node has no triangles, because its points are collinear. Its hull is then all
    /// vertices, in lexicographic order.
    is_on_line: bool,
    /// Most sources of the edges, summed over all edges.
    pub(crate) most_sources: usize,
}

/// The result of constraining a node.
pub(crate) struct ConstrainOutcome {
    /// The subsegments that are done.
    pub(crate) done: Vec<Subsegment>,
    /// The constraints that are passed up.
    pub(crate) pending: Pending,
}

/// The subsegments so far, by whether they were inserted.
struct InsertionProgress {
    /// The inserted subsegments.
    done: LimitedSubsegments,
    /// The subsegments that cannot be inserted.
    rest: LimitedSubsegments,
    /// Number of steps taken.
    steps: usize,
}

impl<'a> NodeMesh<'a> {
    /// Creates the mesh from triangles with their constraint and wall bits, and the hull of the
    /// node.
    pub(crate) fn new(
        points: &'a [Point],
        mesh: Triangulation,
        fixed: Vec<u8>,
        settled: Vec<bool>,
        is_root: bool,
        is_on_line: bool,
        most_sources: usize,
    ) -> Self {
        let next = mesh.hull.iter().cycle().skip(1);
        let hull = mesh.hull.iter().copied().zip(next.copied());
        Self {
            points,
            hull: if is_root { HashMap::new() } else { hull.collect() },
            is_root,
            is_on_line,
            most_sources,
            held: vec![false; settled.len()],
            settled,
            constrained: Constrained::with_constraints(mesh, fixed, points.len()),
        }
    }

    pub(crate) fn point(&self, vertex: u32) -> Point {
        self.points[vertex as usize]
    }

    pub(crate) fn crossed(&self, subsegment: [Point; 2], edge: [u32; 2]) -> Crossed {
        Crossed {
            subsegment,
            edge: edge.map(|v| self.point(v)),
        }
    }

    /// Inserts the subsegments that can be inserted, and holds the triangles that the others cross,
    /// which are passed up. If these are more than `limit` triangles, defers the segments that hold
    /// most, beside those that are `deferred` already.
    pub(crate) fn constrain(
        &mut self,
        inserter: &mut Inserter,
        (subsegments, mut open): (LimitedSubsegments, Vec<OpenSegment>),
        (mut deferred, limit): (Deferred, usize),
        vertex: impl Fn(u32) -> SeamVertex,
    ) -> Result<ConstrainOutcome, Refusal> {
        let subsegments = subsegments.sorted(self.points.len());
        let mut progress = InsertionProgress {
            done: LimitedSubsegments::new(self.most_sources),
            rest: LimitedSubsegments::new(self.most_sources),
            steps: 0,
        };
        // A line passes no vertex twice, unless lines overlap.
        let most_steps = subsegments.len() + 4 * self.points.len();
        let mut left = &*subsegments;
        while let Some(first) = left.first() {
            if progress.steps > most_steps {
                let points = self.points;
                for_each_part(
                    left,
                    |v| points[v as usize],
                    |along| self.insert(inserter, along, &mut progress),
                )?;
                break;
            }
            let count = left
                .iter()
                .take_while(|subsegment| subsegment.ends == first.ends)
                .count();
            let (along, others) = left.split_at(count);
            self.insert(inserter, along, &mut progress)?;
            left = others;
        }
        let (mut rest, done) = (
            progress.rest.sorted(self.points.len()),
            progress.done.sorted(self.points.len()),
        );
        let held = self.hold_for(inserter, &rest, &open)?;
        if self.held.iter().filter(|held| **held).count() > limit {
            deferred.extend(self.defer(&choose_deferred(&held, limit), &mut rest, &mut open));
            self.held.fill(false);
            self.hold_for(inserter, &rest, &open)?;
        }
        let pending = Pending {
            deferred,
            ..self.pending(rest, open, vertex)
        };
        Ok(ConstrainOutcome { done, pending })
    }

    /// Holds the triangles crossed by subsegments and segments that cannot be inserted yet. Returns
    /// the number of triangles that each crosses; subsegments between the same vertices count as
    /// one.
    fn hold_for(
        &mut self,
        inserter: &mut Inserter,
        rest: &[Subsegment],
        open: &[OpenSegment],
    ) -> Result<Vec<usize>, Crossed> {
        let mut crossed = Vec::new();
        let mut stars = Stars::default();
        for along in rest.chunk_by(|a, b| a.ends == b.ends) {
            let [mut at, to] = along[0].ends;
            let mut count = 0;
            while at != to {
                let next = self.hold_from(inserter, &mut stars, at, self.point(to))?;
                count += inserter.crossed().len();
                match next {
                    Some(vertex) => at = vertex,
                    None => break,
                }
            }
            crossed.push(count);
        }
        for OpenSegment { segment, run } in open {
            let [a, b] = segment.ends;
            let mut count = 0;
            match run {
                Some([first, last]) => {
                    for (&vertex, end) in [(first, a), (last, b)] {
                        if self.point(vertex) != end {
                            self.hold_from(inserter, &mut stars, vertex, end)?;
                            count += inserter.crossed().len();
                        }
                    }
                }
                None => {
                    let step = inserter.enter(self.points, &self.constrained, [a, b]);
                    if step.map_err(|edge| self.crossed([a, b], edge))?.is_some() {
                        self.hold(inserter.crossed());
                        count += inserter.crossed().len();
                    }
                }
            }
            crossed.push(count);
        }
        Ok(crossed)
    }

    /// Takes out the subsegments and segments to be deferred, and returns them with the numbers of
    /// their copies. `is_deferred` is in the order of the result of [`hold_for`](Self::hold_for).
    fn defer(
        &self,
        is_deferred: &[bool],
        rest: &mut Vec<Subsegment>,
        open: &mut Vec<OpenSegment>,
    ) -> Vec<(Segment, u64)> {
        let mut deferred = Vec::new();
        let mut kept = Vec::with_capacity(rest.len());
        let groups: Vec<&[Subsegment]> = rest.chunk_by(|a, b| a.ends == b.ends).collect();
        let (of_rest, of_open) = is_deferred.split_at(groups.len());
        for (along, is_deferred) in groups.into_iter().zip(of_rest) {
            if !is_deferred {
                kept.extend_from_slice(along);
                continue;
            }
            for copies in along.chunk_by(|a, b| a == b) {
                let Subsegment { ends, source } = copies[0];
                let ends = ends.map(|vertex| self.point(vertex));
                deferred.push((Segment { ends, source }, copies.len() as u64));
            }
        }
        *rest = kept;
        let mut copies: HashMap<_, u64> = HashMap::new();
        for (open, _) in open.iter().zip(of_open).filter(|(_, is_deferred)| **is_deferred) {
            *copies.entry(open.segment.key()).or_default() += 1;
        }
        for open in open.iter() {
            if let Some(&copies) = copies.get(&open.segment.key()) {
                deferred.push((open.segment, copies));
            }
        }
        open.retain(|open| !copies.contains_key(&open.segment.key()));
        deferred
    }

    /// Inserts subsegments that have the same ends. Records each part of them either as done or as
    /// one that cannot be inserted.
    fn insert(
        &mut self,
        inserter: &mut Inserter,
        along: &[Subsegment],
        progress: &mut InsertionProgress,
    ) -> Result<(), Refusal> {
        if self.is_on_line {
            return self.insert_on_line(along, progress);
        }
        let is_wall = along.iter().any(|subsegment| subsegment.source.is_wall());
        let mut ends = along[0].ends;
        while ends[0] != ends[1] {
            let step = inserter.step_between(self.points, &self.constrained, ends);
            let line = ends.map(|v| self.point(v));
            let (which, step) = step.map_err(|edge| self.crossed(line, edge))?;
            let (vertex, is_in) = match step {
                LineStep::Edge(half_edge, vertex) => (vertex, self.mark(half_edge, is_wall)),
                LineStep::Triangles(vertex) => {
                    let can = inserter.crossed().iter().all(|&t| self.settled[t.index()]);
                    if can {
                        inserter.replace(self.points, &mut self.constrained, is_wall);
                    }
                    // Both half-edges are final, and nothing is left to mark.
                    (vertex, can)
                }
                // At the root this is an edge, on the hull, whose triangles are all in their tiles
                // already.
                LineStep::Out => (ends[1 - which], self.is_root),
            };
            let part = match which {
                0 => [ends[0], vertex],
                _ => [vertex, ends[1]],
            };
            let subsegments = along.iter().map(|subsegment| subsegment.part(part));
            let into = if is_in { &mut progress.done } else { &mut progress.rest };
            for subsegment in subsegments {
                into.push(subsegment, line[0])?;
            }
            progress.steps += 1;
            ends[which] = vertex;
        }
        Ok(())
    }

    /// Inserts subsegments that have the same ends into a node with collinear points. At the root
    /// they are cut at each vertex. All of them are passed up.
    fn insert_on_line(&mut self, along: &[Subsegment], progress: &mut InsertionProgress) -> Result<(), Refusal> {
        let all = &self.constrained.mesh().hull;
        let before = |end: Point| all.partition_point(|&v| self.point(v).lex_cmp(end).is_lt());
        let [a, b] = along[0].ends.map(|v| before(self.point(v)));
        let between = &all[a.min(b)..=a.max(b)];
        let ends = [between[0], between[between.len() - 1]];
        let of_root = between
            .windows(2)
            .map(|pair| [pair[0], pair[1]])
            .filter(|_| self.is_root);
        for part in of_root.chain((!self.is_root).then_some(ends)) {
            for subsegment in along {
                let is_forward = self
                    .point(subsegment.ends[0])
                    .lex_cmp(self.point(subsegment.ends[1]))
                    .is_lt();
                let source = if is_forward {
                    subsegment.source
                } else {
                    subsegment.source.reversed()
                };
                let source = source.between(part, ends);
                progress
                    .rest
                    .push(Subsegment::new(part[0], part[1], source), self.point(part[0]))?;
            }
            progress.steps += 1;
        }
        Ok(())
    }

    /// Marks an edge as a constraint if one of its half-edges is final. Returns whether both are.
    fn mark(&mut self, half_edge: HalfEdge, is_wall: bool) -> bool {
        let twin = self.constrained.mesh().twin(half_edge).half_edge();
        let half_edges = [Some(half_edge), twin].into_iter().flatten();
        let final_half_edges = half_edges
            .filter(|half_edge| self.settled[half_edge.triangle().index()])
            .count();
        if final_half_edges > 0 {
            self.constrained.fix(half_edge, is_wall);
        }
        let [from, to] = [half_edge, half_edge.next()].map(|half_edge| self.constrained.mesh().origin(half_edge).0);
        let on_hull = self.hull.get(&from) == Some(&to) || self.hull.get(&to) == Some(&from);
        match twin {
            // The twin's triangle may be in its tile already, with its mark; on the hull it does
            // not exist yet.
            None => final_half_edges == 1 && !on_hull,
            Some(_) => final_half_edges == 2,
        }
    }

    /// Holds the triangles that a line crosses from a vertex to the next vertex on it. Returns that
    /// vertex.
    fn hold_from(
        &mut self,
        inserter: &mut Inserter,
        stars: &mut Stars,
        from: u32,
        to: Point,
    ) -> Result<Option<u32>, Crossed> {
        let step = inserter.step(self.points, &self.constrained, stars, from, to);
        match step.map_err(|edge| self.crossed([self.point(from), to], edge))? {
            LineStep::Edge(_, vertex) => Ok(Some(vertex)),
            LineStep::Triangles(vertex) => {
                self.hold(inserter.crossed());
                Ok(Some(vertex))
            }
            LineStep::Out => {
                self.hold(inserter.crossed());
                Ok(None)
            }
        }
    }

    fn hold(&mut self, crossed: &[TriangleId]) {
        for &triangle in crossed {
            self.held[triangle.index()] = self.settled[triangle.index()];
        }
    }

    /// Returns the constraints that are passed up.
    fn pending(
        &self,
        subsegments: Vec<Subsegment>,
        open: Vec<OpenSegment>,
        vertex: impl Fn(u32) -> SeamVertex,
    ) -> Pending {
        let held = self
            .constrained
            .mesh()
            .triangle_ids()
            .zip(&self.held)
            .filter(|(_, held)| **held);
        let held: Vec<TriangleId> = held.map(|(triangle, _)| triangle).collect();
        let corners = |triangle: TriangleId| self.constrained.mesh().triangles[triangle.index()];
        let mut used: Vec<u32> = held.iter().flat_map(|&triangle| corners(triangle)).collect();
        used.extend(subsegments.iter().flat_map(|subsegment| subsegment.ends));
        used.extend(open.iter().filter_map(|open| open.run).flatten());
        used.sort_unstable();
        used.dedup();
        let mut vertices: Vec<(SeamVertex, u32)> = used.into_iter().map(|v| (vertex(v), v)).collect();
        vertices.sort_unstable_by_key(|(vertex, _)| vertex.id);
        let mut indices = vec![NONE; if vertices.is_empty() { 0 } else { self.points.len() }];
        for (&(_, v), index) in vertices.iter().zip(0..) {
            indices[v as usize] = index;
        }
        let index = |v: u32| indices[v as usize];
        let held = held
            .iter()
            .map(|&t| (corners(t).map(index), self.constrained.edge_bits(t)));
        Pending {
            vertices: vertices.iter().map(|(vertex, _)| *vertex).collect(),
            held: held.collect(),
            subsegments: subsegments
                .into_iter()
                .map(|subsegment| subsegment.renumbered(index))
                .collect(),
            open: open.into_iter().map(|open| open.renumbered(index)).collect(),
            deferred: Deferred::default(),
        }
    }
}
