//! Volumes between a surface and a level.
//!
//! In: an open tile file, a level and polygons. Out: the volumes above and below the level, from one
//! pass over the tiles that meet the polygons. The prism of each triangle is exact but for rounding; one
//! that the level cuts is three prisms. All are added [without rounding](super::exact_sum), so that the
//! sums do not depend on the order of the triangles.

use std::sync::Arc;

use futures::future::FutureExt;
use futures::stream::StreamExt;

use super::clip::{Clip, Side};
use super::error::TerrainError;
use super::exact_sum::ExactSum;
use super::facet::{Facet, Place};
use super::overlap::overlap;
use super::surface::{FileSurface, Surface, TileSurface};
use crate::store::{Needs, Tile, TileId, TileReader};

/// Bytes of memory that the overlap with a triangle takes for each edge of polygons there.
const PER_EDGE: u64 = 160;

/// The volumes between a surface and a horizontal plane.
///
/// The [example of `TileReader::volume`](crate::store::TileReader::volume) uses it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct Volume {
    /// The volume below the surface and above the plane: what has to be removed to make the surface
    /// level. In units of the coordinates squared, times those of z.
    pub cut: f64,
    /// The volume above the surface and below the plane: what has to be added.
    pub fill: f64,
    /// The area of the triangles that count, in the polygons, as seen from above. In units of the
    /// coordinates squared.
    pub area: f64,
    /// The area where the surface is above the plane. Where it is exactly in the plane, it is neither
    /// above nor below it.
    pub area_above: f64,
    /// The area where the surface is below the plane.
    pub area_below: f64,
}

impl Volume {
    /// Adds what a triangle of the surface has, given its area and the heights of its corners above the
    /// plane.
    fn add(&mut self, area: f64, heights: [f64; 3]) {
        self.area += area;
        let count = |is_so: fn(&f64) -> bool| heights.iter().filter(|&height| is_so(height)).count();
        let (above, below) = (count(|&height| height > 0.0), count(|&height| height < 0.0));
        let mean = heights.iter().sum::<f64>() / 3.0;
        match (above, below) {
            // Heights so large that their sum is no number. The total is then none either.
            _ if mean.is_nan() => self.cut = mean,
            (0, 0) => {}
            (_, 0) => {
                self.cut += area * mean;
                self.area_above += area;
            }
            (0, _) => {
                self.fill -= area * mean;
                self.area_below += area;
            }
            _ => self.add_crossing(area, heights, above < below || (above == below && heights[0] > 0.0)),
        }
    }

    /// Adds what a triangle has that the plane cuts. `is_above` says whether the one corner on its side
    /// is above the plane; the other two are below it, or one of them is in it.
    fn add_crossing(&mut self, area: f64, heights: [f64; 3], is_above: bool) {
        let is_alone = |height: &f64| if is_above { *height > 0.0 } else { *height < 0.0 };
        let first = heights.iter().position(is_alone).unwrap_or(0);
        let [tip, one, other] = [0, 1, 2].map(|i| heights[(first + i) % 3].abs());
        // The shares of the two sides at the tip that are on the tip's side. No difference cancels.
        let (to_one, to_other) = (tip / (tip + one), tip / (tip + other));
        let (past_one, past_other) = (one / (tip + one), other / (tip + other));
        let of_tip = area * to_one * to_other;
        // The rest is a quadrangle, cut by a diagonal from the other corner to the first side.
        let of_rest = [area * past_one, area * to_one * past_other];
        let tip_volume = of_tip * tip / 3.0;
        let rest_volume = (of_rest[0] * (one + other) + of_rest[1] * other) / 3.0;
        let rest = of_rest[0] + of_rest[1];
        let of_side = |is_above: bool, alone: f64, rest: f64| if is_above { [alone, rest] } else { [rest, alone] };
        let [cut, fill] = of_side(is_above, tip_volume, rest_volume);
        let [area_above, area_below] = of_side(is_above, of_tip, rest);
        self.cut += cut;
        self.fill += fill;
        self.area_above += area_above;
        self.area_below += area_below;
    }

