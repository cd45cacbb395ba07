//! Pages with component tables.

use super::*;
use crate::store::format::kd_tree::KdNode;
use crate::store::format::limits::{MAX_PAGE, PAGE_TILES};

const WHOLE: Rect = Rect::new(-3.0, 0.5, 70.0, 9.0);
const FRAME: Frame = Frame {
    bounds: WHOLE,
    next_tile: 10_000,
    file_length: 1 << 30,
};

fn entry(tile: u32, table: TablePlace) -> TileEntry {
    TileEntry {
        core: Extent::raw(1 << 20, 160, tile),
        border: Extent::raw(1 << 21, 60, tile),
        generation: 1,
        vertices: 10,
        core_triangles: 0,
        border_triangles: 10,
        owned_triangles: 5,
        bounds: WHOLE,
        table,
    }
}

/// Returns a page from tile 500 on. Its leaves name tiles in reverse order, so each must be stored,
/// and its tree is as deep as can be.
fn page(tables: Vec<TablePlace>) -> Page {
    let entries: Vec<TileEntry> = tables.into_iter().zip(500..).map(|(t, id)| entry(id, t)).collect();
    let count = entries.len() as u32;
    let mut nodes = Vec::new();
    for leaf in (0..count).rev() {
        if leaf > 0 {
            nodes.push(KdNode::X {
                cut: f64::from(leaf) / 3.0,
                right: nodes.len() as u32 + 2,
            });
        }
        nodes.push(KdNode::Leaf(TileId(500 + leaf)));
    }
    Page {
        first: 500,
        entries,
        tree: KdTree::new(nodes).unwrap(),
    }
}

fn short(length: usize) -> TablePlace {
    let bytes: Vec<u8> = (0..length).map(|i| (i + length) as u8).collect();
    TablePlace::InPage(ShortTable::new(&bytes).unwrap())
}

fn decoded(page: &Page, bytes: &[u8]) -> Result<Page, Damage> {
    let extent = Extent::raw(1 << 22, bytes.len() as u32, crc32c::crc32c(bytes));
    let next = page.first + page.entries.len() as u32;
    Page::decode(bytes, &page.at(extent, WHOLE), next, &FRAME)
}

#[test]
fn the_longest_page_is_within_the_limit() {
    let longest = page(vec![short(ShortTable::MAX); PAGE_TILES as usize]);
    let bytes = longest.encode();
    println!("{} bytes", bytes.len());
    assert!(bytes.len() as u64 <= MAX_PAGE, "{} bytes", bytes.len());
    assert_eq!(decoded(&longest, &bytes), Ok(longest));
    // A place apart takes less than the longest table.
    let apart = TablePlace::Apart(Extent::raw(u64::from(u32::MAX), 1 << 20, 7));
    for count in [1, 50, 96] {
        let mut tables = vec![short(ShortTable::MAX); PAGE_TILES as usize];
        tables[..count].fill(apart);
        assert!(page(tables).encode().len() <= bytes.len());
    }
}

#[test]
fn pages_with_tables_of_all_kinds_are_decoded_as_they_were_encoded() {
    let apart = |at: u64| TablePlace::Apart(Extent::raw(8192 + 8 * at, 57 + 3 * at as u32, 9 + at as u32));
    let kinds = |place: usize| match place % 5 {
        0 => TablePlace::Nowhere,
        1 => short(1),
        2 => short(1 + place % ShortTable::MAX),
        3 => apart(place as u64),
        _ => short(ShortTable::MAX),
    };
    for tables in [
        vec![TablePlace::Nowhere; 20],
        vec![short(30); 20],
        vec![apart(3); 20],
        (0..96).map(kinds).collect(),
        (0..5).rev().map(kinds).collect(),
    ] {
        let page = page(tables);
        assert_eq!(decoded(&page, &page.encode()), Ok(page));
    }
}

#[test]
fn tables_of_numbers_that_are_not_in_use_and_extents_out_of_the_file_are_damage() {
    let mut unused = page(vec![short(30); 3]);
    unused.entries[1] = TileEntry {
        table: short(7),
        ..TileEntry::UNUSED
    };
    let damage = decoded(&unused, &unused.encode()).unwrap_err();
    assert!(damage.to_string().contains("wrong lengths"), "{damage}");
    for extent in [
        Extent::raw(0, 80, 1),
        Extent::raw(FRAME.file_length - 79, 80, 1),
        Extent::raw(u64::MAX - 7, 80, 1),
        Extent::raw(8192, (64 << 20) + 1, 1),
    ] {
        let outside = page(vec![short(30), TablePlace::Apart(extent)]);
        let damage = decoded(&outside, &outside.encode()).unwrap_err();
        assert!(damage.to_string().contains("a component table"), "{damage}");
    }
}

#[test]
fn short_tables_hold_at_most_the_limit() {
    let bytes = [7; ShortTable::MAX + 1];
    assert!(ShortTable::new(&[]).is_none());
    assert!(ShortTable::new(&bytes).is_none());
    let longest = ShortTable::new(&bytes[1..]).unwrap();
    assert_eq!(longest.bytes(), &bytes[1..]);
    let place = TablePlace::InPage(longest);
    assert!(place.holds(&bytes[1..]) && !place.holds(&bytes) && !place.holds(&[]));
    let extent = Extent::raw(8192, bytes.len() as u32, crc32c::crc32c(&bytes));
    let apart = TablePlace::Apart(extent);
    assert!(apart.holds(&bytes) && !apart.holds(&bytes[1..]) && !apart.holds(&[0; ShortTable::MAX + 1]));
    assert!(TablePlace::Nowhere.holds(&[]) && !TablePlace::Nowhere.holds(&[0]));
}
