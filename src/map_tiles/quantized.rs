//! Meshes in the format quantized-mesh-1.0.

use bytes::Bytes;
use quantized_mesh::{EdgeIndices, QuantizedMeshEncoder, QuantizedMeshHeader, QuantizedVertices, TileBounds};

use crate::geometry::Point;
use crate::map_tiles::coord::TerrainCoord;
use crate::mesh::{EngineKind, Triangulation};

/// The number of steps along the side of a tile, and of its heights.
pub(super) const STEPS: u16 = 32767;
/// The number of parts of a side, between the samples on it.
const PARTS: u32 = 32;
/// The number of parts of a tile between the samples in it, if it has few vertices.
const INNER: u32 = 16;
/// Fewer vertices are few.
const FEW: usize = 256;
/// The maximum number of vertices of the file in a tile; of more, there is one in each of so many
/// squares.
const MOST: usize = 1 << 14;
/// The side of these squares in steps.
const SQUARE: u16 = 256;

/// A vertex of a terrain tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MeshVertex {
    /// The steps from the west and from the south.
    pub(super) place: [u16; 2],
    pub(super) z: f64,
}

/// Returns those of the vertices inside a tile that it has, one at each place, and the places at
/// which it has samples.
pub(super) fn places(mut vertices: Vec<MeshVertex>) -> (Vec<MeshVertex>, Vec<[u16; 2]>) {
    let order = |vertex: &MeshVertex| (vertex.place, vertex.z.to_bits());
    vertices.sort_unstable_by_key(order);
    vertices.dedup_by_key(|vertex| vertex.place);
    if vertices.len() > MOST {
        let square = |vertex: &MeshVertex| vertex.place.map(|step| step / SQUARE);
        vertices.sort_by_key(square);
        vertices.dedup_by_key(|vertex| square(vertex));
        vertices.sort_unstable_by_key(order);
    }
    let step = |part: u32, parts: u32| (part * u32::from(STEPS) / parts) as u16;
    let side = (0..=PARTS).map(|part| step(part, PARTS));
    let mut places: Vec<[u16; 2]> = side
        .flat_map(|at| [[at, 0], [at, STEPS], [0, at], [STEPS, at]])
        .collect();
    if vertices.len() < FEW {
        let inner = (1..INNER).flat_map(|row| (1..INNER).map(move |column| [step(column, INNER), step(row, INNER)]));
        let is_free = |place: &[u16; 2]| vertices.binary_search_by_key(place, |vertex| vertex.place).is_err();
        places.extend(inner.filter(is_free));
    }
    places.sort_unstable();
    places.dedup();
    (vertices, places)
}

/// Returns a tile. The heights of the vertices are in metres, NaN where there is no surface.
/// `range` is that of the file in metres.
pub(super) fn encode(at: TerrainCoord, mut vertices: Vec<MeshVertex>, range: [f64; 2]) -> Bytes {
    vertices.sort_unstable_by_key(|vertex| vertex.place);
    // The range as it is read again.
    let [low, high] = range.map(|z| z as f32);
    let span = f64::from(high) - f64::from(low);
    let step = |z: f64| match z.is_nan() || span <= 0.0 {
        true => 0,
        // Conversions saturate.
        false => ((z - f64::from(low)) / span * f64::from(STEPS))
            .round()
            .min(f64::from(STEPS)) as u16,
    };
    let points: Vec<Point> = vertices
        .iter()
        .map(|v| Point::new(v.place[0].into(), v.place[1].into()))
        .collect();
    let mut mesh = Triangulation::default();
    EngineKind::Native.create().triangulate(&points, &mut mesh);
    // Vertices are numbered in the order in which triangles need them, as the encoding of indices
    // expects.
    let mut numbers: Vec<Option<u32>> = vec![None; vertices.len()];
    let mut encoded = QuantizedVertices::with_capacity(vertices.len());
    let mut indices = Vec::with_capacity(3 * mesh.triangles.len());
    for &corner in mesh.triangles.as_flattened() {
        let number = *numbers[corner as usize].get_or_insert_with(|| {
            let MeshVertex { place: [u, v], z } = vertices[corner as usize];
            encoded.push(u, v, step(z));
            encoded.len() as u32 - 1
        });
        indices.push(number);
    }
    let edges = EdgeIndices::from_vertices(&encoded);
    let header = header(at, &encoded, [low, high]);
    QuantizedMeshEncoder::new(header, encoded, indices, edges)
        .encode()
        .into()
}

/// Returns the header of a tile: its spheres, and its range of heights, which is that of the file.
fn header(at: TerrainCoord, vertices: &QuantizedVertices, [low, high]: [f32; 2]) -> QuantizedMeshHeader {
    let bounds = at.bounds();
    let share = |step: u16| f64::from(step) / f64::from(STEPS);
    let places = (0..vertices.len()).map(|i| {
        let height = f64::from(low) + (f64::from(high) - f64::from(low)) * share(vertices.height[i]);
        [
            bounds.min_x + at.side() * share(vertices.u[i]),
            bounds.min_y + at.side() * share(vertices.v[i]),
            height,
        ]
    });
    let tile = TileBounds::new(bounds.min_x, bounds.min_y, bounds.max_x, bounds.max_y);
    QuantizedMeshHeader::from_bounds_with_vertices_iter(&tile, low, high, places)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_on_sides_are_the_same_from_both_tiles() {
        let (_, places) = places(Vec::new());
        let on = |axis: usize, step: u16| -> Vec<u16> {
            places
                .iter()
                .filter(|place| place[axis] == step)
                .map(|place| place[1 - axis])
                .collect()
        };
        for axis in [0, 1] {
            assert_eq!(on(axis, 0), on(axis, STEPS));
            assert_eq!(on(axis, 0).len(), PARTS as usize + 1);
        }
    }

    #[test]
    fn of_very_many_vertices_there_is_one_in_each_square() {
        let vertices = (0..60_000u64).map(|i| {
            let place = [1 + (i * 7919 % 32_766) as u16, 1 + (i * 104_729 % 32_766) as u16];
            MeshVertex { place, z: i as f64 }
        });
        let (kept, places) = places(vertices.collect());
        assert!(kept.len() > 10_000 && kept.len() <= MOST);
        assert_eq!(places.len(), 4 * PARTS as usize);
    }
}
