//! How the wave spreads: through triangles, and round vertices.

use super::waiting::Ahead;
use super::*;

/// Triangles that a cone passes at most without a look at how long its ways are now, where it leaves each by one side only. To look takes
/// longer than to pass such a triangle, so it may as well go a little too far.
const TRUST: u32 = 8;

/// In place of a side that another tile has.
const NO_SIDE: u32 = u32::MAX;

/// A side by which a cone leaves a triangle, with its ends as seen on the right and on the left: corners, and where they are.
#[derive(Clone, Copy)]
struct Door {
    side: u32,
    right: (u32, Point),
    left: (u32, Point),
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
    /// A cone enters a triangle.
    pub(super) fn enter(&mut self, ground: Ground<'_>, item: &Item) -> Result<(), String> {
        let root = item.root;
        let cone = Cone {
            root: self.roots[root as usize].point,
            right: item.right,
            left: item.left,
        };
        if item.other.tile == NOWHERE {
            return self.through(ground, root, item.index, cone);
        }
        if item.index >= ground.tile.vertex_count() {
            return Err(format!("there is no vertex {}, but other tiles have it", item.index));
        }
        match side_towards(ground.tile, item.index, item.other)? {
            Some(side) if ground.is_free(side / 3) => {
                let ends = [side, next(side)].map(|side| ground.point(ground.tile.origin(side)));
                if seam_between(ends) != item.seam {
                    return Err(format!("an end of side {side} lies elsewhere for other tiles"));
                }
                ground.check_crossing(side, ends)?;
                self.through(ground, root, side, cone)
            }
            None if self.outside_is_free => {
                let edge = ground.first(item.index)?;
                let edge = [edge, next(edge)].map(|side| ground.point(ground.tile.origin(side)));
                self.see_outside(root, edge, &cone);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// Pushes a cone through the free triangle of a side, and on as long as nothing else is nearer.
    pub(super) fn through(&mut self, ground: Ground<'_>, root: u32, side: u32, cone: Cone) -> Result<(), String> {
        let (tile, passages) = (ground.tile.id(), ground.passages());
        let end = |side: u32| {
            let corner = passages.corner(side);
            (corner, ground.point(corner))
        };
        let (mut side, mut cone) = (side, cone);
        let [mut right, mut left] = [next(side), side].map(end);
        let mut stride = Stride::default();
        loop {
            self.pause = self.pause.saturating_sub(1);
            let apex = end(previous(side));
            let point = apex.1;
            let corners = [left.1, right.1, point];
            self.see_places_within(root, corners, &cone);
            let between = Some([cone.right, cone.left]);
            self.keep(root, Shape::Triangle { corners, between });
            let to_right = Door {
                side: next(side),
                right,
                left: apex,
            };
            let to_left = Door {
                side: previous(side),
                right: apex,
                left,
            };
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
                        self.see_by(ground, root, apex.0, previous(side));
                        let [mut one, mut other] = [None, None];
                        let halves = [Cone { left: point, ..cone }, Cone { right: point, ..cone }];
                        // A cone between two equal rays shows nothing that its neighbours do not.
                        if on_right != Orientation::Collinear {
                            one = self.look(passages, root, &to_right, &halves[0])?;
                        }
                        if on_left != Orientation::Collinear {
                            other = self.look(passages, root, &to_left, &halves[1])?;
                        }
                        match (one, other) {
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
                        }
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

    /// Looks over the only side by which a cone leaves a triangle, but not each time.
    #[inline]
    fn look_or_trust(
        &mut self,
        passages: Passages<'_>,
        root: u32,
        door: &Door,
        cone: &Cone,
        stride: &mut Stride,
    ) -> Result<Option<Ahead>, String> {
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
    fn look(&mut self, passages: Passages<'_>, root: u32, door: &Door, cone: &Cone) -> Result<Option<Ahead>, String> {
        let [(right_corner, right), (left_corner, left)] = [door.right, door.left];
        let entered = match passages.beyond(door.side) {
            Passage::Side(side) => side,
            Passage::Blocked => return Ok(None),
            Passage::DeadEnd(side) if self.is_all_wanted() || self.here.may_enter(side / 3) => side,
            Passage::DeadEnd(_) => return Ok(None),
            Passage::Outside => {
                self.see_outside(root, [right, left], cone);
                return Ok(None);
            }
            Passage::Elsewhere => NO_SIDE,
            Passage::AtOdds => return Err(at_odds(door.side)),
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
        if entered != NO_SIDE {
            return Ok(Some(Ahead { length, side: entered }));
        }
        // Across, the side runs from the one's end to the other's start.
        let [from, to] = passages.ground().tile.ends(door.side).map(|end| end.id);
        let item = Item {
            kind: Kind::Cone,
            tile: from.tile,
            index: from.index,
            other: to,
            root,
            right: cone.right,
            left: cone.left,
            seam: seam_between([left, right]),
        };
        self.push(length, item);
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
        over: u32,
        cone: Cone,
        ends: [Point; 2],
    ) -> Result<(), String> {
        let passages = ground.passages();
        let [from, to] = [over, next(over)].map(|side| passages.corner(side));
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

    /// A vertex is seen from a root by way of the triangle of a side that leaves it.
    pub(super) fn see_by(&mut self, ground: Ground<'_>, root: u32, corner: u32, side: u32) {
        let via = if corner < ground.tile.vertex_count() {
            Via::Side(side)
        } else {
            Via::RightOf(ground.tile.vertex(ground.tile.origin(previous(side))).id)
        };
        self.see(ground, root, corner, via);
    }

    /// A vertex is seen from a root.
    pub(super) fn see(&mut self, ground: Ground<'_>, root: u32, corner: u32, via: Via) {
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
        let is_own = corner < ground.tile.vertex_count();
        let own_marks = is_own.then(|| ground.marks().of_vertices[corner as usize]);
        let length = from.length + distance(from.point, point);
        if let Some(marks) = own_marks {
            if marks & SINGLE != 0 && !self.here.reach(corner, length) {
                return;
            }
            if !self.is_told_of(marks) && (marks & TURNING == 0 || !ground.can_turn(from.point, corner)) {
                return;
            }
        }
        let id = ground.tile.vertex(corner).id;
        // Of a vertex of this tile that has one free sector it is known by now that no way to it was shorter.
        let is_known = own_marks.is_some_and(|marks| marks & SINGLE != 0);
        if !is_known && let Some(seen) = self.seen.get_mut(&id) {
            let marks = own_marks.or(seen.marks);
            if length > seen.limit * TIE {
                return;
            }
            if let Some(marks) = marks {
                if marks & SINGLE != 0 {
                    seen.limit = seen.limit.min(length);
                }
                if marks & TURNING == 0 && !self.is_told_of(marks) {
                    return;
                }
            }
        }
        let ahead = self.towards.map_or(0.0, |goal| distance(point, goal));
        let item = Item {
            kind: Kind::Vertex,
            tile: id.tile,
            index: id.index,
            other: via.to_vertex(),
            root,
            right: point,
            left: Point::new(length, 0.0),
            seam: 0,
        };
        self.push(length + ahead, item);
    }

    /// A vertex is the nearest thing to do.
    pub(super) fn reach(&mut self, ground: Ground<'_>, item: &Item) -> Result<(), String> {
        let (vertex, length) = (item.index, item.left.x);
        let Some(&marks) = ground.marks().of_vertices.get(vertex as usize) else {
            return Err(format!("there is no vertex {vertex}, but other tiles have it"));
        };
        let id = ground.tile.vertex(vertex).id;
        let seen = self.seen.entry(id).or_default();
        seen.marks = Some(marks);
        if length > seen.limit * TIE || marks & SINGLE != 0 && self.here.is_nearer(vertex, length) {
            return Ok(());
        }
        if length < seen.told {
            seen.told = length;
            self.tell_vertex(ground, vertex, length, item.root);
        }
        if marks & TURNING == 0 {
            return Ok(());
        }
        let wedge = match Via::from_vertex(item.other) {
            Via::Side(side) => Wedge::Triangle(side),
            Via::Outside => Wedge::Outside,
            Via::RightOf(to) => match side_towards(ground.tile, vertex, to)? {
                Some(back) => Wedge::Triangle(next(back)),
                None => return Err(format!("vertex {vertex} lacks a triangle that other tiles have")),
            },
        };
        if marks & SINGLE == 0 && !ground.sector_turns(vertex, wedge)? {
            return Ok(());
        }
        let seen = self.seen.entry(id).or_default();
        let mut root = seen.root;
        // Whatever came from a longer way is superseded.
        if root == NO_ROOT || length < self.roots[root as usize].length {
            root = self.roots.len() as u32;
            (seen.root, seen.limit) = (root, length);
            self.roots.push(Root {
                point: item.right,
                vertex: Some(id),
                length,
                parent: item.root,
                done: [0; 2],
            });
        }
        let from = self.roots[item.root as usize].point;
        for leftwards in [true, false] {
            self.spread_round(ground, root, vertex, from, wedge, leftwards)?;
        }
        Ok(())
    }

    /// Whoever comes to a root from a point, in a wedge, can turn round what is on the left, or on the right, and sees what is there.
    fn spread_round(
        &mut self,
        ground: Ground<'_>,
        root: u32,
        vertex: u32,
        from: Point,
        start: Wedge,
        leftwards: bool,
    ) -> Result<(), String> {
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
            let next = if leftwards {
                ground.left_of(vertex, wedge)?
            } else {
                ground.right_of(vertex, wedge)?
            };
            match next {
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
            self.see_places_in(ground, root, side / 3);
            self.see_by(ground, root, far, if leftwards { previous(side) } else { next(side) });
            let [right, left] = [next(side), previous(side)].map(|side| ground.point(ground.tile.origin(side)));
            let cone = Cone { root: at, right, left };
            self.pass(ground, root, next(side), cone, [right, left])?;
        }
        Ok(())
    }

    /// A root at a hull vertex sees its neighbours along the hull, or one of them, and the places before it.
    pub(super) fn spread_outside(
        &mut self,
        ground: Ground<'_>,
        root: u32,
        vertex: u32,
        only: Option<u32>,
    ) -> Result<(), String> {
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
    pub(super) fn see_places_in(&mut self, ground: Ground<'_>, root: u32, triangle: u32) {
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
    fn see_places_within(&mut self, root: u32, corners: [Point; 3], cone: &Cone) {
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
}

/// Whether of three points on a line the second lies between the others.
fn is_between(a: Point, b: Point, c: Point) -> bool {
    a.lex_cmp(b) == b.lex_cmp(c)
}

/// What is wrong with a side of a damaged tile.
fn at_odds(side: u32) -> String {
    format!(
        "triangle {} does not lie beside what it is said to lie beside",
        side / 3
    )
}
