//! The file against its input: every point is a vertex, and every vertex is the record that it says.

use futures::stream::StreamExt;

use super::{VerifyError, VerifyReport};
use crate::geometry::Point;
use crate::input::PointBatch;
use crate::store::{Tile, TileId, TileReader};

/// A point of the input, by the tile that must have it.
struct Sought {
    tile: u32,
    record: u64,
    point: Point,
    z: f64,
}

/// Which vertices have been found in the input.
struct Seen {
    /// For each tile the number of its first vertex.
    first: Vec<u64>,
    bits: Vec<u64>,
}

impl TileReader {
    /// Checks that every point of the input is a vertex of the file, and that the record of every vertex lies where the
    /// vertex does, with the same z. `next` fills batches and says whether there was one.
    ///
    /// The file is read once for each `memory` bytes of points; beyond that, memory grows by a bit for each vertex. Must be
    /// awaited within a tokio runtime.
    ///
    /// # Errors
    /// The first point or vertex without its like, or what `next` says.
    pub async fn verify_points<E: std::fmt::Display>(
        &self,
        mut next: impl FnMut(&mut PointBatch) -> Result<bool, E>,
        memory: u64,
    ) -> Result<VerifyReport, VerifyError> {
        let at_once = (memory / size_of::<Sought>() as u64).clamp(1 << 12, 1 << 28) as usize;
        let tree = &self.directory().tree;
        let mut seen = Seen::new(self);
        let mut batch = PointBatch::default();
        let mut sought = Vec::new();
        let mut points = 0;
        loop {
            batch.clear();
            let more = next(&mut batch).map_err(|error| VerifyError::Input(error.to_string()))?;
            for (i, (&point, &record)) in batch.points.iter().zip(&batch.records).enumerate() {
                let point = point.normalized();
                let Some(tile) = tree.tile_at(point) else {
                    return Err(missing(record, point));
                };
                let z = batch.z.get(i).copied().unwrap_or(0.0);
                points += 1;
                sought.push(Sought {
                    tile: tile.0,
                    record,
                    point,
                    z,
                });
            }
            if !more || sought.len() >= at_once {
                self.find(&mut sought, &mut seen).await?;
                sought.clear();
            }
            if !more {
                break;
            }
        }
        if let Some((tile, vertex)) = seen.first_unseen(self.directory().metadata.vertices) {
            let tile = self.tile(tile).await?;
            let (record, p) = (tile.record(vertex), tile.point(vertex));
            return Err(VerifyError::Points(format!(
                "vertex {vertex} of tile {} at ({}, {}) says that it is record {record}, but that lies elsewhere or has another z",
                tile.id(),
                p.x,
                p.y
            )));
        }
        Ok(VerifyReport {
            tiles: self.directory().tiles.len() as u64,
            vertices: points,
            ..VerifyReport::default()
        })
    }

    /// Looks the points up, tile by tile.
    async fn find(&self, sought: &mut [Sought], seen: &mut Seen) -> Result<(), VerifyError> {
        sought.sort_unstable_by_key(|s| (s.tile, s.record));
        let groups: Vec<&[Sought]> = sought.chunk_by(|a, b| a.tile == b.tile).collect();
        let mut tiles = self.scan(groups.iter().map(|group| TileId(group[0].tile)).collect());
        for group in groups {
            let Some(tile) = tiles.next().await else { break };
            find_in_tile(&*tile?, group, seen)?;
        }
        Ok(())
    }
}

fn find_in_tile(tile: &Tile, group: &[Sought], seen: &mut Seen) -> Result<(), VerifyError> {
    let mut vertices: Vec<(Point, u32)> = tile.points().zip(0..).collect();
    vertices.sort_unstable_by(|a, b| a.0.lex_cmp(b.0));
    for s in group {
        let place = vertices.binary_search_by(|v| v.0.lex_cmp(s.point));
        let Ok(place) = place else {
            return Err(missing(s.record, s.point));
        };
        let vertex = vertices[place].1;
        let z = tile.z(vertex).unwrap_or(0.0);
        if tile.record(vertex) == s.record && (z == s.z || tile.z(vertex).is_none()) {
            seen.set(tile.id(), vertex);
        }
    }
    Ok(())
}

fn missing(record: u64, p: Point) -> VerifyError {
    VerifyError::Points(format!("record {record} at ({}, {}) is not in the file", p.x, p.y))
}

impl Seen {
    fn new(reader: &TileReader) -> Self {
        let mut total = 0;
        let first = reader.directory().tiles.iter().map(|tile| {
            total += u64::from(tile.vertices);
            total - u64::from(tile.vertices)
        });
        let first = first.collect();
        Self {
            first,
            bits: vec![0; total.div_ceil(64) as usize],
        }
    }

    fn set(&mut self, tile: TileId, vertex: u32) {
        let number = self.first[tile.0 as usize] + u64::from(vertex);
        self.bits[(number / 64) as usize] |= 1 << (number % 64);
    }

    fn first_unseen(&self, total: u64) -> Option<(TileId, u32)> {
        let word = self.bits.iter().position(|&word| word != u64::MAX)?;
        let number = 64 * word as u64 + u64::from(self.bits[word].trailing_ones());
        if number >= total {
            return None;
        }
        let tile = self.first.partition_point(|&first| first <= number) - 1;
        Some((TileId(tile as u32), (number - self.first[tile]) as u32))
    }
}
