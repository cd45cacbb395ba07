//! How the wavefront bends round vertices.

use super::goal::Goal;
use super::regions::{HalfPlane, RegionShape};
use super::roots::{Root, TIE};
use super::state::Wavefront;
use super::task::Via;
use super::window::Window;
use crate::geometry::{Orientation, Point, VertexIndex, orient2d};
use crate::query::free_space::{FreeSpace, Wedge};
use crate::query::request::Contradiction;

impl Wavefront {
    /// Processes a vertex that is next in the queue, reached from the root `before`.
    pub(super) fn reach(
        &mut self,
        space: FreeSpace<'_>,
        vertex: VertexIndex,
        point: Point,
        before: u32,
        length: f64,
        via: Via,
    ) -> Result<(), Contradiction> {
        let mark = space.mark(vertex).ok_or(Contradiction::NoVertex(vertex))?;
        if mark.is_single() && self.here.is_nearer(vertex, length) {
            return Ok(());
        }
        let id = space.tile.vertex(vertex).id;
        let seen = self.seen.entry(id).or_default();
        seen.mark = Some(mark);
        if length > seen.limit * TIE {
            return Ok(());
        }
        if length < seen.reported {
            seen.reported = length;
            self.report_vertex(space, vertex, length, before);
        }
        if !mark.turns() {
            return Ok(());
        }
        let wedge = match via {
            Via::HalfEdge(half_edge) => Wedge::Triangle(half_edge),
            Via::Outside => Wedge::Outside,
            Via::RightOf(to) => {
                let wedge = space.right_of_edge(vertex, to)?;
                wedge.ok_or(Contradiction::LacksTriangle(vertex))?
            }
        };
        if !mark.is_single() && !space.sector_turns(vertex, wedge)? {
            return Ok(());
        }
        let seen = self.seen.entry(id).or_default();
        // A root that was reached by a longer path is replaced.
        let known = seen.root.filter(|&root| length >= self.roots[root as usize].length);
        let root = known.unwrap_or_else(|| {
            let root = self.roots.len() as u32;
            (seen.root, seen.limit) = (Some(root), length);
            self.roots.push(Root {
                point,
                vertex: Some(id),
                length,
                parent: Some(before),
                depth: self.roots[before as usize].depth + 1,
                done: [0; 2],
            });
            root
        });
        let from = self.roots[before as usize].point;
        for leftwards in [true, false] {
            self.spread_round(space, root, vertex, from, wedge, leftwards)?;
        }
        Ok(())
    }

    /// Spreads from a root to what a path from `from`, which arrives in the wedge `start`, can see
    /// after a turn to the left or to the right.
    pub(super) fn spread_round(
        &mut self,
        space: FreeSpace<'_>,
        root: u32,
        vertex: VertexIndex,
        from: Point,
        start: Wedge,
        leftwards: bool,
    ) -> Result<(), Contradiction> {
        let at = self.roots[root as usize].point;
        let turn = if leftwards {
            Orientation::CounterClockwise
        } else {
            Orientation::Clockwise
        };
        let mut wedges = Vec::new();
        let (mut wedge, mut is_beyond) = (start, false);
        for _ in 0..=space.tile.triangle_count() {
            let far = space.neighbours(vertex, wedge)?[usize::from(leftwards)];
            // The wedge is beyond the ray from the point: the outside is never narrower than a
            // half-turn.
            let is_whole_outside = wedge == Wedge::Outside && wedge != start;
            if !is_beyond {
                let there = space.point(far);
                is_beyond = match orient2d(from, at, there) {
                    _ if is_whole_outside => true,
                    Orientation::Collinear => is_between(from, at, there),
                    found => found == turn,
                };
            }
            if is_beyond {
                wedges.push((wedge, far));
            }
            match space.beside(vertex, wedge, leftwards)? {
                Some(next) if next != start => wedge = next,
                _ => break,
            }
        }
        // An equally long path to the root may have processed these wedges already.
        let done = &mut self.roots[root as usize].done[usize::from(leftwards)];
        let new = wedges.len().saturating_sub(*done as usize);
        *done = (*done).max(wedges.len() as u32);
        for &(wedge, far) in &wedges[..new] {
            let Wedge::Triangle(half_edge) = wedge else {
                self.spread_outside(space, root, vertex, Some(far))?;
                continue;
            };
            self.see_points_in(space, root, half_edge.triangle());
            self.see_by(
                space,
                root,
                far,
                if leftwards { half_edge.prev() } else { half_edge.next() },
            );
            let [right, left] =
                [half_edge.next(), half_edge.prev()].map(|half_edge| space.point(space.tile.origin(half_edge)));
            let window = Window { root: at, right, left };
            self.pass(space, root, half_edge.next(), window, [right, left])?;
        }
        Ok(())
    }

    /// Lets a root at a hull vertex see its neighbours along the hull, or only the neighbour
    /// `only`, and the goals outside.
    pub(super) fn spread_outside(
        &mut self,
        space: FreeSpace<'_>,
        root: u32,
        vertex: VertexIndex,
        only: Option<VertexIndex>,
    ) -> Result<(), Contradiction> {
        let ends = space.neighbours(vertex, Wedge::Outside)?;
        for end in ends.into_iter().filter(|&end| only.is_none_or(|only| only == end)) {
            self.see(space, root, end, Via::Outside);
        }
        let at = space.point(vertex);
        let [right, left] = ends.map(|end| space.point(end));
        let [beside_right, beside_left] =
            [(right, true), (left, false)].map(|(towards, is_left)| HalfPlane { towards, is_left });
        for (half_plane, except) in [(beside_right, None), (beside_left, Some(beside_right))] {
            self.keep(root, RegionShape::HalfPlane { half_plane, except });
        }
        let Goal::Points(points) = &self.goal else {
            return Ok(());
        };
        // The outside is a half-turn or wider. It is everything that is not strictly between the
        // two edges, seen from inside.
        let sees = |&goal: &u32| {
            let point = points.points()[goal as usize];
            orient2d(at, right, point) != Orientation::Clockwise
                || orient2d(at, left, point) != Orientation::CounterClockwise
        };
        let seen: Vec<u32> = points.outside.iter().copied().filter(sees).collect();
        self.see_points(&seen, root);
        Ok(())
    }
}

/// Returns whether `b` is between `a` and `c`, which are collinear with it.
fn is_between(a: Point, b: Point, c: Point) -> bool {
    a.lex_cmp(b) == b.lex_cmp(c)
}
