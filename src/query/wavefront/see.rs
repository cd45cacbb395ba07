//! What a root of the wavefront sees: vertices and query points.

use super::found::Target;
use super::goal::Goal;
use super::regions::{HalfPlane, RegionShape};
use super::roots::TIE;
use super::state::Wavefront;
use super::task::{Task, Via};
use super::whole::Part;
use super::window::Window;
use crate::geometry::{HalfEdge, Orientation, Point, TriangleId, VertexIndex, orient2d};
use crate::query::answer::distance;
use crate::query::free_space::{FreeSpace, Mark};

impl Wavefront {
    /// Lets a root see a vertex through the triangle of a half-edge whose origin is the vertex.
    pub(super) fn see_by(&mut self, space: FreeSpace<'_>, root: u32, corner: VertexIndex, half_edge: HalfEdge) {
        let via = if space.tile.has_vertex(corner) {
            Via::HalfEdge(half_edge)
        } else {
            Via::RightOf(space.tile.vertex(space.tile.origin(half_edge.prev())).id)
        };
        self.see(space, root, corner, via);
    }

    /// Lets a root see a vertex.
    pub(super) fn see(&mut self, space: FreeSpace<'_>, root: u32, corner: VertexIndex, via: Via) {
        let from = self.roots[root as usize];
        let point = space.point(corner);
        if point == from.point {
            return;
        }
        if let Goal::Points(points) = &self.goal {
            let here: Vec<u32> = points.on_vertex(point).collect();
            for goal in here {
                self.see_point(goal, point, root);
            }
        }
        // `None` if the vertex belongs to another tile.
        let own_mark = space.mark(corner);
        let length = from.length + distance(from.point, point);
        if let Some(mark) = own_mark {
            if mark.is_single() && !self.here.reach(corner, length) {
                return;
            }
            if !self.is_reported(mark) && (!mark.turns() || !space.can_turn(from.point, corner)) {
                return;
            }
        }
        let id = space.tile.vertex(corner).id;
        // For a vertex of this tile with one free sector, the test above has shown that no known
        // path is shorter.
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
                if !mark.turns() && !self.is_reported(mark) {
                    return;
                }
            }
        }
        let ahead = self.aims.from(point);
        let task = Task::Vertex {
            vertex: id.index,
            point,
            root,
            length,
            via,
        };
        self.push(length + ahead, Some(id.tile), task);
    }

    /// Lets a root see what is outside the hull, through a hull edge. The ends of the edge are
    /// those seen on the right and on the left.
    pub(super) fn see_outside(&mut self, root: u32, edge: [Point; 2], window: &Window) {
        let between = [window.right, window.left];
        self.keep(root, RegionShape::BehindHullEdge { edge, between });
        let Goal::Points(points) = &self.goal else { return };
        if points.outside.is_empty() {
            return;
        }
        let seen = points.outside_within(window.root, window.right, window.left);
        let seen: Vec<u32> = seen.collect();
        self.see_points(&seen, root);
    }

    /// Lets the source see what is outside the hull, on one side of the line through `towards`.
    pub(super) fn see_half(&mut self, towards: Point, is_left: bool) {
        let half_plane = HalfPlane { towards, is_left };
        let except = self.seen_half_plane.replace(half_plane);
        self.keep(0, RegionShape::HalfPlane { half_plane, except });
        let Goal::Points(points) = &self.goal else { return };
        let hidden = if is_left {
            Orientation::Clockwise
        } else {
            Orientation::CounterClockwise
        };
        let is_seen = |&goal: &u32| orient2d(self.source, towards, points.points()[goal as usize]) != hidden;
        let seen: Vec<u32> = points.outside.iter().copied().filter(is_seen).collect();
        self.see_points(&seen, 0);
    }

    pub(super) fn see_points(&mut self, seen: &[u32], root: u32) {
        for &goal in seen {
            let Goal::Points(points) = &self.goal else { return };
            let point = points.points()[goal as usize];
            self.see_point(goal, point, root);
        }
    }

    /// Lets a root see the query points in a closed triangle, all of which it sees.
    pub(super) fn see_points_in(&mut self, space: FreeSpace<'_>, root: u32, triangle: TriangleId) {
        if self.regions.is_some() {
            let part = Part {
                triangle,
                vertices: HalfEdge::of_triangle(triangle).map(|half_edge| space.tile.origin(half_edge)),
                corners: space.tile.triangle_points(triangle),
                between: None,
            };
            self.keep_part(space, root, part);
        }
        let Goal::Points(points) = &self.goal else { return };
        let mut found = Vec::new();
        points.in_triangle(space.tile.triangle_points(triangle), |goal, _| found.push(goal));
        self.see_points(&found, root);
    }

    /// Lets a root see the query points in the part of a closed triangle that is in a window.
    pub(super) fn see_points_within(&mut self, root: u32, corners: [Point; 3], window: &Window) {
        let Goal::Points(points) = &self.goal else { return };
        let mut found = Vec::new();
        points.in_triangle(corners, |goal, point| {
            let is_within = orient2d(window.root, window.right, point) != Orientation::Clockwise
                && orient2d(window.root, window.left, point) != Orientation::CounterClockwise;
            if is_within {
                found.push(goal);
            }
        });
        self.see_points(&found, root);
    }

    /// Lets a root see a query point.
    pub(super) fn see_point(&mut self, goal: u32, point: Point, root: u32) {
        let from = &self.roots[root as usize];
        let length = from.length + distance(from.point, point);
        self.push(length, None, Task::Goal { goal, root, length });
    }

    /// Reports a vertex of the file, or its sites, once.
    pub(super) fn report_vertex(&mut self, space: FreeSpace<'_>, index: VertexIndex, length: f64, root: u32) {
        let vertex = space.tile.vertex(index);
        match self.goal {
            Goal::Sites => {
                for site in space.tile.sites_at(index) {
                    let target = Target::Site {
                        number: site.number,
                        id: site.id.map(str::to_owned),
                        vertex,
                    };
                    self.report(target, site.number, length, root);
                }
            }
            Goal::Vertices => {
                let number = u64::from(vertex.id.tile.0) << 32 | u64::from(index.0);
                self.report(Target::Vertex(vertex), number, length, root);
            }
            Goal::Points(_) => {}
        }
    }

    /// Lets a source outside see the query points between itself and a hull edge.
    pub(super) fn see_before_hull(&mut self, right: Point, left: Point) {
        let corners = [self.source, right, left];
        self.keep(0, RegionShape::Triangle { corners, between: None });
        let Goal::Points(points) = &self.goal else { return };
        let within = points.outside_within(self.source, right, left);
        let before = within.filter(|&goal| {
            let point = points.points()[goal as usize];
            orient2d(left, right, point) != Orientation::CounterClockwise
        });
        let before: Vec<u32> = before.collect();
        self.see_points(&before, 0);
    }
}
