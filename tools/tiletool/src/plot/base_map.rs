//! The triangulation below the answer to a query: what blocks, what was searched, and the edges.

use std::collections::{HashMap, HashSet};

use delaunay_tiles::geometry::{HalfEdge, Point, Rect, TriangleId};
use delaunay_tiles::mesh::Twin;
use delaunay_tiles::store::{Tile, TileId, TileReader};

use super::ink::Pixel;
use super::legend::{Legend, Sign};
use super::page::Page;
use super::style::{CONSTRAINT, FAINT_EDGE, HOLE, PAPER, WALL, fill, stroke};
use super::svg::{Path, Svg};
use super::widths;

const EXPLORED: &str = "#d6e6f5";
const EXPLORED_EDGE: &str = "#9dbbd8";
/// Minimum size in pixels of a triangle that is drawn.
const MIN_TRIANGLE: f64 = 0.35;
/// Maximum number of triangles whose edges are drawn.
const MAX_MESH: u64 = 12_000;
/// Maximum widths of walls and of break lines.
const WALL_WIDTH: f64 = 1.6;
const BREAK_WIDTH: f64 = 1.0;
/// Searched triangles whose edges would be closer to each other have none.
const MIN_HEIGHT: f64 = 2.5;
/// The distance in pixels of opposite sides of triangles from which edges are opaque.
const OPAQUE: f64 = 16.0;
/// The distance in pixels of other sites that are drawn.
const APART: f64 = 5.0;

/// The triangulation within the frame.
#[derive(Default)]
pub struct BaseMap {
    exterior_is_hole: bool,
    triangles: u64,
    free: Path,
    holes: Path,
    edges: Path,
    breaks: Lines,
    walls: Lines,
    /// The sites within the frame.
    pub sites: Vec<Point>,
}

/// Lines between numbered pixels.
#[derive(Default)]
struct Lines {
    pixels: Vec<Pixel>,
    numbers: HashMap<[u64; 2], u32>,
    edges: Vec<[u32; 2]>,
}

impl Lines {
    fn add(&mut self, ends: [Pixel; 2]) {
        let Self { pixels, numbers, edges } = self;
        edges.push(ends.map(|(x, y)| {
            *numbers.entry([x.to_bits(), y.to_bits()]).or_insert_with(|| {
                pixels.push((x, y));
                pixels.len() as u32 - 1
            })
        }));
    }
}

impl BaseMap {
    /// Reads the tiles that the page shows.
    pub async fn gather(reader: &TileReader, page: &Page) -> anyhow::Result<Self> {
        let directory = reader.directory().await?;
        let mut this = Self {
            exterior_is_hole: directory.metadata.exterior_is_hole,
            ..Self::default()
        };
        let view = page.view();
        let tiles = directory.tiles.iter().zip(0..);
        let seen: Vec<TileId> = tiles
            .filter(|(entry, _)| !entry.is_unused() && entry.bounds.intersects(view))
            .map(|(_, id)| TileId(id))
            .collect();
        let mut places = HashSet::new();
        for id in seen {
            let tile = reader.tile(id).await?;
            for triangle in tile.owned_triangles() {
                this.add_triangle(&tile, triangle, page, view);
            }
            // One of several sites at nearly the same pixel is enough.
            let sites = tile.sites().map(|site| tile.point(site.vertex));
            let place = |&site: &Point| <[f64; 2]>::from(page.pixel(site)).map(|v| (v / APART).round() as i64);
            this.sites
                .extend(sites.filter(|site| view.contains(*site) && places.insert(place(site))));
        }
        Ok(this)
    }

