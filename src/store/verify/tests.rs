//! The power of the verifier: right files that are made wrong, consistently and with right checksums.

use std::collections::{HashMap, HashSet};

use futures::stream::TryStreamExt;

use super::VerifyError;
use crate::build::{BuildOptions, Builder};
use crate::geometry::{Point, Rect};
use crate::input::PointBatch;
use crate::io::{Buffers, MemoryFile};
use crate::mesh::NONE;
use crate::store::directory::Directory;
use crate::store::{
    BorderDraft, CoreDraft, ELSEWHERE, HULL, OpenOptions, TileEntry, TileId, TileReader, TileWriter, VertexId,
};

type Named = [VertexId; 3];

/// A file as sets of triangles, from which cores, borders and entries are made.
#[derive(Clone)]
struct Model {
    directory: Directory,
    tiles: Vec<ModelTile>,
}

#[derive(Clone, Default)]
struct ModelTile {
    points: Vec<Point>,
    z: Vec<f64>,
    core: Vec<Named>,
    border: Vec<Named>,
    /// Where the tile believes vertices of others to be, if not where they are.
    beliefs: HashMap<VertexId, Point>,
    /// Pairs of vertices, the smaller first, between which the tile has constraints.
    constraints: HashSet<[VertexId; 2]>,
}

fn run<T>(work: impl Future<Output = T>) -> T {
    tokio::runtime::Builder::new_current_thread()
        .build()
        .unwrap()
        .block_on(work)
}

fn pair(a: VertexId, b: VertexId) -> [VertexId; 2] {
    [a.min(b), a.max(b)]
}

fn smallest_first(mut t: Named) -> Named {
    let first = (0..3).min_by_key(|&i| t[i]).unwrap();
    t.rotate_left(first);
    t
}

