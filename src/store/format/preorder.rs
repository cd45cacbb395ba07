//! Builds k-d trees from their nodes in preorder, without the numbers of right children: those
//! follow from the order. So trees are stored without them, and are cut and joined node by node.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::store::format::damage::Damage;
use crate::store::format::kd_tree::{KdNode, KdTree};

/// A k-d tree to which nodes are added in preorder.
#[derive(Debug)]
pub(super) struct Preorder<L> {
    nodes: Vec<KdNode<L>>,
    /// The cuts whose right child is not there yet, innermost last.
    open: Vec<u32>,
}

impl<L> Default for Preorder<L> {
    fn default() -> Self {
        Self {
            nodes: Vec::new(),
            open: Vec::new(),
        }
    }
}

impl<L: Copy> Preorder<L> {
    /// Adds the next node. The number of a right child in it does not matter.
    pub(super) fn push(&mut self, node: KdNode<L>) -> Result<(), Damage> {
        let number = self.nodes.len() as u32;
        // After a leaf, the innermost cut without a right child gets it.
        if let Some(KdNode::Leaf(_)) = self.nodes.last() {
            let parent = self
                .open
                .pop()
                .ok_or_else(|| Damage::new("the k-d tree has too many nodes"))?;
            if let KdNode::X { right, .. } | KdNode::Y { right, .. } = &mut self.nodes[parent as usize] {
                *right = number;
            }
        }
        if !matches!(node, KdNode::Leaf(_)) {
            self.open.push(number);
        }
        self.nodes.push(node);
        Ok(())
    }

    /// Returns the tree.
    pub(super) fn finish(self) -> Result<KdTree<L>, Damage> {
        KdTree::new(self.nodes)
    }
}

impl<L: Copy> KdTree<L> {
    /// Returns the tree with each leaf replaced by a subtree. `subtree` returns it, given the value
    /// of the leaf.
    pub(super) fn grafted<'t, M: Copy + 't>(
        &self,
        mut subtree: impl FnMut(L) -> Result<&'t KdTree<M>, Damage>,
    ) -> Result<KdTree<M>, Damage> {
        let mut whole = Preorder::default();
        for node in self.nodes() {
            match *node {
                KdNode::X { cut, right } => whole.push(KdNode::X { cut, right })?,
                KdNode::Y { cut, right } => whole.push(KdNode::Y { cut, right })?,
                KdNode::Leaf(leaf) => {
                    for &node in subtree(leaf)?.nodes() {
                        whole.push(node)?;
                    }
                }
            }
        }
        whole.finish()
    }

    /// Returns the tree with some leaves replaced by subtrees, by the values of the leaves.
    pub(super) fn with_subtrees(&self, subtrees: &BTreeMap<L, Self>) -> Self
    where
        L: Ord,
    {
        let mut whole = Preorder::default();
        for node in self.nodes() {
            let subtree = match node {
                KdNode::Leaf(leaf) => subtrees.get(leaf),
                _ => None,
            };
            for &node in subtree.map_or(std::slice::from_ref(node), KdTree::nodes) {
                whole.push(node).expect("a subtree takes the place of a leaf");
            }
        }
        whole.finish().expect("a subtree takes the place of a leaf")
    }

    /// Returns the tree without some of its leaves. The other child of a cut above such a leaf takes
    /// the whole cell of the cut.
    pub(crate) fn without(&self, is_removed: impl Fn(L) -> bool) -> Self {
        // Whether any leaf below each node stays. Children follow their parents.
        let nodes = self.nodes();
        let mut stays = vec![false; nodes.len()];
        for (number, node) in nodes.iter().enumerate().rev() {
            stays[number] = match *node {
                KdNode::X { right, .. } | KdNode::Y { right, .. } => stays[number + 1] || stays[right as usize],
                KdNode::Leaf(leaf) => !is_removed(leaf),
            };
        }
        let mut left = Preorder::default();
        for (number, &node) in nodes.iter().enumerate() {
            let is_kept = match node {
                KdNode::X { right, .. } | KdNode::Y { right, .. } => stays[number + 1] && stays[right as usize],
                KdNode::Leaf(_) => stays[number],
            };
            if is_kept {
                left.push(node).expect("a cut stays with leaves on both sides");
            }
        }
        match left.nodes.is_empty() {
            true => Self::default(),
            false => left.finish().expect("a cut stays with leaves on both sides"),
        }
    }

    /// Returns the subtree of consecutive nodes.
    pub(super) fn subtree(&self, nodes: Range<u32>) -> Self {
        let mut part = Preorder::default();
        for &node in &self.nodes()[nodes.start as usize..nodes.end as usize] {
            part.push(node).expect("the nodes are a subtree");
        }
        part.finish().expect("the nodes are a subtree")
    }

