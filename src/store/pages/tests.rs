//! Directories of many shapes, written, read in parts and as a whole, and changed.

use super::*;
use crate::geometry::{Point, Rect};
use crate::io::MemoryFile;
use crate::store::directory_writer::front_end_for;
use crate::store::format::kd_tree::KdNode;
use crate::store::format::line_source::LineSource;
use crate::store::format::lists::Source;
use crate::store::format::metadata::Metadata;
use crate::store::format::table_place::{ShortTable, TablePlace};
use crate::store::open_options::OpenOptions;
use crate::store::reader::TileReader;
use crate::store::writer::TileWriter;
use crate::store::{KdTree, LineKind};

struct Dice(u64);

impl Dice {
    fn below(&mut self, end: u32) -> u32 {
        self.0 = self
            .0
            .wrapping_mul(0x5851_F42D_4C95_7F2D)
            .wrapping_add(0x1405_7B7E_F767_814F);
        ((self.0 >> 33) as u32) % end
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.below(1 << 20)) / f64::from(1 << 20)
    }
}

const WHOLE: Rect = Rect::new(-1e3, 0.25, 1e3, 7.5);

/// Appends the nodes of a random tree whose leaves are `ids`, and the cell of each leaf.
fn grow(ids: &[u32], cell: Rect, dice: &mut Dice, nodes: &mut Vec<KdNode>, cells: &mut Vec<(u32, Rect)>) {
    if let [id] = ids {
        nodes.push(KdNode::Leaf(TileId(*id)));
        cells.push((*id, cell));
        return;
    }
    // Mostly balanced, sometimes not at all.
    let left = match dice.below(8) {
        0 => 1 + dice.below(ids.len() as u32 - 1) as usize,
        _ => ids.len() / 2,
    };
    let at = nodes.len();
    let (low, high) = if dice.below(2) == 0 {
        let cut = dice.within(cell.min_x, cell.max_x);
        nodes.push(KdNode::X { cut, right: 0 });
        (Rect { max_x: cut, ..cell }, Rect { min_x: cut, ..cell })
    } else {
        let cut = dice.within(cell.min_y, cell.max_y);
        nodes.push(KdNode::Y { cut, right: 0 });
        (Rect { max_y: cut, ..cell }, Rect { min_y: cut, ..cell })
    };
    grow(&ids[..left], low, dice, nodes, cells);
    let next = nodes.len() as u32;
    if let KdNode::X { right, .. } | KdNode::Y { right, .. } = &mut nodes[at] {
        *right = next;
    }
    grow(&ids[left..], high, dice, nodes, cells);
}

/// Returns a place of a component table of any kind.
fn table(dice: &mut Dice) -> TablePlace {
    match dice.below(8) {
        0 => TablePlace::Nowhere,
        1 => TablePlace::Apart(Extent::raw(
            8192 + u64::from(dice.below(100)),
            57 + dice.below(400),
            dice.below(1 << 30),
        )),
        _ => {
            let length = 1 + dice.below(ShortTable::MAX as u32);
            let bytes: Vec<u8> = (0..length).map(|_| dice.below(256) as u8).collect();
            TablePlace::InPage(ShortTable::new(&bytes).unwrap())
        }
    }
}

