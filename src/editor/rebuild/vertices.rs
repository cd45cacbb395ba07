//! The vertices of a tile, after changes of its points.

use crate::constraints::without_z::NO_Z;
use crate::edit::{Attributes, CallInTile, Missing, PointCall, PointCalls, PointCounts, Positions};
use crate::editor::look_up::look_up;
use crate::geometry::{HalfEdge, Point};
use crate::input::PointBatch;
use crate::mesh::Topology;
use crate::store::{KdTree, Tile};

/// Vertices that go to a builder.
#[derive(Default)]
pub(super) struct NewVertices {
    pub(super) batch: PointBatch,
    /// The places of the vertices in the batch that are no points. They have no record numbers yet.
    pub(super) ends: Vec<usize>,
    /// Calls that change points at vertices which lines and sites hold. These vertices are as before.
    pub(super) left: Vec<PointCall>,
}

/// Carries out the calls in a tile, given all calls by tile. Returns its vertices then, what the calls
/// changed, and those whose points are not there.
pub(super) fn changed_tile(
    tile: &Tile,
    tree: &KdTree,
    calls: &PointCalls,
    by_tile: &[CallInTile],
    has_z: bool,
) -> (NewVertices, PointCounts, Missing) {
    let first = by_tile.partition_point(|(id, _)| *id < tile.id());
    let count = by_tile[first..].partition_point(|(id, _)| *id == tile.id());
    let numbers = &by_tile[first..first + count];
    let mut positions = Positions::named(tree, calls, numbers);
    look_up(tile, &mut positions);
    let mut missing = Missing::default();
    positions.carry_out(calls, numbers, has_z, &mut missing);
    let mut vertices = NewVertices::of(tile, &mut positions, has_z);
    vertices.take_those_at(&positions, has_z);
    (vertices, positions.counts, missing)
}

impl NewVertices {
    /// Takes the vertices of a tile, without points at positions which calls name. Where lines and
    /// sites hold a vertex, it takes it, and the calls that the position needs then.
    pub(super) fn of(tile: &Tile, positions: &mut Positions, has_z: bool) -> Self {
        let mut this = Self::default();
        let is_on_line = on_lines(tile);
        for vertex in tile.vertex_indices() {
            let point = tile.point(vertex);
            let is_input_point = tile.is_input_point(vertex);
            if let Some(position) = positions.at(point) {
                let is_held = tile.is_site(vertex) || is_on_line.get(vertex.index()) == Some(&true);
                if is_input_point && !is_held {
                    continue;
                }
                let (before, now) = (position.before, position.now.take());
                if before != now {
                    let delete = before.map(|_| PointCall::Delete(point));
                    let z_of = |now: Attributes| if has_z { now.z } else { NO_Z };
                    let insert = now.map(|now| PointCall::Insert(point, z_of(now), now.record));
                    this.left.extend(delete.into_iter().chain(insert));
                }
            }
            let record = match is_input_point {
                true => tile.record(vertex),
                false => {
                    this.ends.push(this.batch.len());
                    0
                }
            };
            let z = tile.z(vertex).unwrap_or_default();
            this.take(point, Attributes { z, record }, has_z);
        }
        this
    }

    /// Takes the points that lie at positions after the calls, except where `of` left them to an edit.
    pub(super) fn take_those_at(&mut self, positions: &Positions, has_z: bool) {
        for position in &positions.all {
            if let Some(now) = position.now {
                self.take(position.point, now, has_z);
            }
        }
    }

    fn take(&mut self, point: Point, Attributes { z, record }: Attributes, has_z: bool) {
        self.batch.points.push(point);
        self.batch.records.push(record);
        if has_z {
            self.batch.z.push(z);
        }
    }
}

/// Returns whether each vertex of a tile is on a line; empty if none is.
fn on_lines(tile: &Tile) -> Vec<bool> {
    let mut is_on_line = Vec::new();
    let half_edges = tile.triangle_ids().flat_map(HalfEdge::of_triangle);
    for edge in half_edges.filter(|&edge| tile.is_constraint(edge)) {
        is_on_line.resize(tile.vertex_count() as usize, false);
        for end in [tile.origin(edge), tile.destination(edge)] {
            if let Some(is_on_line) = is_on_line.get_mut(end.index()) {
                *is_on_line = true;
            }
        }
    }
    is_on_line
}