    /// Returns what a facet has, in polygons if there are any.
    fn of(facet: &Facet, level: f64, clip: Option<&Clip>) -> Self {
        let mut volume = Self::default();
        let corners = facet.corners();
        let points = corners.map(|corner| corner.point);
        match clip.map_or(Side::Inside, |clip| clip.side(points)) {
            Side::Outside => {}
            Side::Inside => volume.add(facet.doubled_area() / 2.0, corners.map(|corner| corner.z - level)),
            Side::Both => {
                if let Some(clip) = clip {
                    let height = |p| facet.z_at(p, Place::Inside) - level;
                    overlap(points, clip, |piece, area| volume.add(area, piece.map(height)));
                }
            }
        }
        volume
    }
}

/// The sums of a [`Volume`], in the order of its fields.
#[derive(Clone, Default)]
struct Sums([ExactSum; 5]);

impl Sums {
    fn add(&mut self, volume: Volume) {
        let Volume {
            cut,
            fill,
            area,
            area_above,
            area_below,
        } = volume;
        let numbers = [cut, fill, area, area_above, area_below];
        self.0.iter_mut().zip(numbers).for_each(|(sum, number)| sum.add(number));
    }

    fn merge(&mut self, other: Self) {
        self.0.iter_mut().zip(other.0).for_each(|(sum, other)| sum.merge(other));
    }

    /// Returns the rounded sums; `None` if one is too large.
    fn total(&self) -> Option<Volume> {
        let [cut, fill, area, area_above, area_below] = [0, 1, 2, 3, 4].map(|i| self.0[i].total());
        Some(Volume {
            cut: cut?,
            fill: fill?,
            area: area?,
            area_above: area_above?,
            area_below: area_below?,
        })
    }

    /// Returns the sums over the triangles that a tile owns.
    ///
    /// # Errors
    /// Fails if a triangle is not counter-clockwise, which valid files do not have.
    fn of(tile: &Tile, level: f64, surface: &TileSurface, clip: Option<&Clip>) -> Result<Self, String> {
        let mut sums = Self::default();
        for triangle in tile.owned_triangles() {
            if let Some(facet) = surface.checked_facet(tile, triangle)? {
                sums.add(Volume::of(&facet, level, clip));
            }
        }
        Ok(sums)
    }
}