    /// Returns the colour of the ground.
    pub fn ground(&self) -> &'static str {
        if self.exterior_is_hole { HOLE } else { PAPER }
    }

    fn add_triangle(&mut self, tile: &Tile, triangle: TriangleId, page: &Page, view: Rect) {
        let corners = tile.triangle_points(triangle);
        let around = Rect::around(corners);
        let (width, height) = around.size();
        if !around.intersects(view) || page.length(width.max(height)) < MIN_TRIANGLE {
            return;
        }
        self.triangles += 1;
        let pixels = corners.map(|corner| page.pixel(corner));
        let is_hole = tile.is_hole(triangle);
        let base_map = if is_hole { &mut self.holes } else { &mut self.free };
        base_map.polygon(pixels);
        for s in 0..3 {
            let (e, half_edge) = ((s + 1) % 3, HalfEdge::new(triangle, s as u32));
            let twin = tile.twin(half_edge);
            // Draws each edge once, if both its triangles are drawn here.
            let is_first = corners[s].lex_cmp(corners[e]).is_lt() || twin == Twin::Hull;
            if !is_first {
                continue;
            }
            let blocks = tile.is_wall(half_edge)
                || match twin {
                    Twin::HalfEdge(twin) => tile.is_hole(twin.triangle()) != is_hole,
                    Twin::Hull | Twin::Elsewhere => is_hole,
                };
            let ends = [pixels[s], pixels[e]];
            match (tile.is_constraint(half_edge), blocks) {
                (false, _) if is_hole || self.triangles > MAX_MESH => {}
                (false, _) => self.edges.line(ends),
                (true, true) => self.walls.add(ends),
                (true, false) => self.breaks.add(ends),
            }
        }
    }

    /// Draws the map, with the triangles that were searched.
    pub fn draw(&self, svg: &mut Svg, legend: &mut Legend, explored: &[[Point; 3]], page: &Page) {
        if self.exterior_is_hole {
            svg.path(&self.free, &solid(PAPER));
        }
        let explored: Vec<_> = explored
            .iter()
            .map(|corners| corners.map(|corner| page.pixel(corner)))
            .collect();
        if !explored.is_empty() {
            let path = Path::polygons(explored.iter().copied());
            legend.path(svg, &path, &solid(EXPLORED), Sign::Patch(EXPLORED), "searched");
        }
        if self.triangles <= MAX_MESH {
            let style = format!("{} stroke-opacity=\"0.45\"", stroke(FAINT_EDGE, 0.5));
            svg.path(&self.edges, &style);
        }
        draw_searched_edges(svg, &explored);
        svg.path(&self.holes, &solid(HOLE));
        let (width, height) = page.frame.size();
        for (lines, colour, most, text) in [
            (&self.breaks, CONSTRAINT, BREAK_WIDTH, "break lines"),
            (&self.walls, WALL, WALL_WIDTH, "walls"),
        ] {
            if lines.edges.is_empty() {
                continue;
            }
            let count = widths::count(&lines.pixels, &lines.edges);
            let line = widths::of_many(count, width * height, most);
            for (line, edges) in widths::by_size(&lines.pixels, &lines.edges, line) {
                let mut path = Path::default();
                path.trails(&lines.pixels, &edges);
                svg.path(&path, &stroke(colour, line));
            }
            legend.add(Sign::Line(colour, line.max(0.9)), text);
        }
        if !self.holes.is_empty() || self.exterior_is_hole {
            legend.add(Sign::Patch(HOLE), "obstacles");
        }
    }
}

/// Draws the edges of searched triangles, fainter where they are small. Slivers have none, because
/// bundles of their edges would be a blot.
fn draw_searched_edges(svg: &mut Svg, explored: &[[Pixel; 3]]) {
    let height = |&[a, b, c]: &[Pixel; 3]| {
        let side = |p: Pixel, q: Pixel| (q.0 - p.0).hypot(q.1 - p.1);
        let area = (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0);
        area.abs() / side(a, b).max(side(b, c)).max(side(c, a))
    };
    let mut seen: Vec<_> = explored.iter().map(|corners| (height(corners), corners)).collect();
    seen.retain(|&(height, _)| height >= MIN_HEIGHT);
    if seen.is_empty() || seen.len() as u64 > MAX_MESH {
        return;
    }
    seen.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let middle = seen[seen.len() / 2].0;
    let opacity = (middle / OPAQUE).clamp(0.45, 1.0);
    let path = Path::polygons(seen.iter().map(|&(_, corners)| *corners));
    svg.path(
        &path,
        &format!("{} stroke-opacity=\"{opacity:.2}\"", stroke(EXPLORED_EDGE, 0.6)),
    );
}

/// Returns the style of filled shapes. A thin line of the same colour closes the gaps between
/// triangles.
fn solid(colour: &str) -> String {
    format!("{} {}", fill(colour), stroke(colour, 0.5))
}