/// Returns a directory of `used` tiles with numbers below `next`, in the order of the leaves or in
/// any order.
fn directory(used: u32, next: u32, in_order: bool, dice: &mut Dice) -> Directory {
    let mut ids: Vec<u32> = (0..next).collect();
    if !in_order {
        for i in (1..ids.len()).rev() {
            ids.swap(i, dice.below(i as u32 + 1) as usize);
        }
    }
    ids.truncate(used as usize);
    let (mut nodes, mut cells) = (Vec::new(), Vec::new());
    if used > 0 {
        grow(&ids, WHOLE, dice, &mut nodes, &mut cells);
    }
    let mut tiles = vec![TileEntry::UNUSED; next as usize];
    for (id, cell) in cells {
        let extent = |length| Extent::raw(8192, length, id);
        tiles[id as usize] = TileEntry {
            core: extent(160),
            border: extent(60),
            generation: 1,
            vertices: 10,
            core_triangles: 0,
            border_triangles: 10,
            owned_triangles: id % 10,
            bounds: cell,
            table: table(dice),
        };
    }
    let entries = || tiles.iter();
    let metadata = Metadata {
        vertices: entries().map(|t| u64::from(t.vertices)).sum(),
        triangles: entries().map(|t| u64::from(t.owned_triangles)).sum(),
        bounds: if used > 0 { WHOLE } else { Rect::EMPTY },
        ..Metadata::default()
    };
    let lists = Lists {
        sources: vec![Source {
            name: "a.csv".to_owned(),
            records: 7,
            first: 0,
        }],
        crs: Some("EPSG:25832".to_owned()),
        ..Lists::default()
    };
    Directory::new(metadata, lists, KdTree::new(nodes).unwrap(), tiles)
}

/// Writes a directory behind a few kilobytes for each tile. Returns the file.
async fn written(directory: &Directory) -> MemoryFile {
    let file = MemoryFile::default();
    let mut writer = TileWriter::new(file.clone(), front_end_for(directory.metadata.tiles.into()));
    let bytes = vec![1; 220 * directory.tiles.len() + 9000];
    writer.append_core(&bytes.into()).await.unwrap();
    writer.finish(directory).await.unwrap();
    file
}

async fn open(file: &MemoryFile) -> TileReader {
    let opened = TileReader::open_source(file.clone(), "directory", OpenOptions::default()).await;
    opened.unwrap()
}

fn without_layout(directory: &Directory) -> Directory {
    let Directory {
        metadata,
        lists,
        tree,
        tiles,
        ..
    } = directory.clone();
    let metadata = Metadata {
        line_kinds: lists.line_kinds(),
        ..metadata
    };
    Directory::new(metadata, lists, tree, tiles)
}

/// Reads a directory in all ways, and compares it with what was written.
async fn compare(file: &MemoryFile, expected: &Directory, dice: &mut Dice) {
    let reader = open(file).await;
    let whole = reader.directory().await.unwrap();
    assert_eq!(without_layout(&whole), without_layout(expected));
    let next = expected.tiles.len() as u32;
    for id in (0..next + 2).map(TileId) {
        let found = reader.entry(id).await;
        match expected.entry(id) {
            Some(entry) => {
                assert_eq!(found.unwrap(), *entry);
                assert_eq!(reader.entry_in_memory(id), Some(*entry));
            }
            None => assert!(matches!(found, Err(ReadError::NoSuchTile { .. })), "{id}"),
        }
    }
    for _ in 0..50 {
        let p = Point::new(dice.within(-1.2e3, 1.2e3), dice.within(0.0, 8.0));
        assert_eq!(reader.tile_at(p).await.unwrap(), expected.tree.tile_at(p));
    }
    for _ in 0..20 {
        let (x, y) = (dice.within(-1.2e3, 1.2e3), dice.within(0.0, 8.0));
        let rect = Rect::new(x, y, x + dice.within(0.0, 100.0), y + dice.within(0.0, 0.5));
        let found = reader.tiles_where(|bounds| bounds.intersects(rect)).await.unwrap();
        let all = (0..next).map(TileId).filter(|&id| expected.entry(id).is_some());
        let wanted: Vec<TileId> = all
            .filter(|id| expected.tiles[id.0 as usize].bounds.intersects(rect))
            .collect();
        assert_eq!(found, wanted);
    }
}

fn run<T>(work: impl Future<Output = T>) -> T {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    runtime.unwrap().block_on(work)
}

