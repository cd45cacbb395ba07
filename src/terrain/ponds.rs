//! Ponds: areas in which all vertices get one z, the lowest on the shore.
//!
//! In: the shores of ponds, and each tile of a surface. Out: the z of each pond, and the z at points in
//! ponds. The lowest z of a shore is exact: it is that of a corner, or of a place where the shore
//! crosses an edge of the triangulation.

use std::sync::Arc;

use super::chord::{Link, Station, chord};
use super::clip::Passing;
use super::outline::Outline;
use super::strips::Strips;
use super::surface::facet;
use crate::geometry::{Point, Rect};
use crate::input::SegmentBatch;
use crate::store::Tile;

/// The shores of ponds: the rings of polygons, in memory.
///
/// ```
/// use delaunay_tiles::Point;
/// use delaunay_tiles::input::SegmentBatch;
/// use delaunay_tiles::terrain::Shores;
///
/// let corners = [(0.0, 0.0), (4.0, 0.0), (0.0, 4.0)].map(|(x, y)| Point::new(x, y));
/// let mut shores = Shores::default();
/// shores.push(&SegmentBatch {
///     ends: (0..3).map(|i| [corners[i], corners[(i + 1) % 3]]).collect(),
///     lines: vec![0; 3],
///     ..SegmentBatch::default()
/// });
/// let ponds = shores.with_z(vec![7.5]);
/// assert_eq!(ponds.z_at(Point::new(1.0, 1.0)), Some(7.5));
/// assert_eq!(ponds.z_at(Point::new(3.0, 3.0)), None);
/// ```
#[derive(Debug, Default)]
pub struct Shores {
    edges: Vec<[Point; 2]>,
    /// z at the ends of each edge; NaN where there is none.
    z: Vec<[f64; 2]>,
    /// The pond of each edge, in ascending order.
    ponds: Vec<u32>,
    /// The number that the last pond has in its batches.
    last: Option<u64>,
}

impl Shores {
    /// The largest number of edges.
    pub const MAX_EDGES: usize = Strips::MAX;

    /// The bytes of memory per edge that shores, the search for their z and [`Ponds`] take, at most.
    pub const BYTES_PER_EDGE: u64 = 240;

    /// Adds polygons as [`SegmentSource::open_obstacles`](crate::input::SegmentSource::open_obstacles)
    /// reads them: the interior is on the left of the edges, and those of one polygon come one after
    /// another, in one batch or several. Each polygon is a pond. Segments between records are left out.
    pub fn push(&mut self, batch: &SegmentBatch) {
        for (at, &ends) in batch.ends.iter().enumerate() {
            let number = batch.polygons.get(at).or(batch.lines.get(at)).copied();
            if self.ponds.is_empty() || self.last != number {
                self.ponds.push(self.count() as u32);
                self.last = number;
            } else {
                self.ponds.push(self.count() as u32 - 1);
            }
            self.edges.push(ends.map(Point::normalized));
            self.z.push(batch.z.get(at).copied().unwrap_or([f64::NAN; 2]));
        }
    }

    /// Returns the number of ponds.
    #[must_use]
    pub fn count(&self) -> usize {
        self.ponds.last().map_or(0, |&pond| pond as usize + 1)
    }

    /// Returns the edges of all shores, in the order in which they were added.
    #[must_use]
    pub fn edges(&self) -> &[[Point; 2]] {
        &self.edges
    }

    /// Returns one corner of each pond.
    #[must_use]
    pub fn corners(&self) -> Vec<Point> {
        let firsts = self.ponds.chunk_by(|a, b| a == b).scan(0, |next, edges| {
            let first = *next;
            *next += edges.len();
            Some(first)
        });
        firsts.map(|first| self.edges[first][0]).collect()
    }

