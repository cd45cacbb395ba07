//! How the wave spreads through triangles.

use super::cone::{Cone, minus};
use super::goal::Goal;
use super::parts::Shape;
use super::task::{Task, seam_between};
use super::waiting::Ahead;
use super::wave::Wave;
use crate::geometry::{HalfEdge, Orientation, Point, VertexIndex, orient2d};
use crate::query::free_space::{Ground, Passage, Passages};
use crate::query::request::{Contradiction, side_towards};
use crate::store::VertexId;

/// Triangles that a cone passes at most without a look at how long its ways are now, where it leaves each by one side only. To look takes
/// longer than to pass such a triangle, so it may as well go a little too far.
const TRUST: u32 = 8;

/// A side by which a cone leaves a triangle, with its ends as seen on the right and on the left: corners, and where they are.
#[derive(Clone, Copy)]
struct Door {
    side: HalfEdge,
    right: (VertexIndex, Point),
    left: (VertexIndex, Point),
}

/// The sides by which a cone leaves the triangle of the side by which it came: that on its right, and that on its left.
#[inline]
fn doors(
    entered: HalfEdge,
    right: (VertexIndex, Point),
    left: (VertexIndex, Point),
    apex: (VertexIndex, Point),
) -> [Door; 2] {
    let [to_right, to_left] = [(entered.next(), right, apex), (entered.prev(), apex, left)];
    [to_right, to_left].map(|(side, right, left)| Door { side, right, left })
}

/// How far a cone went on.
#[derive(Clone, Copy, Default)]
struct Stride {
    /// What its ways had at least when there was a look.
    length: f64,
    /// Triangles that it may still pass without one.
    trust: u32,
}

impl Wave {
    /// The cone of a root between the rays through two points.
    #[inline]
    pub(super) fn cone(&self, root: u32, right: Point, left: Point) -> Cone {
        let root = self.roots[root as usize].point;
        Cone { root, right, left }
    }

