//! Constrain: pieces of segments go in as soon as all triangles that they cross are final.
//!
//! In: the triangles of a node with what has become of them, and the segments of its cell. Out: triangles that pieces went
//! into, which are final too, and what goes up.
//!
//! ```text
//!   leaf     segments ──▶ vertices on them ──▶ pieces, and runs that go on elsewhere ─┐
//!   above    children's pieces, and those between one child's run and the next's ─────┤
//!                                                                                     ▼
//!            insert what crosses settled triangles alone;  mark what is an edge already
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
//! same, so that whichever triangle comes to lie there is marked too.

use std::collections::HashMap;

use super::border_log::LateTriangle;
use super::node::{Fate, SeamVertex, Workspace};
use crate::geometry::{Orientation, Point, Rect, orient2d};
use crate::mesh::{Constrained, Inserter, NONE, Step, Triangulation, next_side};
use crate::store::{KdNode, KdTree, TileId, VertexId};

/// What goes up from a node for its constraints.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Pending {
    /// The vertices of what follows, in order.
    pub(super) vertices: Vec<SeamVertex>,
    /// Final triangles that pieces cross which are not in yet: corners, and a bit for each side that is a constraint.
    pub(super) held: Vec<([u32; 3], u8)>,
    /// Pieces that are not in yet.
    pub(super) pieces: Vec<[u32; 2]>,
    /// Segments that leave the cell.
    pub(super) open: Vec<Open>,
}

/// A segment that leaves a node's cell on one side at least.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Open {
    /// Its number.
    pub(super) segment: u32,
    /// The first and the last vertex on it in the node, from its first end on. None: it passes between vertices.
    pub(super) run: Option<[u32; 2]>,
}

impl Pending {
    /// Bytes that it takes in memory.
    pub(super) fn byte_size(&self) -> u64 {
        let bytes = size_of_val(&*self.vertices)
            + size_of_val(&*self.held)
            + size_of_val(&*self.pieces)
            + size_of_val(&*self.open);
        bytes as u64
    }
}

/// Two segments cross, or a piece cannot be placed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossed {
    /// A piece, or the end of one.
    pub(super) piece: [Point; 2],
    /// The constraint that it crosses.
    pub(super) edge: [Point; 2],
}

/// The triangles of a node.
struct Ground<'a> {
    points: &'a [Point],
    mesh: Constrained,
    /// Whether each triangle is final.
    settled: Vec<bool>,
    /// Whether each triangle must go up.
    held: Vec<bool>,
    /// The hull of the node, counter-clockwise from each vertex to the next, unless the node is the root.
    hull: HashMap<u32, u32>,
    /// Whether a piece that is nowhere here is done: an edge whose triangles are all in their tiles, on the hull of the root.
    is_whole: bool,
}

/// Pieces and segments of a node, by place among its vertices.
#[derive(Default)]
struct Lines {
    pieces: Vec<[u32; 2]>,
    open: Vec<Open>,
}

/// Constrains the triangles of a leaf, which are in the workspace. Those that are held, and the marks of sides, stay there.
pub(super) fn constrain_leaf(
    workspace: &mut Workspace,
    points: &[Point],
    segments: &[[Point; 2]],
    its: &[u32],
    tile: TileId,
    is_root: bool,
) -> Result<Pending, Crossed> {
    let mut inserter = std::mem::take(&mut workspace.inserter);
    let mesh = std::mem::take(&mut workspace.mesh);
    let mut ground = Ground {
        points,
        hull: hull_edges(&mesh, is_root),
        is_whole: is_root && !mesh.triangles.is_empty(),
        settled: workspace.fates.iter().map(|fate| *fate == Fate::Settled).collect(),
        held: vec![false; workspace.fates.len()],
        mesh: Constrained::new(mesh, points.len()),
    };
    let done = ground
        .find_lines(&mut inserter, segments, its)
        .and_then(|lines| ground.constrain(&mut inserter, segments, lines));
    let vertex = |index: u32| SeamVertex {
        id: VertexId { tile, index },
        point: points[index as usize],
    };
    let pending = done.map(|lines| ground.pending(&lines, vertex));
    for (fate, held) in workspace.fates.iter_mut().zip(&ground.held) {
        if *held {
            *fate = Fate::Held;
        }
    }
    (workspace.mesh, workspace.constraints) = ground.mesh.into_parts();
    workspace.inserter = inserter;
    pending
}

