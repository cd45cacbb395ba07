//! The vertices on segments: they cut these into pieces.

use super::ground::Ground;
use super::{Crossed, Open, Piece};
use crate::build::segments::Segment;
use crate::build::vertex_index::VertexIndex;
use crate::geometry::{Orientation, Point, orient2d};
use crate::mesh::{Inserter, Step};
use crate::store::{EdgeSource, LineKind};

/// Pieces and segments of a node, by place among its vertices.
#[derive(Debug, Default)]
pub(super) struct Lines {
    pub(super) pieces: Vec<Piece>,
    pub(super) open: Vec<Open>,
}

impl Lines {
    /// Those of the segments that meet a leaf.
    pub(super) fn of_leaf(
        ground: &Ground<'_>,
        inserter: &mut Inserter,
        segments: impl Iterator<Item = Segment>,
    ) -> Result<Self, Crossed> {
        let mut lines = Self::default();
        if ground.mesh.mesh().triangles.is_empty() {
            for segment in segments {
                lines.find_among_points(ground, segment);
            }
            return Ok(lines);
        }
        let index = VertexIndex::new(ground.points);
        for segment in segments {
            let (ends, source) = (segment.ends, segment.source);
            let run = match ends.map(|end| index.at(end)) {
                [Some(from), Some(to)] => {
                    lines.pieces.push(Piece::new(from, to, source));
                    continue;
                }
                [Some(from), None] => Some(lines.trace(ground, inserter, from, ends[1], source)?),
                [None, Some(to)] => {
                    let [to, from] = lines.trace(ground, inserter, to, ends[0], source.reversed())?;
                    Some([from, to])
                }
                [None, None] => match first_vertex(ground, inserter, ends)? {
                    Some(first) => Some(lines.trace(ground, inserter, first, ends[1], source)?),
                    None => None,
                },
            };
            lines.open.push(Open { segment, run });
        }
        Ok(lines)
    }

    /// Those of a node above the leaves: what its children hand up, and what joins a child's run of vertices on a segment to
    /// the next.
    pub(super) fn of_children(pieces: Vec<Piece>, mut runs: Vec<Open>, points: &[Point]) -> Self {
        let mut lines = Self {
            pieces,
            open: Vec::new(),
        };
        runs.sort_unstable_by_key(|open| open.segment.key());
        for of_segment in runs.chunk_by(|a, b| a.segment == b.segment) {
            lines.join(of_segment, points);
        }
        lines
    }

    fn join(&mut self, of_segment: &[Open], points: &[Point]) {
        let point = |v: u32| points[v as usize];
        let segment = of_segment[0].segment;
        let [a, b] = segment.ends;
        let mut runs: Vec<[u32; 2]> = of_segment.iter().filter_map(|open| open.run).collect();
        runs.sort_unstable_by(|p, q| point(p[0]).lex_cmp(point(q[0])));
        if b.lex_cmp(a).is_lt() {
            runs.reverse();
        }
        let all = runs.len();
        runs.dedup();
        // Where an obstacle runs twice along the same line, it counts twice.
        let copies = match segment.source.kind() {
            LineKind::Obstacle => all / runs.len().max(1),
            LineKind::BreakLine | LineKind::Wall => 1,
        };
        let run = runs.first().zip(runs.last()).map(|(first, last)| [first[0], last[1]]);
        let is_open = run.is_none_or(|[first, last]| point(first) != a || point(last) != b);
        for _ in 0..copies.max(1) {
            let between = runs.windows(2).map(|pair| [pair[0][1], pair[1][0]]);
            self.pieces
                .extend(between.map(|[from, to]| Piece::new(from, to, segment.source)));
            if is_open {
                self.open.push(Open { segment, run });
            }
        }
    }

    /// Finds the vertices on a segment where all lie on one line, or are fewer than three: by halving, since there may be as
    /// many of them as of segments.
    fn find_among_points(&mut self, ground: &Ground<'_>, segment: Segment) {
        let [a, b] = segment.ends;
        // Without triangles the hull is all points in lexicographic order.
        let all = &ground.mesh.mesh().hull;
        let side = |v: u32| orient2d(a, b, ground.point(v));
        let (low, high) = if a.lex_cmp(b).is_lt() { (a, b) } else { (b, a) };
        let first = all.partition_point(|&v| ground.point(v).lex_cmp(low).is_lt());
        let end = all.partition_point(|&v| ground.point(v).lex_cmp(high).is_le());
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
        self.pieces
            .extend(run.windows(2).map(|pair| Piece::new(pair[0], pair[1], segment.source)));
        let run = run.first().zip(run.last()).map(|(&first, &last)| [first, last]);
        if run.is_none_or(|[first, last]| ground.point(first) != a || ground.point(last) != b) {
            self.open.push(Open { segment, run });
        }
    }

    /// Follows a segment from a vertex on it towards its end elsewhere. Returns the first and the last vertex. The source is
    /// seen in that direction.
    fn trace(
        &mut self,
        ground: &Ground<'_>,
        inserter: &mut Inserter,
        from: u32,
        to: Point,
        source: EdgeSource,
    ) -> Result<[u32; 2], Crossed> {
        let mut last = from;
        loop {
            let step = inserter.step(ground.points, &ground.mesh, last, to);
            match step.map_err(|edge| ground.crossed([ground.point(last), to], edge))? {
                Step::Edge(_, vertex) | Step::Triangles(vertex) => {
                    self.pieces.push(Piece::new(last, vertex, source));
                    last = vertex;
                }
                Step::Out => return Ok([from, last]),
            }
        }
    }
}

/// The first vertex on a segment that comes from outside.
fn first_vertex(ground: &Ground<'_>, inserter: &mut Inserter, line: [Point; 2]) -> Result<Option<u32>, Crossed> {
    let step = inserter.enter(ground.points, &ground.mesh, line);
    match step.map_err(|edge| ground.crossed(line, edge))? {
        Some(Step::Triangles(vertex) | Step::Edge(_, vertex)) => Ok(Some(vertex)),
        Some(Step::Out) => Ok(None),
        // It may come in through a vertex.
        None => {
            let [a, b] = line;
            let is_on_it = |&&v: &&u32| {
                let p = ground.point(v);
                p.lex_cmp(a) != p.lex_cmp(b) && orient2d(a, b, p) == Orientation::Collinear
            };
            let on_it = ground.mesh.mesh().hull.iter().filter(is_on_it).copied();
            let along = |&p: &u32, &q: &u32| match a.lex_cmp(b).is_lt() {
                true => ground.point(p).lex_cmp(ground.point(q)),
                false => ground.point(q).lex_cmp(ground.point(p)),
            };
            Ok(on_it.min_by(along))
        }
    }
}
