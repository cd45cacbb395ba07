//! The components of a tile's core: triangles that are connected without passing a constraint.
//!
//! Those with a side at which the core ends are *open*: what they belong to is known after the root only. The others are closed:
//! each is a region of its own, and only how many obstacles cover it depends on the rest. That is told by its *anchor*, an open
//! component that is connected with it across constraints, and by how much deeper it lies than that.

use crate::geometry::HalfEdge;
use crate::mesh::NONE;
use crate::pipeline::records::{Anchor, OpenSide};
use crate::store::format::components::joined;
use crate::store::{CoreDraft, EdgeSource};

/// The components of a core, open ones first.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Components {
    /// That of each triangle.
    pub(crate) of_triangles: Vec<u32>,
    pub(crate) count: u32,
    pub(crate) open: u32,
    /// Of each component, where there are obstacles at all.
    pub(crate) anchors: Vec<Anchor>,
}

/// Two components side by side, and how much deeper the first lies by the edge between them.
struct Link {
    sides: [u32; 2],
    change: i32,
    source: EdgeSource,
}

impl Components {
    /// Finds them.
    pub(crate) fn of(core: &CoreDraft, open_sides: &[OpenSide]) -> Self {
        let (mut of_triangles, found) = joined(core);
        let mut is_open = vec![false; found as usize];
        for side in open_sides {
            is_open[of_triangles[side.side.triangle().index()] as usize] = true;
        }
        let mut numbers = vec![NONE; found as usize];
        let (open, closed): (Vec<usize>, Vec<usize>) = (0..found as usize).partition(|&component| is_open[component]);
        for (&component, number) in open.iter().chain(&closed).zip(0..) {
            numbers[component] = number;
        }
        for component in &mut of_triangles {
            *component = numbers[*component as usize];
        }
        Self {
            of_triangles,
            count: found,
            open: open.len() as u32,
            anchors: Vec::new(),
        }
    }

    /// Anchors every component. The sources are those of the constraint edges within the core, by a side of each, in order.
    ///
    /// An error is a ring that does not close: around it one side would be deeper than itself.
    pub(crate) fn anchor(&mut self, core: &CoreDraft, sources: &[(u32, EdgeSource)]) -> Result<(), EdgeSource> {
        let link = |of_side: &[(u32, EdgeSource)]| {
            let (side, source) = of_side[0];
            let twin = core.neighbours.as_flattened()[side as usize];
            Link {
                sides: [HalfEdge(side).triangle().0, twin.triangle_or_more()]
                    .map(|triangle| self.of_triangles[triangle as usize]),
                change: of_side.iter().map(|(_, source)| source.depth_change()).sum(),
                source,
            }
        };
        let links: Vec<Link> = sources.chunk_by(|a, b| a.0 == b.0).map(link).collect();
        let both = links.iter().flat_map(
            |&Link {
                 sides: [a, b], change, ..
             }| [(a, b, change), (b, a, -change)],
        );
        let mut steps: Vec<(u32, u32, i32)> = both.collect();
        steps.sort_unstable();
        steps.dedup();
        let mut anchors: Vec<Option<Anchor>> = vec![None; self.count as usize];
        let mut reached = Vec::new();
        for first in 0..self.count {
            if anchors[first as usize].is_none() {
                reached.push((first, 0));
            }
            while let Some((component, deeper)) = reached.pop() {
                if anchors[component as usize].is_some() {
                    continue;
                }
                anchors[component as usize] = Some(Anchor {
                    component: first,
                    deeper,
                    triangles: 0,
                });
                let start = steps.partition_point(|&(from, ..)| from < component);
                let on = steps[start..].iter().take_while(|&&(from, ..)| from == component);
                reached.extend(on.map(|&(_, to, change)| (to, deeper - change)));
            }
        }
        self.anchors = anchors.into_iter().flatten().collect();
        for &component in &self.of_triangles {
            self.anchors[component as usize].triangles += 1;
        }
        let deeper = |component: u32| self.anchors[component as usize].deeper;
        let broken = links
            .iter()
            .find(|link| deeper(link.sides[0]) - deeper(link.sides[1]) != link.change);
        broken.map_or(Ok(()), |link| Err(link.source))
    }
}
