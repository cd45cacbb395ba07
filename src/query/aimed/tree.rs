//! Targets in a k-d tree, and their division into groups.

use super::cost::{Disc, Expectation, Work};
use crate::geometry::{Point, Rect};
use crate::query::answer::distance;

/// The maximum number of targets in a leaf.
const LEAF: usize = 2;
/// The maximum number of targets that are divided. Of more, a wavefront to all of them finds a
/// target in nearly every triangle that it passes.
const MOST: usize = 1 << 16;

/// Targets of searches, by their indices in a list of points.
#[derive(Debug)]
pub(crate) struct Targets {
    points: Vec<Point>,
    /// The indices, in the order of the leaves.
    order: Vec<u32>,
    /// The nodes in preorder; the root comes first.
    nodes: Vec<Node>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    disc: Disc,
    /// The range of the node's targets in the order of the leaves.
    from: u32,
    to: u32,
    /// The node of the upper half; the next node is that of the lower half. 0 for leaves.
    upper: u32,
}

/// Targets that one wavefront finds.
#[derive(Clone, Debug)]
pub(super) struct Group {
    pub(super) disc: Disc,
    pub(super) members: Vec<u32>,
    pub(super) expected: Work,
}

/// A division of a part of the tree.
#[derive(Clone, Copy, Default)]
struct Division {
    /// The number of targets that are wanted.
    wanted: usize,
    cost: f64,
    /// Whether the targets of the node are one group.
    is_group: bool,
}

impl Targets {
    /// Arranges the points with these indices. All indices must be below the number of points.
    pub(crate) fn new(points: Vec<Point>, indices: impl IntoIterator<Item = u32>) -> Self {
        let mut this = Self {
            order: indices.into_iter().collect(),
            points,
            nodes: Vec::new(),
        };
        if !this.order.is_empty() {
            let mut order = std::mem::take(&mut this.order);
            this.arrange(&mut order, 0);
            this.order = order;
        }
        this
    }

    /// Makes the node of some targets, which begin at `from` in the order of the leaves, and those
    /// below it.
    fn arrange(&mut self, indices: &mut [u32], from: usize) {
        let points = &self.points;
        let at = |index: u32| points[index as usize];
        let node = self.nodes.len();
        self.nodes.push(Node {
            disc: disc_of(indices.iter().map(|&index| at(index))),
            from: from as u32,
            to: (from + indices.len()) as u32,
            upper: 0,
        });
        let count = indices.len();
        if count <= LEAF || count > MOST {
            return;
        }
        let (width, height) = Rect::around(indices.iter().map(|&index| at(index))).size();
        let is_wide = width >= height;
        indices.select_nth_unstable_by(count / 2, |&a, &b| {
            let [a, b] = [a, b].map(|index| if is_wide { at(index).x } else { at(index).y });
            a.total_cmp(&b)
        });
        let (lower, upper) = indices.split_at_mut(count / 2);
        self.arrange(lower, from);
        self.nodes[node].upper = self.nodes.len() as u32;
        self.arrange(upper, from + count / 2);
    }

    /// Returns whether the targets are never divided.
    pub(crate) fn is_one_group(&self) -> bool {
        self.nodes.len() <= 1
    }

    pub(super) fn point(&self, index: u32) -> Point {
        self.points[index as usize]
    }

    /// Makes one group of the targets that are wanted.
    pub(super) fn one_group(&self, from: Point, is_wanted: &[bool], expectation: &Expectation) -> Option<Group> {
        let root = self.nodes.first()?;
        let members: Vec<u32> = self.members(root, is_wanted).collect();
        if members.is_empty() {
            return None;
        }
        Some(Group {
            disc: root.disc,
            expected: expectation.of(from, root.disc, members.len()),
            members,
        })
    }

    /// Divides the targets that are wanted into groups with the least expected work. The groups
    /// that are nearer come later.
    pub(super) fn groups(&self, from: Point, is_wanted: &[bool], expectation: &Expectation) -> Vec<Group> {
        let mut divisions = vec![Division::default(); self.nodes.len()];
        // Children have higher numbers than their parents.
        for (index, node) in self.nodes.iter().enumerate().rev() {
            let (wanted, apart) = match node.upper {
                0 => (self.members(node, is_wanted).count(), f64::INFINITY),
                upper => {
                    let [lower, upper] = [divisions[index + 1], divisions[upper as usize]];
                    (lower.wanted + upper.wanted, lower.cost + upper.cost)
                }
            };
            let together = expectation.of(from, node.disc, wanted).triangles;
            let is_group = wanted > 0 && together <= apart;
            let cost = match wanted {
                0 => 0.0,
                _ => together.min(apart),
            };
            divisions[index] = Division { wanted, cost, is_group };
        }
        let mut groups = Vec::new();
        let mut done = 0;
        for (node, division) in self.nodes.iter().zip(&divisions) {
            if !division.is_group || node.from < done {
                continue;
            }
            done = node.to;
            let members: Vec<u32> = self.members(node, is_wanted).collect();
            let disc = disc_of(members.iter().map(|&index| self.point(index)));
            groups.push(Group {
                disc,
                expected: expectation.of(from, disc, members.len()),
                members,
            });
        }
        let far = |group: &Group| distance(from, group.disc.centre) - group.disc.radius;
        groups.sort_by(|a, b| far(b).total_cmp(&far(a)));
        groups
    }

