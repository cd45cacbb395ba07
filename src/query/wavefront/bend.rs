//! How the wave bends round vertices.

use super::cone::Cone;
use super::goal::Goal;
use super::parts::{Shape, Side};
use super::roots::{Root, TIE};
use super::task::Via;
use super::wave::Wave;
use crate::geometry::{Orientation, Point, VertexIndex, orient2d};
use crate::query::free_space::{Ground, Wedge};
use crate::query::request::Contradiction;

impl Wave {
    /// A vertex is the nearest thing to do.
    pub(super) fn reach(
        &mut self,
        ground: Ground<'_>,
        vertex: VertexIndex,
        point: Point,
        before: u32,
        length: f64,
        via: Via,
    ) -> Result<(), Contradiction> {
        let mark = ground.mark(vertex).ok_or(Contradiction::NoVertex(vertex))?;
        let id = ground.tile.vertex(vertex).id;
        let seen = self.seen.entry(id).or_default();
        seen.mark = Some(mark);
        if length > seen.limit * TIE || mark.is_single() && self.here.is_nearer(vertex, length) {
            return Ok(());
        }
        if length < seen.told {
            seen.told = length;
            self.tell_vertex(ground, vertex, length, before);
        }
        if !mark.turns() {
            return Ok(());
        }
        let wedge = match via {
            Via::Side(side) => Wedge::Triangle(side),
            Via::Outside => Wedge::Outside,
            Via::RightOf(to) => {
                let wedge = ground.right_of_edge(vertex, to)?;
                wedge.ok_or(Contradiction::LacksTriangle(vertex))?
            }
        };
        if !mark.is_single() && !ground.sector_turns(vertex, wedge)? {
            return Ok(());
        }
        let seen = self.seen.entry(id).or_default();
        // Whatever came from a longer way is superseded.
        let known = seen.root.filter(|&root| length >= self.roots[root as usize].length);
        let root = known.unwrap_or_else(|| {
            let root = self.roots.len() as u32;
            (seen.root, seen.limit) = (Some(root), length);
            self.roots.push(Root {
                point,
                vertex: Some(id),
                length,
                parent: Some(before),
                done: [0; 2],
            });
            root
        });
        let from = self.roots[before as usize].point;
        for leftwards in [true, false] {
            self.spread_round(ground, root, vertex, from, wedge, leftwards)?;
        }
        Ok(())
    }

    /// Whoever comes to a root from a point, in a wedge, can turn round what is on the left, or on the right, and sees what is there.
    pub(super) fn spread_round(
        &mut self,
        ground: Ground<'_>,
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
        for _ in 0..=ground.tile.triangle_count() {
            let far = ground.neighbours(vertex, wedge)?[usize::from(leftwards)];
            // Beyond the ray from the point: the outside is never narrower than a half-turn.
            let is_whole_outside = wedge == Wedge::Outside && wedge != start;
            if !is_beyond {
                let there = ground.point(far);
                is_beyond = match orient2d(from, at, there) {
                    _ if is_whole_outside => true,
                    Orientation::Collinear => is_between(from, at, there),
                    found => found == turn,
                };
            }
            if is_beyond {
                wedges.push((wedge, far));
            }
            match ground.beside(vertex, wedge, leftwards)? {
                Some(next) if next != start => wedge = next,
                _ => break,
            }
        }
        // What another way to the root, equally long, has done is done.
        let done = &mut self.roots[root as usize].done[usize::from(leftwards)];
        let new = wedges.len().saturating_sub(*done as usize);
        *done = (*done).max(wedges.len() as u32);
        for &(wedge, far) in &wedges[..new] {
            let Wedge::Triangle(side) = wedge else {
                self.spread_outside(ground, root, vertex, Some(far))?;
                continue;
            };
            self.see_places_in(ground, root, side.triangle());
            self.see_by(ground, root, far, if leftwards { side.prev() } else { side.next() });
            let [right, left] = [side.next(), side.prev()].map(|side| ground.point(ground.tile.origin(side)));
            let cone = Cone { root: at, right, left };
            self.pass(ground, root, side.next(), cone, [right, left])?;
        }
        Ok(())
    }

    /// A root at a hull vertex sees its neighbours along the hull, or one of them, and the places before it.
    pub(super) fn spread_outside(
        &mut self,
        ground: Ground<'_>,
        root: u32,
        vertex: VertexIndex,
        only: Option<VertexIndex>,
    ) -> Result<(), Contradiction> {
        let ends = ground.neighbours(vertex, Wedge::Outside)?;
        for end in ends.into_iter().filter(|&end| only.is_none_or(|only| only == end)) {
            self.see(ground, root, end, Via::Outside);
        }
        let at = ground.point(vertex);
        let [right, left] = ends.map(|end| ground.point(end));
        let [beside_right, beside_left] =
            [(right, true), (left, false)].map(|(towards, is_left)| Side { towards, is_left });
        for (side, except) in [(beside_right, None), (beside_left, Some(beside_right))] {
            self.keep(root, Shape::Half { side, except });
        }
        let Goal::Places(places) = &self.goal else {
            return Ok(());
        };
        // The outside is wider than a half-turn, or one: what is not strictly between the edges, seen from inside.
        let sees = |&goal: &u32| {
            let point = places.points()[goal as usize];
            orient2d(at, right, point) != Orientation::Clockwise
                || orient2d(at, left, point) != Orientation::CounterClockwise
        };
        let seen: Vec<u32> = places.outside.iter().copied().filter(sees).collect();
        self.see_places(&seen, root);
        Ok(())
    }
}

/// Whether of three points on a line the second lies between the others.
fn is_between(a: Point, b: Point, c: Point) -> bool {
    a.lex_cmp(b) == b.lex_cmp(c)
}
