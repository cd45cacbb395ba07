//! How the wavefront spreads through triangles.

use super::goal::Goal;
use super::state::Wavefront;
use super::task::{Task, seam_between};
use super::waiting::{Ahead, WaitingKey};
use super::whole::Part;
use super::window::Window;
use crate::geometry::{HalfEdge, Orientation, Point, VertexIndex, orient2d};
use crate::query::free_space::{FreeSpace, Passage, Passages};
use crate::query::request::{Contradiction, half_edge_towards};
use crate::store::VertexId;

/// The maximum number of triangles that a window passes without computing its length again, if it
/// leaves each of them by one edge only. The computation takes longer than passing such a triangle,
/// so going a little too far is cheaper.
const TRUST: u32 = 8;

/// A half-edge by which a window leaves a triangle, with its ends as seen on the right and on the
/// left: corner and position of each.
#[derive(Clone, Copy)]
struct ExitEdge {
    half_edge: HalfEdge,
    right: (VertexIndex, Point),
    left: (VertexIndex, Point),
}

/// Returns the half-edges by which a window leaves the triangle that it entered by `entered`: the
/// one on its right, then the one on its left.
#[inline]
fn exits(
    entered: HalfEdge,
    right: (VertexIndex, Point),
    left: (VertexIndex, Point),
    apex: (VertexIndex, Point),
) -> [ExitEdge; 2] {
    let [to_right, to_left] = [(entered.next(), right, apex), (entered.prev(), apex, left)];
    [to_right, to_left].map(|(half_edge, right, left)| ExitEdge { half_edge, right, left })
}

/// The advance of a window since its length was computed.
#[derive(Clone, Copy, Default)]
struct Stride {
    /// The lower bound of the lengths of its paths, as last computed.
    length: f64,
    /// The number of triangles that it may still pass without computing the bound again.
    trust: u32,
}

impl Wavefront {
    /// Returns the window of a root between the rays through two points.
    #[inline]
    pub(super) fn window(&self, root: u32, right: Point, left: Point) -> Window {
        let root = self.roots[root as usize].point;
        Window { root, right, left }
    }

