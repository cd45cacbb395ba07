//! Profiles: the heights of a surface along a line.
//!
//! In: an open tile file and a line. Out: the points where the line crosses edges of triangles that
//! count, and its corners, with their heights. Between two points that follow each other the height is
//! linear, so nothing is lost.
//!
//! Each triangle gives a [link](super::chord::Link) from the point where a segment of the line enters
//! it to the one where it leaves it. These points have names that all triangles there agree on, so
//! links of different tiles are joined by name. No coordinate is compared with a tolerance.

use std::collections::HashMap;

use futures::future::FutureExt;
use futures::stream::{self, StreamExt, TryStreamExt};

use super::chord::{Link, Mark, Station, chord};
use super::error::TerrainError;
use super::strips::Strips;
use super::surface::{FileSurface, Surface, TileSurface};
use crate::geometry::{Point, Rect, segment_meets};
use crate::store::{Tile, TileReader};

/// The number of tiles that are read ahead.
const AHEAD: usize = 4;

/// The heights of a surface along a line.
///
/// The [example of `TileReader::profile`](crate::store::TileReader::profile) uses it.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct Profile {
    /// The length of the line, in units of the coordinates.
    pub length: f64,
    /// The parts of the line that are on the surface, in order. Between them are gaps: the line is
    /// outside of the hull, in holes, or in triangles that do not count.
    pub parts: Vec<ProfilePart>,
}

/// A part of a line that is on the surface from its first to its last point. A line that only touches
/// the surface has a part of one point there.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct ProfilePart {
    /// The points, in order: where the part begins and ends, and between them each corner of the line
    /// and each place where it crosses an edge or meets a vertex of the triangulation. Between two of
    /// them, the surface is a straight line. Two edges that cross the line closer to each other than
    /// coordinates can tell have two points at the same position.
    pub points: Vec<ProfilePoint>,
}

/// A point of a line on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct ProfilePoint {
    /// The distance from the beginning of the line, along the line and horizontally, in units of the
    /// coordinates.
    pub distance: f64,
    /// The position. Where the line crosses an edge, this is the exact crossing point, with each
    /// coordinate rounded once.
    pub point: Point,
    /// The height of the surface.
    pub z: f64,
}

impl Profile {
    /// Returns the distances from the beginning of the line between which it is not on the surface, in
    /// order.
    #[must_use]
    pub fn gaps(&self) -> Vec<[f64; 2]> {
        let ends = |part: &ProfilePart| Some([part.points.first()?.distance, part.points.last()?.distance]);
        let mut gaps = Vec::new();
        let mut reached = 0.0;
        for [from, to] in self.parts.iter().filter_map(ends) {
            gaps.push([reached, from]);
            reached = to;
        }
        gaps.push([reached, self.length]);
        gaps.retain(|[from, to]| from < to);
        gaps
    }
}

/// The line of a profile.
struct Line {
    corners: Vec<Point>,
    /// The distance of each corner from the beginning.
    distances: Vec<f64>,
    /// The segments, found by their place.
    segments: Strips,
}

impl Line {
    /// # Errors
    /// Fails if the line has no length, too many points, or a point whose coordinates are too large or
    /// not finite.
    fn new(points: &[Point]) -> Result<Self, TerrainError> {
        let refused = |reason: String| Err(TerrainError::Line { reason });
        let mut corners: Vec<Point> = points.iter().map(|point| point.representable()).collect();
        if let Some(bad) = corners.iter().find(|point| !point.is_valid()) {
            return refused(format!(
                "its point ({:?}, {:?}) is not finite, or its coordinates are beyond {:?}",
                bad.x,
                bad.y,
                Point::MAX_MAGNITUDE
            ));
        }
        corners.dedup();
        if corners.len() < 2 {
            return refused("it has no two different points".to_owned());
        }
        if corners.len() > Strips::MAX {
            return refused(format!("it has {} points, and can have {}", corners.len(), Strips::MAX));
        }
        let segments: Vec<[Point; 2]> = corners.windows(2).map(|ends| [ends[0], ends[1]]).collect();
        let mut distances = vec![0.0];
        for &[a, b] in &segments {
            distances.push(distances[distances.len() - 1] + (b.x - a.x).hypot(b.y - a.y));
        }
        Ok(Self {
            corners,
            distances,
            segments: Strips::new(segments),
        })
    }