/// Volumes of the surface.
impl TileReader {
    /// Returns the volumes between the surface and the horizontal plane at `level`, in polygons if there
    /// are any. Where polygons overlap, the surface counts once.
    ///
    /// Reads the tiles that meet the polygons, and all tiles before if triangles are left out [from the
    /// hull](Surface::from_hull). The result does not depend on tiles, threads and memory,
    /// to the last bit. The memory that the reader may use is that of the pass; the polygons, with
    /// [`Clip::bytes`], come on top of it. Must be awaited within a tokio runtime.
    ///
    /// # Errors
    /// Fails if the file has no z, if a tile cannot be read, if the memory that the reader may use does
    /// not suffice, or if a volume is too large to be a number.
    ///
    /// # Examples
    ///
    /// ```
    /// # use delaunay_tiles::{BuildOptions, Builder, OpenOptions, Point, TileReader, input::PointBatch};
    /// use delaunay_tiles::terrain::{Clip, Surface};
    /// use std::sync::Arc;
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("slope.tiles");
    /// # tokio::runtime::Runtime::new()?.block_on(async {
    /// # let points: Vec<Point> = (0..441).map(|i| Point::new(f64::from(i % 21), f64::from(i / 21))).collect();
    /// # let z = points.iter().map(|p| p.x).collect();
    /// # let options = BuildOptions::default().tile_vertices(100);
    /// # let mut builder = Builder::new(&path, options)?;
    /// # builder.push(&PointBatch { records: (0..441).collect(), points, z }).await?;
    /// # builder.finish().await?;
    /// // A square of 20 by 20 that rises from 0 in the west to 20 in the east.
    /// let slope = TileReader::open(&path, OpenOptions::default()).await?;
    /// let volume = slope.volume(5.0, Surface::default(), None).await?;
    /// assert!((volume.cut - 20.0 * 15.0 * 15.0 / 2.0).abs() < 1e-9);
    /// assert!((volume.fill - 20.0 * 5.0 * 5.0 / 2.0).abs() < 1e-9);
    ///
    /// let corners = [(0.0, 0.0), (6.0, 0.0), (6.0, 2.5), (0.0, 2.5)].map(|(x, y)| Point::new(x, y));
    /// let clip = Clip::new((0..4).map(|i| [corners[i], corners[(i + 1) % 4]]).collect());
    /// let volume = slope.volume(5.0, Surface::default(), Some(Arc::new(clip))).await?;
    /// assert!((volume.cut - 2.5 * 0.5).abs() < 1e-9 && (volume.area - 15.0).abs() < 1e-9);
    /// # Ok(())
    /// # })
    /// # }
    /// ```
    pub fn volume(
        &self,
        level: f64,
        surface: Surface,
        clip: Option<Arc<Clip>>,
    ) -> impl Future<Output = Result<Volume, TerrainError>> + Send {
        async move {
            if !self.metadata().has_z {
                return Err(TerrainError::no_z(self));
            }
            let reader = self.for_passes().await?;
            let surface = FileSurface::of(&reader, surface, || {}).await?;
            let directory = reader.directory();
            let meets = |id: &TileId| {
                let bounds = directory.tiles[id.0 as usize].bounds;
                clip.as_ref().is_none_or(|clip| clip.bounds().intersects(bounds))
            };
            let tiles = directory.tile_ids().filter(meets).map(|id| (id, ())).collect();
            let of_clip = Needs {
                // The polygons are the caller's, and beside the memory of the reader.
                fixed: 0,
                // All edges may be in one triangle.
                per_thread: clip.as_ref().map_or(0, |clip| PER_EDGE * clip.edge_count()),
                per_vertex: 0,
            };
            let plan = reader.plan(of_clip.and(surface.needs()))?;
            let mut passes = reader.for_some_tiles(tiles, plan, move |tile, ()| {
                let sums = Sums::of(&tile, level, &surface.in_tile(&tile), clip.as_deref());
                (tile.id(), sums.map(Box::new))
            });
            let mut total = Sums::default();
            while let Some(done) = passes.next().await {
                let (id, sums) = done?;
                total.merge(*sums.map_err(|reason| reader.damaged(id, reason))?);
            }
            total.total().ok_or_else(|| TerrainError::TooLarge {
                file: self.name().to_owned(),
            })
        }
        .boxed()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against sums of thin strips, for all signs and orders of heights.
    #[test]
    fn a_prism_that_the_plane_cuts_has_the_parts_above_and_below() {
        let heights = [-2.0, -0.5, 0.0, 1.0, 3.0];
        for (a, b, c) in heights
            .iter()
            .flat_map(|&a| heights.iter().map(move |&b| (a, b)))
            .flat_map(|(a, b)| heights.iter().map(move |&c| (a, b, c)))
        {
            let mut volume = Volume::default();
            volume.add(0.5, [a, b, c]);
            // The triangle (0, 0), (1, 0), (0, 1), row by row; each row is a linear function.
            let rows = 20_000;
            let [mut cut, mut fill, mut above] = [0.0; 3];
            for row in 0..rows {
                let y = (f64::from(row) + 0.5) / f64::from(rows);
                let (left, right, length) = (a + (c - a) * y, b + (c - b) * y, 1.0 - y);
                let positive = |p: f64, q: f64| match (p > 0.0, q > 0.0) {
                    (true, true) => ((p + q) / 2.0, 1.0),
                    (false, false) => (0.0, 0.0),
                    _ => (p.max(q) * p.max(q) / (p - q).abs() / 2.0, p.max(q) / (p - q).abs()),
                };
                cut += positive(left, right).0 * length / f64::from(rows);
                above += positive(left, right).1 * length / f64::from(rows);
                fill += positive(-left, -right).0 * length / f64::from(rows);
            }
            let close = |x: f64, y: f64| (x - y).abs() < 1e-4;
            assert!(
                close(volume.cut, cut) && close(volume.fill, fill),
                "{a} {b} {c}: {volume:?}, {cut} {fill}"
            );
            assert!(close(volume.area_above, above), "{a} {b} {c}: {volume:?}, {above}");
            assert!((volume.cut - volume.fill - 0.5 * (a + b + c) / 3.0).abs() < 1e-12);
            let whole = if (a, b, c) == (0.0, 0.0, 0.0) { 0.0 } else { 0.5 };
            assert!((volume.area_above + volume.area_below - whole).abs() < 1e-12 && volume.area == 0.5);
        }
    }
}
