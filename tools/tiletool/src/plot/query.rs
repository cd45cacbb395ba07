//! The picture of an answer: obstacles, searched triangles, and results.

use delaunay_tiles::geometry::{HalfEdge, Point, Rect, TriangleId};
use delaunay_tiles::mesh::Twin;
use delaunay_tiles::store::{Tile, TileId, TileReader};

use super::legend::{Legend, Sign};
use super::map::{Ground, draw_axes, draw_frame, middle_cut};
use super::page::Page;
use super::scales;
use super::style::{CONSTRAINT, FAINT_EDGE, GREY, HOLE, INK, LINES, PAPER, SITE, WALL, fill, stroke};
use super::svg::{Anchor, Path, Svg};

const EXPLORED: &str = "#d6e6f5";
const EXPLORED_EDGE: &str = "#9dbbd8";
const AREA: &str = "#f0b23e";
/// The colour of the transparent area over the paper, for the legend.
const AREA_SEEN: &str = "#f7dfb5";
const AREA_EDGE: &str = "#b06f00";
const WAY: &str = "#d1352b";
const START: &str = "#1f4fa8";
/// Colours of intervals, used cyclically.
const INTERVALS: [&str; 6] = ["#1b7f79", "#d1352b", "#6a4fb3", "#c77f0a", "#2f6fb8", "#a8327a"];

/// Minimum size in pixels of a triangle that is drawn.
const MIN_TRIANGLE: f64 = 0.35;
/// Maximum number of triangles whose edges are drawn.
const MAX_MESH: u64 = 12_000;
/// Maximum number of paths that are drawn with thick lines.
const FEW_PATHS: usize = 12;
/// Maximum number of sites whose ranks are written beside them.
const MAX_RANKS: usize = 40;

/// The question and the answer, which are drawn over the base map.
#[derive(Default)]
pub struct Overlay {
    /// The question and a summary of the answer, in one line.
    pub title: String,
    /// Start points of the queries.
    pub starts: Vec<Point>,
    /// End points of paths.
    pub ends: Vec<Point>,
    /// The sites or vertices found, the nearest first.
    pub sites: Vec<Point>,
    /// The paths found.
    pub paths: Vec<Vec<Point>>,
    /// The rings of areas.
    pub areas: Vec<Vec<Point>>,
    /// Intervals of lines, each with its number, or `None` inside an obstacle.
    pub intervals: Vec<([Point; 2], Option<usize>)>,
    /// The triangles that were searched.
    pub explored: Vec<[Point; 3]>,
}

impl Overlay {
    /// Returns the bounds of all that must be seen, with a margin. `whole` are the bounds of the
    /// file.
    pub fn window(&self, whole: Rect) -> Rect {
        let lines = self.intervals.iter().flat_map(|(ends, _)| ends);
        let rings = self.areas.iter().flatten();
        let points = [&self.starts, &self.ends, &self.sites].into_iter().flatten();
        let all = points.chain(lines).chain(rings).chain(self.paths.iter().flatten());
        let seen = Rect::around(all.copied());
        let (width, height) = whole.size();
        if seen.is_empty() {
            return whole;
        }
        let (seen_width, seen_height) = seen.size();
        let room = (0.12 * seen_width.max(seen_height)).max(0.01 * width.max(height));
        Rect::new(
            seen.min_x - room,
            seen.min_y - room,
            seen.max_x + room,
            seen.max_y + room,
        )
    }
}

/// The triangulation within the frame, as SVG paths.
#[derive(Default)]
struct BaseMap {
    exterior_is_hole: bool,
    triangles: u64,
    free: Path,
    holes: Path,
    edges: Path,
    breaks: Path,
    walls: Path,
}

impl BaseMap {
    async fn gather(reader: &TileReader, page: &Page) -> anyhow::Result<Self> {
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
        for id in seen {
            let tile = reader.tile(id).await?;
            for triangle in tile.owned_triangles() {
                this.add_triangle(&tile, triangle, page, view);
            }
        }
        Ok(this)
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
            let path = match (tile.is_constraint(half_edge), blocks) {
                (false, _) if is_hole || self.triangles > MAX_MESH => continue,
                (false, _) => &mut self.edges,
                (true, true) => &mut self.walls,
                (true, false) => &mut self.breaks,
            };
            path.line([pixels[s], pixels[e]]);
        }
    }
}

/// Draws the page of an answer.
pub async fn draw(reader: &TileReader, name: &str, overlay: &Overlay, page: &Page) -> anyhow::Result<String> {
    let (base_map, unit) = (BaseMap::gather(reader, page).await?, scales::unit_of(reader).await?);
    let name = middle_cut(name);
    let mut svg = Svg::new(page.width, page.height, &name);
    let mut legend = Legend::default();
    let base = if base_map.exterior_is_hole { HOLE } else { PAPER };
    draw_frame(&mut svg, page, Ground::Colour(base), [&name, &overlay.title], |svg| {
        svg.in_units(&format!("{LINES} stroke-linecap=\"round\""), |svg| {
            draw_base_map(svg, &mut legend, &base_map, overlay, page);
            draw_found(svg, &mut legend, overlay, page);
        });
        draw_ranks(svg, overlay, page);
    });
    draw_axes(&mut svg, page);
    let [legend_y, ..] = page.footer();
    legend.draw(&mut svg, (page.frame.min_x, legend_y));
    scales::draw(&mut svg, page, unit, None);
    Ok(svg.finish())
}