    /// Returns whether the line meets a closed rectangle. Exact, if the rectangle is finite.
    fn meets(&self, rect: Rect) -> bool {
        let mut near = self.segments.near(rect).into_iter();
        near.any(|number| segment_meets(self.segments.segment(number), rect))
    }

    /// Adds the links of a tile's triangles that count.
    ///
    /// # Errors
    /// Fails if a triangle is not counter-clockwise, which valid files do not have.
    fn walk(&self, tile: &Tile, surface: &TileSurface, links: &mut Links) -> Result<(), String> {
        for triangle in tile.owned_triangles() {
            let corners = tile.triangle_points(triangle);
            let near = self.segments.near(Rect::around(corners));
            let mut near = near
                .into_iter()
                .filter(|&number| segment_meets(self.segments.segment(number), Rect::around(corners)))
                .peekable();
            if near.peek().is_none() {
                continue;
            }
            if let Some(facet) = surface.checked_facet(tile, triangle)? {
                near.for_each(|number| links.add(chord(&facet, number, self.segments.segment(number))));
            }
        }
        Ok(())
    }

    /// Returns the point of a profile at a station.
    fn point(&self, station: &Station) -> ProfilePoint {
        let distance = match station.mark {
            Mark::Corner(corner) => self.distances[corner as usize],
            Mark::Vertex(segment, _) | Mark::Edge(segment, _) => {
                let segment = segment as usize;
                let from = self.corners[segment];
                let along = (station.point.x - from.x).hypot(station.point.y - from.y);
                (self.distances[segment] + along).min(self.distances[segment + 1])
            }
        };
        ProfilePoint {
            distance,
            point: station.point,
            z: station.z,
        }
    }

    /// Returns a number that orders stations of different parts along the line.
    fn position(&self, station: &Station) -> (u32, f64) {
        match station.mark {
            Mark::Corner(corner) => (corner, f64::NEG_INFINITY),
            Mark::Vertex(segment, _) | Mark::Edge(segment, _) => {
                let [from, to] = self.segments.segment(segment);
                let (dx, dy) = (to.x - from.x, to.y - from.y);
                // Coordinates of rounded crossing points are monotonic.
                let along = match dx.abs() >= dy.abs() {
                    true => station.point.x * dx.signum(),
                    false => station.point.y * dy.signum(),
                };
                (segment, along)
            }
        }
    }
}

/// All links of a line, by the mark at which they begin.
#[derive(Default)]
struct Links {
    next: HashMap<Mark, Station>,
    stations: HashMap<Mark, Station>,
}

impl Links {
    fn add(&mut self, link: Option<Link>) {
        match link {
            None => {}
            Some(Link::Touch(station)) => _ = self.stations.insert(station.mark, station),
            Some(Link::Chord(from, to)) => {
                self.stations.insert(from.mark, from);
                self.stations.insert(to.mark, to);
                // Both triangles at an edge that the line runs along give the same link.
                self.next.insert(from.mark, to);
            }
        }
    }

    /// Joins all links.
    fn into_parts(self, line: &Line) -> Vec<ProfilePart> {
        let Self { mut next, mut stations } = self;
        let inner: Vec<Mark> = next.values().map(|to| to.mark).collect();
        for mark in inner {
            stations.remove(&mark);
        }
        let mut starts: Vec<Station> = stations.into_values().collect();
        let position = |station: &Station| line.position(station);
        starts.sort_by(|a, b| {
            let ((a, along_a), (b, along_b)) = (position(a), position(b));
            a.cmp(&b).then(along_a.total_cmp(&along_b))
        });
        let parts = starts.into_iter().map(|start| {
            let mut part = ProfilePart {
                points: vec![line.point(&start)],
            };
            let (mut mark, mut reached) = (start.mark, part.points[0].distance);
            // Each link is used once, so that this ends.
            while let Some(station) = next.remove(&mark) {
                let mut point = line.point(&station);
                // Roundings must not lead back.
                point.distance = point.distance.max(reached);
                (mark, reached) = (station.mark, point.distance);
                part.points.push(point);
            }
            part
        });
        parts.collect()
    }
}