/// Constrains the triangles of a node above the leaves: those in the workspace, of these vertices, and those that its children
/// hold. Returns those that are final and not held.
pub(super) fn constrain_node(
    workspace: &mut Workspace,
    vertices: &[SeamVertex],
    children: Vec<Pending>,
    segments: &[[Point; 2]],
    is_root: bool,
) -> Result<(Vec<LateTriangle>, Pending), Crossed> {
    let mut vertices = vertices.to_vec();
    let kept = workspace.mesh.triangles.iter().zip(&workspace.fates);
    let kept = kept.filter(|(_, fate)| **fate != Fate::Dropped);
    let mut triangles = Vec::new();
    let (mut settled, mut fixed) = (Vec::new(), Vec::new());
    for (corners, fate) in kept {
        triangles.push(*corners);
        settled.push(*fate == Fate::Settled);
        fixed.push(0);
    }
    let hull = hull_edges(&workspace.mesh, is_root);
    let in_seams = vertices.len();
    let mut lines = Lines::default();
    let mut runs: Vec<Open> = Vec::new();
    for child in children {
        let mut places = Vec::with_capacity(child.vertices.len());
        for vertex in child.vertices {
            let in_seam = vertices[..in_seams].binary_search_by_key(&vertex.id, |v| v.id);
            let place = in_seam.unwrap_or(vertices.len());
            if place == vertices.len() {
                vertices.push(vertex);
            }
            places.push(place as u32);
        }
        let place = |v: u32| places[v as usize];
        for (corners, bits) in child.held {
            triangles.push(corners.map(place));
            settled.push(true);
            fixed.push(bits);
        }
        lines.pieces.extend(child.pieces.iter().map(|piece| piece.map(place)));
        runs.extend(child.open.iter().map(|open| Open {
            run: open.run.map(|run| run.map(place)),
            ..*open
        }));
    }
    let points: Vec<Point> = vertices.iter().map(|v| v.point).collect();
    lines.join(runs, &points, segments);
    let mut ground = Ground {
        points: &points,
        hull,
        is_whole: is_root && !workspace.mesh.triangles.is_empty(),
        held: vec![false; triangles.len()],
        settled,
        mesh: Constrained::with_constraints(glued(triangles), fixed, points.len()),
    };
    let mut inserter = std::mem::take(&mut workspace.inserter);
    let lines = ground.constrain(&mut inserter, segments, lines);
    workspace.inserter = inserter;
    let lines = lines?;
    let vertex = |index: u32| vertices[index as usize];
    let pending = ground.pending(&lines, vertex);
    let (mesh, fixed) = ground.mesh.into_parts();
    let states = ground.settled.iter().zip(&ground.held);
    let all = mesh.triangles.iter().zip(fixed).zip(states);
    let is_final = all.filter(|(_, (settled, held))| **settled && !**held);
    let late = is_final.map(|((corners, constraints), _)| LateTriangle {
        corners: corners.map(vertex),
        constraints,
    });
    Ok((late.collect(), pending))
}

/// Triangles with their adjacency, found by their edges.
fn glued(triangles: Vec<[u32; 3]>) -> Triangulation {
    let mut edges: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * triangles.len());
    for (t, first) in triangles.iter().zip((0u32..).step_by(3)) {
        for (side, s) in (first..).zip(0..3) {
            let (a, b) = (t[s], t[(s + 1) % 3]);
            edges.push(([a.min(b), a.max(b)], side));
        }
    }
    edges.sort_unstable();
    let mut neighbours = vec![[NONE; 3]; triangles.len()];
    for pair in edges.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        for (side, other) in [(pair[0].1, pair[1].1), (pair[1].1, pair[0].1)] {
            neighbours[(side / 3) as usize][(side % 3) as usize] = other;
        }
    }
    Triangulation {
        triangles,
        neighbours,
        hull: Vec::new(),
    }
}

fn hull_edges(mesh: &Triangulation, is_root: bool) -> HashMap<u32, u32> {
    if is_root || mesh.hull.is_empty() {
        return HashMap::new();
    }
    let next = mesh.hull.iter().cycle().skip(1);
    mesh.hull.iter().copied().zip(next.copied()).collect()
}