    /// Lets a window enter the triangle of the half-edge from `from` to `vertex`, a vertex of the
    /// tile.
    pub(super) fn enter(
        &mut self,
        space: FreeSpace<'_>,
        vertex: VertexIndex,
        from: VertexId,
        root: u32,
        window: Window,
        seam: u64,
    ) -> Result<(), Contradiction> {
        if !space.tile.has_vertex(vertex) {
            return Err(Contradiction::NoVertex(vertex));
        }
        match half_edge_towards(space.tile, vertex, from)? {
            Some(half_edge) if space.is_free(half_edge.triangle()) => {
                let ends = [half_edge, half_edge.next()].map(|half_edge| space.point(space.tile.origin(half_edge)));
                if seam_between(ends) != seam {
                    return Err(Contradiction::EndElsewhere(half_edge.0));
                }
                space.check_crossing(half_edge, ends)?;
                self.through(space, root, half_edge, window)
            }
            None if self.outside_is_free => {
                let edge = space.first(vertex)?;
                let edge = [edge, edge.next()].map(|half_edge| space.point(space.tile.origin(half_edge)));
                self.see_outside(root, edge, &window);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// Pushes a window through the free triangle of a half-edge, and on as long as nothing else in
    /// the queue is nearer.
    pub(super) fn through(
        &mut self,
        space: FreeSpace<'_>,
        root: u32,
        half_edge: HalfEdge,
        window: Window,
    ) -> Result<(), Contradiction> {
        let (tile, passages) = (space.tile.id(), space.passages());
        let end = |half_edge: HalfEdge| {
            let corner = passages.corner(half_edge);
            (corner, space.point(corner))
        };
        let (mut half_edge, mut window) = (half_edge, window);
        let [mut right, mut left] = [half_edge.next(), half_edge].map(end);
        let mut stride = Stride::default();
        loop {
            self.pause = self.pause.saturating_sub(1);
            let apex = end(half_edge.prev());
            let point = apex.1;
            let corners = [left.1, right.1, point];
            self.see_points_within(root, corners, &window);
            if self.regions.is_some() {
                let part = Part {
                    triangle: half_edge.triangle(),
                    vertices: [left.0, right.0, apex.0],
                    corners,
                    between: Some([window.right, window.left]),
                };
                self.keep_part(space, root, part);
            }
            let [to_right, to_left] = exits(half_edge, right, left, apex);
            let on_right = orient2d(window.root, window.right, point);
            let best = if on_right == Orientation::Clockwise {
                let ahead = self.look_or_trust(passages, root, &to_left, &window, &mut stride)?;
                ahead.map(|ahead| (ahead, to_left, window))
            } else {
                match orient2d(window.root, window.left, point) {
                    Orientation::CounterClockwise => {
                        let ahead = self.look_or_trust(passages, root, &to_right, &window, &mut stride)?;
                        ahead.map(|ahead| (ahead, to_right, window))
                    }
                    on_left => {
                        stride.trust = TRUST;
                        self.see_by(space, root, apex.0, half_edge.prev());
                        self.split(passages, root, [to_right, to_left], window, [on_right, on_left])?
                    }
                }
            };
            let Some((mut ahead, exit, mut narrow)) = best else {
                return Ok(());
            };
            if self.joins && ahead.is_cut {
                self.join(tile, root, &mut ahead, &mut narrow);
            }
            if self.pause == 0 || !self.queue.would_be_next(ahead.length) {
                self.wait(tile, root, ahead, &narrow);
                return Ok(());
            }
            (half_edge, window, stride.length) = (ahead.half_edge, narrow, ahead.length);
            (right, left) = (exit.right, exit.left);
        }
    }

    /// Splits a window at a vertex inside it, where its two parts leave the triangle by different
    /// edges. Continues with the part whose paths are shorter, and defers the other. `turns` are
    /// the orientations of the vertex, seen from the root, with respect to the right and the left
    /// ray of the window.
    #[inline]
    fn split(
        &mut self,
        passages: Passages<'_>,
        root: u32,
        exits: [ExitEdge; 2],
        window: Window,
        turns: [Orientation; 2],
    ) -> Result<Option<(Ahead, ExitEdge, Window)>, Contradiction> {
        let [to_right, to_left] = exits;
        let point = to_right.left.1;
        let halves = [Window { left: point, ..window }, Window { right: point, ..window }];
        let [mut one, mut other] = [None, None];
        // A window between two equal rays sees nothing that its neighbours do not see.
        if turns[0] != Orientation::Collinear {
            one = self.look(passages, root, &to_right, &halves[0])?;
        }
        if turns[1] != Orientation::Collinear {
            other = self.look(passages, root, &to_left, &halves[1])?;
        }
        let tile = passages.space().tile.id();
        Ok(match (one, other) {
            (Some(one), Some(other)) if one.length <= other.length => {
                self.defer(tile, root, other, &halves[1]);
                Some((one, to_right, halves[0]))
            }
            (Some(one), Some(other)) => {
                self.defer(tile, root, one, &halves[0]);
                Some((other, to_left, halves[1]))
            }
            (Some(one), None) => Some((one, to_right, halves[0])),
            (None, Some(other)) => Some((other, to_left, halves[1])),
            (None, None) => None,
        })
    }

    /// Examines the only half-edge by which a window leaves a triangle, but does not compute its
    /// length each time.
    #[inline]
    fn look_or_trust(
        &mut self,
        passages: Passages<'_>,
        root: u32,
        exit: &ExitEdge,
        window: &Window,
        stride: &mut Stride,
    ) -> Result<Option<Ahead>, Contradiction> {
        if stride.trust > 0
            && !self.joins
            && let Passage::HalfEdge(half_edge) = passages.twin(exit.half_edge)
        {
            stride.trust -= 1;
            let length = stride.length;
            return Ok(Some(Ahead {
                length,
                half_edge,
                is_cut: false,
            }));
        }
        stride.trust = TRUST;
        self.look(passages, root, exit, window)
    }

    /// Examines a half-edge by which a window leaves its triangle. Returns how the window continues
    /// if the triangle beyond is free, belongs to this tile, and may be reached on a shortest path.
    /// If the triangle belongs to another tile, the window is put in the queue.
    #[inline]
    fn look(
        &mut self,
        passages: Passages<'_>,
        root: u32,
        exit: &ExitEdge,
        window: &Window,
    ) -> Result<Option<Ahead>, Contradiction> {
        let [(right_corner, right), (left_corner, left)] = [exit.right, exit.left];
        let entered = match passages.twin(exit.half_edge) {
            Passage::HalfEdge(half_edge) => Some(half_edge),
            Passage::Blocked => return Ok(None),
            Passage::DeadEnd(half_edge) if self.is_all_wanted() || self.here.may_enter(half_edge.triangle()) => {
                Some(half_edge)
            }
            Passage::DeadEnd(_) => return Ok(None),
            Passage::Outside => {
                self.see_outside(root, [right, left], window);
                return Ok(None);
            }
            Passage::Elsewhere => None,
            Passage::Contradictory => return Err(Contradiction::NotBeside(exit.half_edge.triangle())),
        };
        let is_cut = window.right != right || window.left != left;
        if let Some(half_edge) = entered
            && self.joins
            && is_cut
        {
            let tile = passages.space().tile.id();
            self.waiting.expect(WaitingKey::new(tile, root, half_edge));
        }
        let crossing = window.crossing(right, left);
        let way = self.roots[root as usize].length;
        if self.here.beats(way, &crossing, [right_corner, left_corner]) {
            return Ok(None);
        }
        let length = way + self.aims.beyond(&crossing, window.root);
        if length > self.limit {
            return Ok(None);
        }
        if let Some(half_edge) = entered {
            return Ok(Some(Ahead {
                length,
                half_edge,
                is_cut,
            }));
        }
        // The twin runs from the end to the start.
        let [from, to] = passages.space().tile.ends(exit.half_edge).map(|end| end.id);
        let task = Task::IncomingWindow {
            vertex: from.index,
            from: to,
            root,
            right: window.right,
            left: window.left,
            seam: seam_between([left, right]),
        };
        self.push(length, Some(from.tile), task);
        Ok(None)
    }

    /// Returns whether targets in all dead ends are wanted.
    fn is_all_wanted(&self) -> bool {
        self.regions.is_some() || matches!(self.goal, Goal::Vertices)
    }

    /// Puts the window through a half-edge of a triangle in the queue.
    pub(super) fn pass(
        &mut self,
        space: FreeSpace<'_>,
        root: u32,
        over: HalfEdge,
        window: Window,
        ends: [Point; 2],
    ) -> Result<(), Contradiction> {
        let passages = space.passages();
        let [from, to] = [over, over.next()].map(|half_edge| passages.corner(half_edge));
        let exit = ExitEdge {
            half_edge: over,
            right: (from, ends[0]),
            left: (to, ends[1]),
        };
        if let Some(ahead) = self.look(passages, root, &exit, &window)? {
            self.defer(space.tile.id(), root, ahead, &window);
        }
        Ok(())
    }
}