    /// Returns the ponds with the given z, one for each.
    ///
    /// # Panics
    /// Panics if there is not one z for each pond, or if there are more than
    /// [`MAX_EDGES`](Self::MAX_EDGES) edges.
    #[must_use]
    pub fn with_z(self, z: Vec<f64>) -> Ponds {
        assert_eq!(z.len(), self.count(), "one z for each pond");
        Ponds {
            edges: Strips::new(self.edges),
            pond_of: self.ponds,
            z: z.into(),
        }
    }
}

/// Ponds, and the z that all vertices in each of them get.
///
/// The [example of `Shores`](Shores) makes some.
#[derive(Clone, Debug)]
pub struct Ponds {
    edges: Strips,
    /// The pond of each edge.
    pond_of: Vec<u32>,
    z: Arc<[f64]>,
}

impl Ponds {
    /// Returns the z of the pond that a point is in or on the shore of; of several ponds, that of the
    /// first one. `None` if the point is in no pond. Exact.
    #[must_use]
    pub fn z_at(&self, p: Point) -> Option<f64> {
        if !self.edges.bounds().contains(p) {
            return None;
        }
        let mut near: Vec<(u32, i32)> = Vec::new();
        for (number, edge) in self.edges.between(p.y, p.y) {
            let pond = self.pond_of[number as usize];
            match Passing::of(edge, p) {
                Passing::Through => near.push((pond, i32::MAX)),
                Passing::Right(turn) => near.push((pond, turn)),
                Passing::Elsewhere => {}
            }
        }
        near.sort_unstable();
        // The largest turn of a pond comes last.
        let is_in = |turns: &&[(u32, i32)]| {
            turns.last().is_some_and(|&(_, turn)| turn == i32::MAX) || turns.iter().map(|turn| turn.1).sum::<i32>() > 0
        };
        let first = near.chunk_by(|a, b| a.0 == b.0).find(is_in)?;
        Some(self.z[first[0].0 as usize])
    }

    /// Returns the ponds that may have points in a rectangle.
    pub(crate) fn near(&self, rect: Rect) -> Self {
        let mut bounds = vec![None::<Rect>; self.z.len()];
        let edges = || self.pond_of.iter().zip(0u32..);
        for (&pond, number) in edges() {
            let of_edge = Rect::around(self.edges.segment(number));
            let all = &mut bounds[pond as usize];
            *all = Some(all.map_or(of_edge, |all| all.union(of_edge)));
        }
        let is_near = |pond: u32| bounds[pond as usize].is_some_and(|bounds| bounds.intersects(rect));
        let near = || edges().filter(|&(&pond, _)| is_near(pond));
        Self {
            edges: Strips::new(near().map(|(_, number)| self.edges.segment(number)).collect()),
            pond_of: near().map(|(&pond, _)| pond).collect(),
            z: Arc::clone(&self.z),
        }
    }

    /// Returns the z at the ends of each edge of the shores, in the order in which they were added.
    #[must_use]
    pub fn z_of_edges(&self) -> Vec<[f64; 2]> {
        self.pond_of.iter().map(|&pond| [self.z[pond as usize]; 2]).collect()
    }

    /// Returns the edges of the shores, in the order in which they were added.
    pub(crate) fn shores(&self) -> Vec<[Point; 2]> {
        (0..self.pond_of.len() as u32)
            .map(|number| self.edges.segment(number))
            .collect()
    }

    /// Returns the ponds with these [shores](Self::shores), the
    /// [pond of each edge](Self::pond_of_edges), and the [z of each pond](Self::levels). `None` if
    /// these do not match.
    pub(crate) fn of_parts(shores: Vec<[Point; 2]>, pond_of: Vec<u32>, z: Vec<f64>) -> Option<Self> {
        let is_pond = |&pond: &u32| (pond as usize) < z.len();
        let do_match = shores.len() == pond_of.len() && shores.len() <= Strips::MAX && pond_of.iter().all(is_pond);
        do_match.then(|| Self {
            edges: Strips::new(shores),
            pond_of,
            z: z.into(),
        })
    }

    /// Returns the pond of each edge of the shores.
    pub(crate) fn pond_of_edges(&self) -> &[u32] {
        &self.pond_of
    }