impl Model {
    fn of(points: &[Point], tile_vertices: usize) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("right.tiles");
        let options = BuildOptions {
            tile_vertices,
            threads: 1,
            ..BuildOptions::default()
        };
        run(async {
            let mut builder = Builder::new(&path, options).unwrap();
            let records = (0..points.len() as u64).collect();
            let (points, z) = (points.to_vec(), vec![1.0; points.len()]);
            builder.push(&PointBatch { points, z, records }).await.unwrap();
            builder.finish().await.unwrap();
            let reader = TileReader::open(&path, OpenOptions::default()).await.unwrap();
            let tiles: Vec<_> = reader.tiles().try_collect().await.unwrap();
            let tiles = tiles.iter().map(|tile| {
                let named = |t: u32| smallest_first(tile.vertices(t).map(|v| v.id));
                ModelTile {
                    points: tile.points().collect(),
                    z: vec![1.0; tile.vertex_count() as usize],
                    core: (0..tile.core_triangle_count()).map(named).collect(),
                    border: (tile.core_triangle_count()..tile.triangle_count()).map(named).collect(),
                    beliefs: HashMap::new(),
                    constraints: HashSet::new(),
                }
            });
            Self {
                tiles: tiles.collect(),
                directory: reader.directory().clone(),
            }
        })
    }

    fn point(&self, v: VertexId) -> Point {
        self.tiles[v.tile.0 as usize].points[v.index as usize]
    }

    /// All triangles, each once.
    fn triangles(&self) -> Vec<Named> {
        let all = self.tiles.iter().flat_map(|t| t.core.iter().chain(&t.border).copied());
        let mut all: Vec<_> = all.collect::<HashSet<_>>().into_iter().collect();
        all.sort_unstable();
        all
    }

    /// Removes a triangle from all tiles.
    fn remove(&mut self, t: Named) {
        for tile in &mut self.tiles {
            tile.core.retain(|&other| other != t);
            tile.border.retain(|&other| other != t);
        }
    }

    /// Adds a triangle to the borders of its tiles, or to the core.
    fn add(&mut self, t: Named, core: bool) {
        let t = smallest_first(t);
        let tiles: HashSet<TileId> = t.iter().map(|v| v.tile).collect();
        for tile in tiles {
            let tile = &mut self.tiles[tile.0 as usize];
            if core { tile.core.push(t) } else { tile.border.push(t) }
        }
    }

    /// The other triangle at the edge from `a` to `b` of a triangle.
    fn across(&self, a: VertexId, b: VertexId) -> Option<Named> {
        self.triangles()
            .into_iter()
            .find(|t| (0..3).any(|i| t[i] == b && t[(i + 1) % 3] == a))
    }

    fn verify(&self) -> Result<(), VerifyError> {
        run(async {
            let file = MemoryFile::default();
            let mut writer = TileWriter::new(file.clone());
            let mut entries = Vec::new();
            for (tile, id) in self.tiles.iter().zip(0..) {
                let (core, border, entry) = self.encode(TileId(id), tile);
                let core = writer
                    .append_core(&core.encode(TileId(id), 1, &Buffers::default()))
                    .await
                    .unwrap();
                let border = writer
                    .append_border(&border.encode(TileId(id), 1, &Buffers::default()))
                    .await
                    .unwrap();
                entries.push(TileEntry { core, border, ..entry });
            }
            let mut directory = self.directory.clone();
            let metadata = &mut directory.metadata;
            metadata.vertices = entries.iter().map(|e| u64::from(e.vertices)).sum();
            metadata.triangles = entries.iter().map(|e| u64::from(e.owned_triangles)).sum();
            metadata.points = metadata.vertices;
            metadata.bounds = entries.iter().fold(Rect::EMPTY, |all, e| all.union(e.bounds));
            metadata.tile_vertices = 1000;
            let constraints = self.tiles.iter().flat_map(|tile| &tile.constraints);
            metadata.constraint_edges = constraints.collect::<HashSet<_>>().len() as u64;
            metadata.hull_edges = match metadata.triangles {
                0 => 0,
                triangles => (2 * metadata.vertices - 2).saturating_sub(triangles),
            };
            directory.tiles = entries;
            writer.finish(&directory).await.unwrap();
            let reader = TileReader::open_source(file, "wrong", OpenOptions::default())
                .await
                .unwrap();
            reader.verify(true).await.map(|_| ())
        })
    }

    fn encode(&self, id: TileId, tile: &ModelTile) -> (CoreDraft, BorderDraft, TileEntry) {
        let own = tile.points.len() as u32;
        let mut foreign: Vec<VertexId> = tile.border.iter().flatten().copied().filter(|v| v.tile != id).collect();
        foreign.sort_unstable();
        foreign.dedup();
        let corner = |v: VertexId| match foreign.binary_search(&v) {
            Ok(place) => own + place as u32,
            Err(_) => v.index,
        };
        let at = |v: VertexId| tile.beliefs.get(&v).copied().unwrap_or_else(|| self.point(v));
        let triangles: Vec<[u32; 3]> = tile.core.iter().chain(&tile.border).map(|t| t.map(corner)).collect();
        let core_sides = 3 * tile.core.len() as u32;
        let mut sides: HashMap<(u32, u32), u32> = HashMap::new();
        for (t, first) in triangles.iter().zip((0u32..).step_by(3)) {
            for s in 0..3 {
                sides.insert((t[s as usize], t[(s as usize + 1) % 3]), first + s);
            }
        }
        let (mut core_neighbours, mut neighbours, mut core_links) = (Vec::new(), Vec::new(), Vec::new());
        for (t, first) in triangles.iter().zip((0u32..).step_by(3)) {
            let across = [0, 1, 2].map(|s| {
                let (from, to) = (t[s], t[(s + 1) % 3]);
                (sides.get(&(to, from)).copied(), from >= own && to >= own)
            });
            if first < core_sides {
                core_neighbours.push(across.map(|(side, _)| side.filter(|&s| s < core_sides).unwrap_or(NONE)));
                for (s, (side, _)) in (0..).zip(across) {
                    core_links.extend(
                        side.filter(|&other| other >= core_sides)
                            .map(|other| (first + s, other)),
                    );
                }
            } else {
                neighbours.push(across.map(|(side, foreign)| match side {
                    Some(side) => side.into(),
                    None if foreign => ELSEWHERE,
                    None => HULL,
                }));
            }
        }
        let bits = |triangles: &[Named]| -> Vec<u8> {
            let is_one = |t: &Named, s: usize| tile.constraints.contains(&pair(t[s], t[(s + 1) % 3]));
            let sides = |t| (0..3).filter(|&s| is_one(t, s)).map(|s| 1 << s).sum();
            triangles.iter().map(sides).collect()
        };
        let in_core: HashSet<u32> = tile.core.iter().flatten().map(|v| v.index).collect();
        let mut leaving: Vec<(u32, u32)> = triangles[tile.core.len()..]
            .as_flattened()
            .iter()
            .copied()
            .zip(core_sides..)
            .collect();
        leaving.retain(|(v, _)| *v < own && !in_core.contains(v));
        leaving.sort_unstable();
        leaving.dedup_by_key(|s| s.0);
        let smallest = |t: &Named| t.iter().min_by(|a, b| at(**a).lex_cmp(at(**b))).unwrap().tile;
        let owned: Vec<&Named> = tile
            .core
            .iter()
            .chain(tile.border.iter().filter(|t| smallest(t) == id))
            .collect();
        let corners = owned.iter().flat_map(|t| t.iter().map(|&v| at(v)));
        let bounds = Rect::around(tile.points.iter().copied().chain(corners));
        let entry = TileEntry {
            generation: 1,
            vertices: own,
            core_triangles: tile.core.len() as u32,
            border_triangles: tile.border.len() as u32,
            owned_triangles: owned.len() as u32,
            bounds,
            ..self.directory.tiles[0]
        };
        let core = CoreDraft {
            points: tile.points.clone(),
            z: tile.z.clone(),
            records: (0..own.into()).collect(),
            triangles: triangles[..tile.core.len()].to_vec(),
            neighbours: core_neighbours,
            constraints: bits(&tile.core),
        };
        let border = BorderDraft {
            vertices: own,
            core_triangles: tile.core.len() as u32,
            foreign: foreign.iter().map(|&v| (v, at(v))).collect(),
            triangles: triangles[tile.core.len()..].to_vec(),
            neighbours,
            core_links,
            vertex_sides: leaving,
            constraints: bits(&tile.border),
        };
        (core, border, entry)
    }

    /// Two neighbours whose quad is convex, so that their edge can be flipped: the triangles, and what they become.
    fn flips(&self, wanted: impl Fn(&[VertexId; 4]) -> bool) -> Vec<([Named; 2], [Named; 2])> {
        use crate::geometry::{Orientation::CounterClockwise, orient2d};
        let left = |a, b, c| orient2d(self.point(a), self.point(b), self.point(c)) == CounterClockwise;
        let sides = self
            .triangles()
            .into_iter()
            .flat_map(|t| [0, 1, 2].map(|i| (t, [t[i], t[(i + 1) % 3], t[(i + 2) % 3]])));
        let flips = sides.filter_map(|(t, [a, b, c])| {
            let other = self.across(a, b)?;
            let d = *other.iter().find(|&&v| v != a && v != b)?;
            let convex = left(d, b, c) && left(c, a, d);
            (convex && wanted(&[a, b, c, d])).then_some(([t, other], [[d, b, c], [c, a, d]]))
        });
        flips.collect()
    }
}

