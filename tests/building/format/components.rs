//! Component tables as the page describes them, and what they must say, computed from the tiles.

use std::collections::{BTreeSet, HashMap};

use delaunay_tiles::Builder;
use delaunay_tiles::geometry::{Orientation, Point, orient2d};
use delaunay_tiles::input::SegmentBatch;
use delaunay_tiles::store::LineKind;

use crate::format::digest::hash;
use crate::format::page::Page;
use crate::format::reader::{File, Tile, Twin};
use crate::format::{compare, options};
use crate::support::{Scratch, batches, runtime};

const HOLE: u8 = 1;
const SEEDED: u8 = 2;
const OPEN: u8 = 4;
const AT_HULL: u8 = 8;

/// What a table says of a component.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Component {
    pub flags: u8,
    pub region: u64,
    pub depth: i64,
    /// The number of triangles that belong to the tile, and the sum of their hashes.
    pub triangles: (u64, u128),
    /// Tiles and components.
    pub links: Vec<(usize, usize)>,
}

impl Component {
    pub fn is_hole(&self) -> bool {
        self.flags & HOLE != 0
    }
}

/// The part of a table that is not read yet.
struct Rest<'a>(&'a [u8]);

impl Rest<'_> {
    fn take(&mut self, count: usize) -> &[u8] {
        let (taken, rest) = self.0.split_at(count);
        self.0 = rest;
        taken
    }

    fn number(&mut self) -> u64 {
        let length = 1 + self.0.iter().position(|byte| byte >> 7 == 0).unwrap();
        let bytes = self.take(length);
        assert!(length == 1 || bytes[length - 1] != 0, "writers take the fewest bytes");
        let sum: u128 = bytes
            .iter()
            .zip(0..)
            .map(|(byte, place)| u128::from(byte & 0x7f) << (7 * place))
            .sum();
        sum.try_into().expect("64 bits")
    }

    /// The numbers 0, 1, 2, 3 stand for 0, −1, 1, −2.
    fn zigzag(&mut self) -> i64 {
        let number = self.number();
        let half = (number / 2) as i64;
        if number.is_multiple_of(2) { half } else { -half - 1 }
    }

    fn component(&mut self, tile: usize) -> Component {
        let flags = self.take(1)[0];
        assert_eq!(flags >> 4, 0);
        let (region, depth) = (self.number(), self.zigzag());
        let count = self.number();
        let sum = match count {
            0 => 0,
            _ => u128::from_le_bytes(self.take(16).try_into().unwrap()),
        };
        let links = (0..self.number()).map(|_| {
            let other = tile as i64 + self.zigzag();
            (usize::try_from(other).unwrap(), self.number() as usize)
        });
        let links: Vec<_> = links.collect();
        assert!(links.is_sorted_by(|a, b| a < b), "links ascend");
        Component {
            flags,
            region,
            depth,
            triangles: (count, sum),
            links,
        }
    }
}

/// Reads the component table of a tile, which is empty if there is none.
pub fn read_table(tile: usize, bytes: &[u8]) -> Vec<Component> {
    if bytes.is_empty() {
        return vec![Component::default()];
    }
    let mut rest = Rest(bytes);
    let count = rest.number();
    assert!(count > 0);
    let components = (0..count).map(|_| rest.component(tile)).collect();
    assert!(rest.0.is_empty());
    components
}

/// Returns, for each triangle of a tile, the smallest triangle that it is connected with within the
/// tile without passing a constraint.
fn sets(tile: &Tile) -> Vec<usize> {
    let count = tile.triangles().count();
    let mut sets = vec![usize::MAX; count];
    for first in 0..count {
        let mut open = vec![first];
        while let Some(triangle) = open.pop() {
            if sets[triangle] != usize::MAX {
                continue;
            }
            sets[triangle] = first;
            for side in (3 * triangle..3 * triangle + 3).filter(|&side| !tile.constraints[side]) {
                if let Twin::HalfEdge(other) = tile.twin(side) {
                    open.push(other / 3);
                }
            }
        }
    }
    sets
}

/// Turns a triangle so that its lexicographically smallest corner, whose tile owns it, comes first.
pub fn from_smallest(mut corners: [(usize, Point); 3]) -> [(usize, Point); 3] {
    while (1..3).any(|other| corners[other].1.lex_cmp(corners[0].1).is_lt()) {
        corners.rotate_left(1);
    }
    corners
}

