//! Cells of a raster that threads fill from tiles.
//!
//! In: tiles, in any order and from any thread. Out: a value for each cell, which does not depend on
//! that order to the last bit: either all triangles at a centre give the same bits, or one of them is
//! chosen by a rule of coordinates ([`Measure`](super::Measure)).

use std::cmp::Ordering;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use parking_lot::Mutex;

use super::facet::{Facet, Place};
use super::grid::Window;
use super::measure::Measuring;
use super::scan::scan;
use super::surface::FileSurface;
use crate::geometry::{Point, Rect};
use crate::store::Tile;

/// The bits of a cell that has got no value.
const NONE: u64 = f64::NAN.to_bits();
/// The bits of a cell whose triangle has no value.
const WITHOUT: u64 = NONE | 1;

fn bits(value: f64) -> u64 {
    if value.is_nan() { WITHOUT } else { value.to_bits() }
}

/// The cells of a window, being filled.
pub(crate) struct Cells {
    window: Window,
    surface: FileSurface,
    measuring: Measuring,
    /// The bits of the values, row by row. Relaxed order suffices: no two threads write different bits
    /// to a cell, and what starts and joins the threads orders all else.
    values: Vec<AtomicU64>,
    /// Candidates for centres on the boundaries of triangles.
    candidates: Mutex<Vec<Candidate>>,
}

/// The value of a triangle at a centre on its boundary.
struct Candidate {
    cell: usize,
    /// The corners, sorted.
    corners: [Point; 3],
    value: f64,
}

impl Candidate {
    fn compare(&self, other: &Self) -> Ordering {
        let corners = self.corners.iter().zip(&other.corners);
        let different = corners.map(|(a, b)| a.lex_cmp(*b)).find(|order| order.is_ne());
        self.cell.cmp(&other.cell).then(different.unwrap_or(Ordering::Equal))
    }
}

impl Cells {
    /// Bytes of memory for each cell.
    pub(crate) const BYTES: u64 = size_of::<AtomicU64>() as u64;

    pub(crate) fn new(window: Window, surface: FileSurface, measuring: Measuring) -> Self {
        let cells = window.columns() * window.rows();
        Self {
            values: (0..cells).map(|_| AtomicU64::new(NONE)).collect(),
            candidates: Mutex::default(),
            window,
            surface,
            measuring,
        }
    }

    pub(crate) fn window(&self) -> &Window {
        &self.window
    }

    /// Gives values to the cells whose centres are in triangles that a tile owns.
    pub(crate) fn fill(&self, tile: &Tile) {
        let around = self.window.around_centres();
        let surface = self.surface.in_tile(tile);
        let facets = || {
            let triangles = tile.owned_triangles().filter(|&triangle| {
                let [a, b, c] = tile.triangle_points(triangle);
                Rect::around([a, b, c]).intersects(around)
            });
            triangles.filter_map(|triangle| surface.facet(tile, triangle))
        };
        let mut has_candidates = false;
        for facet in facets() {
            has_candidates |= self.fill_from(&facet);
        }
        if has_candidates {
            // Most centres on boundaries have got their value by now.
            let mut candidates = Vec::new();
            facets().for_each(|facet| self.collect(&facet, &mut candidates));
            self.candidates.lock().append(&mut candidates);
        }
    }

    /// Writes the values of a facet that no other one competes for. Returns whether there are others.
    fn fill_from(&self, facet: &Facet) -> bool {
        let value = self.measuring.of(facet);
        let mut has_others = false;
        scan(facet, &self.window, |column, row, centre, place| {
            if self.measuring.is_continuous() || facet.has_moved(place) {
                let cell = row * self.window.columns() + column;
                self.values[cell].store(bits(value(centre, place)), Relaxed);
            } else {
                has_others = true;
            }
        });
        has_others
    }

    /// Collects the values of a facet for centres on its boundary that have no value yet.
    fn collect(&self, facet: &Facet, candidates: &mut Vec<Candidate>) {
        let value = self.measuring.of(facet);
        scan(facet, &self.window, |column, row, centre, place| {
            let cell = row * self.window.columns() + column;
            if place != Place::Inside && !facet.has_moved(place) && self.values[cell].load(Relaxed) == NONE {
                let mut corners = facet.corners().map(|corner| corner.point);
                corners.sort_by(|a, b| a.lex_cmp(*b));
                candidates.push(Candidate {
                    cell,
                    corners,
                    value: value(centre, place),
                });
            }
        });
    }

    /// Returns the bytes of memory of the values.
    pub(crate) fn bytes(&self) -> u64 {
        Self::BYTES * self.values.len() as u64
    }

    /// Returns the value of a cell; NaN if it has none.
    pub(crate) fn value(&self, column: usize, row: usize) -> f64 {
        f64::from_bits(self.values[row * self.window.columns() + column].load(Relaxed))
    }

    /// Chooses among the candidates, after all tiles.
    pub(crate) fn settle(&self) {
        let mut candidates = std::mem::take(&mut *self.candidates.lock());
        candidates.sort_unstable_by(Candidate::compare);
        for of_cell in candidates.chunk_by(|a, b| a.cell == b.cell) {
            let cell = &self.values[of_cell[0].cell];
            if cell.load(Relaxed) == NONE {
                cell.store(bits(of_cell[0].value), Relaxed);
            }
        }
    }
}
