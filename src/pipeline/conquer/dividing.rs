//! Divides blocks into leaves, and looks there for what is wrong with the input.

use crate::constraints::segments::cells::segments_of_leaves;
use crate::geometry::Rect;
use crate::input::MissingZ;
use crate::pipeline::conquer::conquest::Conquest;
use crate::pipeline::conquer::crossings::{LeafLines, in_leaves};
use crate::pipeline::conquer::leaf::first_duplicate;
use crate::pipeline::conquer::schedule::BlockPoints;
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::divide::{Division, divide};
use crate::pipeline::ingest::missing_z::FoundWithoutZ;
use crate::pipeline::options::Duplicates;
use crate::pipeline::output::ordered::Closed;
use crate::pipeline::records::{BlockFound, TileState};
use crate::store::MAX_TILES;

impl Conquest {
    pub(crate) fn divide(&self, mut block: BlockPoints, threads: usize) -> Result<(), Closed> {
        let _span = tracing::debug_span!("divide", block = block.number, points = block.store.items.len()).entered();
        let division = divide(&mut block.store.items, self.options.tile_vertices, threads);
        if self.options.duplicates == Duplicates::Error {
            let leaves = division.leaves.iter().map(|leaf| &block.store.items[leaf.clone()]);
            let first_end = self.rules.duplicates.first_end;
            let duplicates = leaves.filter_map(|items| first_duplicate(items, &block.store.attributes, first_end));
            let mut found = self.found.lock();
            let first = duplicates.chain(found.first_duplicate);
            found.first_duplicate = first.min_by_key(|(records, _)| (records[1], records[0]));
            if found.first_duplicate.is_some() {
                // There is no file to come; but the blocks that are left may have one that comes before it.
                drop(found);
                self.board.only_divide();
            }
        }
        self.look_for_missing_z(&block, &division);
        let tiles = division.leaves.len();
        let tree = division.tree.clone();
        if !block.segments.is_empty() {
            let cell = self.board.block_cell(block.number);
            block.of_leaves = segments_of_leaves(&tree, cell, &block.segments);
            self.look_for_crossings(&block, &division, cell, threads);
        }
        let mut many = false;
        self.board.divided(block, division, |first_tile| {
            many = first_tile as usize + tiles > MAX_TILES as usize;
            self.add_block(BlockFound {
                first_tile,
                tree,
                tiles: vec![TileState::default(); tiles],
                ..BlockFound::default()
            });
        });
        if many {
            self.fail(BuildError::TooManyTiles { max: MAX_TILES });
        }
        Ok(())
    }

    /// Looks for vertices that have no z, where that is an error. Then there is no file to come,
    /// but the blocks that are left may have those that are to be told first.
    fn look_for_missing_z(&self, block: &BlockPoints, division: &Division) {
        let attributes = &block.store.attributes;
        if self.options.missing_z == MissingZ::Zero || !attributes.has_z() {
            return;
        }
        let mut lacking = FoundWithoutZ::default();
        for leaf in &division.leaves {
            let items = &block.store.items[leaf.clone()];
            lacking.merge(&FoundWithoutZ::in_leaf(items, attributes, self.rules.duplicates));
        }
        if lacking.count > 0 {
            lacking.name_line(&block.segments);
            let mut found = self.found.lock();
            found.without_z.merge(&lacking);
            found.lacks_z = true;
            drop(found);
            self.board.only_divide();
        }
    }

    /// Looks for segments that cross in a block that was divided. If there are any there is no file to come, but the blocks
    /// that are left may have those that are to be told first.
    fn look_for_crossings(&self, block: &BlockPoints, division: &Division, cell: Rect, threads: usize) {
        let items = &block.store.items;
        let cells = division.tree.cells_within(cell);
        let leaves = cells.into_iter().zip(&division.leaves).zip(&block.of_leaves);
        let leaves: Vec<LeafLines<'_>> = leaves
            .map(|((cell, points), its)| LeafLines {
                cell,
                items: &items[points.clone()],
                its,
            })
            .collect();
        let crossings = in_leaves(&block.segments, &leaves, threads);
        if crossings.count() > 0 {
            self.found.lock().crossings.merge(&crossings);
            self.board.only_divide();
        }
    }
}
