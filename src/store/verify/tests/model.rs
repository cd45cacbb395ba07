//! A file as sets of triangles, from which cores, borders and entries are made, even if the sets
//! are inconsistent.

use std::collections::{HashMap, HashSet};
use std::pin::{Pin, pin};

use bytes::Bytes;
use futures::stream::TryStreamExt;

use crate::geometry::{HalfEdge, PackedHalfEdge, Point, Rect};
use crate::input::{PointBatch, SegmentBatch, SiteBatch, SiteId};
use crate::io::{Buffers, MemoryFile};
use crate::mesh::{Topology, Twin};
use crate::store::directory_writer::front_end_for;
use crate::store::format::component_table::{Component, ComponentRecord, encode};
use crate::store::format::digest::Digest;
use crate::store::format::directory::Directory;
use crate::store::format::encode::{BorderDraft, CoreDraft};
use crate::store::format::entry::TileEntry;
use crate::store::format::ids::{TileId, VertexId};
use crate::store::format::line_part::LinePart;
use crate::store::format::tile::Tile;
pub(crate) use crate::store::format::tile::edges::TileEdge;
use crate::store::open_options::OpenOptions;
use crate::store::reader::TileReader;
use crate::store::verify::error::VerifyError;
use crate::store::verify::tests::tables::{ModelTable, tables};
use crate::store::writer::TileWriter;
use crate::{BuildOptions, Builder, MissingZ};

pub(super) type Named = [VertexId; 3];

/// A segment, and the source that it gives to the edges along it.
pub(super) type Sourced = ([Point; 2], LinePart);

/// A change of what a component table says of a component.
pub(super) type TableChange = fn(&mut ComponentRecord);

/// A file as sets of triangles, from which cores, borders and entries are made.
#[derive(Clone)]
pub(super) struct Model {
    pub(super) directory: Directory,
    pub(super) tiles: Vec<ModelTile>,
    /// What the directory's digest has more than that of the tiles.
    pub(super) surplus: Digest,
    /// Changes of component tables: the tile, the component, and what is done to its record.
    pub(super) table_changes: Vec<(TileId, usize, TableChange)>,
}

#[derive(Clone, Default)]
pub(super) struct ModelTile {
    pub(super) points: Vec<Point>,
    pub(super) z: Vec<f64>,
    /// Whether a point of the input lies at each vertex.
    pub(super) input_points: Vec<bool>,
    pub(super) core: Vec<Named>,
    pub(super) border: Vec<Named>,
    /// Points at which the tile stores foreign vertices, if they differ from the real ones.
    pub(super) beliefs: HashMap<VertexId, Point>,
    /// The z that the tile stores for foreign vertices, if they differ from the real ones.
    pub(super) z_beliefs: HashMap<VertexId, f64>,
    /// The constraints of the tile, as pairs of vertices, the smaller first.
    pub(super) constraints: HashSet<[VertexId; 2]>,
    /// The constraints that the tile stores as walls.
    pub(super) walls: HashSet<[VertexId; 2]>,
    /// The sources that the tile stores for them, as seen from the first vertex to the second.
    pub(super) sources: HashMap<[VertexId; 2], Vec<LinePart>>,
    /// The components that the tile stores for its triangles.
    pub(super) labels: HashMap<Named, Component>,
    /// Vertices and numbers of its sites.
    pub(super) sites: Vec<(u32, u64)>,
}

pub(super) fn run<T>(work: impl Future<Output = T>) -> T {
    let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
    // `block_on` is generic. It is compiled once for all futures with this result.
    let work: Pin<&mut dyn Future<Output = T>> = pin!(work);
    runtime.block_on(work)
}

pub(super) fn pair(a: VertexId, b: VertexId) -> [VertexId; 2] {
    [a.min(b), a.max(b)]
}

pub(super) fn smallest_first(mut t: Named) -> Named {
    let first = (0..3).min_by_key(|&i| t[i]).unwrap();
    t.rotate_left(first);
    t
}

