//! The promise: polygons of maps and of others' bug reports, and broken polygons, become the holes
//! that a person would draw, in tiles of any size; or an error says which polygon is wrong, and
//! where.
//!
//! All input passes from files through the readers and the build to the tiles, as in the tool.

mod bad;
mod fixtures;
mod maps;
mod normal;
mod rings;

use std::collections::{HashMap, HashSet};
use std::error::Error;
use std::path::PathBuf;

use self::rings::Polygon;
use crate::support::{Scratch, runtime};
use delaunay_tiles::geometry::{Orientation, Point, orient2d};
use delaunay_tiles::input::{InputOptions, PointBatch, PointSource, PolySource, SegmentBatch, SegmentSource};
use delaunay_tiles::store::{Digest, DigestSum, EdgeSource, LineKind, LineSource, TileReader};
use delaunay_tiles::{BuildOptions, BuildSummary, Builder, Description};
use futures::TryStreamExt;

/// The input files of a build.
#[derive(Clone, Debug, Default)]
struct Input {
    points: Vec<PathBuf>,
    /// A `.poly` file; its points are read too.
    poly: Option<PathBuf>,
    segments: Vec<PathBuf>,
    obstacles: Vec<PathBuf>,
}

/// A triangle of a build.
#[derive(Clone, Copy, Debug)]
struct Triangle {
    corners: [Point; 3],
    depth: i32,
    is_hole: bool,
}

/// A vertex of a build.
#[derive(Clone, Copy, Debug)]
struct Vertex {
    point: Point,
    z: Option<f64>,
    record: u64,
}

/// The result of a build.
#[derive(Debug)]
struct Built {
    summary: BuildSummary,
    digest: Digest,
    triangles: Vec<Triangle>,
    vertices: Vec<Vertex>,
    /// Constraint edges and their sources.
    edges: Vec<([Point; 2], Vec<EdgeSource>)>,
    notes: Vec<String>,
}

/// The number of some triangles, and the sum of their areas.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct TriangleTotals {
    triangles: u64,
    area: f64,
}

/// (tile vertices, threads)
type Way = (usize, usize);

const WAYS: [Way; 3] = [(16, 1), (200, 2), (1 << 16, 1)];

impl Input {
    fn obstacles(file: PathBuf) -> Self {
        Self {
            obstacles: vec![file],
            ..Self::default()
        }
    }

    /// Builds in several ways; all must give the same result, or the same error.
    fn build(&self, options: &BuildOptions, ways: &[Way]) -> Result<Built, Box<dyn Error>> {
        let mut all = Vec::new();
        for &(tile_vertices, threads) in ways {
            let options = options.clone().tile_vertices(tile_vertices).threads(threads);
            all.push(runtime().block_on(self.build_once(options)));
        }
        let last = all.pop().expect("there is a way");
        for other in all {
            match (&other, &last) {
                (Ok(other), Ok(last)) => {
                    assert_eq!(other.digest, last.digest);
                    assert_eq!(other.counts(), last.counts());
                    assert_eq!(other.notes, last.notes);
                }
                (Err(other), Err(last)) => assert_eq!(other.to_string(), last.to_string()),
                _ => panic!("{:?}, {:?}", other.err(), last.err()),
            }
        }
        last
    }

    async fn build_once(&self, options: BuildOptions) -> Result<Built, Box<dyn Error>> {
        let scratch = Scratch::new();
        let mut builder = Builder::new(&scratch.path, options)?;
        let (mut batch, mut lines, mut notes) = (SegmentBatch::default(), 0, Vec::new());
        let mut files: Vec<LineSource> = Vec::new();
        for (kind, mut source) in [
            (LineKind::BreakLine, SegmentSource::open(&self.segments)?),
            (LineKind::Obstacle, SegmentSource::open_obstacles(&self.obstacles)?),
        ] {
            while source.next_batch(&mut batch)? {
                builder.push_lines(kind, lines, &batch)?;
            }
            for (name, its) in source.sources() {
                files.push(line_source(name, kind, lines, *its));
                lines += its;
            }
            notes.extend(
                source
                    .notes()
                    .iter()
                    .map(|note| note.split_once(": ").unwrap().1.to_owned()),
            );
        }
        if let Some(path) = &self.poly {
            let mut source = PolySource::open(path)?;
            while source.next_batch(&mut batch)? {
                builder.push_lines(LineKind::Wall, lines, &batch)?;
            }
            files.push(line_source("walls", LineKind::Wall, lines, source.segments()));
            builder.push_seeds(&source.holes()?)?;
        }
        // Deep verification checks the polygons of lines that are known.
        builder.describe(Description {
            lines: files,
            ..Description::default()
        });
        let files: Vec<PathBuf> = self.poly.iter().chain(&self.points).cloned().collect();
        let mut points = PointSource::open(&files, &InputOptions::default())?;
        let mut batch = PointBatch::default();
        while points.next_batch(&mut batch)? {
            builder.push(&batch).await?;
        }
        let summary = builder.finish().await?;
        let reader = scratch.open().await;
        let report = reader.verify(true).await?;
        assert_eq!(report.constraint_edges, summary.constraint_edges);
        Ok(Built::read(&reader, summary, notes).await)
    }
}

fn line_source(name: &str, kind: LineKind, first: u64, lines: u64) -> LineSource {
    LineSource {
        name: name.to_owned(),
        kind,
        first,
        lines,
        edit: 0,
    }
}

