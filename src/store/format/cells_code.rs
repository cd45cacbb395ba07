//! The encoding of parts of the k-d tree in the directory.

use flatbuffers::{FlatBufferBuilder, WIPOffset};

use crate::store::format::damage::Damage;
use crate::store::format::generated::directory as schema;
use crate::store::format::kd_tree::{KdNode, KdTree};
use crate::store::format::preorder::Preorder;

/// The codes of nodes in a part's shape.
const LEAF: u8 = 0;
const X: u8 = 1;
const Y: u8 = 2;

/// Adds a part of the tree to a buffer. `number` returns the number that stands for a leaf; the
/// list of these is left out if they are consecutive from `first` on.
pub(super) fn encode<'b, L: Copy>(
    builder: &mut FlatBufferBuilder<'b>,
    tree: &KdTree<L>,
    first: u32,
    number: impl Fn(L) -> u32,
) -> WIPOffset<schema::Cells<'b>> {
    let mut shape = vec![0u8; tree.nodes().len().div_ceil(4)];
    let (mut cuts, mut leaves) = (Vec::new(), Vec::new());
    for (place, node) in tree.nodes().iter().enumerate() {
        let code = match *node {
            KdNode::X { cut, .. } => {
                cuts.push(cut);
                X
            }
            KdNode::Y { cut, .. } => {
                cuts.push(cut);
                Y
            }
            KdNode::Leaf(leaf) => {
                leaves.push(number(leaf));
                LEAF
            }
        };
        shape[place / 4] |= code << (2 * (place % 4));
    }
    let is_consecutive = leaves.iter().zip(first..).all(|(&leaf, expected)| leaf == expected);
    let args = schema::CellsArgs {
        shape: Some(builder.create_vector(&shape)),
        cuts: Some(builder.create_vector(&cuts)),
        leaves: (!is_consecutive).then(|| builder.create_vector(&leaves)),
    };
    schema::Cells::create(builder, &args)
}

/// Decodes a part of the tree. `leaf` returns what a leaf with this number stands for, or an error
/// if there is no such thing.
pub(super) fn decode<L: Copy>(
    cells: schema::Cells<'_>,
    first: u32,
    leaf: impl Fn(u32) -> Result<L, Damage>,
) -> Result<KdTree<L>, Damage> {
    let wrong = || Damage::new("a part of the k-d tree has lists of wrong lengths");
    let (shape, cuts) = (cells.shape().bytes(), cells.cuts());
    // A tree of n cuts has 2n + 1 nodes.
    let nodes = if shape.is_empty() { 0 } else { 2 * cuts.len() + 1 };
    let leaves = nodes - if shape.is_empty() { 0 } else { cuts.len() };
    let named = cells.leaves();
    if shape.len() != nodes.div_ceil(4)
        || shape.is_empty() && !cuts.is_empty()
        || named.is_some_and(|named| named.len() != leaves)
    {
        return Err(wrong());
    }
    let mut cuts = cuts.iter();
    let mut tree = Preorder::default();
    let mut next = 0usize;
    for place in 0..nodes {
        let mut cut = || cuts.next().ok_or_else(wrong);
        let node = match shape[place / 4] >> (2 * (place % 4)) & 0b11 {
            LEAF => {
                let number = match named {
                    Some(named) if next < leaves => named.get(next),
                    Some(_) => return Err(wrong()),
                    None => first.saturating_add(next as u32),
                };
                next += 1;
                KdNode::Leaf(leaf(number)?)
            }
            X => KdNode::X { cut: cut()?, right: 0 },
            Y => KdNode::Y { cut: cut()?, right: 0 },
            code => return Err(Damage::new(format!("the k-d tree has a node of kind {code}"))),
        };
        tree.push(node)?;
    }
    tree.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::format::flat_buffer::verified;

    fn encoded(tree: &KdTree<u32>, first: u32) -> Vec<u8> {
        let mut builder = FlatBufferBuilder::new();
        let root = encode(&mut builder, tree, first, |leaf| leaf);
        builder.finish(root, None);
        builder.finished_data().to_vec()
    }

    fn decoded(bytes: &[u8], first: u32, below: u32) -> Result<KdTree<u32>, Damage> {
        let leaf = |number| match number < below {
            true => Ok(number),
            false => Err(Damage::new("out of range")),
        };
        decode(verified(bytes, "it")?, first, leaf)
    }

    fn tree(leaves: [u32; 3]) -> KdTree<u32> {
        let [a, b, c] = leaves.map(KdNode::Leaf);
        let nodes = vec![
            KdNode::X { cut: 1.0, right: 2 },
            a,
            KdNode::Y { cut: 5.0, right: 4 },
            b,
            c,
        ];
        KdTree::new(nodes).unwrap()
    }

    #[test]
    fn a_part_is_read_as_it_was_written_and_names_leaves_only_if_they_are_not_consecutive() {
        for (leaves, first) in [([7, 8, 9], 7), ([8, 7, 9], 7), ([7, 8, 9], 6), ([0, 1, 2], 0)] {
            let tree = tree(leaves);
            assert_eq!(decoded(&encoded(&tree, first), first, 10), Ok(tree));
        }
        assert_eq!(decoded(&encoded(&KdTree::default(), 3), 3, 0), Ok(KdTree::default()));
        assert!(encoded(&tree([7, 8, 9]), 7).len() < encoded(&tree([7, 9, 8]), 7).len());
        assert!(decoded(&encoded(&tree([7, 8, 9]), 7), 7, 9).is_err());
    }
}
