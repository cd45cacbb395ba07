//! A large file as pixels: all of its triangles, drawn tile by tile.
//!
//! In: a tile file, and a page. Out: what covers each pixel of the frame, which is then painted over an
//! image. The memory is that of the pixels, whatever the size of the file.

use delaunay_tiles::geometry::{HalfEdge, Point, TriangleId};
use delaunay_tiles::mesh::Twin;
use delaunay_tiles::store::{Tile, TileEdge, TileReader};
use futures::TryStreamExt;
use resvg::tiny_skia::Pixmap;

use super::image::paint;
use super::ink::{Areas, Lengths, Pixel, Strokes};
use super::legend::{Legend, Sign};
use super::page::Page;
use super::style::{CONSTRAINT, EDGE, HOLE, HULL, INK, SITE, WALL};
use super::widths;

/// Widths in pixels of the hull, of few constraints and walls, and of the dots of vertices and of sites.
const HULL_WIDTH: f64 = 1.6;
const CONSTRAINT_WIDTH: f64 = 1.4;
const WALL_WIDTH: f64 = 2.2;
const VERTEX_WIDTH: f64 = 2.0;
const SITE_WIDTH: f64 = 8.0;

/// The opacity of holes over edges, so that both are seen where edges are dense.
const HOLE_OPACITY: f64 = 0.85;
/// The colour of edges, and how much of a pixel is drawn in it where there is as much length of them as on
/// average, and at most; without and with heights below.
const INKS: [(&str, f64, f64); 2] = [(EDGE, 0.38, 0.85), (INK, 0.1, 0.25)];
/// The average length of edges in a pixel above which they are not drawn over heights.
const FULL: f64 = 1.0;

/// What covers the pixels of a frame.
pub struct Layers {
    size: (usize, usize),
    corner: Pixel,
    /// Widths of constraints and of walls.
    widths: [f64; 2],
    edges: Lengths,
    /// This and the rest are `None` until there is one of them, to save memory.
    hull: Option<Strokes>,
    holes: Option<Areas>,
    constraints: Option<Strokes>,
    walls: Option<Strokes>,
    vertices: Option<Strokes>,
    sites: Option<Strokes>,
    triangles: u64,
    vertex_count: u64,
}

impl Layers {
    /// Reads the tiles one by one.
    ///
    /// # Errors
    /// Fails if a tile cannot be read.
    pub async fn gather(reader: &TileReader, page: &Page) -> anyhow::Result<Self> {
        let mut this = Self::new(page, reader.metadata().constraint_edges);
        let mut tiles = reader.tiles();
        while let Some(tile) = tiles.try_next().await? {
            this.add_tile(&tile, page);
        }
        Ok(this)
    }

    fn new(page: &Page, constraints: u64) -> Self {
        let size = page.pixels();
        let area = (size.0 * size.1) as f64;
        Self {
            size,
            corner: (page.frame.min_x, page.frame.min_y),
            widths: [CONSTRAINT_WIDTH, WALL_WIDTH].map(|most| widths::of_many(constraints as f64, area, most)),
            edges: Lengths::new(size),
            hull: None,
            holes: None,
            constraints: None,
            walls: None,
            vertices: None,
            sites: None,
            triangles: 0,
            vertex_count: 0,
        }
    }

    /// Returns the number of vertices and of triangles that were drawn.
    pub fn counts(&self) -> (u64, u64) {
        (self.vertex_count, self.triangles)
    }

    fn pixel(&self, page: &Page, p: Point) -> Pixel {
        let (x, y) = page.pixel(p);
        (x - self.corner.0, y - self.corner.1)
    }

    /// Draws a line, or a dot, into one of the layers.
    fn stroke(&mut self, layer: fn(&mut Self) -> &mut Option<Strokes>, [a, b]: [Pixel; 2], width: f64) {
        let size = self.size;
        layer(self).get_or_insert_with(|| Strokes::new(size)).line(a, b, width);
    }

