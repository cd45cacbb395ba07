//! Finds the vertices on segments, which cut these into subsegments.

use crate::constraints::segment::Segment;
use crate::geometry::{Orientation, Point, orient2d};
use crate::mesh::point_table::PointTable;
use crate::mesh::{Inserter, LineStep, Stars};
use crate::pipeline::conquer::constrain::node_mesh::NodeMesh;
use crate::pipeline::conquer::constrain::overlaps::{LimitedSubsegments, covered};
use crate::pipeline::conquer::constrain::refusal::{Crossed, Refusal};
use crate::pipeline::records::{Deferred, OpenSegment, Subsegment};
use crate::store::{EdgeSource, LineKind, LinePart};

/// Subsegments and segments of a node, by index into its vertices.
#[derive(Debug)]
pub(crate) struct NodeLines {
    pub(crate) subsegments: LimitedSubsegments,
    pub(crate) open: Vec<OpenSegment>,
    stars: Stars,
    /// Number of steps taken to find the vertices.
    steps: usize,
}

impl NodeLines {
    fn new(most_sources: usize) -> Self {
        Self {
            subsegments: LimitedSubsegments::new(most_sources),
            open: Vec::new(),
            stars: Stars::default(),
            steps: 0,
        }
    }

    /// Finds the subsegments of the segments that meet a leaf.
    pub(crate) fn of_leaf(
        node: &NodeMesh<'_>,
        inserter: &mut Inserter,
        mut segments: Vec<Segment>,
    ) -> Result<Self, Refusal> {
        let mut lines = Self::new(node.most_sources);
        if node.constrained.mesh().triangles.is_empty() {
            for segment in segments {
                lines.find_among_points(node, segment)?;
            }
            return Ok(lines);
        }
        let index = PointTable::new(node.points);
        // A line passes no vertex twice, unless lines overlap.
        let most_steps = segments.len() + 4 * node.points.len();
        for number in 0..segments.len() {
            if lines.steps > most_steps {
                lines.find_together(node, inserter, &index, &mut segments[number..])?;
                break;
            }
            lines.find(node, inserter, &index, segments[number])?;
        }
        Ok(lines)
    }

    /// Finds the vertices on a segment.
    fn find(
        &mut self,
        node: &NodeMesh<'_>,
        inserter: &mut Inserter,
        index: &PointTable<'_>,
        segment: Segment,
    ) -> Result<(), Refusal> {
        let (ends, source) = (segment.ends, segment.source);
        let run = match ends.map(|end| index.at(end)) {
            [Some(from), Some(to)] => {
                self.subsegments.push(Subsegment::new(from, to, source), ends[0])?;
                return Ok(());
            }
            // Only the first subsegment of the run can begin the segment: the run leaves the cell.
            [Some(from), None] => Some(self.trace(node, inserter, from, ends[1], source.cut(true, false))?),
            [None, Some(to)] => {
                let source = source.reversed().cut(true, false);
                let [to, from] = self.trace(node, inserter, to, ends[0], source)?;
                Some([from, to])
            }
            [None, None] => match first_vertex(node, inserter, ends)? {
                Some(first) => Some(self.trace(node, inserter, first, ends[1], source.cut(false, false))?),
                None => None,
            },
        };
        self.open.push(OpenSegment { segment, run });
        Ok(())
    }

    /// Finds the vertices on segments many of which overlap: it follows each union of overlapping
    /// segments once.
    fn find_together(
        &mut self,
        node: &NodeMesh<'_>,
        inserter: &mut Inserter,
        index: &PointTable<'_>,
        segments: &mut [Segment],
    ) -> Result<(), Refusal> {
        for (whole, group) in covered(segments) {
            let mut along = Self {
                stars: std::mem::take(&mut self.stars),
                ..Self::new(usize::MAX)
            };
            let source = LinePart::whole(EdgeSource::new(LineKind::BreakLine, 0));
            along.find(node, inserter, index, Segment { ends: whole, source })?;
            self.stars = along.stars;
            let ends = along
                .subsegments
                .subsegments
                .iter()
                .flat_map(|subsegment| subsegment.ends);
            let runs = along.open.iter().filter_map(|open| open.run).flatten();
            let mut vertices: Vec<u32> = ends.chain(runs).collect();
            vertices.sort_unstable_by(|&a, &b| node.point(a).lex_cmp(node.point(b)));
            vertices.dedup();
            for &segment in group {
                match segment.ends.map(|end| index.at(end)) {
                    [Some(from), Some(to)] => {
                        self.subsegments
                            .push(Subsegment::new(from, to, segment.source), segment.ends[0])?;
                    }
                    _ => self.push_run(node, segment, &vertices)?,
                }
            }
        }
        Ok(())
    }

    /// Adds a segment that leaves the cell, given all vertices on its line in lexicographic order.
    fn push_run(&mut self, node: &NodeMesh<'_>, segment: Segment, on_line: &[u32]) -> Result<(), Refusal> {
        let [a, b] = segment.ends;
        let (low, high) = if a.lex_cmp(b).is_lt() { (a, b) } else { (b, a) };
        let first = on_line.partition_point(|&v| node.point(v).lex_cmp(low).is_lt());
        let end = on_line.partition_point(|&v| node.point(v).lex_cmp(high).is_le());
        let on_it = &on_line[first..end];
        let run = on_it.first().zip(on_it.last()).map(|(&first, &last)| match a == low {
            true => [first, last],
            false => [last, first],
        });
        if let Some([from, to]) = run.filter(|[from, to]| from != to) {
            let source = segment.source.between([from, to].map(|v| node.point(v)), segment.ends);
            self.subsegments.push(Subsegment::new(from, to, source), a)?;
        }
        if run.is_none_or(|[first, last]| node.point(first) != a || node.point(last) != b) {
            self.open.push(OpenSegment { segment, run });
        }
        Ok(())
    }