#[test]
fn directories_of_all_sizes_and_orders_are_read_as_they_were_written() {
    run(async {
        let mut dice = Dice(1);
        for (used, next) in [
            (0, 0),
            (0, 200),
            (1, 1),
            (1, 300),
            (2, 2),
            (96, 96),
            (97, 97),
            (700, 1000),
            (3000, 3000),
        ] {
            for in_order in [true, false] {
                let expected = directory(used, next, in_order && used == next, &mut dice);
                compare(&written(&expected).await, &expected, &mut dice).await;
            }
        }
    });
}

/// 70,000 tiles have more pages than a list may have.
#[test]
fn a_directory_with_several_lists_of_pages_is_read_as_it_was_written() {
    run(async {
        let mut dice = Dice(2);
        let expected = directory(70_000, 70_000, true, &mut dice);
        assert!(expected.layout.page_lists.len() > 1);
        compare(&written(&expected).await, &expected, &mut dice).await;
    });
}

#[test]
fn a_change_writes_only_the_pages_on_its_way() {
    run(async {
        let mut dice = Dice(3);
        let file = written(&directory(3000, 3000, true, &mut dice)).await;
        for round in 0..5u32 {
            let reader = open(&file).await;
            let before = reader.directory().await.unwrap();
            let mut after = Directory::clone(&before);
            let mut tiles = after.tiles.clone();
            let [rewritten, relabelled] = [dice.below(3000), dice.below(3000)];
            tiles[rewritten as usize].core.crc ^= 1 << round;
            tiles[rewritten as usize].generation += 1;
            // The tile is as it was, but its page is not.
            tiles[relabelled as usize].table = table(&mut dice);
            after.set_tiles(tiles);
            if round == 3 {
                after.lists.lines.push(LineSource {
                    name: "b.geojson".to_owned(),
                    kind: LineKind::Wall,
                    first: 0,
                    lines: 2,
                    edit: 1,
                });
            }
            if round == 4 {
                // A list that became empty is no longer in the file.
                after.lists.lines.clear();
            }
            let length = reader.file_length();
            let writer = TileWriter::behind(file.clone(), length);
            let now = writer.replace(&after, reader.in_force()).await.unwrap();
            // Two pages, a list of pages and the root, each aligned to a block.
            assert!(now - length <= 5 * (16 << 10), "{}", now - length);
            compare(&file, &after, &mut dice).await;
            let again = open(&file).await;
            assert_eq!(
                (again.generation(), again.file_id()),
                (reader.generation() + 1, reader.file_id())
            );
            // The reader of the generation before sees that one.
            assert_eq!(
                without_layout(&reader.directory().await.unwrap()),
                without_layout(&before)
            );
            let kinds = again.metadata().line_kinds;
            assert_eq!(kinds, if round == 3 { 2 } else { 0 });
        }
    });
}

#[test]
fn readers_share_the_pages_that_an_edit_did_not_change() {
    run(async {
        let mut dice = Dice(4);
        let file = written(&directory(1000, 1000, true, &mut dice)).await;
        let reader = open(&file).await;
        let mut after = Directory::clone(&*reader.directory().await.unwrap());
        let mut tiles = after.tiles.clone();
        tiles[0].core.crc ^= 1;
        after.set_tiles(tiles);
        let cache = Cache::new(1 << 20);
        let with_cache = || TileReader::open_source(file.clone(), "directory", OpenOptions::default().cache(&cache));
        let old = with_cache().await.unwrap();
        for id in [0, 999].map(TileId) {
            old.entry(id).await.unwrap();
        }
        let writer = TileWriter::behind(file.clone(), reader.file_length());
        writer.replace(&after, reader.in_force()).await.unwrap();
        let new = with_cache().await.unwrap();
        // The list of pages is another one, and must be read.
        new.entry(TileId(500)).await.unwrap();
        assert!(new.entry_in_memory(TileId(999)).is_some());
        assert!(new.entry_in_memory(TileId(0)).is_none());
        assert_eq!(new.entry(TileId(0)).await.unwrap(), after.tiles[0]);
        assert_ne!(old.entry(TileId(0)).await.unwrap(), after.tiles[0]);
    });
}