    /// Returns the targets of a node that are wanted.
    fn members<'a>(&'a self, node: &Node, is_wanted: &'a [bool]) -> impl Iterator<Item = u32> + 'a {
        let members = self.order[node.from as usize..node.to as usize].iter().copied();
        members.filter(|&index| is_wanted[index as usize])
    }
}

/// Returns a disc that contains all points.
fn disc_of(points: impl Iterator<Item = Point> + Clone) -> Disc {
    let bounds = Rect::around(points.clone());
    let (width, height) = bounds.size();
    let centre = Point::new(bounds.min_x + width / 2.0, bounds.min_y + height / 2.0);
    let radius = points.map(|point| distance(centre, point)).fold(0.0, f64::max);
    // The distances are rounded.
    Disc {
        centre,
        radius: radius * (1.0 + 1e-12),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(count: u32) -> Vec<Point> {
        let number = |i: u32, by: u32| f64::from(i.wrapping_mul(by) % 10_007);
        (0..count)
            .map(|i| Point::new(number(i, 7919), number(i, 104_729)))
            .collect()
    }

    #[test]
    fn each_wanted_target_is_in_one_group_within_its_disc() {
        let points = points(700);
        let targets = Targets::new(points.clone(), (0..700).filter(|i| i % 7 != 0));
        let is_wanted: Vec<bool> = (0..700).map(|i| i % 3 != 0).collect();
        for density in [1e-6, 1e-3, 1.0] {
            let expectation = Expectation::new(density);
            let groups = targets.groups(points[0], &is_wanted, &expectation);
            let mut members: Vec<u32> = groups.iter().flat_map(|group| group.members.clone()).collect();
            members.sort_unstable();
            let expected: Vec<u32> = (0..700).filter(|i| i % 7 != 0 && i % 3 != 0).collect();
            assert_eq!(members, expected);
            for Group { disc, members, .. } in &groups {
                let is_inside = |&i: &u32| distance(disc.centre, points[i as usize]) <= disc.radius;
                assert!(members.iter().all(is_inside));
            }
            let nearest = |group: &Group| distance(points[0], group.disc.centre) - group.disc.radius;
            assert!(groups.is_sorted_by(|a, b| nearest(a) >= nearest(b)));
        }
    }

    #[test]
    fn opposite_clusters_are_apart_on_dense_ground_and_together_on_bare_ground() {
        let is_east = |i: u32| i < 8;
        let points: Vec<Point> = (0..16)
            .map(|i| Point::new(if is_east(i) { 9_000.0 } else { -9_000.0 }, f64::from(i)))
            .collect();
        let targets = Targets::new(points, 0..16);
        let groups = |density: f64| {
            let expectation = Expectation::new(density);
            targets.groups(Point::new(0.0, 0.0), &[true; 16], &expectation)
        };
        assert_eq!(groups(1e-7).len(), 1);
        let on_dense_ground = groups(0.1);
        assert!(on_dense_ground.len() >= 2);
        for Group { members, .. } in on_dense_ground {
            let east = members.iter().filter(|&&i| is_east(i)).count();
            assert!(east == 0 || east == members.len(), "{members:?}");
        }
    }

    #[test]
    fn no_targets_make_no_groups() {
        let targets = Targets::new(points(3), []);
        let expectation = Expectation::new(f64::NAN);
        assert!(
            targets
                .groups(Point::new(0.0, 0.0), &[true; 3], &expectation)
                .is_empty()
        );
        assert!(
            targets
                .one_group(Point::new(0.0, 0.0), &[true; 3], &expectation)
                .is_none()
        );
        let one = Targets::new(points(3), [2, 1]);
        let groups = one.groups(Point::new(0.0, 0.0), &[true, false, true], &expectation);
        assert_eq!(groups[0].members, [2]);
    }
}