impl ModelTile {
    /// Returns whether the tile has no triangles.
    fn is_on_line(&self) -> bool {
        self.core.is_empty() && self.border.is_empty()
    }

    fn of(tile: &Tile) -> Self {
        let all = || {
            tile.triangle_ids()
                .map(|t| (t, smallest_first(tile.vertices(t).map(|v| v.id))))
        };
        let directed = |edge: TileEdge| tile.ends(edge).map(|v| v.id);
        let unordered = |edge: TileEdge| pair(directed(edge)[0], directed(edge)[1]);
        let half_edges = || tile.half_edges().map(TileEdge::HalfEdge);
        let sources = tile.owned_constraints().map(|edge| {
            let is_forward = directed(edge) == unordered(edge);
            let seen = |part: LinePart| if is_forward { part } else { part.reversed() };
            (unordered(edge), tile.edge_parts(edge).map(seen).collect())
        });
        Self {
            points: tile.points().collect(),
            z: tile.vertex_indices().filter_map(|v| tile.z(v)).collect(),
            input_points: tile.vertex_indices().map(|v| tile.is_input_point(v)).collect(),
            core: all()
                .filter(|(t, _)| t.0 < tile.core_triangle_count())
                .map(|(_, t)| t)
                .collect(),
            border: all()
                .filter(|(t, _)| t.0 >= tile.core_triangle_count())
                .map(|(_, t)| t)
                .collect(),
            beliefs: HashMap::new(),
            z_beliefs: HashMap::new(),
            constraints: half_edges()
                .filter(|&edge| tile.is_constraint(edge))
                .map(unordered)
                .collect(),
            walls: half_edges().filter(|&edge| tile.is_wall(edge)).map(unordered).collect(),
            sources: sources.collect(),
            labels: all().map(|(t, named)| (named, tile.component(t))).collect(),
            sites: tile.sites().map(|site| (site.vertex.0, site.number)).collect(),
        }
    }
}

impl Model {
    pub(super) fn of(points: &[Point], tile_vertices: usize) -> Self {
        Self::with_lines(points, &[], &[], tile_vertices)
    }

