//! The triangles of a node, into which pieces go.

use foldhash::{HashMap, HashMapExt};

use crate::constraints::segment::Segment;
use crate::geometry::{HalfEdge, Point, TriangleId};
use crate::mesh::{Constrained, Inserter, NONE, Stars, Step, Topology, Triangulation};
use crate::pipeline::conquer::constrain::overlaps::{Limited, for_each_part};
use crate::pipeline::conquer::constrain::refusal::{Crossed, Refusal};
use crate::pipeline::conquer::deferral::{Deferral, put_off};
use crate::pipeline::records::{Open, Pending, Piece, SeamVertex};

/// The triangles of a node.
pub(crate) struct Ground<'a> {
    pub(crate) points: &'a [Point],
    pub(crate) mesh: Constrained,
    /// Whether each triangle is final.
    pub(crate) settled: Vec<bool>,
    /// Whether each triangle must go up.
    pub(crate) held: Vec<bool>,
    /// The hull of the node, counter-clockwise from each vertex to the next, unless the node is the root.
    hull: HashMap<u32, u32>,
    is_root: bool,
    /// Whether the node has no triangles at all: its hull are all vertices, in lexicographic order.
    is_on_line: bool,
    /// How often lines may run along edges, all in all.
    pub(crate) most_sources: usize,
}

/// What came of the pieces of a node.
pub(crate) struct Outcome {
    /// Those that are done.
    pub(crate) done: Vec<Piece>,
    /// What goes up.
    pub(crate) pending: Pending,
}

/// What became of pieces so far.
struct Parts {
    /// Those that are in.
    done: Limited,
    /// Those that cannot go in.
    rest: Limited,
    /// How many steps it took.
    steps: usize,
}