fn contains([a, b, c]: [Point; 3], p: Point) -> bool {
    let sides = [(a, b), (b, c), (c, a)];
    let is_left = |(from, to)| orient2d(from, to, p) != Orientation::Clockwise;
    sides.into_iter().all(is_left)
}

/// Checks the components of all tiles of a new file. No hole point may lie at a vertex or on a
/// constraint.
pub fn check(file: &File) {
    let has_regions = file.directory.counts[0] > 0;
    type Corners = Vec<(usize, usize)>;
    let named = file.tiles.iter().enumerate().map(|(number, tile)| {
        let corners = tile.triangles().map(|corners| {
            let mut ids = corners.map(|corner| tile.id(number, corner)).to_vec();
            ids.sort_unstable();
            ids
        });
        corners.zip(tile.components.iter().copied()).collect()
    });
    let named: Vec<HashMap<Corners, usize>> = named.collect();
    for (number, tile) in file.tiles.iter().enumerate() {
        let mut expected = vec![Component::default(); tile.table.len()];
        let mut links = vec![BTreeSet::new(); tile.table.len()];
        for (triangle, corners) in tile.triangles().enumerate() {
            let component = tile.components[triangle];
            let this = &mut expected[component];
            let at = from_smallest(corners.map(|corner| tile.corner(file, corner)));
            let points = at.map(|corner| corner.1);
            let owner = at[0].0;
            if owner == number {
                this.triangles.0 += 1;
                this.triangles.1 = this.triangles.1.wrapping_add(hash(&points));
            } else {
                let mut ids = corners.map(|corner| tile.id(number, corner)).to_vec();
                ids.sort_unstable();
                links[component].insert((owner, named[owner][&ids]));
            }
            if file.directory.hole_points.iter().any(|&seed| contains(points, seed)) {
                this.flags |= SEEDED;
            }
            for side in (3 * triangle..3 * triangle + 3).filter(|&side| tile.twin(side) == Twin::Hull) {
                this.flags |= AT_HULL | if tile.constraints[side] { 0 } else { OPEN };
            }
        }
        if has_regions {
            for (component, first) in first_of_components(tile).into_iter().enumerate() {
                if first != component {
                    links[component].insert((number, first));
                }
            }
        } else {
            assert_eq!(tile.table.len(), 1, "tile {number}");
        }
        for ((expected, links), found) in expected.iter_mut().zip(links).zip(&tile.table) {
            expected.links = links.into_iter().collect();
            // The library says the same of regions, or the test fails elsewhere.
            (expected.region, expected.depth) = (found.region, found.depth);
            expected.flags |= found.flags & HOLE;
            for &(other, component) in &found.links {
                let other = &file.tiles[other].table[component];
                assert_eq!(
                    (other.region, other.depth, other.is_hole()),
                    (found.region, found.depth, found.is_hole())
                );
            }
        }
        assert_eq!(tile.table, expected, "tile {number}");
    }
    check_regions(file);
}

/// Returns, for each component, the first one that it is connected with within the tile. Checks
/// that components are connected.
fn first_of_components(tile: &Tile) -> Vec<usize> {
    let sets = sets(tile);
    let mut of_components = vec![None; tile.table.len()];
    let mut first_of_sets = HashMap::new();
    for (&set, &component) in sets.iter().zip(&tile.components) {
        assert_eq!(*of_components[component].get_or_insert(set), set, "it is connected");
        let first = first_of_sets.entry(set).or_insert(component);
        *first = component.min(*first);
    }
    let first = |set: Option<usize>| first_of_sets[&set.expect("no component is empty")];
    of_components.into_iter().map(first).collect()
}