/// Returns the style of filled shapes. A thin line of the same colour closes the gaps between
/// triangles.
fn solid(colour: &str) -> String {
    format!("{} {}", fill(colour), stroke(colour, 0.5))
}

fn draw_base_map(svg: &mut Svg, legend: &mut Legend, base_map: &BaseMap, overlay: &Overlay, page: &Page) {
    if base_map.exterior_is_hole {
        svg.path(&base_map.free, &solid(PAPER));
    }
    let explored = Path::polygons(
        overlay
            .explored
            .iter()
            .map(|corners| corners.map(|corner| page.pixel(corner))),
    );
    if !overlay.explored.is_empty() {
        legend.path(svg, &explored, &solid(EXPLORED), Sign::Patch(EXPLORED), "searched");
    }
    if base_map.triangles <= MAX_MESH {
        svg.path(
            &base_map.edges,
            &format!("{} stroke-opacity=\"0.45\"", stroke(FAINT_EDGE, 0.5)),
        );
    }
    if overlay.explored.len() as u64 <= MAX_MESH {
        svg.path(&explored, &stroke(EXPLORED_EDGE, 0.6));
    }
    svg.path(&base_map.holes, &solid(HOLE));
    // Many triangles are drawn with thinner lines.
    let line = if base_map.triangles <= MAX_MESH / 2 { 1.6 } else { 0.9 };
    for (path, colour, width, text) in [
        (&base_map.breaks, CONSTRAINT, 0.6 * line, "break lines"),
        (&base_map.walls, WALL, line, "walls"),
    ] {
        if !path.is_empty() {
            legend.path(svg, path, &stroke(colour, width), Sign::Line(colour, width), text);
        }
    }
    if !base_map.holes.is_empty() || base_map.exterior_is_hole {
        legend.add(Sign::Patch(HOLE), "obstacles");
    }
}

fn draw_found(svg: &mut Svg, legend: &mut Legend, overlay: &Overlay, page: &Page) {
    let pixel = |&point: &Point| page.pixel(point);
    let areas = overlay.areas.iter();
    let areas = Path::polygons(areas.map(|ring| ring.iter().map(pixel)));
    if !areas.is_empty() {
        let style = format!(
            "{} fill-opacity=\"0.38\" fill-rule=\"evenodd\" {}",
            fill(AREA),
            stroke(AREA_EDGE, 1.6)
        );
        legend.path(svg, &areas, &style, Sign::Patch(AREA_SEEN), "within reach");
    }
    let mut paths = Path::default();
    overlay.paths.iter().for_each(|path| paths.line(path.iter().map(pixel)));
    if !paths.is_empty() {
        let width = if overlay.paths.len() <= FEW_PATHS { 2.8 } else { 1.2 };
        let text = if overlay.paths.len() == 1 { "path" } else { "paths" };
        svg.path(&paths, &stroke("#fff", 2.0 * width));
        legend.path(svg, &paths, &stroke(WAY, width), Sign::Line(WAY, width), text);
    }
    draw_intervals(svg, legend, overlay, page);
    for (points, colour, radius, text) in [
        (&overlay.sites, SITE, 5.0, "sites found"),
        (&overlay.ends, WAY, 6.5, "to"),
        (&overlay.starts, START, 6.5, "from"),
    ] {
        if !points.is_empty() {
            let style = format!("{} {}", fill(colour), stroke("#fff", 1.5));
            let discs = Path::discs(points.iter().map(pixel), radius);
            legend.path(svg, &discs, &style, Sign::Dot(colour), text);
        }
    }
}

fn draw_intervals(svg: &mut Svg, legend: &mut Legend, overlay: &Overlay, page: &Page) {
    for &(ends, number) in &overlay.intervals {
        let ends = ends.map(|end| page.pixel(end));
        let mut interval = Path::default();
        interval.line(ends);
        let style = match number {
            Some(number) => stroke(INTERVALS[number % INTERVALS.len()], 5.0),
            None => format!("{} stroke-dasharray=\"40 60\"", stroke(GREY, 2.0)),
        };
        svg.path(&interval, &format!("{style} stroke-linecap=\"butt\""));
        svg.path(&Path::discs([ends[0]], 2.6), &fill(INK));
    }
    if overlay.intervals.iter().any(|(_, number)| number.is_some()) {
        legend.add(Sign::Line(INTERVALS[0], 5.0), "same nearest sites");
    }
}

/// Writes the ranks of sites beside them, if there are few sites.
fn draw_ranks(svg: &mut Svg, overlay: &Overlay, page: &Page) {
    if overlay.sites.len() > MAX_RANKS || overlay.starts.len() > 1 || !overlay.intervals.is_empty() {
        return;
    }
    let style = format!(
        "{} stroke=\"#fff\" stroke-opacity=\"0.85\" stroke-width=\"3.5\" stroke-linejoin=\"round\" paint-order=\"stroke\"",
        fill(INK)
    );
    for (&site, rank) in overlay.sites.iter().zip(1..) {
        let (x, y) = page.pixel(site);
        svg.text((x + 8.0, y - 7.0), 15.0, Anchor::Start, &style, &rank.to_string());
    }
}