    /// Cuts the tree into subtrees of at most `most` leaves each, which are as large as possible.
    /// Returns the tree above them, whose leaves are the numbers of the subtrees from left to
    /// right, and the nodes of each subtree.
    pub(super) fn cut_into(&self, most: u32) -> (KdTree<u32>, Vec<Range<u32>>) {
        let below = self.leaves_below();
        let (mut top, mut parts) = (Preorder::default(), Vec::<Range<u32>>::new());
        let mut node = 0;
        while let Some(&here) = self.nodes().get(node as usize) {
            let leaves = below[node as usize];
            let pushed = if leaves <= most {
                let number = parts.len() as u32;
                // A tree of n leaves has 2n - 1 nodes, which are consecutive.
                let end = node + 2 * leaves - 1;
                parts.push(node..end);
                node = end;
                KdNode::Leaf(number)
            } else {
                node += 1;
                match here {
                    KdNode::X { cut, right } => KdNode::X { cut, right },
                    KdNode::Y { cut, right } => KdNode::Y { cut, right },
                    KdNode::Leaf(_) => unreachable!("a leaf is one leaf"),
                }
            };
            top.push(pushed).expect("the nodes above subtrees are a tree");
        }
        (top.finish().expect("the nodes above subtrees are a tree"), parts)
    }

    /// Returns the number of leaves below each node.
    fn leaves_below(&self) -> Vec<u32> {
        let mut below = vec![1; self.nodes().len()];
        // Children follow their parents.
        for (number, node) in self.nodes().iter().enumerate().rev() {
            if let KdNode::X { right, .. } | KdNode::Y { right, .. } = *node {
                below[number] = below[number + 1] + below[right as usize];
            }
        }
        below
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Returns a tree of `leaves` leaves that are numbered from left to right, of a shape that
    /// `dice` determine.
    fn tree(leaves: u32, dice: &mut impl FnMut(u32) -> u32) -> KdTree<u32> {
        fn grow(leaves: u32, first: u32, dice: &mut impl FnMut(u32) -> u32, out: &mut Preorder<u32>) {
            if leaves == 1 {
                return out.push(KdNode::Leaf(first)).unwrap();
            }
            let left = 1 + dice(leaves - 1);
            let (cut, right) = (f64::from(first), 0);
            let node = if dice(2) == 0 {
                KdNode::X { cut, right }
            } else {
                KdNode::Y { cut, right }
            };
            out.push(node).unwrap();
            grow(left, first, dice, out);
            grow(leaves - left, first + left, dice, out);
        }
        let mut out = Preorder::default();
        if leaves > 0 {
            grow(leaves, 0, dice, &mut out);
        }
        out.finish().unwrap()
    }

    proptest! {
        #[test]
        fn a_tree_that_was_cut_is_joined_again(leaves in 0..200u32, most in 1..30u32, seed: u64) {
            let mut state = seed | 1;
            let mut dice = |below: u32| {
                state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
                (state >> 33) as u32 % below
            };
            let whole = tree(leaves, &mut dice);
            let (top, parts) = whole.cut_into(most);
            let subtrees: Vec<_> = parts.into_iter().map(|part| whole.subtree(part)).collect();
            prop_assert_eq!(top.leaves().collect::<Vec<_>>(), (0..subtrees.len() as u32).collect::<Vec<_>>());
            prop_assert!(subtrees.iter().all(|subtree| (1..=most).contains(&subtree.tiles())));
            prop_assert_eq!(top.grafted(|number| Ok(&subtrees[number as usize])), Ok(whole));
        }
    }

    #[test]
    fn nodes_that_are_no_tree_are_rejected() {
        let cut = KdNode::X { cut: 1.0, right: 0 };
        let of = |nodes: &[KdNode<u32>]| {
            let mut tree = Preorder::default();
            nodes.iter().try_for_each(|&node| tree.push(node))?;
            tree.finish()
        };
        assert!(of(&[cut, KdNode::Leaf(1), KdNode::Leaf(1)]).is_ok());
        for nodes in [
            &[cut][..],
            &[cut, KdNode::Leaf(0)],
            &[KdNode::Leaf(0), KdNode::Leaf(1)],
            &[cut, KdNode::Leaf(0), KdNode::Leaf(1), cut],
            &[cut, KdNode::Leaf(0), cut, KdNode::Leaf(1)],
        ] {
            assert!(of(nodes).is_err(), "{nodes:?}");
        }
    }
}
