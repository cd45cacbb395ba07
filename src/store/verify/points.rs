//! Compares the file with its points: every point is a vertex, and every vertex has the position
//! and the z of its record.

use std::sync::Arc;

use futures::stream::StreamExt;

use crate::geometry::{Point, VertexIndex};
use crate::input::PointBatch;
use crate::store::error::ReadError;
use crate::store::format::directory::Directory;
use crate::store::format::ids::TileId;
use crate::store::format::tile::Tile;
use crate::store::pass::{Needs, PassPlan, PassReader, Workspaces, by_tile, list_for, spawn};
use crate::store::reader::TileReader;
use crate::store::verify::error::{VerifyError, VerifyReport};

/// The minimum number of points that are looked up at once.
const LEAST_POINTS: u64 = 1 << 16;
/// Bytes that a lookup takes per vertex of its tile: point and index for the search, and the index
/// of the result.
const BYTES_PER_VERTEX: u64 = (size_of::<(Point, u32)>() + size_of::<u32>()) as u64;

/// A point of the input, and the tile that must have it.
struct SoughtPoint {
    tile: u32,
    record: u64,
    point: Point,
    /// `None` if any z is right.
    z: Option<f64>,
    origin: PointOrigin,
    /// Whether the vertex must have the record number.
    has_record: bool,
}

/// The reason why points given to [`TileReader::verify_points`] are vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointOrigin {
    /// They are points of the input.
    Input,
    /// They are ends of segments, sites, or points at which lines were split.
    Other,
}

/// The vertices of a tile with their indices, in lexicographical order.
type SortedVertices = Vec<(Point, VertexIndex)>;

/// A bit for each vertex that says whether it was found in the input.
struct SeenVertices {
    /// For each tile, the number of its first vertex.
    first: Vec<u64>,
    bits: Vec<u64>,
}

impl TileReader {
    /// Checks that every point of the input is a vertex of the file, and that each vertex has the
    /// position and the z of its record, and says whether a point of the input lies there. After
    /// changes of points, record numbers do not count, and a vertex needs the position and the z of
    /// any record. `next`
    /// fills a batch and returns why its points are vertices, or `None` if there was no batch. A
    /// point of the input takes precedence over others at its position. Vertices of others without
    /// z may have any z: they may have taken it from the surface.
    ///
    /// The points are looked up in parts, with as many points as fit into the memory that the
    /// reader may use, or into 512 MiB. Each part passes over the file once. The check also keeps
    /// one bit per vertex. Must be awaited within a tokio runtime.
    ///
    /// # Errors
    ///
    /// Returns an error for the first point, in the order of the input, that is no vertex; for the
    /// first vertex that is no point; if `next` fails; or if the memory does not suffice for the
    /// bits and a tile.
    pub async fn verify_points<E: std::fmt::Display>(
        &self,
        next: impl FnMut(&mut PointBatch) -> Result<Option<PointOrigin>, E>,
    ) -> Result<VerifyReport, VerifyError> {
        self.for_passes().await?.verify_points(next).await
    }
}

impl PassReader {
    async fn verify_points<E: std::fmt::Display>(
        &self,
        mut next: impl FnMut(&mut PointBatch) -> Result<Option<PointOrigin>, E>,
    ) -> Result<VerifyReport, VerifyError> {
        let directory = self.directory();
        let (plan, at_once) = self.plan_points()?;
        // After changes of points, records have other numbers than in a build of the points.
        let has_records = directory.metadata.last_transaction == 0;
        let mut seen = SeenVertices::new(self);
        let mut batch = PointBatch::default();
        let mut sought = list_for(at_once);
        let vertices = Arc::default();
        let mut points = 0;
        let mut end = None;
        while end.is_none() {
            batch.clear();
            let origin = match next(&mut batch) {
                Ok(Some(origin)) => origin,
                stopped => {
                    end = Some(
                        stopped
                            .map(|_| ())
                            .map_err(|error| VerifyError::Input(error.to_string())),
                    );
                    break;
                }
            };
            for (i, (&point, &record)) in batch.points.iter().zip(&batch.records).enumerate() {
                let point = point.normalized();
                let Some(tile) = directory.tree.tile_at(point) else {
                    end = Some(Err(missing(record, point)));
                    break;
                };
                let z = batch.z.get(i).copied().filter(|z| !z.is_nan());
                let z = match origin {
                    // A point without z has z 0, if the file has z.
                    PointOrigin::Input => Some(z.unwrap_or(0.0)),
                    // Others may have taken it from the surface.
                    PointOrigin::Other => z,
                };
                points += 1;
                sought.push(SoughtPoint {
                    tile: tile.0,
                    record,
                    point,
                    z,
                    origin,
                    has_record: has_records,
                });
                if sought.len() == at_once {
                    sought = self.find(sought, &mut seen, plan, &vertices).await?;
                }
            }
        }
        // Whatever ends the input, a fault before the end is reported first, regardless of the
        // parts.
        self.find(sought, &mut seen, plan, &vertices).await?;
        end.unwrap_or(Ok(()))?;
        if let Some((tile, vertex)) = seen.first_unseen(directory.metadata.vertices) {
            let tile = self.tile(tile).await?;
            return Err(not_of_the_input(&tile, vertex));
        }
        Ok(VerifyReport {
            tiles: directory.metadata.tiles.into(),
            vertices: points,
            ..VerifyReport::default()
        })
    }

