//! Pictures of the structures on which both distances are measured, like Figures 4.1 to 4.5 of the
//! thesis.

use std::collections::{HashMap, HashSet};

use anyhow::Context;
use delaunay_tiles::geometry::{Point, Rect};
use delaunay_tiles::query::{PathOutcome, QueryError, QueryOptions};
use delaunay_tiles::store::{TileReader, VertexId};
use futures::{StreamExt, TryStreamExt, stream};

use super::pairs::{Drawn, Pair};
use crate::plot::figure::{Figure, Layer, Shape};
use tiletool::common::thousands;
use tiletool::plot::scene::Scene;
use tiletool::plot::style::{EDGE, SITE};

const LAND: &str = "#d9d3c3";
const SHORE: &str = "#6b5537";
const SIGHT: &str = "#7aa6c9";
const SHORTEST: &str = "#0072b2";
const ALONG: &str = "#d55e00";

/// A picture, with the beginning of its file name.
pub struct Named {
    pub stem: &'static str,
    pub figure: Figure,
}

/// The figures, and notes on those that are left out.
pub struct Figures {
    pub drawn: Vec<Named>,
    pub notes: Vec<String>,
}

/// Draws a file; a note names a figure that is too large for a picture.
pub async fn figures(
    reader: &TileReader,
    name: &str,
    drawn: &Drawn,
    graph_vertices: u64,
    at_once: usize,
) -> anyhow::Result<Figures> {
    let Some(scene) = Scene::gather(reader).await? else {
        let vertices = thousands(reader.metadata().vertices);
        return Ok(Figures {
            drawn: Vec::new(),
            notes: vec![format!("The file has {vertices} vertices, too many for pictures.")],
        });
    };
    let map = Map::new(reader, name, &scene);
    let (mut figures, mut notes) = (vec![map.islands()], Vec::new());
    if map.points.len() as u64 <= graph_vertices {
        figures.push(map.visibility(at_once).await?);
    } else {
        notes.push(format!(
            "The visibility graph of {} vertices is not drawn; `--graph-vertices` draws it.",
            thousands(map.points.len() as u64)
        ));
    }
    figures.push(map.triangulation());
    // Both trees have the source of the first pair.
    if let Some(&Pair { from, .. }) = drawn.pairs.first() {
        let (edges, title) = (tree(reader, from).await?, "Tree of shortest paths");
        figures.push(map.tree("tree-geodesic", title, from, edges, SHORTEST));
        let (edges, title) = (tree_along(reader, from).await?, "Tree of shortest paths along edges");
        figures.push(map.tree("tree-cdt", title, from, edges, ALONG));
    }
    if let Some(worst) = worst(&drawn.pairs) {
        figures.push(map.both_paths(worst).await?);
    }
    Ok(Figures { drawn: figures, notes })
}

/// Returns the pair with the largest ratio.
pub fn worst(pairs: &[Pair]) -> Option<&Pair> {
    pairs.iter().max_by(|a, b| a.ratio().total_cmp(&b.ratio()))
}

/// A scene with its points, from which figures are drawn.
struct Map<'a> {
    reader: &'a TileReader,
    name: &'a str,
    points: &'a [Point],
    holes: Vec<[Point; 3]>,
    walls: Vec<[Point; 2]>,
    scene: &'a Scene,
}

impl<'a> Map<'a> {
    fn new(reader: &'a TileReader, name: &'a str, scene: &'a Scene) -> Self {
        let at = |corner: u32| scene.points[corner as usize];
        Self {
            reader,
            name,
            points: &scene.points,
            holes: scene.holes.iter().map(|corners| corners.map(at)).collect(),
            walls: scene.walls.iter().map(|ends| ends.map(at)).collect(),
            scene,
        }
    }

    /// Returns a figure of the whole scene.
    fn figure(&self, stem: &'static str, title: &str, caption: String, layers: Vec<Layer>) -> Named {
        let figure = Figure {
            title: format!("{title}: {}", self.name),
            caption,
            bounds: self.scene.bounds,
            layers,
        };
        Named { stem, figure }
    }

    fn islands(&self) -> Named {
        let [vertices, walls] = [self.points.len(), self.walls.len()].map(|count| thousands(count as u64));
        let layers = vec![self.land(), self.shore(1.0)];
        self.figure(
            "islands",
            "Obstacles",
            format!("{vertices} vertices, {walls} walls"),
            layers,
        )
    }

    async fn visibility(&self, at_once: usize) -> anyhow::Result<Named> {
        let sights = sights(self.reader, self.points, at_once).await?;
        let caption = format!("{} pairs of vertices see each other", thousands(sights.len() as u64));
        let lines = Layer::edges("lines of sight", SIGHT, sights, 0.15);
        let layers = vec![self.land(), lines, self.shore(0.8)];
        Ok(self.figure("visibility", "Visibility graph", caption, layers))
    }

    fn triangulation(&self) -> Named {
        let free = self.free_edges();
        let caption = format!(
            "constrained Delaunay triangulation, {} edges that are no walls",
            thousands(free.len() as u64)
        );
        let edges = Layer::edges("edges", EDGE, free, 0.6);
        let layers = vec![edges, self.land(), self.shore(1.0)];
        self.figure("triangulation", "Free space", caption, layers)
    }

    /// Returns a figure of a tree of paths from a point.
    fn tree(
        &self,
        stem: &'static str,
        title: &str,
        from: Point,
        edges: Vec<[Point; 2]>,
        colour: &'static str,
    ) -> Named {
        let caption = format!("from ({}, {}), {} edges", from.x, from.y, thousands(edges.len() as u64));
        let lines = Layer::edges("shortest paths", colour, edges, 0.9);
        let source = Layer {
            name: "source",
            colour: SITE,
            shape: Shape::Dots(vec![from], 6.0),
        };
        self.figure(stem, title, caption, vec![self.land(), self.shore(0.5), lines, source])
    }