/// Checks that links join the components of each region, and no others: without cores and borders,
/// the tables say what regions there are, which ones are holes, and how many triangles these have.
fn check_regions(file: &File) {
    let d = &file.directory;
    let mut joined: HashMap<(usize, usize), (usize, usize)> = HashMap::new();
    let find = |joined: &HashMap<_, _>, mut id: (usize, usize)| {
        while let Some(&above) = joined.get(&id) {
            id = above;
        }
        id
    };
    let components = || {
        let tiles = file.tiles.iter().enumerate();
        tiles.flat_map(|(number, tile)| {
            let table = tile.table.iter().enumerate();
            table.map(move |(place, component)| ((number, place), component))
        })
    };
    for (id, component) in components() {
        for &link in &component.links {
            let [from, to] = [id, link].map(|id| find(&joined, id));
            if from != to {
                joined.insert(from, to);
            }
        }
    }
    let mut regions: HashMap<(usize, usize), (u64, i64, bool, u8)> = HashMap::new();
    let mut holes = (0, 0u128);
    for (id, component) in components() {
        let of_region = (component.region, component.depth, component.is_hole());
        let (region, depth, is_hole, flags) =
            regions
                .entry(find(&joined, id))
                .or_insert((of_region.0, of_region.1, of_region.2, 0));
        assert_eq!((*region, *depth, *is_hole), of_region);
        *flags |= component.flags;
        if component.is_hole() {
            holes.0 += component.triangles.0;
            holes.1 = holes.1.wrapping_add(component.triangles.1);
        }
    }
    let numbers: BTreeSet<u64> = regions.values().map(|region| region.0).collect();
    if d.triangles > 0 {
        assert_eq!(numbers.len(), regions.len(), "regions have numbers of their own");
        assert!(numbers.into_iter().eq(0..d.counts[0].max(1)));
        assert_eq!(holes, d.digest[3], "the triangles in holes");
    }
    for (_, depth, is_hole, flags) in regions.into_values() {
        let is_seeded = flags & SEEDED != 0;
        let is_outside = d.exterior_is_hole && flags & OPEN != 0;
        assert_eq!(is_hole, depth != 0 || is_seeded || is_outside);
    }
}

/// Houses, some of them with courts, each ring a line of its own, and walled gardens with a hole
/// point.
fn town() -> (Vec<Point>, SegmentBatch, SegmentBatch, Vec<Point>) {
    let ring = |x: f64, y: f64, size: f64, is_court: bool| {
        let mut corners = [[x, y], [x + size, y], [x + size, y + size], [x, y + size]].map(|[x, y]| Point::new(x, y));
        if is_court {
            corners.reverse();
        }
        (0..4).map(move |i| [corners[i], corners[(i + 1) % 4]])
    };
    let (mut houses, mut gardens, mut seeds) = (SegmentBatch::default(), SegmentBatch::default(), Vec::new());
    for (place, (i, j)) in (0..5).flat_map(|i| (0..5).map(move |j| (i, j))).enumerate() {
        let (x, y) = (5.0 * f64::from(i) + 0.75, 5.0 * f64::from(j) + 0.5);
        let add = |batch: &mut SegmentBatch, ring: &mut dyn Iterator<Item = [Point; 2]>| {
            let line = batch.lines.last().map_or(0, |last| last + 1);
            batch.ends.extend(ring);
            batch.lines.resize(batch.ends.len(), line);
            batch.polygons.resize(batch.ends.len(), place as u64);
        };
        match place % 4 {
            3 => {
                add(&mut gardens, &mut ring(x, y, 2.25, false));
                gardens.polygons.clear();
                seeds.push(Point::new(x + 1.2, y + 1.3));
            }
            kind => {
                add(&mut houses, &mut ring(x, y, 3.5, false));
                if kind == 1 {
                    add(&mut houses, &mut ring(x + 1.0, y + 1.0, 1.5, true));
                }
            }
        }
    }
    let points = (0..625).map(|i| Point::new(f64::from(i % 25), f64::from(i / 25)));
    (points.collect(), houses, gardens, seeds)
}

/// Component tables lie in pages and apart.
#[test]
fn component_tables_of_towns_are_readable_from_the_format_page_alone() {
    let (points, houses, gardens, seeds) = town();
    let mut counts = [0; 2];
    for (tile_vertices, exterior) in [(8, false), (40, true), (150, false), (65536, true)] {
        let scratch = Scratch::new();
        let bytes = runtime().block_on(async {
            let options = options(tile_vertices).exterior_is_hole(exterior);
            let mut builder = Builder::new(&scratch.path, options).unwrap();
            builder.push_lines(LineKind::Obstacle, 0, &houses).unwrap();
            builder.push_lines(LineKind::Wall, 100, &gardens).unwrap();
            builder.push_seeds(&seeds).unwrap();
            for batch in batches(&points, &[]) {
                builder.push(&batch).await.unwrap();
            }
            builder.finish().await.unwrap();
            std::fs::read(&scratch.path).unwrap()
        });
        let file = File::read(&Page::read(), &bytes);
        let [in_page, apart] = file.directory.table_counts;
        assert_eq!(in_page + apart, file.tiles.len());
        println!("tiles of {tile_vertices}: {in_page} tables in pages, {apart} apart");
        (counts[0], counts[1]) = (counts[0] + in_page, counts[1] + apart);
        runtime().block_on(compare(&file, bytes));
    }
    assert!(counts[0] > 20 && counts[1] > 20, "{counts:?}");
}