fn grid() -> Vec<Point> {
    (0..100)
        .map(|i| Point::new(f64::from(i % 10), f64::from(i / 10)))
        .collect()
}

fn scattered() -> Vec<Point> {
    let mut seed = 7u64;
    let mut random = || {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (seed >> 40) as f64 / 1e6
    };
    (0..200).map(|_| Point::new(random(), random())).collect()
}

fn models() -> Vec<Model> {
    [(grid(), 16), (scattered(), 16), (scattered(), 1000), (grid(), 1000)]
        .map(|(p, n)| Model::of(&p, n))
        .into()
}

/// The model must be found wrong, and where.
#[track_caller]
fn found(model: &Model) -> (TileId, Option<u32>, String) {
    match model.verify() {
        Err(VerifyError::Tile { tile, triangle, reason }) => (tile, triangle, reason),
        other => panic!("{other:?}"),
    }
}

#[test]
fn models_are_right_before_they_are_made_wrong() {
    for model in models() {
        model.verify().unwrap();
    }
}

#[test]
fn a_flipped_edge() {
    let mut ties = 0;
    for model in models() {
        let whole: Vec<Named> = model.tiles.iter().flat_map(|t| t.core.clone()).collect();
        for (old, new) in model.flips(|_| true).into_iter().step_by(7) {
            let core = old.iter().all(|t| whole.contains(t));
            let mut wrong = model.clone();
            old.iter().for_each(|&t| wrong.remove(t));
            new.iter().for_each(|&t| wrong.add(t, core));
            let (_, triangle, reason) = found(&wrong);
            assert!(triangle.is_some() && reason.contains("circle"), "{reason}");
            ties += usize::from(core);
        }
    }
    assert!(ties > 20, "{ties}");
}

/// A flipped edge is right where it is a constraint, and all tiles say so.
#[test]
fn constraints_and_tiles_that_do_not_know_of_them() {
    let mut partly = 0;
    for model in models() {
        let whole: Vec<Named> = model.tiles.iter().flat_map(|t| t.core.clone()).collect();
        for (old, new) in model.flips(|_| true).into_iter().step_by(11) {
            let core = old.iter().all(|t| whole.contains(t));
            let edge = pair(new[0][0], new[0][2]);
            let mut right = model.clone();
            old.iter().for_each(|&t| right.remove(t));
            new.iter().for_each(|&t| right.add(t, core));
            right
                .tiles
                .iter_mut()
                .for_each(|tile| _ = tile.constraints.insert(edge));
            right.verify().unwrap();
            let knows = |tile: &ModelTile| {
                let triangles = tile.core.iter().chain(&tile.border);
                triangles.filter(|t| edge.iter().all(|v| t.contains(v))).count() > 0
            };
            for tile in (0..right.tiles.len()).filter(|&tile| knows(&right.tiles[tile])) {
                let mut wrong = right.clone();
                wrong.tiles[tile].constraints.clear();
                found(&wrong);
                partly += usize::from(!core);
            }
        }
    }
    assert!(partly > 100, "{partly}");
}

