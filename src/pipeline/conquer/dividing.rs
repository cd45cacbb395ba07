//! Divides blocks into leaves, and checks the input there.

use crate::constraints::segments::cells::segments_of_leaves;
use crate::geometry::Rect;
use crate::input::MissingZ;
use crate::pipeline::conquer::conquest::Conquest;
use crate::pipeline::conquer::crossings::{LeafLines, in_leaves};
use crate::pipeline::conquer::leaf::first_duplicate;
use crate::pipeline::conquer::schedule::BlockPoints;
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::missing_z::FoundWithoutZ;
use crate::pipeline::options::Duplicates;
use crate::pipeline::output::ordered::Closed;
use crate::pipeline::records::{BlockState, TileState};
use crate::store::MAX_TILES;
use crate::store::divide::{Division, divide};

impl Conquest {
    pub(crate) fn divide(&self, mut block: BlockPoints, threads: usize) -> Result<(), Closed> {
        let _span = tracing::debug_span!("divide", block = block.number, points = block.store.items.len()).entered();
        let division = divide(&mut block.store.items, self.options.tile_vertices, threads);
        if self.options.duplicates == Duplicates::Error {
            let leaves = division.leaves.iter().map(|leaf| &block.store.items[leaf.clone()]);
            let first_end = self.rules.duplicates.first_end;
            let duplicates = leaves.filter_map(|items| first_duplicate(items, &block.store.attributes, first_end));
            let mut state = self.state.lock();
            let first = duplicates.chain(state.first_duplicate);
            state.first_duplicate = first.min_by_key(|(records, _)| (records[1], records[0]));
            if state.first_duplicate.is_some() {
                // The build will fail, but the remaining blocks may have an earlier duplicate.
                drop(state);
                self.board.only_divide();
            }
        }
        self.find_missing_z(&block, &division);
        let tiles = division.leaves.len();
        let tree = division.tree.clone();
        if !block.segments.is_empty() {
            let cell = self.board.block_cell(block.number);
            block.of_leaves = segments_of_leaves(&tree, cell, &block.segments);
            self.find_crossings(&block, &division, cell, threads);
        }
        let (draped, mut many) = (block.draped, false);
        self.board.divided(block, division, |first_tile| {
            many = first_tile as usize + tiles > MAX_TILES as usize;
            self.add_block(BlockState {
                first_tile,
                tree,
                tiles: vec![TileState::default(); tiles],
                draped,
                ..BlockState::default()
            });
        });
        if many {
            self.fail(BuildError::TooManyTiles { max: MAX_TILES });
        }
        Ok(())
    }

    /// Finds vertices without z, if these are an error. The build will fail then, but the remaining
    /// blocks may have vertices that are to be reported first.
    fn find_missing_z(&self, block: &BlockPoints, division: &Division) {
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
            let mut state = self.state.lock();
            state.without_z.merge(&lacking);
            state.lacks_z = true;
            drop(state);
            self.board.only_divide();
        }
    }

    /// Finds segments that cross in a divided block. If there are any, the build will fail, but the
    /// remaining blocks may have crossings that are to be reported first.
    fn find_crossings(&self, block: &BlockPoints, division: &Division, cell: Rect, threads: usize) {
        let items = &block.store.items;
        let cells = division.tree.cells_within(cell);
        let leaves = cells.into_iter().zip(&division.leaves).zip(&block.of_leaves);
        let leaves: Vec<LeafLines<'_>> = leaves
            .map(|((cell, points), segment_indices)| LeafLines {
                cell,
                items: &items[points.clone()],
                segment_indices,
            })
            .collect();
        let crossings = in_leaves(&block.segments, &leaves, threads);
        if crossings.count() > 0 {
            self.state.lock().crossings.merge(&crossings);
            self.board.only_divide();
        }
    }
}