impl Lines {
    /// Joins the children's runs of vertices on each segment.
    fn join(&mut self, mut runs: Vec<Open>, points: &[Point], segments: &[[Point; 2]]) {
        let point = |v: u32| points[v as usize];
        runs.sort_by_key(|open| open.segment);
        for of_segment in runs.chunk_by(|a, b| a.segment == b.segment) {
            let segment = of_segment[0].segment;
            let [a, b] = segments[segment as usize];
            let mut runs: Vec<[u32; 2]> = of_segment.iter().filter_map(|open| open.run).collect();
            runs.sort_by(|p, q| point(p[0]).lex_cmp(point(q[0])));
            if b.lex_cmp(a).is_lt() {
                runs.reverse();
            }
            self.pieces.extend(runs.windows(2).map(|pair| [pair[0][1], pair[1][0]]));
            let run = runs.first().zip(runs.last()).map(|(first, last)| [first[0], last[1]]);
            if run.is_none_or(|[first, last]| point(first) != a || point(last) != b) {
                self.open.push(Open { segment, run });
            }
        }
    }
}

impl Ground<'_> {
    fn point(&self, vertex: u32) -> Point {
        self.points[vertex as usize]
    }

    fn crossed(&self, piece: [Point; 2], edge: [u32; 2]) -> Crossed {
        Crossed {
            piece,
            edge: edge.map(|v| self.point(v)),
        }
    }

    /// Finds the vertices on the segments of a leaf.
    fn find_lines(&self, inserter: &mut Inserter, segments: &[[Point; 2]], its: &[u32]) -> Result<Lines, Crossed> {
        let bits = |p: Point| [p.x.to_bits(), p.y.to_bits()];
        let ends = its.iter().flat_map(|&segment| segments[segment as usize]);
        let mut vertices: HashMap<[u64; 2], u32> = ends.map(|end| (bits(end), NONE)).collect();
        for (&point, vertex) in self.points.iter().zip(0..) {
            if let Some(place) = vertices.get_mut(&bits(point)) {
                *place = vertex;
            }
        }
        let mut lines = Lines::default();
        for &segment in its {
            let line = segments[segment as usize];
            let found = line.map(|end| Some(vertices[&bits(end)]).filter(|&v| v != NONE));
            if self.mesh.mesh().triangles.is_empty() {
                self.find_among_points(line, &mut lines, segment);
                continue;
            }
            let run = match found {
                [Some(from), Some(to)] => {
                    lines.pieces.push([from, to]);
                    continue;
                }
                [Some(from), None] => Some(self.trace(inserter, from, line[1], &mut lines.pieces)?),
                [None, Some(to)] => {
                    let [to, from] = self.trace(inserter, to, line[0], &mut lines.pieces)?;
                    Some([from, to])
                }
                [None, None] => match self.first_vertex(inserter, line)? {
                    Some(first) => Some(self.trace(inserter, first, line[1], &mut lines.pieces)?),
                    None => None,
                },
            };
            lines.open.push(Open { segment, run });
        }
        Ok(lines)
    }

    /// Finds the vertices on a segment where all lie on one line, or are fewer than three: by halving, since there may be as
    /// many of them as of segments.
    fn find_among_points(&self, [a, b]: [Point; 2], lines: &mut Lines, segment: u32) {
        // Without triangles the hull is all points in lexicographic order.
        let all = &self.mesh.mesh().hull;
        let side = |v: u32| orient2d(a, b, self.point(v));
        let (low, high) = if a.lex_cmp(b).is_lt() { (a, b) } else { (b, a) };
        let first = all.partition_point(|&v| self.point(v).lex_cmp(low).is_lt());
        let end = all.partition_point(|&v| self.point(v).lex_cmp(high).is_le());
        // On one side of the segment's line come first, then at most one on it, unless all are.
        let between = &all[first..end];
        let start = between.first().map_or(Orientation::Collinear, |&v| side(v));
        let before = match start {
            Orientation::Collinear => 0,
            start => between.partition_point(|&v| side(v) == start),
        };
        let on_it = between[before..].partition_point(|&v| side(v) == Orientation::Collinear);
        let mut run = between[before..before + on_it].to_vec();
        if b.lex_cmp(a).is_lt() {
            run.reverse();
        }
        lines.pieces.extend(run.windows(2).map(|pair| [pair[0], pair[1]]));
        let run = run.first().zip(run.last()).map(|(&first, &last)| [first, last]);
        if run.is_none_or(|[first, last]| self.point(first) != a || self.point(last) != b) {
            lines.open.push(Open { segment, run });
        }
    }

    /// The first vertex on a segment that comes from outside.
    fn first_vertex(&self, inserter: &mut Inserter, line: [Point; 2]) -> Result<Option<u32>, Crossed> {
        let step = inserter.enter(self.points, &self.mesh, line);
        match step.map_err(|edge| self.crossed(line, edge))? {
            Some(Step::Triangles(vertex) | Step::Edge(_, vertex)) => Ok(Some(vertex)),
            Some(Step::Out) => Ok(None),
            // It may come in through a vertex.
            None => {
                let [a, b] = line;
                let is_on_it = |&&v: &&u32| {
                    let p = self.point(v);
                    p.lex_cmp(a) != p.lex_cmp(b) && orient2d(a, b, p) == Orientation::Collinear
                };
                let on_it = self.mesh.mesh().hull.iter().filter(is_on_it).copied();
                let along = |&p: &u32, &q: &u32| match a.lex_cmp(b).is_lt() {
                    true => self.point(p).lex_cmp(self.point(q)),
                    false => self.point(q).lex_cmp(self.point(p)),
                };
                Ok(on_it.min_by(along))
            }
        }
    }

    /// Follows a segment from a vertex on it towards its end elsewhere. Returns the first and the last vertex.
    fn trace(
        &self,
        inserter: &mut Inserter,
        from: u32,
        to: Point,
        pieces: &mut Vec<[u32; 2]>,
    ) -> Result<[u32; 2], Crossed> {
        let mut last = from;
        loop {
            let step = inserter.step(self.points, &self.mesh, last, to);
            match step.map_err(|edge| self.crossed([self.point(last), to], edge))? {
                Step::Edge(_, vertex) | Step::Triangles(vertex) => {
                    pieces.push([last, vertex]);
                    last = vertex;
                }
                Step::Out => return Ok([from, last]),
            }
        }
    }

    /// Inserts what can go in, and holds what the rest needs. Returns the rest.
    fn constrain(&mut self, inserter: &mut Inserter, segments: &[[Point; 2]], lines: Lines) -> Result<Lines, Crossed> {
        let Lines { mut pieces, open } = lines;
        for piece in &mut pieces {
            piece.sort_unstable();
        }
        pieces.sort_unstable();
        pieces.dedup();
        let mut rest = Vec::new();
        for piece in pieces {
            self.insert(inserter, piece, &mut rest)?;
        }
        rest.sort_unstable();
        rest.dedup();
        for &[from, to] in &rest {
            let mut at = from;
            while at != to {
                at = match self.hold_from(inserter, at, self.point(to))? {
                    Some(vertex) => vertex,
                    None => break,
                };
            }
        }
        for &Open { segment, run } in &open {
            let [a, b] = segments[segment as usize];
            match run {
                Some([first, last]) => {
                    for (vertex, end) in [(first, a), (last, b)] {
                        if self.point(vertex) != end {
                            self.hold_from(inserter, vertex, end)?;
                        }
                    }
                }
                None => {
                    let step = inserter.enter(self.points, &self.mesh, [a, b]);
                    if step.map_err(|edge| self.crossed([a, b], edge))?.is_some() {
                        self.hold(inserter.crossed());
                    }
                }
            }
        }
        Ok(Lines { pieces: rest, open })
    }

    /// Inserts a piece, or notes as the rest what of it cannot go in.
    fn insert(&mut self, inserter: &mut Inserter, piece: [u32; 2], rest: &mut Vec<[u32; 2]>) -> Result<(), Crossed> {
        let mut ends = piece;
        while ends[0] != ends[1] {
            let step = inserter.step_between(self.points, &self.mesh, ends);
            let line = ends.map(|v| self.point(v));
            let (which, step) = step.map_err(|edge| self.crossed(line, edge))?;
            let (vertex, is_in) = match step {
                Step::Edge(side, vertex) => (vertex, self.mark(side)),
                Step::Triangles(vertex) => {
                    let can = inserter.crossed().iter().all(|&t| self.settled[t as usize]);
                    if can {
                        inserter.replace(self.points, &mut self.mesh);
                    }
                    // Both sides are final, and nothing is left to mark.
                    (vertex, can)
                }
                Step::Out => (ends[1 - which], self.is_whole),
            };
            if !is_in {
                rest.push([ends[which].min(vertex), ends[which].max(vertex)]);
            }
            ends[which] = vertex;
        }
        Ok(())
    }

    /// Marks an edge as a constraint, if it is final. Returns whether both its sides are.
    fn mark(&mut self, side: u32) -> bool {
        let twin = self.mesh.mesh().twin(side);
        let sides = [side, twin].into_iter().filter(|&side| side != NONE);
        let final_sides = sides.filter(|&side| self.settled[(side / 3) as usize]).count();
        if final_sides > 0 {
            self.mesh.fix(side);
        }
        let [from, to] = [side, next_side(side)].map(|side| self.mesh.mesh().origin(side));
        let on_hull = self.hull.get(&from) == Some(&to) || self.hull.get(&to) == Some(&from);
        match twin {
            // What was across may be in its tile already, with its mark; on the hull it is still to come.
            NONE => final_sides == 1 && !on_hull,
            _ => final_sides == 2,
        }
    }

    /// Holds what a line crosses from a vertex to the next on it, which it returns.
    fn hold_from(&mut self, inserter: &mut Inserter, from: u32, to: Point) -> Result<Option<u32>, Crossed> {
        let step = inserter.step(self.points, &self.mesh, from, to);
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

    fn hold(&mut self, crossed: &[u32]) {
        for &triangle in crossed {
            self.held[triangle as usize] = self.settled[triangle as usize];
        }
    }

    /// What goes up.
    fn pending(&self, lines: &Lines, vertex: impl Fn(u32) -> SeamVertex) -> Pending {
        let held = (0..).zip(&self.held).filter(|(_, held)| **held);
        let held: Vec<u32> = held.map(|(triangle, _)| triangle).collect();
        let corners = |triangle: u32| self.mesh.mesh().triangles[triangle as usize];
        let mut used: Vec<u32> = held.iter().flat_map(|&triangle| corners(triangle)).collect();
        used.extend(lines.pieces.as_flattened());
        used.extend(lines.open.iter().filter_map(|open| open.run).flatten());
        used.sort_unstable();
        used.dedup();
        let mut vertices: Vec<(SeamVertex, u32)> = used.into_iter().map(|v| (vertex(v), v)).collect();
        vertices.sort_unstable_by_key(|(vertex, _)| vertex.id);
        let places: HashMap<u32, u32> = vertices.iter().zip(0..).map(|(&(_, v), place)| (v, place)).collect();
        let place = |v: u32| places[&v];
        Pending {
            vertices: vertices.iter().map(|(vertex, _)| *vertex).collect(),
            held: held
                .iter()
                .map(|&t| (corners(t).map(place), self.mesh.constraint_bits(t)))
                .collect(),
            pieces: lines.pieces.iter().map(|piece| piece.map(place)).collect(),
            open: lines
                .open
                .iter()
                .map(|open| Open {
                    run: open.run.map(|run| run.map(place)),
                    ..*open
                })
                .collect(),
        }
    }
}

