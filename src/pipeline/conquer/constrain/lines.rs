//! The vertices on segments: they cut these into pieces.

use crate::constraints::segment::Segment;
use crate::geometry::{Orientation, Point, orient2d};
use crate::mesh::point_table::PointTable;
use crate::mesh::{Inserter, Stars, Step};
use crate::pipeline::conquer::constrain::ground::Ground;
use crate::pipeline::conquer::constrain::overlaps::{Limited, covered};
use crate::pipeline::conquer::constrain::refusal::{Crossed, Refusal};
use crate::pipeline::conquer::deferral::Deferral;
use crate::pipeline::records::{Open, Piece};
use crate::store::{EdgeSource, LineKind};

/// Pieces and segments of a node, by place among its vertices.
#[derive(Debug)]
pub(crate) struct Lines {
    pub(crate) pieces: Limited,
    pub(crate) open: Vec<Open>,
    stars: Stars,
    /// How many steps it took to find them.
    steps: usize,
}

impl Lines {
    fn new(most_sources: usize) -> Self {
        Self {
            pieces: Limited::new(most_sources),
            open: Vec::new(),
            stars: Stars::default(),
            steps: 0,
        }
    }

    /// Those of the segments that meet a leaf.
    pub(crate) fn of_leaf(
        ground: &Ground<'_>,
        inserter: &mut Inserter,
        mut segments: Vec<Segment>,
    ) -> Result<Self, Refusal> {
        let mut lines = Self::new(ground.most_sources);
        if ground.mesh.mesh().triangles.is_empty() {
            for segment in segments {
                lines.find_among_points(ground, segment)?;
            }
            return Ok(lines);
        }
        let index = PointTable::new(ground.points);
        // A line passes no vertex twice, unless others do so too.
        let most_steps = segments.len() + 4 * ground.points.len();
        for place in 0..segments.len() {
            if lines.steps > most_steps {
                lines.find_together(ground, inserter, &index, &mut segments[place..])?;
                break;
            }
            lines.find(ground, inserter, &index, segments[place])?;
        }
        Ok(lines)
    }

    /// Finds the vertices on a segment.
    fn find(
        &mut self,
        ground: &Ground<'_>,
        inserter: &mut Inserter,
        index: &PointTable<'_>,
        segment: Segment,
    ) -> Result<(), Refusal> {
        let (ends, source) = (segment.ends, segment.source);
        let run = match ends.map(|end| index.at(end)) {
            [Some(from), Some(to)] => {
                self.pieces.push(Piece::new(from, to, source), ends[0])?;
                return Ok(());
            }
            [Some(from), None] => Some(self.trace(ground, inserter, from, ends[1], source)?),
            [None, Some(to)] => {
                let [to, from] = self.trace(ground, inserter, to, ends[0], source.reversed())?;
                Some([from, to])
            }
            [None, None] => match first_vertex(ground, inserter, ends)? {
                Some(first) => Some(self.trace(ground, inserter, first, ends[1], source)?),
                None => None,
            },
        };
        self.open.push(Open { segment, run });
        Ok(())
    }

    /// Finds the vertices on segments many of which run along each other: once on what these cover together.
    fn find_together(
        &mut self,
        ground: &Ground<'_>,
        inserter: &mut Inserter,
        index: &PointTable<'_>,
        segments: &mut [Segment],
    ) -> Result<(), Refusal> {
        for (whole, group) in covered(segments) {
            let mut along = Self {
                stars: std::mem::take(&mut self.stars),
                ..Self::new(usize::MAX)
            };
            let source = EdgeSource::new(LineKind::BreakLine, 0);
            along.find(ground, inserter, index, Segment { ends: whole, source })?;
            self.stars = along.stars;
            let ends = along.pieces.pieces.iter().flat_map(|piece| piece.ends);
            let runs = along.open.iter().filter_map(|open| open.run).flatten();
            let mut vertices: Vec<u32> = ends.chain(runs).collect();
            vertices.sort_unstable_by(|&a, &b| ground.point(a).lex_cmp(ground.point(b)));
            vertices.dedup();
            for &segment in group {
                match segment.ends.map(|end| index.at(end)) {
                    [Some(from), Some(to)] => {
                        self.pieces
                            .push(Piece::new(from, to, segment.source), segment.ends[0])?;
                    }
                    _ => self.push_run(ground, segment, &vertices)?,
                }
            }
        }
        Ok(())
    }

    /// Takes a segment that leaves the cell, and all vertices on its line, in lexicographic order.
    fn push_run(&mut self, ground: &Ground<'_>, segment: Segment, on_line: &[u32]) -> Result<(), Refusal> {
        let [a, b] = segment.ends;
        let (low, high) = if a.lex_cmp(b).is_lt() { (a, b) } else { (b, a) };
        let first = on_line.partition_point(|&v| ground.point(v).lex_cmp(low).is_lt());
        let end = on_line.partition_point(|&v| ground.point(v).lex_cmp(high).is_le());
        let on_it = &on_line[first..end];
        let run = on_it.first().zip(on_it.last()).map(|(&first, &last)| match a == low {
            true => [first, last],
            false => [last, first],
        });
        if let Some([from, to]) = run.filter(|[from, to]| from != to) {
            self.pieces.push(Piece::new(from, to, segment.source), a)?;
        }
        if run.is_none_or(|[first, last]| ground.point(first) != a || ground.point(last) != b) {
            self.open.push(Open { segment, run });
        }
        Ok(())
    }

    /// Those of a node above the leaves: what its children hand up, and what joins a child's run of vertices on a segment to
    /// the next, unless the segment is put off.
    pub(crate) fn of_children(
        pieces: Vec<Piece>,
        mut runs: Vec<Open>,
        points: &[Point],
        (deferral, most_sources): (&Deferral, usize),
    ) -> Self {
        let mut lines = Self::new(most_sources);
        lines.pieces.pieces = pieces;
        runs.sort_unstable_by_key(|open| open.segment.key());
        for of_segment in runs.chunk_by(|a, b| a.segment == b.segment) {
            // Asked once: other threads put segments off meanwhile, and runs of some of the children do not make one of the whole.
            if !deferral.has(&of_segment[0].segment) {
                lines.join(of_segment, points);
            }
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
                .pieces
                .extend(between.map(|[from, to]| Piece::new(from, to, segment.source)));
            if is_open {
                self.open.push(Open { segment, run });
            }
        }
    }

    /// Finds the vertices on a segment where all lie on one line, or are fewer than three: by halving, since there may be as
    /// many of them as of segments.
    fn find_among_points(&mut self, ground: &Ground<'_>, segment: Segment) -> Result<(), Refusal> {
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
        self.push_run(ground, segment, &between[before..before + on_it])
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
    ) -> Result<[u32; 2], Refusal> {
        let mut last = from;
        loop {
            self.steps += 1;
            let step = inserter.step(ground.points, &ground.mesh, &mut self.stars, last, to);
            match step.map_err(|edge| ground.crossed([ground.point(last), to], edge))? {
                Step::Edge(_, vertex) | Step::Triangles(vertex) => {
                    self.pieces.push(Piece::new(last, vertex, source), ground.point(last))?;
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