    /// Collects the lines of a node above the leaves: the subsegments that its children pass up,
    /// and those that join one child's run of vertices on a segment to the next, unless a child
    /// deferred the segment: the runs of the other children do not make a run of the whole.
    pub(crate) fn of_children(
        subsegments: Vec<Subsegment>,
        mut runs: Vec<OpenSegment>,
        points: &[Point],
        (deferred, most_sources): (&Deferred, usize),
    ) -> Self {
        let mut lines = Self::new(most_sources);
        lines.subsegments.subsegments = subsegments;
        runs.sort_unstable_by_key(|open| open.segment.key());
        for of_segment in runs.chunk_by(|a, b| a.segment == b.segment) {
            if !deferred.has(&of_segment[0].segment) {
                lines.join(of_segment, points);
            }
        }
        lines
    }

    fn join(&mut self, of_segment: &[OpenSegment], points: &[Point]) {
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
        // An obstacle that runs along the same line twice counts twice.
        let copies = match segment.source.kind() {
            LineKind::Obstacle => all / runs.len().max(1),
            LineKind::BreakLine | LineKind::Wall => 1,
        };
        let run = runs.first().zip(runs.last()).map(|(first, last)| [first[0], last[1]]);
        let is_open = run.is_none_or(|[first, last]| point(first) != a || point(last) != b);
        for _ in 0..copies.max(1) {
            let between = runs.windows(2).map(|pair| [pair[0][1], pair[1][0]]);
            let part = |ends: [u32; 2]| segment.source.between(ends.map(point), segment.ends);
            self.subsegments
                .subsegments
                .extend(between.map(|ends| Subsegment::new(ends[0], ends[1], part(ends))));
            if is_open {
                self.open.push(OpenSegment { segment, run });
            }
        }
    }

    /// Finds the vertices on a segment if the points are collinear or fewer than three. Uses binary
    /// search, since there may be as many vertices as segments.
    fn find_among_points(&mut self, node: &NodeMesh<'_>, segment: Segment) -> Result<(), Refusal> {
        let [a, b] = segment.ends;
        // Without triangles, the hull is all points in lexicographic order.
        let all = &node.constrained.mesh().hull;
        let side = |v: u32| orient2d(a, b, node.point(v));
        let (low, high) = if a.lex_cmp(b).is_lt() { (a, b) } else { (b, a) };
        let first = all.partition_point(|&v| node.point(v).lex_cmp(low).is_lt());
        let end = all.partition_point(|&v| node.point(v).lex_cmp(high).is_le());
        // First come the points on one side of the segment's line, then at most one on it, unless
        // all are on it.
        let between = &all[first..end];
        let start = between.first().map_or(Orientation::Collinear, |&v| side(v));
        let before = match start {
            Orientation::Collinear => 0,
            start => between.partition_point(|&v| side(v) == start),
        };
        let on_it = between[before..].partition_point(|&v| side(v) == Orientation::Collinear);
        self.push_run(node, segment, &between[before..before + on_it])
    }

    /// Follows a segment from a vertex on it towards its end outside the cell. Returns the first
    /// and the last vertex. `source` is seen in that direction, and begins where the vertex is.
    fn trace(
        &mut self,
        node: &NodeMesh<'_>,
        inserter: &mut Inserter,
        from: u32,
        to: Point,
        mut source: LinePart,
    ) -> Result<[u32; 2], Refusal> {
        let mut last = from;
        loop {
            self.steps += 1;
            let step = inserter.step(node.points, &node.constrained, &mut self.stars, last, to);
            match step.map_err(|edge| node.crossed([node.point(last), to], edge))? {
                LineStep::Edge(_, vertex) | LineStep::Triangles(vertex) => {
                    self.subsegments
                        .push(Subsegment::new(last, vertex, source), node.point(last))?;
                    source = source.cut(false, false);
                    last = vertex;
                }
                LineStep::Out => return Ok([from, last]),
            }
        }
    }
}

/// Returns the first vertex on a segment that enters from outside.
fn first_vertex(node: &NodeMesh<'_>, inserter: &mut Inserter, line: [Point; 2]) -> Result<Option<u32>, Crossed> {
    let step = inserter.enter(node.points, &node.constrained, line);
    match step.map_err(|edge| node.crossed(line, edge))? {
        Some(LineStep::Triangles(vertex) | LineStep::Edge(_, vertex)) => Ok(Some(vertex)),
        Some(LineStep::Out) => Ok(None),
        // It may enter through a vertex.
        None => {
            let [a, b] = line;
            let is_on_it = |&&v: &&u32| {
                let p = node.point(v);
                p.lex_cmp(a) != p.lex_cmp(b) && orient2d(a, b, p) == Orientation::Collinear
            };
            let on_it = node.constrained.mesh().hull.iter().filter(is_on_it).copied();
            let along = |&p: &u32, &q: &u32| match a.lex_cmp(b).is_lt() {
                true => node.point(p).lex_cmp(node.point(q)),
                false => node.point(q).lex_cmp(node.point(p)),
            };
            Ok(on_it.min_by(along))
        }
    }
}
