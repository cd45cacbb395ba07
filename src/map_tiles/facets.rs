//! Triangles and holes of the tiles of a level, in units of a map tile.

use std::collections::BTreeMap;

use crate::geometry::Rect;
use crate::map_tiles::window::{Far, Unit, Window, doubled_area};
use crate::store::Tile;

/// The part of a triangle in a map tile.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Facet {
    /// Clockwise on a screen.
    pub(super) corners: Vec<Unit>,
    /// The lowest and the highest z of the corners of the triangle.
    pub(super) z: Option<[f32; 2]>,
    /// The region, and whether it is a hole, of triangles of the file.
    pub(super) region: Option<(u64, bool)>,
}

/// Triangles and holes in a map tile.
#[derive(Clone, Debug, Default)]
pub(super) struct Facets {
    pub(super) triangles: Vec<Facet>,
    /// The parts of triangles in holes, by region.
    pub(super) holes: BTreeMap<u64, Vec<Vec<Unit>>>,
    /// More triangles than there may be.
    pub(super) too_many: bool,
}

/// What is wanted of a tile.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    /// Whether triangles are, and how many at most.
    pub(super) triangles: Option<usize>,
    /// Whether holes are.
    pub(super) holes: bool,
    /// Whether the tile is one of the file, which has regions.
    pub(super) regions: bool,
}

impl Facets {
    /// Returns what is wanted of the triangles of a tile that meet a map tile. What is not larger
    /// than nothing after rounding is left out.
    pub(super) fn of(tile: &Tile, window: &Window, wanted: Wanted) -> Self {
        let mut this = Self::default();
        let mut positions: Vec<Option<Option<Far>>> = vec![None; tile.corner_count()];
        for triangle in tile.owned_triangles() {
            let corners = tile.corners(triangle);
            let is_hole = wanted.holes && tile.is_hole(triangle);
            let is_wanted = wanted.triangles.is_some() && !this.too_many;
            let meets = || Rect::around(corners.map(|corner| tile.point(corner))).intersects(window.rect());
            if !(is_hole || is_wanted) || !meets() {
                continue;
            }
            let mut position = |i: usize| {
                let corner = corners[i];
                *positions[corner.index()].get_or_insert_with(|| window.units(tile.point(corner)))
            };
            // Clockwise on a screen, whose y goes down.
            let (Some(a), Some(b), Some(c)) = (position(0), position(2), position(1)) else {
                continue;
            };
            if !window.meets(&[a, b, c]) {
                continue;
            }
            let part = window.clip_polygon(&[a, b, c]);
            if part.len() < 3 || doubled_area(&part) <= 0 {
                continue;
            }
            if is_hole {
                this.holes.entry(tile.region(triangle)).or_default().push(part.clone());
            }
            if is_wanted {
                this.too_many = wanted.triangles.is_some_and(|most| this.triangles.len() >= most);
                this.triangles.push(Facet {
                    corners: part,
                    z: range(corners.map(|corner| tile.z(corner))),
                    region: wanted.regions.then(|| (tile.region(triangle), tile.is_hole(triangle))),
                });
            }
        }
        this
    }

    /// Adds what is in another tile. `most` is the number of triangles that there may be.
    pub(super) fn append(&mut self, mut other: Self, most: usize) {
        self.triangles.append(&mut other.triangles);
        for (region, mut parts) in other.holes {
            self.holes.entry(region).or_default().append(&mut parts);
        }
        self.too_many |= other.too_many || self.triangles.len() > most;
        if self.too_many {
            self.triangles.clear();
        }
    }

    /// Sorts all, so that their order does not depend on the tiles.
    pub(super) fn sort(&mut self) {
        for facet in &mut self.triangles {
            facet.corners = first_corner(&facet.corners);
        }
        let bits = |facet: &Facet| (facet.z.map(|z| z.map(f32::to_bits)), facet.region);
        self.triangles
            .sort_unstable_by(|a, b| a.corners.cmp(&b.corners).then_with(|| bits(a).cmp(&bits(b))));
        for parts in self.holes.values_mut() {
            for part in parts.iter_mut() {
                *part = first_corner(part);
            }
            parts.sort_unstable();
        }
    }
}

/// Returns the same polygon from its smallest corner on.
fn first_corner(corners: &[Unit]) -> Vec<Unit> {
    let mut corners = corners.to_vec();
    let first = (0..corners.len()).min_by_key(|&i| corners[i]).unwrap_or(0);
    corners.rotate_left(first);
    corners
}

/// Returns the lowest and the highest of three heights.
fn range(z: [Option<f64>; 3]) -> Option<[f32; 2]> {
    let [a, b, c] = z;
    let (a, b, c) = (a?, b?, c?);
    Some([a.min(b).min(c) as f32, a.max(b).max(c) as f32])
}