    fn add_tile(&mut self, tile: &Tile, page: &Page) {
        self.vertex_count += tile.points().len() as u64;
        for triangle in tile.owned_triangles() {
            self.triangles += 1;
            self.add_triangle(tile, triangle, page);
        }
        for site in tile.sites() {
            let at = self.pixel(page, tile.point(site.vertex));
            self.stroke(|this| &mut this.sites, [at, at], SITE_WIDTH);
        }
        // Without triangles, vertices are all there is, and edges are stored on their own.
        if tile.triangle_count() == 0 {
            for p in tile.points() {
                let at = self.pixel(page, p);
                self.stroke(|this| &mut this.vertices, [at, at], VERTEX_WIDTH);
            }
            for edge in tile.owned_constraints() {
                let ends = tile.ends(edge).map(|end| self.pixel(page, end.point));
                self.add_constraint(tile, edge, ends);
            }
        }
    }

    fn add_triangle(&mut self, tile: &Tile, triangle: TriangleId, page: &Page) {
        let corners = tile.triangle_points(triangle);
        let pixels = corners.map(|corner| self.pixel(page, corner));
        if tile.is_hole(triangle) {
            let size = self.size;
            self.holes.get_or_insert_with(|| Areas::new(size)).triangle(pixels);
        }
        for start in 0..3 {
            let (end, half_edge) = ((start + 1) % 3, HalfEdge::new(triangle, start as u32));
            let is_hull = tile.twin(half_edge) == Twin::Hull;
            // Draws each edge once: the other triangle has it in the other direction.
            if !is_hull && corners[start].lex_cmp(corners[end]).is_ge() {
                continue;
            }
            let ends = [pixels[start], pixels[end]];
            if tile.is_constraint(half_edge) {
                self.add_constraint(tile, half_edge, ends);
            } else if is_hull {
                self.stroke(|this| &mut this.hull, ends, HULL_WIDTH);
            } else {
                self.edges.line(ends[0], ends[1]);
            }
        }
    }

    fn add_constraint(&mut self, tile: &Tile, edge: impl Into<TileEdge>, ends: [Pixel; 2]) {
        let [constraint, wall] = self.widths;
        match tile.is_wall(edge) {
            true => self.stroke(|this| &mut this.walls, ends, wall),
            false => self.stroke(|this| &mut this.constraints, ends, constraint),
        }
    }

    /// Paints all layers over an image, which shows heights or is blank, and adds their signs to the
    /// legend.
    pub fn paint(&self, image: &mut Pixmap, has_heights: bool, legend: &mut Legend) {
        self.paint_edges(image, has_heights, legend);
        if let Some(holes) = &self.holes {
            paint(image, HOLE, holes.all().map(|covered| HOLE_OPACITY * covered));
            legend.add(Sign::Patch(HOLE), "holes");
        }
        let others = if self.walls.is_some() {
            "break lines"
        } else {
            "constraints"
        };
        let [constraint, wall] = self.widths;
        for (strokes, colour, sign, text) in [
            (&self.hull, HULL, Sign::Line(HULL, HULL_WIDTH), "hull"),
            (
                &self.constraints,
                CONSTRAINT,
                Sign::Line(CONSTRAINT, constraint.max(0.9)),
                others,
            ),
            (&self.walls, WALL, Sign::Line(WALL, wall.max(0.9)), "walls"),
            (&self.vertices, INK, Sign::Dot(INK), "vertices"),
            (&self.sites, SITE, Sign::Dot(SITE), "sites"),
        ] {
            if let Some(strokes) = strokes {
                paint(image, colour, strokes.all());
                legend.add(sign, text);
            }
        }
    }

    /// Paints the edges as a tone: the more length of them in a pixel, the darker. An average pixel has
    /// the same tone in all maps, so that there is always more and less to see.
    fn paint_edges(&self, image: &mut Pixmap, has_heights: bool, legend: &mut Legend) {
        let seen = self.edges.all().filter(|&length| length > 0.0);
        let (sum, count) = seen.fold((0.0, 0u64), |(sum, count), length| (sum + length, count + 1));
        let average = sum / count.max(1) as f64;
        if count == 0 || has_heights && average > FULL {
            return;
        }
        let (colour, tone, most) = INKS[usize::from(has_heights)];
        // `most` is approached exponentially, and `tone` is reached at the average.
        let rate = -(1.0 - tone / most).ln() / average;
        let tones = self.edges.all().map(|length| most * (1.0 - (-rate * length).exp()));
        paint(image, colour, tones);
        let text = if average > FULL {
            "edges: the darker, the more"
        } else {
            "edges"
        };
        legend.add(Sign::Line(colour, 0.9), text);
    }
}
