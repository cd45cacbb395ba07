//! The goals towards which a wavefront is directed.
//!
//! The wavefront is directed by a lower bound of the rest of the way: that of the goal for which it
//! is least.

use super::window::{Crossing, minus};
use crate::geometry::Point;

/// The goals towards which a wavefront is directed, as far as they were not found yet. There are
/// none if it is not directed.
#[derive(Clone, Debug, Default)]
pub(super) struct Aims {
    goals: Vec<(u32, Point)>,
}

impl Aims {
    pub(super) fn new(points: &[Point]) -> Self {
        Self {
            goals: (0..).zip(points.iter().copied()).collect(),
        }
    }

    /// Returns whether the wavefront is not directed.
    pub(super) fn is_empty(&self) -> bool {
        self.goals.is_empty()
    }

    /// Returns whether the wavefront is directed towards one goal.
    pub(super) fn is_one(&self) -> bool {
        self.goals.len() == 1
    }

    /// Directs the wavefront towards the other goals only, if there are others.
    pub(super) fn forget(&mut self, found: u32) {
        if self.goals.len() > 1 {
            self.goals.retain(|&(goal, _)| goal != found);
        }
    }

    /// Returns a lower bound of the way from a point to a goal.
    #[inline]
    pub(super) fn from(&self, point: Point) -> f64 {
        let squares = self.goals.iter().map(|&(_, goal)| square(minus(goal, point)));
        match self.goals.is_empty() {
            true => 0.0,
            false => squares.fold(f64::INFINITY, f64::min).sqrt(),
        }
    }

    /// Returns a lower bound of the way from a root through a crossing to a goal, or to the
    /// crossing if the wavefront is not directed.
    #[inline]
    pub(super) fn beyond(&mut self, crossing: &Crossing, root: Point) -> f64 {
        match self.goals[..] {
            [] => crossing.length_to_edge(),
            [(_, goal)] => crossing.length_to_goal(minus(goal, root)),
            ref mut goals => nearest_beyond(goals, crossing, root),
        }
    }
}

/// Returns the least lower bound of the goals, and puts its goal first: most likely, it is also the
/// best for the next crossing.
fn nearest_beyond(goals: &mut [(u32, Point)], crossing: &Crossing, root: Point) -> f64 {
    let (mut least, mut best) = (f64::INFINITY, 0);
    // A goal that is farther than this, as the crow flies, is not better.
    let mut enough = f64::INFINITY;
    for (index, &(_, goal)) in goals.iter().enumerate() {
        let goal = minus(goal, root);
        if square(goal) > enough {
            continue;
        }
        let length = crossing.length_to_goal(goal);
        if length < least {
            (least, best) = (length, index);
            let farthest = (length + crossing.slack) * (1.0 + 1e-12);
            enough = farthest * farthest;
        }
    }
    goals.swap(0, best);
    least
}

#[inline]
fn square(p: Point) -> f64 {
    p.x * p.x + p.y * p.y
}