    /// Builds a triangulation of `points` with segments, each with its source, and with numbered
    /// sites.
    pub(super) fn with_lines(
        points: &[Point],
        lines: &[Sourced],
        sites: &[(Point, u64)],
        tile_vertices: usize,
    ) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("right.tiles");
        let options = BuildOptions::default()
            .tile_vertices(tile_vertices)
            .threads(1)
            .missing_z(MissingZ::Zero);
        run(async {
            let mut builder = Builder::new(&path, options).unwrap();
            for (ends, source) in lines {
                let batch = SegmentBatch {
                    ends: vec![*ends],
                    lines: vec![0],
                    ..SegmentBatch::default()
                };
                builder.push_lines(source.kind(), source.number(), &batch).unwrap();
            }
            let sites = SiteBatch {
                points: sites.iter().map(|site| site.0).collect(),
                ids: sites.iter().map(|site| SiteId::Number(site.1)).collect(),
                ..SiteBatch::default()
            };
            builder.push_sites(&sites).unwrap();
            let records = (0..points.len() as u64).collect();
            let z = (1..=points.len()).map(|i| i as f64).collect();
            let points = points.to_vec();
            builder.push(&PointBatch { points, z, records }).await.unwrap();
            builder.finish().await.unwrap();
            let reader = TileReader::open(&path, OpenOptions::default()).await.unwrap();
            let tiles: Vec<_> = reader.tiles().try_collect().await.unwrap();
            Self {
                tiles: tiles.iter().map(|tile| ModelTile::of(tile)).collect(),
                directory: Directory::clone(&*reader.directory().await.unwrap()),
                surplus: Digest::default(),
                table_changes: Vec::new(),
            }
        })
    }

    pub(super) fn point(&self, v: VertexId) -> Point {
        self.tiles[v.tile.0 as usize].points[v.index.index()]
    }

    /// Returns all triangles, each once.
    pub(super) fn triangles(&self) -> Vec<Named> {
        let all = self.tiles.iter().flat_map(|t| t.core.iter().chain(&t.border).copied());
        let mut all: Vec<_> = all.collect::<HashSet<_>>().into_iter().collect();
        all.sort_unstable();
        all
    }

    /// Removes a triangle from all tiles.
    pub(super) fn remove(&mut self, t: Named) {
        for tile in &mut self.tiles {
            tile.core.retain(|&other| other != t);
            tile.border.retain(|&other| other != t);
        }
    }

    /// Adds a triangle to the borders of its tiles, or to the core.
    pub(super) fn add(&mut self, t: Named, core: bool) {
        let t = smallest_first(t);
        let tiles: HashSet<TileId> = t.iter().map(|v| v.tile).collect();
        for tile in tiles {
            let tile = &mut self.tiles[tile.0 as usize];
            if core { tile.core.push(t) } else { tile.border.push(t) }
        }
    }

    /// Returns the other triangle at the edge from `a` to `b` of a triangle.
    pub(super) fn twin(&self, a: VertexId, b: VertexId) -> Option<Named> {
        self.triangles()
            .into_iter()
            .find(|t| (0..3).any(|i| t[i] == b && t[(i + 1) % 3] == a))
    }

    pub(super) fn verify(&self) -> Result<(), VerifyError> {
        run(async { self.open().await.verify(true).await.map(|_| ()) })
    }

    /// Encodes the model as a file in memory, and opens it.
    pub(super) async fn open(&self) -> TileReader {
        self.open_with(OpenOptions::default()).await
    }

    pub(super) async fn open_with(&self, options: OpenOptions) -> TileReader {
        let file = MemoryFile::default();
        let mut writer = TileWriter::new(file.clone(), front_end_for(2));
        let mut entries = Vec::new();
        let mut digest = self.surplus;
        let tables = tables(self);
        for ((tile, table), id) in self.tiles.iter().zip(&tables).zip((0..).map(TileId)) {
            if tile.points.is_empty() {
                entries.push(TileEntry::UNUSED);
                continue;
            }
            let (core, border, entry) = self.encode(id, tile, table);
            let bytes = [
                core.encode(id, 1, &Buffers::default()),
                border.encode(id, 1, &Buffers::default()),
            ];
            let core = writer.append_core(&bytes[0]).await.unwrap();
            let border = writer.append_border(&bytes[1]).await.unwrap();
            let table = encode(id, &self.changed_records(id, &table.records));
            let (short, table) = (writer.place_table(table.clone()).await.unwrap(), Bytes::from(table));
            let entry = TileEntry {
                core,
                border,
                table: short,
                ..entry
            };
            // A tile that cannot be opened is found before the digest matters.
            if let Ok(tile) = Tile::open(id, &entry, [&bytes[0], &bytes[1]], Some(&table)) {
                digest += Digest::of_tile(&tile);
            }
            entries.push(entry);
        }
        let mut metadata = self.directory.metadata.clone();
        metadata.vertices = entries.iter().map(|e| u64::from(e.vertices)).sum();
        metadata.triangles = entries.iter().map(|e| u64::from(e.owned_triangles)).sum();
        (metadata.points, metadata.duplicates) = (metadata.vertices - metadata.ends, 0);
        metadata.bounds = entries.iter().fold(Rect::EMPTY, |all, e| all.union(e.bounds));
        metadata.tile_vertices = 1000;
        metadata.digest = digest;
        let on_line = self.tiles.iter().filter(|tile| tile.is_on_line());
        let on_line = on_line.flat_map(|tile| tile.sources.keys());
        let constraints = self.tiles.iter().flat_map(|tile| &tile.constraints);
        metadata.constraint_edges = constraints.chain(on_line).collect::<HashSet<_>>().len() as u64;
        metadata.hull_edges = match metadata.triangles {
            0 => 0,
            triangles => (2 * metadata.vertices - 2).saturating_sub(triangles),
        };
        let (lists, tree) = (self.directory.lists.clone(), self.directory.tree.clone());
        let directory = Directory::new(metadata, lists, tree, entries);
        writer.finish(&directory).await.unwrap();
        TileReader::open_source(file, "wrong", options).await.unwrap()
    }

    /// Returns the records of a tile's components after the model's changes of them.
    fn changed_records(&self, id: TileId, records: &[ComponentRecord]) -> Vec<ComponentRecord> {
        let mut records = records.to_vec();
        for (_, component, change) in self.table_changes.iter().filter(|(tile, ..)| *tile == id) {
            change(&mut records[*component]);
        }
        records
    }

    fn encode(&self, id: TileId, tile: &ModelTile, table: &ModelTable) -> (CoreDraft, BorderDraft, TileEntry) {
        let own = tile.points.len() as u32;
        let is_on_line = tile.is_on_line();
        let corners = tile.border.iter().flatten();
        let ends = tile.sources.keys().flatten().filter(|_| is_on_line);
        let mut foreign: Vec<VertexId> = corners.chain(ends).copied().filter(|v| v.tile != id).collect();
        foreign.sort_unstable();
        foreign.dedup();
        let corner = |v: VertexId| match foreign.binary_search(&v) {
            Ok(index) => own + index as u32,
            Err(_) => v.index.0,
        };
        let at = |v: VertexId| tile.beliefs.get(&v).copied().unwrap_or_else(|| self.point(v));
        let z = |v: VertexId| {
            let owner = self.tiles.get(v.tile.0 as usize);
            let right = owner.and_then(|owner| owner.z.get(v.index.index()));
            tile.z_beliefs.get(&v).or(right).copied().unwrap_or(0.0)
        };
        let triangles: Vec<[u32; 3]> = tile.core.iter().chain(&tile.border).map(|t| t.map(corner)).collect();
        let core_half_edges = 3 * tile.core.len() as u32;
        let mut half_edges: HashMap<(u32, u32), u32> = HashMap::new();
        for (t, first) in triangles.iter().zip((0u32..).step_by(3)) {
            for s in 0..3 {
                half_edges.insert((t[s as usize], t[(s as usize + 1) % 3]), first + s);
            }
        }
        let (mut core_neighbours, mut neighbours, mut core_links) = (Vec::new(), Vec::new(), Vec::new());
        for (t, first) in triangles.iter().zip((0u32..).step_by(3)) {
            let twins = [0, 1, 2].map(|s| {
                let (from, to) = (t[s], t[(s + 1) % 3]);
                (half_edges.get(&(to, from)).copied(), from >= own && to >= own)
            });
            if first < core_half_edges {
                core_neighbours.push(twins.map(|(twin, _)| {
                    let twin = twin.filter(|&s| s < core_half_edges).map(HalfEdge);
                    PackedHalfEdge::from(twin)
                }));
                for (s, (twin, _)) in (0..).zip(twins) {
                    core_links.extend(
                        twin.filter(|&other| other >= core_half_edges)
                            .map(|other| (first + s, other)),
                    );
                }
            } else {
                neighbours.push(twins.map(|(twin, foreign)| match twin {
                    Some(twin) => Twin::HalfEdge(HalfEdge(twin)),
                    None if foreign => Twin::Elsewhere,
                    None => Twin::Hull,
                }));
            }
        }
        let bits = |triangles: &[Named]| -> Vec<u8> {
            let edge_bits = |t: &Named, set: &HashSet<[VertexId; 2]>| -> u8 {
                let is_one = |s: &usize| set.contains(&pair(t[*s], t[(*s + 1) % 3]));
                (0..3).filter(is_one).map(|s| 1 << s).sum()
            };
            let both = |t: &Named| edge_bits(t, &tile.constraints) | edge_bits(t, &tile.walls) << crate::mesh::WALLS;
            triangles.iter().map(both).collect()
        };
        let mut edge_sources = [Vec::new(), Vec::new()];
        for (&edge, sources) in &tile.sources {
            let [from, to] = edge.map(corner);
            let (forward, backward) = (half_edges.get(&(from, to)), half_edges.get(&(to, from)));
            let Some(&key) = forward.into_iter().chain(backward).min() else {
                continue;
            };
            let seen = |source: &LinePart| {
                if forward == Some(&key) {
                    *source
                } else {
                    source.reversed()
                }
            };
            let in_core = |half_edge: Option<&u32>| half_edge.is_some_and(|&half_edge| half_edge < core_half_edges);
            let part = usize::from(!in_core(forward) || !in_core(backward));
            edge_sources[part].extend(sources.iter().map(|source| (key, seen(source))));
        }
        let mut edges = Vec::new();
        if is_on_line {
            let all = tile.sources.iter().map(|(&[a, b], sources)| {
                let is_forward = at(a).lex_cmp(at(b)).is_lt();
                let seen = |source: &LinePart| if is_forward { *source } else { source.reversed() };
                let ends = if is_forward { [a, b] } else { [b, a] };
                (ends.map(corner), sources.iter().map(seen).collect::<Vec<_>>())
            });
            let mut all: Vec<_> = all.collect();
            all.sort_unstable();
            edges.extend(all.iter().map(|(ends, _)| *ends));
            let numbered = (0..).zip(&all);
            edge_sources[1].extend(numbered.flat_map(|(edge, (_, sources))| sources.iter().map(move |&s| (edge, s))));
        }
        edge_sources.iter_mut().for_each(|edges| edges.sort_unstable());
        let [of_core, of_others] = edge_sources;
        let components = |triangles: &[Named]| triangles.iter().map(|t| table.of_triangles[t]).collect();
        let [core_components, border_components] = [&tile.core, &tile.border].map(|t| components(t));
        let in_core: HashSet<u32> = tile.core.iter().flatten().map(|v| v.index.0).collect();
        let mut leaving: Vec<(u32, u32)> = triangles[tile.core.len()..]
            .as_flattened()
            .iter()
            .copied()
            .zip(core_half_edges..)
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
            input_points: tile.input_points.clone(),
            triangles: triangles[..tile.core.len()].to_vec(),
            neighbours: core_neighbours,
            constraints: bits(&tile.core),
            components: core_components,
            edge_sources: of_core,
            sites: tile.sites.clone(),
            site_ids: Vec::new(),
        };
        let border = BorderDraft {
            vertices: own,
            core_triangles: tile.core.len() as u32,
            foreign: foreign.iter().map(|&v| (v, at(v))).collect(),
            foreign_z: (!tile.z.is_empty()).then(|| foreign.iter().map(|&v| z(v)).collect()),
            triangles: triangles[tile.core.len()..].to_vec(),
            neighbours,
            core_links,
            vertex_sides: leaving,
            constraints: bits(&tile.border),
            components: border_components,
            edge_sources: of_others,
            edges,
        };
        (core, border, entry)
    }

    /// Returns pairs of neighbours whose quadrilateral is convex, so that their edge can be
    /// flipped: the two triangles before and after the flip.
    pub(super) fn flips(&self, wanted: impl Fn(&[VertexId; 4]) -> bool) -> Vec<([Named; 2], [Named; 2])> {
        use crate::geometry::Orientation::CounterClockwise;
        use crate::geometry::orient2d;
        let left = |a, b, c| orient2d(self.point(a), self.point(b), self.point(c)) == CounterClockwise;
        let half_edges = self
            .triangles()
            .into_iter()
            .flat_map(|t| [0, 1, 2].map(|i| (t, [t[i], t[(i + 1) % 3], t[(i + 2) % 3]])));
        let flips = half_edges.filter_map(|(t, [a, b, c])| {
            let other = self.twin(a, b)?;
            let d = *other.iter().find(|&&v| v != a && v != b)?;
            let convex = left(d, b, c) && left(c, a, d);
            (convex && wanted(&[a, b, c, d])).then_some(([t, other], [[d, b, c], [c, a, d]]))
        });
        flips.collect()
    }
}