    /// Returns the z of each pond.
    pub(crate) fn levels(&self) -> &[f64] {
        &self.z
    }

    /// Returns the number of edges of the shores.
    pub(crate) fn edge_count(&self) -> usize {
        self.pond_of.len()
    }

    /// Returns whether there are no ponds.
    pub(crate) fn is_empty(&self) -> bool {
        self.z.is_empty()
    }

    /// Returns the number of ponds.
    pub(crate) fn count(&self) -> usize {
        self.z.len()
    }
}

/// The search for the lowest z of each shore, over all tiles of a surface.
pub(crate) struct ShoreLevels {
    edges: Strips,
    z: Vec<[f64; 2]>,
    pond_of: Vec<u32>,
    /// For each edge, whether its first end was found in a triangle.
    met: Vec<bool>,
    lowest: Vec<f64>,
}

impl ShoreLevels {
    /// Starts a search. Where corners have a z of their own, this is the z of the shore there, and of
    /// an edge between two of them.
    pub(crate) fn new(shores: Shores) -> Self {
        let mut lowest = vec![f64::INFINITY; shores.count()];
        for (z, &pond) in shores.z.iter().zip(&shores.ponds) {
            let own = z.iter().filter(|z| !z.is_nan());
            lowest[pond as usize] = own.fold(lowest[pond as usize], |lowest, &z| lowest.min(z));
        }
        Self {
            met: vec![false; shores.edges.len()],
            edges: Strips::new(shores.edges),
            z: shores.z,
            pond_of: shores.ponds,
            lowest,
        }
    }

    /// Adds a tile of a file with z.
    pub(crate) fn add(&mut self, tile: &Tile) {
        let corners = tile
            .owned_triangles()
            .flat_map(|triangle| tile.triangle_points(triangle));
        // The strips of a part of the edges are shorter to search.
        let in_tile = self.edges.near(Rect::around(corners));
        let edges = Strips::new(in_tile.iter().map(|&number| self.edges.segment(number)).collect());
        for triangle in tile.owned_triangles() {
            let near = edges.near(Rect::around(tile.triangle_points(triangle)));
            if near.is_empty() {
                continue;
            }
            let Some(facet) = facet(tile, triangle) else { continue };
            for number in near.into_iter().map(|number| in_tile[number as usize]) {
                let stations = match chord(&facet, number, self.edges.segment(number)) {
                    None => continue,
                    Some(Link::Touch(station)) => [station; 2],
                    Some(Link::Chord(from, to)) => [from, to],
                };
                stations.iter().for_each(|station| self.meet(number, station));
            }
        }
    }

    /// Takes the z of the surface at a point of an edge.
    fn meet(&mut self, number: u32, station: &Station) {
        let ([from, to], own) = (self.edges.segment(number), self.z[number as usize]);
        let [has_from, has_to] = own.map(|z| !z.is_nan());
        self.met[number as usize] |= station.point == from;
        let has_own = match station.point {
            point if point == from => has_from,
            point if point == to => has_to,
            _ => has_from && has_to,
        };
        if !has_own {
            let lowest = &mut self.lowest[self.pond_of[number as usize] as usize];
            *lowest = lowest.min(station.z);
        }
    }

    /// Returns the ponds, once all tiles were added. Corners outside of the hull have the z of the
    /// nearest point of the outline.
    pub(crate) fn finish(mut self, outline: &Outline) -> Ponds {
        for (number, &pond) in self.pond_of.iter().enumerate() {
            if !self.met[number] && self.z[number][0].is_nan() {
                let z = outline.z_near(self.edges.segment(number as u32)[0]);
                let lowest = &mut self.lowest[pond as usize];
                *lowest = z.map_or(*lowest, |z| lowest.min(z));
            }
        }
        Ponds {
            edges: self.edges,
            pond_of: self.pond_of,
            z: self.lowest.into(),
        }
    }
}