#[test]
fn a_vertex_beside_its_place() {
    for model in models() {
        for step in [1e-9, 0.3] {
            let mut faults = 0;
            for (tile, index) in (0..model.tiles.len()).flat_map(|t| [(t, 3), (t, 7)]) {
                let mut wrong = model.clone();
                wrong.tiles[tile].points[index].x += step;
                faults += usize::from(wrong.verify().is_err());
            }
            // Scattered points may move a little and stay right; a grid's may not, for the rule of ties.
            let tie = model
                .point(VertexId {
                    tile: TileId(0),
                    index: 0,
                })
                .x
                .fract()
                == 0.0;
            assert!(
                !tie || faults == 2 * model.tiles.len(),
                "{faults} of {}",
                2 * model.tiles.len()
            );
        }
    }
}

#[test]
fn a_border_that_lacks_a_triangle() {
    for model in &models()[..2] {
        for tile in 0..model.tiles.len() {
            for place in (0..model.tiles[tile].border.len()).step_by(5) {
                let mut wrong = model.clone();
                wrong.tiles[tile].border.remove(place);
                found(&wrong);
            }
        }
    }
}

#[test]
fn a_border_that_errs_on_a_foreign_vertex() {
    for model in &models()[..2] {
        for tile in 0..model.tiles.len() {
            let id = TileId(tile as u32);
            let foreign = model.tiles[tile].border.iter().flatten().filter(|v| v.tile != id);
            for &v in foreign.step_by(11) {
                let mut wrong = model.clone();
                let p = model.point(v);
                // The smallest step there is.
                let moved = Point::new(p.x, if p.y == 0.0 { 1e-40 } else { p.y.next_up() });
                wrong.tiles[tile].beliefs.insert(v, moved);
                found(&wrong);
                // Another number for the vertex, in this tile only.
                let mut wrong = model.clone();
                let other = VertexId {
                    index: v.index + 1000,
                    ..v
                };
                wrong.tiles[tile].beliefs.insert(other, p);
                for w in wrong.tiles[tile]
                    .border
                    .as_flattened_mut()
                    .iter_mut()
                    .filter(|w| **w == v)
                {
                    *w = other;
                }
                found(&wrong);
            }
        }
    }
}

#[test]
fn a_vertex_twice_and_a_vertex_apart() {
    for model in models() {
        let mut twice = model.clone();
        let p = twice.tiles[0].points[0];
        twice.tiles[0].points.push(p);
        twice.tiles[0].z.push(0.0);
        assert!(found(&twice).2.contains("lies on another"));
        let mut apart = model.clone();
        let mut q = model.tiles[0].points[0];
        q.x -= 1e-7;
        apart.tiles[0].points.push(q);
        apart.tiles[0].z.push(0.0);
        assert!(found(&apart).2.contains("does not know its triangles"));
        let mut nan = model.clone();
        nan.tiles[0].z[2] = f64::NAN;
        found(&nan);
        let mut flat = model.clone();
        flat.tiles.last_mut().unwrap().z.clear();
        found(&flat);
    }
}

#[test]
fn a_hull_that_is_not_convex_a_hole_and_a_second_sheet() {
    for model in models() {
        let all = model.triangles();
        for &t in all.iter().step_by(3) {
            let mut wrong = model.clone();
            wrong.remove(t);
            // A corner that is cut off leaves its vertex without triangles, and else the hull is not convex.
            assert!(wrong.verify().is_err(), "without {t:?}");
            let mut turned = model.clone();
            let core = turned.tiles.iter().any(|tile| tile.core.contains(&t));
            turned.remove(t);
            turned.add([t[0], t[2], t[1]], core);
            assert!(turned.verify().is_err(), "with {t:?} turned round");
        }
        let mut doubled = model.clone();
        let t = all[all.len() / 2];
        doubled.add(t, false);
        assert!(doubled.verify().is_err());
        let mut none = model.clone();
        all.iter().for_each(|&t| none.remove(t));
        assert!(found(&none).2.contains("not in line"));
    }
}