/// Returns a digest without the sources of edges, so that only the triangulation and its holes
/// count.
fn without_sources(digest: Digest) -> Digest {
    Digest {
        edge_sources: DigestSum::default(),
        ..digest
    }
}

impl Built {
    async fn read(reader: &TileReader, summary: BuildSummary, notes: Vec<String>) -> Self {
        let mut this = Self {
            summary,
            digest: reader.recompute_digest().await.unwrap(),
            triangles: Vec::new(),
            vertices: Vec::new(),
            edges: Vec::new(),
            notes,
        };
        let (mut regions, mut hole_regions) = (HashSet::new(), HashSet::new());
        let mut tiles = reader.tiles();
        while let Some(tile) = tiles.try_next().await.unwrap() {
            this.triangles.extend(tile.owned_triangles().map(|triangle| Triangle {
                corners: tile.triangle_points(triangle),
                depth: tile.depth(triangle),
                is_hole: tile.is_hole(triangle),
            }));
            for triangle in tile.owned_triangles() {
                regions.insert(tile.region(triangle));
                if tile.is_hole(triangle) {
                    hole_regions.insert(tile.region(triangle));
                }
            }
            this.vertices.extend(tile.vertex_indices().map(|vertex| Vertex {
                point: tile.point(vertex),
                z: tile.z(vertex),
                record: tile.record(vertex),
            }));
            let edges = tile.owned_constraints().map(|edge| {
                let ends = tile.ends(edge).map(|end| end.point);
                (ends, tile.edge_sources(edge).collect())
            });
            this.edges.extend(edges);
        }
        let summary = &this.summary;
        assert_eq!(summary.triangles, this.triangles.len() as u64);
        assert_eq!(summary.vertices, this.vertices.len() as u64);
        assert_eq!(summary.constraint_edges, this.edges.len() as u64);
        assert_eq!(summary.hole_triangles, this.holes().triangles);
        assert_eq!(summary.hole_regions, hole_regions.len() as u64);
        assert_eq!(summary.regions, regions.len() as u64);
        this
    }

    /// Returns counts that do not depend on the tile size.
    fn counts(&self) -> [u64; 7] {
        let s = &self.summary;
        [
            s.vertices,
            s.added_vertices,
            s.constraint_edges,
            s.crossings,
            s.regions,
            s.hole_regions,
            s.hole_triangles,
        ]
    }

    fn part(&self, is_hole: bool) -> TriangleTotals {
        let triangles = self.triangles.iter().filter(|triangle| triangle.is_hole == is_hole);
        triangles.fold(TriangleTotals::default(), |part, triangle| TriangleTotals {
            triangles: part.triangles + 1,
            area: part.area + rings::area(&triangle.corners),
        })
    }

    fn holes(&self) -> TriangleTotals {
        self.part(true)
    }

    fn free(&self) -> TriangleTotals {
        self.part(false)
    }

    /// Returns the rings that the constraint edges form, if each vertex has two edges or none.
    fn rings(&self) -> Vec<Vec<Point>> {
        let bits = |p: Point| [p.x, p.y].map(f64::to_bits);
        let mut neighbours: HashMap<_, Vec<Point>> = HashMap::new();
        for ([a, b], _) in &self.edges {
            neighbours.entry(bits(*a)).or_default().push(*b);
            neighbours.entry(bits(*b)).or_default().push(*a);
        }
        assert!(neighbours.values().all(|neighbours| neighbours.len() == 2));
        let mut rings = Vec::new();
        while let Some(&first) = neighbours.values().flatten().next() {
            let (mut ring, mut next) = (Vec::new(), Some(first));
            while let Some(point) = next {
                ring.push(point);
                let around = neighbours.remove(&bits(point)).unwrap();
                next = around.into_iter().find(|p| neighbours.contains_key(&bits(*p)));
            }
            rings.push(ring);
        }
        rings
    }

    /// Asserts for every `step`-th triangle that its depth is the number of polygons that wind around
    /// its centroid. Returns the number of triangles checked.
    fn check_depths(&self, polygons: &[Polygon], step: usize) -> usize {
        let polygons: Vec<Vec<[Point; 2]>> = polygons.iter().map(|polygon| polygon.segments().collect()).collect();
        let depth = |p| polygons.iter().filter(|its| rings::winding(its, p) != 0).count() as i32;
        let mut checked = 0;
        for triangle in self.triangles.iter().step_by(step) {
            let [a, b, c] = triangle.corners;
            let centroid = Point::new((a.x + b.x + c.x) / 3.0, (a.y + b.y + c.y) / 3.0);
            let is_left = |from, to| orient2d(from, to, centroid) == Orientation::CounterClockwise;
            // The centroid of a sliver may round to a point outside of it.
            if is_left(a, b) && is_left(b, c) && is_left(c, a) {
                assert_eq!(triangle.depth, depth(centroid), "{triangle:?}");
                assert_eq!(triangle.is_hole, triangle.depth != 0, "{triangle:?}");
                checked += 1;
            }
        }
        checked
    }
}

/// Asserts that two areas differ by rounding only.
#[track_caller]
fn assert_same_area(found: f64, expected: f64) {
    assert!(
        (found - expected).abs() <= 1e-9 * expected.abs(),
        "{found}, not {expected}"
    );
}
