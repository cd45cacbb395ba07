//! What a root of the wave sees: vertices, and places.

use super::cone::Cone;
use super::found::What;
use super::goal::Goal;
use super::parts::{Shape, Side};
use super::roots::TIE;
use super::task::{Task, Via};
use super::wave::Wave;
use crate::geometry::{HalfEdge, Orientation, Point, TriangleId, VertexIndex, orient2d};
use crate::query::answer::distance;
use crate::query::free_space::{Ground, Mark};

impl Wave {
    /// A vertex is seen from a root by way of the triangle of a side that leaves it.
    pub(super) fn see_by(&mut self, ground: Ground<'_>, root: u32, corner: VertexIndex, side: HalfEdge) {
        let via = if ground.tile.has_vertex(corner) {
            Via::Side(side)
        } else {
            Via::RightOf(ground.tile.vertex(ground.tile.origin(side.prev())).id)
        };
        self.see(ground, root, corner, via);
    }

    /// A vertex is seen from a root.
    pub(super) fn see(&mut self, ground: Ground<'_>, root: u32, corner: VertexIndex, via: Via) {
        let from = self.roots[root as usize];
        let point = ground.point(corner);
        if point == from.point {
            return;
        }
        if let Goal::Places(places) = &self.goal {
            let here: Vec<u32> = places.on_vertex(point).collect();
            for goal in here {
                self.see_place(goal, point, root);
            }
        }
        // None if it is another tile's.
        let own_mark = ground.mark(corner);
        let length = from.length + distance(from.point, point);
        if let Some(mark) = own_mark {
            if mark.is_single() && !self.here.reach(corner, length) {
                return;
            }
            if !self.is_told_of(mark) && (!mark.turns() || !ground.can_turn(from.point, corner)) {
                return;
            }
        }
        let id = ground.tile.vertex(corner).id;
        // Of a vertex of this tile that has one free sector it is known by now that no way to it was shorter.
        let is_known = own_mark.is_some_and(Mark::is_single);
        if !is_known && let Some(seen) = self.seen.get_mut(&id) {
            let mark = own_mark.or(seen.mark);
            if length > seen.limit * TIE {
                return;
            }
            if let Some(mark) = mark {
                if mark.is_single() {
                    seen.limit = seen.limit.min(length);
                }
                if !mark.turns() && !self.is_told_of(mark) {
                    return;
                }
            }
        }
        let ahead = self.towards.map_or(0.0, |goal| distance(point, goal));
        let task = Task::Vertex {
            vertex: id.index,
            point,
            root,
            length,
            via,
        };
        self.push(length + ahead, Some(id.tile), task);
    }

    /// What lies outside the hull and is seen over a hull edge, ends as seen on the right and on the left.
    pub(super) fn see_outside(&mut self, root: u32, edge: [Point; 2], cone: &Cone) {
        let between = [cone.right, cone.left];
        self.keep(root, Shape::Beyond { edge, between });
        let Goal::Places(places) = &self.goal else { return };
        if places.outside.is_empty() {
            return;
        }
        let seen = places.outside_within(cone.root, cone.right, cone.left);
        let seen: Vec<u32> = seen.collect();
        self.see_places(&seen, root);
    }

    /// What lies outside the hull, on one side of the line from the source through a point.
    pub(super) fn see_half(&mut self, towards: Point, is_left: bool) {
        let side = Side { towards, is_left };
        let except = self.beside.replace(side);
        self.keep(0, Shape::Half { side, except });
        let Goal::Places(places) = &self.goal else { return };
        let hidden = if is_left {
            Orientation::Clockwise
        } else {
            Orientation::CounterClockwise
        };
        let is_seen = |&goal: &u32| orient2d(self.source, towards, places.points()[goal as usize]) != hidden;
        let seen: Vec<u32> = places.outside.iter().copied().filter(is_seen).collect();
        self.see_places(&seen, 0);
    }

    pub(super) fn see_places(&mut self, seen: &[u32], root: u32) {
        for &goal in seen {
            let Goal::Places(places) = &self.goal else { return };
            let point = places.points()[goal as usize];
            self.see_place(goal, point, root);
        }
    }

    /// The places in a closed triangle that a root sees whole.
    pub(super) fn see_places_in(&mut self, ground: Ground<'_>, root: u32, triangle: TriangleId) {
        if self.parts.is_some() {
            let corners = ground.tile.triangle_points(triangle);
            self.keep(root, Shape::Triangle { corners, between: None });
        }
        let Goal::Places(places) = &self.goal else { return };
        let mut found = Vec::new();
        places.in_triangle(ground.tile.triangle_points(triangle), |goal, _| found.push(goal));
        self.see_places(&found, root);
    }

    /// The places in a closed triangle that a cone holds.
    pub(super) fn see_places_within(&mut self, root: u32, corners: [Point; 3], cone: &Cone) {
        let Goal::Places(places) = &self.goal else { return };
        let mut found = Vec::new();
        places.in_triangle(corners, |goal, point| {
            let is_within = orient2d(cone.root, cone.right, point) != Orientation::Clockwise
                && orient2d(cone.root, cone.left, point) != Orientation::CounterClockwise;
            if is_within {
                found.push(goal);
            }
        });
        self.see_places(&found, root);
    }

    /// A place is seen from a root.
    pub(super) fn see_place(&mut self, goal: u32, point: Point, root: u32) {
        let from = &self.roots[root as usize];
        let length = from.length + distance(from.point, point);
        self.push(length, None, Task::Goal { goal, root, length });
    }

    /// A vertex of the file was reached: tells of it, once.
    pub(super) fn tell_vertex(&mut self, ground: Ground<'_>, index: VertexIndex, length: f64, root: u32) {
        let vertex = ground.tile.vertex(index);
        match self.goal {
            Goal::Sites => {
                for site in ground.tile.sites_at(index) {
                    let what = What::Site {
                        number: site.number,
                        id: site.id.map(str::to_owned),
                        vertex,
                    };
                    self.tell(what, site.number, length, root);
                }
            }
            Goal::Vertices => {
                let number = u64::from(vertex.id.tile.0) << 32 | u64::from(index.0);
                self.tell(What::Vertex(vertex), number, length, root);
            }
            Goal::Places(_) => {}
        }
    }

    /// Places outside that the source sees before a hull edge.
    pub(super) fn see_before_hull(&mut self, right: Point, left: Point) {
        let corners = [self.source, right, left];
        self.keep(0, Shape::Triangle { corners, between: None });
        let Goal::Places(places) = &self.goal else { return };
        let within = places.outside_within(self.source, right, left);
        let before = within.filter(|&goal| {
            let point = places.points()[goal as usize];
            orient2d(left, right, point) != Orientation::CounterClockwise
        });
        let before: Vec<u32> = before.collect();
        self.see_places(&before, 0);
    }
}
