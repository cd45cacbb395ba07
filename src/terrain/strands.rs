//! Contours that pass through several tiles, as they grow.
//!
//! In: the chains of all tiles that end at junctions, one after the other. Out: complete contours, each
//! as the list of its chains. The points are elsewhere: only where they are is kept here, and only of
//! contours that are not complete. So the memory follows the border between the tiles that were read and
//! those that were not, and not the size of the file.

use foldhash::{HashMap, HashMapExt};

use super::contours::Junction;

/// Where the points of a chain are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Run {
    /// The number of points before them.
    pub(crate) start: u64,
    /// Their number.
    pub(crate) points: u64,
}

/// A complete contour of several chains.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Strand {
    pub(crate) level: i64,
    pub(crate) runs: Vec<Run>,
    pub(crate) is_closed: bool,
}

impl Strand {
    /// Returns a closed contour of one chain.
    pub(crate) fn closed(level: i64, run: Run) -> Self {
        Self {
            level,
            runs: vec![run],
            is_closed: true,
        }
    }

    /// Returns the number of points of all chains.
    pub(crate) fn points(&self) -> u64 {
        self.runs.iter().map(|run| run.points).sum()
    }
}

/// Two chains begin, or two end, at the same junction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the triangles at the edge from vertex {} to {} have different corners in different tiles", .0.ends[0], .0.ends[1])]
pub(crate) struct BadJunction(Junction);

/// A chain in the list of a contour.
#[derive(Clone, Copy)]
struct Node {
    run: Run,
    /// The index of the next one. The last one of a contour has itself.
    next: u32,
}

/// A contour that is not complete.
#[derive(Clone, Copy)]
struct Growing {
    level: i64,
    first: u32,
    last: u32,
    /// The junctions at which its start and its end may continue.
    ends: [Option<Junction>; 2],
}

/// Items with an index, which others get when they are gone.
struct Slab<T> {
    items: Vec<Option<T>>,
    free: Vec<u32>,
}

impl<T: Copy> Slab<T> {
    const BYTES: usize = size_of::<Option<T>>();

    fn new() -> Self {
        Self {
            items: Vec::new(),
            free: Vec::new(),
        }
    }

    fn insert(&mut self, item: T) -> u32 {
        if let Some(index) = self.free.pop() {
            self.items[index as usize] = Some(item);
            return index;
        }
        self.items.push(Some(item));
        u32::try_from(self.items.len() - 1).expect("the memory does not suffice for so many chains")
    }

    fn get(&mut self, index: u32) -> &mut T {
        self.items[index as usize]
            .as_mut()
            .expect("nobody refers to a free index")
    }

    fn remove(&mut self, index: u32) -> T {
        self.free.push(index);
        self.items[index as usize]
            .take()
            .expect("nobody refers to a free index")
    }

    fn bytes(&self) -> usize {
        self.items.capacity() * Self::BYTES + self.free.capacity() * size_of::<u32>()
    }
}

/// The contours of several tiles that are not complete.
pub(crate) struct Strands {
    nodes: Slab<Node>,
    growing: Slab<Growing>,
    /// The contours that may continue at a junction with their start, and with their end.
    at: [HashMap<Junction, u32>; 2],
}

impl Strands {
    pub(crate) fn new() -> Self {
        Self {
            nodes: Slab::new(),
            growing: Slab::new(),
            at: [HashMap::new(), HashMap::new()],
        }
    }

    /// Returns the memory that is taken, and that may be taken when another chain is added.
    pub(crate) fn bytes(&self) -> u64 {
        let entry = size_of::<(Junction, u32)>() + 1;
        let tables: usize = self.at.iter().map(|table| table.capacity() / 7 * 8 * entry).sum();
        // What grows is in memory twice, the new one with twice the room.
        3 * (self.nodes.bytes() + self.growing.bytes() + tables) as u64
    }

    /// Adds a chain with its start and its end. Returns the contour that it completes.
    pub(crate) fn add(
        &mut self,
        level: i64,
        run: Run,
        [start, end]: [Option<Junction>; 2],
    ) -> Result<Option<Strand>, BadJunction> {
        let node = self.nodes.insert(Node { run, next: 0 });
        self.nodes.get(node).next = node;
        let mut chain = Growing {
            level,
            first: node,
            last: node,
            ends: [start, end],
        };
        if let Some(before) = start.and_then(|start| self.at[1].get(&start).copied()) {
            let before = self.take(before);
            chain = self.joined(before, chain);
        }
        if end.is_some() && chain.ends[0] == end {
            return Ok(Some(self.complete(chain, true)));
        }
        if let Some(after) = end.and_then(|end| self.at[0].get(&end).copied()) {
            let after = self.take(after);
            chain = self.joined(chain, after);
        }
        if chain.ends == [None, None] {
            return Ok(Some(self.complete(chain, false)));
        }
        let index = self.growing.insert(chain);
        for (table, end) in self.at.iter_mut().zip(chain.ends) {
            if let Some(junction) = end
                && table.insert(junction, index).is_some()
            {
                return Err(BadJunction(junction));
            }
        }
        Ok(None)
    }