    /// Returns the plan of a pass, and the number of points to look up at once.
    fn plan_points(&self) -> Result<(PassPlan, usize), ReadError> {
        let directory = self.directory();
        let needs = |points: u64| Needs {
            fixed: SeenVertices::byte_size(directory) + points * size_of::<SoughtPoint>() as u64,
            per_vertex: BYTES_PER_VERTEX,
            ..Needs::default()
        };
        // The file certainly has room for its vertices, whatever it claims about points.
        self.plan_lookups(
            needs,
            LEAST_POINTS..directory.metadata.vertices,
            size_of::<SoughtPoint>() as u64,
        )
    }

    /// Looks the points up, tile by tile. `vertices` provides workspaces. Returns the memory of
    /// `sought`.
    async fn find(
        &self,
        mut sought: Vec<SoughtPoint>,
        seen: &mut SeenVertices,
        plan: PassPlan,
        vertices: &Arc<Workspaces<SortedVertices>>,
    ) -> Result<Vec<SoughtPoint>, VerifyError> {
        let sorted = spawn(move || {
            sought.sort_unstable_by_key(|s| (s.tile, s.record));
            Arc::new(sought)
        });
        let mut sought = sorted.await?;
        let groups = by_tile(&sought, |s| s.tile);
        let (sought_by_all, vertices) = (Arc::clone(&sought), Arc::clone(vertices));
        let mut lookups = self.for_some_tiles(groups, plan, move |tile, group| {
            let found = vertices.with(|vertices| find_in_tile(&tile, &sought_by_all[group], vertices));
            (tile.id(), found)
        });
        // Points are in the order of their records, so the first missing point does not depend on
        // the parts.
        let mut first_missing: Option<(u64, Point)> = None;
        while let Some(lookup) = lookups.next().await {
            let (tile, found) = lookup?;
            match found {
                Ok(vertices) => vertices.into_iter().for_each(|vertex| seen.set(tile, vertex)),
                Err((record, p)) if first_missing.is_none_or(|(first, _)| record < first) => {
                    first_missing = Some((record, p));
                }
                Err(_) => {}
            }
        }
        drop(lookups);
        if let Some((record, p)) = first_missing {
            return Err(missing(record, p));
        }
        // Finished tasks no longer hold a reference.
        Ok(match Arc::get_mut(&mut sought) {
            Some(sought) => {
                let mut sought = std::mem::take(sought);
                sought.clear();
                sought
            }
            None => Vec::new(),
        })
    }
}

/// Looks up the points that a tile must have. Returns the vertices that match their records, or the
/// first missing point.
fn find_in_tile(
    tile: &Tile,
    group: &[SoughtPoint],
    vertices: &mut Vec<(Point, VertexIndex)>,
) -> Result<Vec<VertexIndex>, (u64, Point)> {
    vertices.clear();
    vertices.extend(tile.points().zip(tile.vertex_indices()));
    vertices.sort_unstable_by(|a, b| a.0.lex_cmp(b.0));
    let mut found = Vec::with_capacity(group.len().min(vertices.len()));
    for s in group {
        let index = vertices.binary_search_by(|v| v.0.lex_cmp(s.point));
        let Ok(index) = index else {
            return Err((s.record, s.point));
        };
        let vertex = vertices[index].1;
        let has_its_z = match (tile.z(vertex), s.z) {
            (Some(z), Some(sought)) => z == sought,
            _ => true,
        };
        // Records are distinct, so at most as many are found as there are vertices.
        let is_input = s.origin == PointOrigin::Input;
        let has_its_record = !s.has_record || tile.record(vertex) == s.record;
        if has_its_record && tile.is_input_point(vertex) == is_input && has_its_z {
            found.push(vertex);
        }
    }
    Ok(found)
}

/// Returns the error for a vertex that is no point of the input.
fn not_of_the_input(tile: &Tile, vertex: VertexIndex) -> VerifyError {
    let (record, p) = (tile.record(vertex), tile.point(vertex));
    let what = match tile.is_input_point(vertex) {
        true => "point",
        false => "end of a segment, site or crossing",
    };
    VerifyError::Points(format!(
        "vertex {vertex} of tile {} at ({}, {}) says that it is record {record}, a {what}, but that record has another position or another z, or is none",
        tile.id(),
        p.x,
        p.y
    ))
}

fn missing(record: u64, p: Point) -> VerifyError {
    VerifyError::Points(format!("record {record} at ({}, {}) is not in the file", p.x, p.y))
}

impl SeenVertices {
    /// Returns the size in bytes. The numbers per tile count with the directory.
    fn byte_size(directory: &Directory) -> u64 {
        let vertices = directory.tiles.iter().map(|tile| u64::from(tile.vertices));
        vertices.sum::<u64>() / 8
    }

    fn new(reader: &PassReader) -> Self {
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

    fn set(&mut self, tile: TileId, vertex: VertexIndex) {
        let number = self.first[tile.0 as usize] + u64::from(vertex.0);
        self.bits[(number / 64) as usize] |= 1 << (number % 64);
    }

    fn first_unseen(&self, total: u64) -> Option<(TileId, VertexIndex)> {
        let word = self.bits.iter().position(|&word| word != u64::MAX)?;
        let number = 64 * word as u64 + u64::from(self.bits[word].trailing_ones());
        if number >= total {
            return None;
        }
        let tile = self.first.partition_point(|&first| first <= number) - 1;
        Some((TileId(tile as u32), VertexIndex((number - self.first[tile]) as u32)))
    }
}