impl<'a> Ground<'a> {
    /// Takes triangles with the bits of their sides, and the hull of the node.
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
            mesh: Constrained::with_constraints(mesh, fixed, points.len()),
        }
    }

    pub(crate) fn point(&self, vertex: u32) -> Point {
        self.points[vertex as usize]
    }

    pub(crate) fn crossed(&self, piece: [Point; 2], edge: [u32; 2]) -> Crossed {
        Crossed {
            piece,
            edge: edge.map(|v| self.point(v)),
        }
    }

    /// Inserts what can go in, and holds what the rest needs, which goes up; but no more than `limit` triangles: the rest is put
    /// off.
    pub(crate) fn constrain(
        &mut self,
        inserter: &mut Inserter,
        (pieces, mut open): (Limited, Vec<Open>),
        (deferral, limit): (&Deferral, usize),
        vertex: impl Fn(u32) -> SeamVertex,
    ) -> Result<Outcome, Refusal> {
        let pieces = pieces.sorted(self.points.len());
        let mut parts = Parts {
            done: Limited::new(self.most_sources),
            rest: Limited::new(self.most_sources),
            steps: 0,
        };
        // A line passes no vertex twice, unless others do so too.
        let most_steps = pieces.len() + 4 * self.points.len();
        let mut left = &*pieces;
        while let Some(first) = left.first() {
            if parts.steps > most_steps {
                let points = self.points;
                for_each_part(
                    left,
                    |v| points[v as usize],
                    |along| self.insert(inserter, along, &mut parts),
                )?;
                break;
            }
            let count = left.iter().take_while(|piece| piece.ends == first.ends).count();
            let (along, others) = left.split_at(count);
            self.insert(inserter, along, &mut parts)?;
            left = others;
        }
        let (mut rest, done) = (
            parts.rest.sorted(self.points.len()),
            parts.done.sorted(self.points.len()),
        );
        let held = self.hold_for(inserter, &rest, &open)?;
        if self.held.iter().filter(|held| **held).count() > limit {
            self.put_off(&put_off(&held, limit), deferral, &mut rest, &mut open);
            self.held.fill(false);
            self.hold_for(inserter, &rest, &open)?;
        }
        let pending = self.pending(rest, open, vertex);
        Ok(Outcome { done, pending })
    }

    /// Holds what pieces and segments cross that cannot go in yet. Returns how many triangles each crosses, pieces between the same
    /// vertices together.
    fn hold_for(&mut self, inserter: &mut Inserter, rest: &[Piece], open: &[Open]) -> Result<Vec<usize>, Crossed> {
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
        for Open { segment, run } in open {
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
                    let step = inserter.enter(self.points, &self.mesh, [a, b]);
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

    /// Puts pieces and segments off; they come as in [`hold_for`](Self::hold_for).
    fn put_off(&self, is_off: &[bool], deferral: &Deferral, rest: &mut Vec<Piece>, open: &mut Vec<Open>) {
        let mut kept = Vec::with_capacity(rest.len());
        let groups: Vec<&[Piece]> = rest.chunk_by(|a, b| a.ends == b.ends).collect();
        let (of_rest, of_open) = is_off.split_at(groups.len());
        for (along, is_off) in groups.into_iter().zip(of_rest) {
            if !is_off {
                kept.extend_from_slice(along);
                continue;
            }
            for copies in along.chunk_by(|a, b| a == b) {
                let Piece { ends, source } = copies[0];
                let ends = ends.map(|vertex| self.point(vertex));
                deferral.add(Segment { ends, source }, copies.len());
            }
        }
        *rest = kept;
        let mut copies: HashMap<_, usize> = HashMap::new();
        for (open, _) in open.iter().zip(of_open).filter(|(_, is_off)| **is_off) {
            *copies.entry(open.segment.key()).or_default() += 1;
        }
        for open in open.iter() {
            if let Some(&copies) = copies.get(&open.segment.key()) {
                deferral.add(open.segment, copies);
            }
        }
        open.retain(|open| !copies.contains_key(&open.segment.key()));
    }

    /// Inserts pieces that have the same ends, and notes each part of them: as done, or as the rest that cannot go in.
    fn insert(&mut self, inserter: &mut Inserter, along: &[Piece], parts: &mut Parts) -> Result<(), Refusal> {
        if self.is_on_line {
            return self.insert_on_line(along, parts);
        }
        let is_wall = along.iter().any(|piece| piece.source.is_wall());
        let mut ends = along[0].ends;
        while ends[0] != ends[1] {
            let step = inserter.step_between(self.points, &self.mesh, ends);
            let line = ends.map(|v| self.point(v));
            let (which, step) = step.map_err(|edge| self.crossed(line, edge))?;
            let (vertex, is_in) = match step {
                Step::Edge(side, vertex) => (vertex, self.mark(side, is_wall)),
                Step::Triangles(vertex) => {
                    let can = inserter.crossed().iter().all(|&t| self.settled[t.index()]);
                    if can {
                        inserter.replace(self.points, &mut self.mesh, is_wall);
                    }
                    // Both sides are final, and nothing is left to mark.
                    (vertex, can)
                }
                // At the root an edge whose triangles are all in their tiles, on the hull.
                Step::Out => (ends[1 - which], self.is_root),
            };
            let part = match which {
                0 => [ends[0], vertex],
                _ => [vertex, ends[1]],
            };
            let pieces = along.iter().map(|piece| Piece::new(part[0], part[1], piece.source));
            let into = if is_in { &mut parts.done } else { &mut parts.rest };
            for piece in pieces {
                into.push(piece, line[0])?;
            }
            parts.steps += 1;
            ends[which] = vertex;
        }
        Ok(())
    }

    /// The same where all vertices lie on one line: at the root pieces are cut at each of them, and all go up.
    fn insert_on_line(&mut self, along: &[Piece], parts: &mut Parts) -> Result<(), Refusal> {
        let all = &self.mesh.mesh().hull;
        let before = |end: Point| all.partition_point(|&v| self.point(v).lex_cmp(end).is_lt());
        let [a, b] = along[0].ends.map(|v| before(self.point(v)));
        let between = &all[a.min(b)..=a.max(b)];
        let ends = [between[0], between[between.len() - 1]];
        let of_root = between
            .windows(2)
            .map(|pair| [pair[0], pair[1]])
            .filter(|_| self.is_root);
        for part in of_root.chain((!self.is_root).then_some(ends)) {
            for piece in along {
                let source = match self.point(piece.ends[0]).lex_cmp(self.point(piece.ends[1])).is_lt() {
                    true => piece.source,
                    false => piece.source.reversed(),
                };
                parts
                    .rest
                    .push(Piece::new(part[0], part[1], source), self.point(part[0]))?;
            }
            parts.steps += 1;
        }
        Ok(())
    }

    /// Marks an edge as a constraint, if it is final. Returns whether both its sides are.
    fn mark(&mut self, side: HalfEdge, is_wall: bool) -> bool {
        let twin = self.mesh.mesh().twin(side).half_edge();
        let sides = [Some(side), twin].into_iter().flatten();
        let final_sides = sides.filter(|side| self.settled[side.triangle().index()]).count();
        if final_sides > 0 {
            self.mesh.fix(side, is_wall);
        }
        let [from, to] = [side, side.next()].map(|side| self.mesh.mesh().origin(side).0);
        let on_hull = self.hull.get(&from) == Some(&to) || self.hull.get(&to) == Some(&from);
        match twin {
            // What was across may be in its tile already, with its mark; on the hull it is still to come.
            None => final_sides == 1 && !on_hull,
            Some(_) => final_sides == 2,
        }
    }

    /// Holds what a line crosses from a vertex to the next on it, which it returns.
    fn hold_from(
        &mut self,
        inserter: &mut Inserter,
        stars: &mut Stars,
        from: u32,
        to: Point,
    ) -> Result<Option<u32>, Crossed> {
        let step = inserter.step(self.points, &self.mesh, stars, from, to);
        match step.map_err(|edge| self.crossed([self.point(from), to], edge))? {
            Step::Edge(_, vertex) => Ok(Some(vertex)),
            Step::Triangles(vertex) => {
                self.hold(inserter.crossed());
                Ok(Some(vertex))
            }
            Step::Out => {
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

    /// What goes up.
    fn pending(&self, pieces: Vec<Piece>, open: Vec<Open>, vertex: impl Fn(u32) -> SeamVertex) -> Pending {
        let held = self
            .mesh
            .mesh()
            .triangle_ids()
            .zip(&self.held)
            .filter(|(_, held)| **held);
        let held: Vec<TriangleId> = held.map(|(triangle, _)| triangle).collect();
        let corners = |triangle: TriangleId| self.mesh.mesh().triangles[triangle.index()];
        let mut used: Vec<u32> = held.iter().flat_map(|&triangle| corners(triangle)).collect();
        used.extend(pieces.iter().flat_map(|piece| piece.ends));
        used.extend(open.iter().filter_map(|open| open.run).flatten());
        used.sort_unstable();
        used.dedup();
        let mut vertices: Vec<(SeamVertex, u32)> = used.into_iter().map(|v| (vertex(v), v)).collect();
        vertices.sort_unstable_by_key(|(vertex, _)| vertex.id);
        let mut places = vec![NONE; if vertices.is_empty() { 0 } else { self.points.len() }];
        for (&(_, v), place) in vertices.iter().zip(0..) {
            places[v as usize] = place;
        }
        let place = |v: u32| places[v as usize];
        let held = held.iter().map(|&t| (corners(t).map(place), self.mesh.side_bits(t)));
        Pending {
            vertices: vertices.iter().map(|(vertex, _)| *vertex).collect(),
            held: held.collect(),
            pieces: pieces.into_iter().map(|piece| piece.renumbered(place)).collect(),
            open: open.into_iter().map(|open| open.renumbered(place)).collect(),
        }
    }
}