/// The segments of each leaf of a tree: those that meet its cell, perhaps some more.
///
/// One after the other, so that the tree is what stays in the processor's cache.
pub(super) fn segments_of_leaves(
    tree: &KdTree,
    cell: Rect,
    segments: &[[Point; 2]],
    its: impl Iterator<Item = u32>,
) -> Vec<Vec<u32>> {
    let mut leaves = vec![Vec::new(); tree.tiles() as usize];
    let mut open: Vec<(u32, Rect)> = Vec::new();
    for number in its.filter(|_| !tree.nodes().is_empty()) {
        let segment = segments[number as usize];
        open.push((0, cell));
        while let Some((node, cell)) = open.pop() {
            let (low, high, right) = match tree.nodes()[node as usize] {
                KdNode::X { cut, right } => (Rect { max_x: cut, ..cell }, Rect { min_x: cut, ..cell }, right),
                KdNode::Y { cut, right } => (Rect { max_y: cut, ..cell }, Rect { min_y: cut, ..cell }, right),
                KdNode::Leaf(tile) => {
                    leaves[tile.0 as usize].push(number);
                    continue;
                }
            };
            let children = [(node + 1, low), (right, high)];
            open.extend(children.into_iter().filter(|(_, cell)| meets(segment, *cell)));
        }
    }
    leaves
}

/// Whether a segment may meet a closed cell; exact where the cell is finite.
fn meets([a, b]: [Point; 2], cell: Rect) -> bool {
    let beside = a.x.max(b.x) < cell.min_x
        || a.x.min(b.x) > cell.max_x
        || a.y.max(b.y) < cell.min_y
        || a.y.min(b.y) > cell.max_y;
    if beside {
        return false;
    }
    if cell.contains(a) || cell.contains(b) {
        return true;
    }
    let corners = [
        Point::new(cell.min_x, cell.min_y),
        Point::new(cell.max_x, cell.min_y),
        Point::new(cell.min_x, cell.max_y),
        Point::new(cell.max_x, cell.max_y),
    ];
    if corners
        .iter()
        .any(|corner| !corner.x.is_finite() || !corner.y.is_finite())
    {
        return true;
    }
    let sides = corners.map(|corner| orient2d(a, b, corner));
    sides.iter().any(|side| *side != sides[0]) || sides[0] == Orientation::Collinear
}
