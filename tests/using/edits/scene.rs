//! Random scenes, from which files are built and which are changed in the same way as the files.

use std::collections::BTreeMap;
use std::ops::Range;

use delaunay_tiles::geometry::{Orientation, Point, orient2d};
use delaunay_tiles::input::{PointBatch, SegmentBatch, SiteBatch, SiteId};
use delaunay_tiles::store::{Digest, LineKind, LineSource};
use delaunay_tiles::{BuildError, BuildOptions, Builder, Description, EditError, EditSummary, Transaction};

use crate::support::{Random, Scratch};

/// A line: its kind, its corners, and its number in the edited file.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    pub kind: LineKind,
    pub corners: Vec<Point>,
    pub number: u64,
}

/// What a file is built from. Points are kept by their coordinates, with z.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    pub points: BTreeMap<[u64; 2], (Point, f64)>,
    pub has_z: bool,
    pub lines: Vec<Line>,
    pub sites: Vec<(Point, SiteId)>,
}

pub fn key(p: Point) -> [u64; 2] {
    [p.x, p.y].map(f64::to_bits)
}

pub fn batch_of_sites(sites: &[(Point, SiteId)]) -> SiteBatch {
    let (points, ids) = sites.iter().cloned().unzip();
    SiteBatch {
        points,
        ids,
        ..SiteBatch::default()
    }
}

/// Returns a site with a number or a text as its id.
pub fn random_site(random: &mut Random, at: &dyn Fn(&mut Random) -> Point) -> (Point, SiteId) {
    let number = random.below(20) as u64;
    let id = match random.below(2) {
        0 => SiteId::Number(number),
        _ => SiteId::Text(format!("site {number}")),
    };
    (at(random), id)
}

pub fn batch_of_line(corners: &[Point]) -> SegmentBatch {
    SegmentBatch {
        ends: corners.array_windows().copied().collect(),
        lines: vec![0; corners.len() - 1],
        ..SegmentBatch::default()
    }
}

impl Scene {
    pub async fn build(&self, tile_vertices: usize) -> Result<Scratch, BuildError> {
        let scratch = Scratch::new();
        let options = BuildOptions::default().tile_vertices(tile_vertices);
        let mut builder = Builder::new(&scratch.path, options)?;
        for (line, number) in self.lines.iter().zip(0..) {
            builder.push_lines(line.kind, number, &batch_of_line(&line.corners))?;
        }
        builder.describe(Description {
            lines: self
                .lines
                .iter()
                .zip(0..)
                .map(|(line, first)| source(line.kind, first))
                .collect(),
            ..Description::default()
        });
        builder.push_sites(&batch_of_sites(&self.sites))?;
        builder.push(&self.batch(self.points.values().copied())).await?;
        builder.finish().await?;
        Ok(scratch)
    }

    pub fn batch(&self, points: impl Iterator<Item = (Point, f64)>) -> PointBatch {
        let (points, z): (Vec<Point>, Vec<f64>) = points.unzip();
        PointBatch {
            records: (0..points.len() as u64).collect(),
            z: if self.has_z { z } else { Vec::new() },
            points,
        }
    }

    fn any(&self, random: &mut Random) -> Option<Point> {
        let number = random.below(self.points.len().max(1));
        self.points.values().nth(number).map(|(point, _)| *point)
    }

    /// Makes a random change in an editor and here.
    pub fn change(&mut self, transaction: &mut Transaction, random: &mut Random, at: impl Fn(&mut Random) -> Point) {
        let z = random.below(9) as f64;
        match (random.below(5), self.any(random)) {
            (2, Some(from)) => {
                let to = at(random);
                if let Some((_, z)) = self.points.remove(&key(from)) {
                    self.points.entry(key(to)).or_insert((to, z));
                }
                transaction.move_points(&[[from, to]]).unwrap();
            }
            (3, Some(_)) => {
                // Sometimes most points go.
                let most = if random.below(6) == 0 { self.points.len() } else { 3 };
                let mut gone: Vec<Point> = self.points.values().map(|(point, _)| *point).collect();
                random.shuffle(&mut gone);
                gone.truncate(1 + random.below(most));
                self.points.retain(|_, (point, _)| !gone.contains(point));
                transaction.delete(&gone).unwrap();
            }
            (4, Some(point)) if self.has_z => {
                self.points.insert(key(point), (point, z));
                transaction.set_z(&self.batch([(point, z)].into_iter())).unwrap();
            }
            _ => {
                let point = at(random);
                self.points.entry(key(point)).or_insert((point, z));
                transaction.insert(&self.batch([(point, z)].into_iter())).unwrap();
            }
        }
    }
}

/// Returns the digest of the tiles, after it proved that the file is right by itself.
pub async fn checked(scratch: &Scratch) -> Digest {
    let reader = scratch.open().await;
    reader.verify(true).await.unwrap();
    reader.recompute_digest().await.unwrap()
}