    /// A cone enters the triangle of the side that comes from one vertex to another one, of the tile.
    pub(super) fn enter(
        &mut self,
        ground: Ground<'_>,
        vertex: VertexIndex,
        from: VertexId,
        root: u32,
        cone: Cone,
        seam: u64,
    ) -> Result<(), Contradiction> {
        if !ground.tile.has_vertex(vertex) {
            return Err(Contradiction::NoVertex(vertex));
        }
        match side_towards(ground.tile, vertex, from)? {
            Some(side) if ground.is_free(side.triangle()) => {
                let ends = [side, side.next()].map(|side| ground.point(ground.tile.origin(side)));
                if seam_between(ends) != seam {
                    return Err(Contradiction::EndElsewhere(side.0));
                }
                ground.check_crossing(side, ends)?;
                self.through(ground, root, side, cone)
            }
            None if self.outside_is_free => {
                let edge = ground.first(vertex)?;
                let edge = [edge, edge.next()].map(|side| ground.point(ground.tile.origin(side)));
                self.see_outside(root, edge, &cone);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// Pushes a cone through the free triangle of a side, and on as long as nothing else is nearer.
    pub(super) fn through(
        &mut self,
        ground: Ground<'_>,
        root: u32,
        side: HalfEdge,
        cone: Cone,
    ) -> Result<(), Contradiction> {
        let (tile, passages) = (ground.tile.id(), ground.passages());
        let end = |side: HalfEdge| {
            let corner = passages.corner(side);
            (corner, ground.point(corner))
        };
        let (mut side, mut cone) = (side, cone);
        let [mut right, mut left] = [side.next(), side].map(end);
        let mut stride = Stride::default();
        loop {
            self.pause = self.pause.saturating_sub(1);
            let apex = end(side.prev());
            let point = apex.1;
            let corners = [left.1, right.1, point];
            self.see_places_within(root, corners, &cone);
            let between = Some([cone.right, cone.left]);
            self.keep(root, Shape::Triangle { corners, between });
            let [to_right, to_left] = doors(side, right, left, apex);
            let on_right = orient2d(cone.root, cone.right, point);
            let best = if on_right == Orientation::Clockwise {
                let ahead = self.look_or_trust(passages, root, &to_left, &cone, &mut stride)?;
                ahead.map(|ahead| (ahead, to_left, cone))
            } else {
                match orient2d(cone.root, cone.left, point) {
                    Orientation::CounterClockwise => {
                        let ahead = self.look_or_trust(passages, root, &to_right, &cone, &mut stride)?;
                        ahead.map(|ahead| (ahead, to_right, cone))
                    }
                    on_left => {
                        stride.trust = TRUST;
                        self.see_by(ground, root, apex.0, side.prev());
                        self.part(passages, root, [to_right, to_left], cone, [on_right, on_left])?
                    }
                }
            };
            let Some((mut ahead, door, mut narrow)) = best else {
                return Ok(());
            };
            if self.joins {
                self.join(tile, root, &mut ahead, &mut narrow);
            }
            if self.pause == 0 || !self.queue.would_be_next(ahead.length) {
                self.wait(tile, root, ahead, &narrow);
                return Ok(());
            }
            (side, cone, stride.length) = (ahead.side, narrow, ahead.length);
            (right, left) = (door.right, door.left);
        }
    }

    /// A vertex in a cone parts it in two, which leave the triangle by a side each: goes on with the one whose ways have less, and puts off
    /// the other. `turns` tell where the vertex lies, seen from the root past the right and the left of the cone.
    #[inline]
    fn part(
        &mut self,
        passages: Passages<'_>,
        root: u32,
        doors: [Door; 2],
        cone: Cone,
        turns: [Orientation; 2],
    ) -> Result<Option<(Ahead, Door, Cone)>, Contradiction> {
        let [to_right, to_left] = doors;
        let point = to_right.left.1;
        let halves = [Cone { left: point, ..cone }, Cone { right: point, ..cone }];
        let [mut one, mut other] = [None, None];
        // A cone between two equal rays shows nothing that its neighbours do not.
        if turns[0] != Orientation::Collinear {
            one = self.look(passages, root, &to_right, &halves[0])?;
        }
        if turns[1] != Orientation::Collinear {
            other = self.look(passages, root, &to_left, &halves[1])?;
        }
        let tile = passages.ground().tile.id();
        Ok(match (one, other) {
            (Some(one), Some(other)) if one.length <= other.length => {
                self.put_off(tile, root, other, &halves[1]);
                Some((one, to_right, halves[0]))
            }
            (Some(one), Some(other)) => {
                self.put_off(tile, root, one, &halves[0]);
                Some((other, to_left, halves[1]))
            }
            (Some(one), None) => Some((one, to_right, halves[0])),
            (None, Some(other)) => Some((other, to_left, halves[1])),
            (None, None) => None,
        })
    }

    /// Looks over the only side by which a cone leaves a triangle, but not each time.
    #[inline]
    fn look_or_trust(
        &mut self,
        passages: Passages<'_>,
        root: u32,
        door: &Door,
        cone: &Cone,
        stride: &mut Stride,
    ) -> Result<Option<Ahead>, Contradiction> {
        if stride.trust > 0
            && !self.joins
            && let Passage::Side(side) = passages.beyond(door.side)
        {
            stride.trust -= 1;
            let length = stride.length;
            return Ok(Some(Ahead { length, side }));
        }
        stride.trust = TRUST;
        self.look(passages, root, door, cone)
    }

    /// Looks over a side out of its triangle: if there is a free triangle of this tile where a cone may show what no other one does, the way
    /// on there. If it is another tile's, it waits in the queue.
    #[inline]
    fn look(
        &mut self,
        passages: Passages<'_>,
        root: u32,
        door: &Door,
        cone: &Cone,
    ) -> Result<Option<Ahead>, Contradiction> {
        let [(right_corner, right), (left_corner, left)] = [door.right, door.left];
        let entered = match passages.beyond(door.side) {
            Passage::Side(side) => Some(side),
            Passage::Blocked => return Ok(None),
            Passage::DeadEnd(side) if self.is_all_wanted() || self.here.may_enter(side.triangle()) => Some(side),
            Passage::DeadEnd(_) => return Ok(None),
            Passage::Outside => {
                self.see_outside(root, [right, left], cone);
                return Ok(None);
            }
            Passage::Elsewhere => None,
            Passage::AtOdds => return Err(Contradiction::NotBeside(door.side.triangle())),
        };
        let crossing = cone.crossing(right, left);
        let way = self.roots[root as usize].length;
        if self.here.beats(way, &crossing, [right_corner, left_corner]) {
            return Ok(None);
        }
        let length = way + crossing.estimate(self.towards.map(|goal| minus(goal, cone.root)));
        if length > self.limit {
            return Ok(None);
        }
        if let Some(side) = entered {
            return Ok(Some(Ahead { length, side }));
        }
        // Across, the side runs from the one's end to the other's start.
        let [from, to] = passages.ground().tile.ends(door.side).map(|end| end.id);
        let task = Task::ConeOver {
            vertex: from.index,
            from: to,
            root,
            right: cone.right,
            left: cone.left,
            seam: seam_between([left, right]),
        };
        self.push(length, Some(from.tile), task);
        Ok(None)
    }

    /// Whether what lies in dead ends is wanted too.
    fn is_all_wanted(&self) -> bool {
        self.parts.is_some() || matches!(self.goal, Goal::Vertices)
    }

    /// The cone over a side out of its triangle waits in the queue.
    pub(super) fn pass(
        &mut self,
        ground: Ground<'_>,
        root: u32,
        over: HalfEdge,
        cone: Cone,
        ends: [Point; 2],
    ) -> Result<(), Contradiction> {
        let passages = ground.passages();
        let [from, to] = [over, over.next()].map(|side| passages.corner(side));
        let door = Door {
            side: over,
            right: (from, ends[0]),
            left: (to, ends[1]),
        };
        if let Some(ahead) = self.look(passages, root, &door, &cone)? {
            self.put_off(ground.tile.id(), root, ahead, &cone);
        }
        Ok(())
    }
}