    /// Returns a figure of the shortest path between a pair, and the shortest path along edges, cut
    /// to their surroundings.
    async fn both_paths(&self, pair: &Pair) -> anyhow::Result<Named> {
        let [path, along] = paths(self.reader, pair).await?;
        let bounds = Rect::around(path.iter().chain(&along).flatten().copied());
        let caption = format!(
            "ratio {:.4}: {:.6} along edges, {:.6} by the shortest path",
            pair.ratio(),
            pair.cdt,
            pair.geodesic
        );
        let along = Layer::edges("along edges", ALONG, along, 2.0);
        let path = Layer::edges("shortest path", SHORTEST, path, 2.0);
        let layers = vec![self.land(), self.shore(0.5), along, path];
        let mut named = self.figure("worst", "The pair with the largest ratio", caption, layers);
        named.figure.bounds = bounds;
        Ok(named)
    }

    fn land(&self) -> Layer {
        Layer {
            name: "obstacles",
            colour: LAND,
            shape: Shape::Triangles(self.holes.clone()),
        }
    }

    fn shore(&self, width: f64) -> Layer {
        Layer::edges("walls", SHORE, self.walls.clone(), width)
    }

    /// Returns the edges that are not walls and not in a hole.
    fn free_edges(&self) -> Vec<[Point; 2]> {
        let edges_of_holes = self.scene.holes.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let inside: HashSet<[u32; 2]> = edges_of_holes.map(|[a, b]| [a.min(b), a.max(b)]).collect();
        let edges = self.scene.edges.iter().chain(&self.scene.outline);
        // An edge of a hole's triangle that is not a wall is in the hole.
        let free = edges.filter(|[a, b]| !inside.contains(&[*a.min(b), *a.max(b)]));
        free.map(|ends| ends.map(|end| self.points[end as usize])).collect()
    }
}

/// Returns all pairs of vertices that see each other, each once.
async fn sights(reader: &TileReader, points: &[Point], at_once: usize) -> anyhow::Result<Vec<[Point; 2]>> {
    let seen = stream::iter(points.to_vec()).map(|from| {
        let reader = reader.clone();
        let task = tokio::spawn(async move {
            let mut found = reader.vertices_by_distance(from, QueryOptions::default());
            let (mut seen, mut source) = (Vec::new(), None);
            loop {
                let next = match found.try_next().await {
                    Ok(Some(next)) => next,
                    // Obstacles that touch may enclose a vertex: it sees nothing.
                    Ok(None) | Err(QueryError::InsideObstacle { .. }) => break,
                    Err(error) => return Err(error.into()),
                };
                let to = next.vertex.point;
                if to == from {
                    source = Some(next.vertex.id);
                }
                // A path to a visible vertex bends nowhere, except at the source, where it begins.
                let is_seen = next.parent.is_none() || next.parent == source;
                if is_seen && from.lex_cmp(to).is_lt() {
                    seen.push([from, to]);
                }
            }
            anyhow::Ok(seen)
        });
        async move { task.await.context("a query panicked")? }
    });
    let lists: Vec<_> = seen.buffered(at_once).try_collect().await?;
    Ok(lists.concat())
}

/// Returns the edges of the tree of shortest paths from a vertex.
async fn tree(reader: &TileReader, from: Point) -> anyhow::Result<Vec<[Point; 2]>> {
    let mut found = reader.vertices_by_distance(from, QueryOptions::default());
    let mut points: HashMap<VertexId, Point> = HashMap::new();
    let mut edges = Vec::new();
    while let Some(next) = found.try_next().await? {
        let point = next.vertex.point;
        points.insert(next.vertex.id, point);
        let parent = next.parent.and_then(|parent| points.get(&parent)).copied();
        edges.push([parent.unwrap_or(from), point]);
    }
    edges.retain(|[a, b]| a != b);
    Ok(edges)
}

/// Returns the edges of the tree of shortest paths along edges from a vertex, to the nearest sector
/// of each vertex.
async fn tree_along(reader: &TileReader, from: Point) -> anyhow::Result<Vec<[Point; 2]>> {
    let mut found = reader.vertices_by_cdt_distance(from, QueryOptions::default());
    let (mut points, mut met) = (Vec::new(), HashSet::new());
    let mut edges = Vec::new();
    while let Some(next) = found.try_next().await? {
        let point = next.vertex.point;
        let parent = next.parent.and_then(|item| points.get(item as usize)).copied();
        points.push(point);
        if met.insert(next.vertex.id) {
            edges.push([parent.unwrap_or(from), point]);
        }
    }
    edges.retain(|[a, b]| a != b);
    Ok(edges)
}

/// Returns both paths between a pair, as edges: the shortest path, and that along edges.
async fn paths(reader: &TileReader, pair: &Pair) -> anyhow::Result<[Vec<[Point; 2]>; 2]> {
    let edges = |points: &[Point]| points.windows(2).map(|ends| [ends[0], ends[1]]).collect();
    let path = match reader
        .shortest_path(pair.from, pair.to, QueryOptions::default())
        .await?
    {
        PathOutcome::Found(path) => edges(&path.points),
        _ => Vec::new(),
    };
    let along = reader.cdt_distance(pair.from, pair.to, QueryOptions::default()).await?;
    Ok([path, along.map_or_else(Vec::new, |along| edges(&along.points))])
}