/// Profiles of the surface.
impl TileReader {
    /// Returns the heights of the surface along a line: at its ends, at each of its corners, and
    /// wherever it crosses an edge or meets a vertex of the triangulation. A line may run along edges,
    /// turn back and cross itself. A coordinate closer to 0 than [`Point::MIN_MAGNITUDE`] counts as 0.
    ///
    /// Only tiles that the line meets are read, unless triangles are left out [from the
    /// hull](Surface::from_hull). The result does not depend on the tiles, to the last
    /// bit. Its memory grows with the number of edges that the line crosses.
    ///
    /// # Errors
    /// Fails if the file has no z, if the line has no length or a point that is not finite, or if a
    /// tile cannot be read.
    ///
    /// # Examples
    ///
    /// ```
    /// # use delaunay_tiles::{BuildOptions, Builder, OpenOptions, Point, TileReader, input::PointBatch};
    /// use delaunay_tiles::terrain::Surface;
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("slope.tiles");
    /// # tokio::runtime::Runtime::new()?.block_on(async {
    /// # let points: Vec<Point> = (0..2500).map(|i| Point::new(f64::from(i % 50), f64::from(i / 50))).collect();
    /// # let z = points.iter().map(|p| p.x + 2.0 * p.y).collect();
    /// # let options = BuildOptions::default().tile_vertices(100);
    /// # let mut builder = Builder::new(&path, options)?;
    /// # builder.push(&PointBatch { records: (0..2500).collect(), points, z }).await?;
    /// # builder.finish().await?;
    /// let slope = TileReader::open(&path, OpenOptions::default()).await?;
    /// // Along a row of vertices, from outside of the hull.
    /// let line = [Point::new(-3.0, 20.0), Point::new(6.0, 20.0)];
    /// assert!(slope.profile_tiles(&line).await? < slope.metadata().tiles.into());
    /// let profile = slope.profile(&line, Surface::default()).await?;
    /// assert_eq!((profile.length, profile.gaps()), (9.0, vec![[0.0, 3.0]]));
    /// let points = &profile.parts[0].points;
    /// let heights: Vec<_> = points.iter().map(|p| (p.distance, p.z)).collect();
    /// assert_eq!(heights[..3], [(3.0, 40.0), (4.0, 41.0), (5.0, 42.0)]);
    /// assert_eq!(heights.len(), 7);
    /// # Ok(())
    /// # })
    /// # }
    /// ```
    pub fn profile<'a>(
        &'a self,
        line: &'a [Point],
        surface: Surface,
    ) -> impl Future<Output = Result<Profile, TerrainError>> + Send + 'a {
        async move {
            if !self.metadata().has_z {
                return Err(TerrainError::no_z(self));
            }
            let line = Line::new(line)?;
            let surface = FileSurface::for_few_tiles(self, surface).await?;
            let ids = self.tiles_where(|bounds| line.meets(bounds)).await?;
            let mut tiles = stream::iter(ids).map(|id| self.tile(id)).buffered(AHEAD);
            let mut links = Links::default();
            while let Some(tile) = tiles.try_next().await? {
                let walked = line.walk(&tile, &surface.in_tile(&tile), &mut links);
                walked.map_err(|reason| self.damaged(tile.id(), reason))?;
            }
            Ok(Profile {
                length: line.distances[line.distances.len() - 1],
                parts: links.into_parts(&line),
            })
        }
        .boxed()
    }

    /// Returns the number of tiles that the profile along a line reads, without reading them.
    ///
    /// # Errors
    /// Fails if the line has no length or a point that is not finite, or if the directory cannot be
    /// read.
    pub async fn profile_tiles(&self, line: &[Point]) -> Result<u64, TerrainError> {
        let line = Line::new(line)?;
        Ok(self.tiles_where(|bounds| line.meets(bounds)).await?.len() as u64)
    }
}