    /// Removes a growing contour, which another one will contain.
    fn take(&mut self, index: u32) -> Growing {
        let taken = self.growing.remove(index);
        for (table, end) in self.at.iter_mut().zip(taken.ends) {
            if let Some(junction) = end {
                table.remove(&junction);
            }
        }
        taken
    }

    /// Appends the chains of `after` to those of `before`.
    fn joined(&mut self, before: Growing, after: Growing) -> Growing {
        self.nodes.get(before.last).next = after.first;
        Growing {
            last: after.last,
            ends: [before.ends[0], after.ends[1]],
            ..before
        }
    }

    /// Returns a contour with the chains in order.
    fn complete(&mut self, contour: Growing, is_closed: bool) -> Strand {
        let mut runs = Vec::new();
        let mut node = contour.first;
        loop {
            let Node { run, next } = self.nodes.remove(node);
            runs.push(run);
            if next == node {
                break;
            }
            node = next;
        }
        Strand {
            level: contour.level,
            runs,
            is_closed,
        }
    }

    /// Returns the contours that no chain continues, when all chains were added.
    pub(crate) fn into_rest(mut self) -> impl Iterator<Item = Strand> {
        self.at = [HashMap::new(), HashMap::new()];
        let growing = std::mem::take(&mut self.growing.items);
        growing
            .into_iter()
            .flatten()
            .map(move |contour| self.complete(contour, false))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::VertexIndex;
    use crate::store::{TileId, VertexId};

    fn junction(number: u32) -> Option<Junction> {
        let ends = [0, number].map(|index| VertexId {
            tile: TileId(7),
            index: VertexIndex(index),
        });
        (number > 0).then_some(Junction { ends, level: 3 })
    }

    fn run(number: u64) -> Run {
        Run {
            start: number,
            points: 1,
        }
    }

    /// The chains of a contour in every order: `count` chains, each from a junction to the next one.
    fn check(count: u32, is_closed: bool) {
        let permutations = (1..=u64::from(count)).product::<u64>();
        for code in 0..permutations {
            let mut left: Vec<u32> = (0..count).collect();
            let (mut code, mut strands, mut complete) = (code, Strands::new(), Vec::new());
            while !left.is_empty() {
                let chain = left.remove((code % left.len() as u64) as usize);
                code /= left.len() as u64 + 1;
                let name = |number: u32| match is_closed {
                    true => junction(number % count + 1),
                    false => junction(number % count),
                };
                let ends = [name(chain), name(chain + 1)];
                complete.extend(strands.add(3, run(chain.into()), ends).unwrap());
            }
            assert_eq!(strands.into_rest().count(), 0);
            let [strand] = &mut complete[..] else {
                panic!("{complete:?}")
            };
            assert_eq!((strand.is_closed, strand.points()), (is_closed, count.into()));
            if is_closed {
                let first = strand.runs.iter().position(|&run| run.start == 0).unwrap();
                strand.runs.rotate_left(first);
            }
            assert!(strand.runs.iter().enumerate().all(|(i, &found)| found == run(i as u64)));
        }
    }

    #[test]
    fn chains_join_in_every_order() {
        for count in 1..=6 {
            check(count, true);
            check(count, false);
        }
    }

    #[test]
    fn what_nobody_continues_is_open_and_two_starts_are_an_error() {
        let mut strands = Strands::new();
        assert_eq!(strands.add(3, run(0), [junction(1), junction(2)]), Ok(None));
        assert_eq!(strands.add(3, run(1), [junction(2), junction(3)]), Ok(None));
        assert_eq!(strands.add(3, run(2), [None, junction(4)]), Ok(None));
        assert!(strands.bytes() > 0);
        assert!(strands.add(3, run(3), [junction(1), junction(9)]).is_err());
        let mut strands = Strands::new();
        for (number, ends) in [[1, 2], [2, 3], [0, 4]].into_iter().enumerate() {
            assert_eq!(strands.add(3, run(number as u64), ends.map(junction)), Ok(None));
        }
        let rest: Vec<_> = strands
            .into_rest()
            .map(|strand| (strand.runs, strand.is_closed))
            .collect();
        assert!(rest.contains(&(vec![run(0), run(1)], false)) && rest.contains(&(vec![run(2)], false)));
        assert_eq!(rest.len(), 2);
    }
}