/// Asserts that an edited file is what a build of the scene gives, or, if the edit failed, that the
/// scene cannot be built so and the file is as it was `before`. Returns the summary of an edit that
/// did not fail.
pub async fn checked_outcome(
    edited: Result<EditSummary, EditError>,
    scratch: &Scratch,
    scene: &Scene,
    before: Digest,
    seed: u64,
) -> Option<EditSummary> {
    let built = scene.build(30).await;
    let after = checked(scratch).await;
    match edited {
        Ok(summary) => {
            let expected = checked(&built.unwrap()).await;
            assert_eq!(after, expected, "seed {seed}");
            let digest = [expected.vertices, expected.triangles, expected.constraint_edges];
            let counts = [summary.vertices, summary.triangles, summary.constraint_edges];
            assert_eq!(counts, digest.map(|sum| sum.count), "seed {seed}");
            return Some(summary);
        }
        // A lattice has few places, so lines meet in points. Of lines that the file has, the vertex cannot
        // go; a line that comes crosses them once the point is gone.
        Err(EditError::LinesCross { .. } | EditError::Crossed { .. }) => assert!(built.is_err(), "seed {seed}"),
        Err(error) => panic!("seed {seed}: {error}"),
    }
    assert_eq!(after, before, "seed {seed}");
    None
}

/// Returns a line on a lattice: a wall, a break line with a bend, or a rectangle. No line runs over
/// itself.
pub fn random_line(random: &mut Random, at: &dyn Fn(&mut Random) -> Point) -> (LineKind, Vec<Point>) {
    let [a, middle, b] = [at(random), at(random), at(random)];
    if a == b || orient2d(a, middle, b) == Orientation::Collinear {
        return random_line(random, at);
    }
    match random.below(3) {
        0 => (LineKind::Wall, vec![a, b]),
        1 => (LineKind::BreakLine, vec![a, middle, b]),
        _ => {
            let [right, up] = [1 + random.below(4), 1 + random.below(4)].map(|side| side as f64);
            let corners = [(0.0, 0.0), (right, 0.0), (right, up), (0.0, up), (0.0, 0.0)];
            let corners = corners.map(|(x, y)| Point::new(a.x + x, a.y + y));
            (LineKind::Obstacle, corners.to_vec())
        }
    }
}

/// Returns the source of one line.
pub fn source(kind: LineKind, first: u64) -> LineSource {
    LineSource {
        name: "line".to_owned(),
        kind,
        first,
        lines: 1,
        edit: 0,
    }
}

/// Returns a scene of one of these kinds: points alone, uniform (0), on a circle (1), on a lattice
/// (2), on a lattice with lines that do not cross and sites (3 and 4), or on one line, with lines along
/// it and sites, or nothing (5 and 6, without z). Points that come to these leave the line now and then.
pub async fn random_scene(random: &mut Random, kinds: Range<usize>) -> (Scene, Box<dyn Fn(&mut Random) -> Point>) {
    let size = 3 + random.below(10);
    let kind = kinds.start + random.below(kinds.len());
    let at = move |random: &mut Random| match kind {
        0 => Point::new(random.unit(), random.unit()),
        1 => {
            let angle = random.below(360) as f64;
            Point::new(100.0 * angle.cos(), 100.0 * angle.sin())
        }
        5.. if random.below(4) > 0 => Point::new(random.below(size) as f64, 0.0),
        _ => Point::new(random.below(size) as f64, random.below(size) as f64),
    };
    if kind >= 5 {
        let scene = scene_on_one_line(random, size, kind == 5);
        return (scene, Box::new(at));
    }
    let mut scene = Scene {
        has_z: random.below(2) == 0,
        ..Scene::default()
    };
    for _ in 0..1 + random.below(80) {
        let point = at(random);
        scene.points.insert(key(point), (point, random.below(9) as f64));
    }
    if kind > 2 {
        scene.has_z = false;
        scene.sites = (0..random.below(5)).map(|_| random_site(random, &at)).collect();
        for _ in 0..random.below(6) {
            let (kind, corners) = random_line(random, &at);
            let number = scene.lines.len() as u64;
            scene.lines.push(Line { kind, corners, number });
            if scene.build(16).await.is_err() {
                scene.lines.pop();
            }
        }
    }
    (scene, Box::new(at))
}

/// Returns a scene on one line, or an empty one.
fn scene_on_one_line(random: &mut Random, size: usize, may_have_z: bool) -> Scene {
    let at = |random: &mut Random| Point::new(random.below(size) as f64, 0.0);
    let mut scene = Scene {
        has_z: may_have_z && random.below(2) == 0,
        ..Scene::default()
    };
    for _ in 0..random.below(20) {
        let point = at(random);
        scene.points.insert(key(point), (point, random.below(9) as f64));
    }
    if random.below(2) == 0 {
        scene.has_z = false;
        scene.sites = (0..random.below(3)).map(|_| random_site(random, &at)).collect();
        for number in 0..random.below(4) as u64 {
            let corners = vec![at(random), at(random)];
            let kind = [LineKind::Wall, LineKind::BreakLine][random.below(2)];
            if corners[0] != corners[1] {
                scene.lines.push(Line { kind, corners, number });
            }
        }
    }
    for (line, number) in scene.lines.iter_mut().zip(0..) {
        line.number = number;
    }
    scene
}
