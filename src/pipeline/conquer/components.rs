//! The components of a tile's core: triangles that are connected without passing a constraint.
//!
//! A component with a boundary half-edge is *open*: its region is known only after the root. The
//! others are closed: each is a region of its own, and only the number of obstacles that cover it
//! depends on the rest. Its *anchor* tells that number: an open component that is connected with it
//! across constraints, and how much deeper it is than that one.

use crate::geometry::HalfEdge;
use crate::mesh::NONE;
use crate::pipeline::records::{Anchor, BoundaryEdge};
use crate::store::{CoreDraft, DigestSum, EdgeSource, LinePart, triangle_hash};

/// The components of a core, open ones first.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Components {
    /// The component of each triangle.
    pub(crate) of_triangles: Vec<u32>,
    pub(crate) count: u32,
    pub(crate) open: u32,
    /// The anchor of each component.
    pub(crate) anchors: Vec<Anchor>,
}

/// Two adjacent components, and how much deeper the first is by the edge between them.
struct ComponentLink {
    components: [u32; 2],
    change: i32,
    source: EdgeSource,
}

impl Components {
    /// Finds the components of a core. They are anchored as if there were no obstacles: all are as
    /// deep as component 0, which is open because every core has a boundary.
    pub(crate) fn of(core: &CoreDraft, boundary_edges: &[BoundaryEdge]) -> Self {
        let (mut of_triangles, found) = joined(core);
        let mut is_open = vec![false; found as usize];
        for edge in boundary_edges {
            is_open[of_triangles[edge.half_edge.triangle().index()] as usize] = true;
        }
        let mut numbers = vec![NONE; found as usize];
        let (open, closed): (Vec<usize>, Vec<usize>) = (0..found as usize).partition(|&component| is_open[component]);
        for (&component, number) in open.iter().chain(&closed).zip(0..) {
            numbers[component] = number;
        }
        for component in &mut of_triangles {
            *component = numbers[*component as usize];
        }
        let alike = Anchor {
            component: 0,
            deeper: 0,
            triangles: DigestSum::default(),
        };
        let mut anchors = vec![alike; found as usize];
        for (corners, &component) in core.triangles.iter().zip(&of_triangles) {
            let hash = triangle_hash(corners.map(|corner| core.points[corner as usize]));
            anchors[component as usize].triangles.add_hash(hash);
        }
        Self {
            of_triangles,
            count: found,
            open: open.len() as u32,
            anchors,
        }
    }

    /// Anchors every component, given the obstacles around them. `sources` holds the sources of the
    /// constraint edges within the core, each with a half-edge of its edge, sorted.
    ///
    /// # Errors
    /// Returns a source of the edge at which a ring does not close: going round it, a component
    /// would be deeper than itself.
    pub(crate) fn anchor(&mut self, core: &CoreDraft, sources: &[(u32, LinePart)]) -> Result<(), EdgeSource> {
        let link = |of_edge: &[(u32, LinePart)]| {
            let (half_edge, part) = of_edge[0];
            let twin = core.neighbours.as_flattened()[half_edge as usize];
            ComponentLink {
                components: [HalfEdge(half_edge).triangle().0, twin.triangle_or_more()]
                    .map(|triangle| self.of_triangles[triangle as usize]),
                change: of_edge.iter().map(|(_, source)| source.depth_change()).sum(),
                source: part.source(),
            }
        };
        let links: Vec<ComponentLink> = sources.chunk_by(|a, b| a.0 == b.0).map(link).collect();
        let both = links.iter().flat_map(
            |&ComponentLink {
                 components: [a, b],
                 change,
                 ..
             }| [(a, b, change), (b, a, -change)],
        );
        let mut steps: Vec<(u32, u32, i32)> = both.collect();
        steps.sort_unstable();
        steps.dedup();
        let mut is_anchored = vec![false; self.count as usize];
        let mut reached = Vec::new();
        for first in 0..self.count {
            if !is_anchored[first as usize] {
                reached.push((first, 0));
            }
            while let Some((component, deeper)) = reached.pop() {
                if std::mem::replace(&mut is_anchored[component as usize], true) {
                    continue;
                }
                let anchor = &mut self.anchors[component as usize];
                (anchor.component, anchor.deeper) = (first, deeper);
                let start = steps.partition_point(|&(from, ..)| from < component);
                let on = steps[start..].iter().take_while(|&&(from, ..)| from == component);
                reached.extend(on.map(|&(_, to, change)| (to, deeper - change)));
            }
        }
        let deeper = |component: u32| self.anchors[component as usize].deeper;
        let broken = links
            .iter()
            .find(|link| deeper(link.components[0]) - deeper(link.components[1]) != link.change);
        broken.map_or(Ok(()), |link| Err(link.source))
    }
}

/// No component yet.
const UNVISITED: u32 = u32::MAX;

/// Numbers the components of a core in the order of their first triangles. Returns the component of
/// each triangle, and the number of components.
///
/// Starts from each triangle that is not in a component yet, and visits all triangles that are
/// connected with it.
fn joined(core: &CoreDraft) -> (Vec<u32>, u32) {
    let count = core.triangles.len();
    // Branch-free, because the test whether a neighbour is new is unpredictable: each neighbour is
    // written to `reached`, and kept only if it is new. A twin outside the core maps to index
    // `count`, which counts as already visited.
    let mut of_triangles: Vec<u32> = vec![UNVISITED; count + 1];
    of_triangles[count] = 0;
    let mut reached: Vec<u32> = vec![0; count + 3];
    let mut components = 0;
    for first in 0..count {
        if of_triangles[first] != UNVISITED {
            continue;
        }
        of_triangles[first] = components;
        reached[0] = first as u32;
        let mut left = 1;
        while left > 0 {
            left -= 1;
            let triangle = reached[left];
            let bits = core.constraints.get(triangle as usize).copied().unwrap_or(0);
            for (s, &twin) in core.neighbours[triangle as usize].iter().enumerate() {
                let other = twin.triangle_or_more().min(count as u32);
                let of_other = &mut of_triangles[other as usize];
                let is_new = (*of_other == UNVISITED) & (bits >> s & 1 == 0);
                *of_other = if is_new { components } else { *of_other };
                reached[left] = other;
                left += usize::from(is_new);
            }
        }
        components += 1;
    }
    of_triangles.truncate(count);
    (of_triangles, components)
}
