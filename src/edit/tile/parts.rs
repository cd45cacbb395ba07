//! The parts of a tile, which become its components when it is written.

use crate::collections::union_find::UnionFind;
use crate::edit::tile::{EditTile, TriangleOrder};
use crate::geometry::{HalfEdge, TriangleId};
use crate::mesh::{Topology, Twin};
use crate::store::Tile;

/// A division of the triangles of a tile: the part of each triangle, and the number of parts.
pub(crate) struct TileParts {
    of_triangles: Vec<u32>,
    count: u32,
}

impl TileParts {
    /// Finds the sets of triangles that are connected within a tile without crossing a constraint.
    /// They are numbered by their first triangles.
    pub(crate) fn of(tile: &EditTile, order: &TriangleOrder) -> Self {
        let triangle_count = tile.triangle_count();
        let mut sets = UnionFind::new(triangle_count);
        for triangle in order.all() {
            for half_edge in HalfEdge::of_triangle(triangle) {
                if let Twin::HalfEdge(twin) = tile.twin(half_edge)
                    && twin < half_edge
                    && !tile.is_constraint(half_edge)
                {
                    sets.union(triangle.0, twin.triangle().0);
                }
            }
        }
        let mut this = Self {
            // Entries of removed triangles mean nothing.
            of_triangles: vec![0; triangle_count as usize],
            count: 0,
        };
        let mut of_sets = vec![None; triangle_count as usize];
        for triangle in order.all() {
            this.of_triangles[triangle.index()] = *of_sets[sets.find(triangle.0) as usize].get_or_insert_with(|| {
                this.count += 1;
                this.count - 1
            });
        }
        this
    }

    /// Returns the one part that a tile is in a file without regions; none without triangles.
    pub(crate) fn whole(tile: &EditTile, order: &TriangleOrder) -> Self {
        Self {
            of_triangles: vec![0; tile.triangle_count() as usize],
            // Not all entries are triangles: some are of removed ones.
            count: u32::from(order.all().next().is_some()),
        }
    }

    /// Returns the components that a tile has in the file.
    pub(crate) fn stored(tile: &Tile) -> Self {
        Self {
            of_triangles: tile.triangle_ids().map(|t| tile.component_number(t)).collect(),
            count: match tile.triangle_ids().next() {
                Some(_) => tile.component_count(),
                None => 0,
            },
        }
    }

    /// Returns the part of a triangle.
    pub(crate) fn of_triangle(&self, triangle: TriangleId) -> u32 {
        self.of_triangles[triangle.index()]
    }

    /// Returns the number of parts.
    pub(crate) fn count(&self) -> u32 {
        self.count
    }
}
