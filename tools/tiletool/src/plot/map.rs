//! The map: title, triangulation, cells, coordinates, legend and caption.

use delaunay_tiles::crs::Unit;
use delaunay_tiles::geometry::{Point, Rect};
use delaunay_tiles::store::{Directory, KdNode};

use super::axis::{TICK_TEXT, fitted_text, text_width};
use super::heading::Heading;
use super::legend::{Legend, Sign};
use super::page::Page;
use super::relief::Heights;
use super::scales;
use super::scene::Scene;
use super::style::{CONSTRAINT, EDGE, GREY, HOLE, HULL, INK, LINES, SITE, WALL, fill, stroke};
use super::svg::{Anchor, Path, Svg};
use super::widths;
use crate::common::counted;

const BORDER: &str = "#f5dfb8";
const CELL: &str = "#c8452f";

/// The opacity of edges over heights.
const OVER_HEIGHTS: f64 = 0.3;
/// The mean distance of points in pixels from which edges are opaque.
const OPAQUE: f64 = 14.0;
/// Maximum number of points that are drawn as dots over their triangles.
const MAX_DOTS: usize = 2000;
/// Maximum number of tiles whose numbers are written on the map.
const MAX_LABELS: usize = 100;
/// Minimum width or height in pixels of a cell whose cut is drawn.
const MIN_CELL: f64 = 2.0;

/// The ground of a frame.
#[derive(Clone, Copy)]
pub enum Ground<'a> {
    Colour(&'a str),
    /// An image of the frame, by its reference.
    Image(&'a str),
    /// Nothing: the document is drawn over an image.
    Beneath,
}

/// A map of a file: what is drawn, on which page.
pub struct Map<'a> {
    pub heading: &'a Heading,
    pub directory: &'a Directory,
    pub page: &'a Page,
    pub unit: Unit,
    /// A small file, which is drawn line by line; a large one is already painted over the ground.
    pub scene: Option<&'a Scene>,
    /// The heights that the ground shows.
    pub heights: Option<Heights>,
}

impl Map<'_> {
    /// Draws the whole page. Returns the document and its height.
    pub fn draw(&self, ground: Ground, mut legend: Legend) -> (String, u32) {
        let Self { directory, page, .. } = *self;
        let mut svg = Svg::new(page.width, page.height, &self.heading.title);
        draw_frame(&mut svg, page, ground, self.heading.lines(), |svg| {
            svg.in_units(LINES, |svg| {
                if let Some(scene) = self.scene {
                    draw_mesh(svg, &mut legend, scene, page, self.heights.is_some());
                }
                draw_cells(svg, &mut legend, directory, page);
            });
            draw_labels(svg, directory, page);
        });
        draw_axes(&mut svg, page);
        let ([legend_y, _, caption_y], x) = (page.footer(), page.frame.min_x);
        let lower = legend.draw_within(&mut svg, (x, legend_y), page.frame.max_x);
        scales::draw(&mut svg, page, lower, self.unit, self.heights);
        let caption = caption(directory);
        svg.text((x, caption_y + lower), 15.0, Anchor::Start, &fill(GREY), &caption);
        let height = svg.grow(lower as u32);
        (svg.finish(), height)
    }
}

/// Draws the paper, the frame with its ground and its content, and two lines of text above.
pub fn draw_frame(
    svg: &mut Svg,
    page: &Page,
    ground: Ground,
    [title, subtitle]: [&str; 2],
    inside: impl FnOnce(&mut Svg),
) {
    if !matches!(ground, Ground::Beneath) {
        svg.raw("<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>");
    }
    let f = page.frame;
    let (left, baseline) = (f.min_x, f.min_y);
    let size = fitted_text(title, 26.0, f.size().0);
    svg.text((left, baseline - 42.0), size, Anchor::Start, &fill(INK), title);
    let (width, height) = f.size();
    let size = fitted_text(subtitle, 16.0, width);
    svg.text((left, baseline - 15.0), size, Anchor::Start, &fill(GREY), subtitle);
    let attributes = format!(
        "x=\"{}\" y=\"{}\" width=\"{width}\" height=\"{height}\"",
        f.min_x, f.min_y
    );
    svg.raw(&format!("<clipPath id=\"frame\"><rect {attributes}/></clipPath>"));
    match ground {
        Ground::Colour(colour) => svg.raw(&format!("<rect {attributes} fill=\"{colour}\"/>")),
        Ground::Image(reference) => svg.raw(&format!("<image {attributes} href=\"{reference}\"/>")),
        Ground::Beneath => {}
    }
    svg.raw("<g clip-path=\"url(#frame)\">");
    inside(svg);
    svg.raw("</g>");
    svg.raw(&format!(
        "<rect {attributes} fill=\"none\" stroke=\"{INK}\" stroke-width=\"1.2\"/>"
    ));
}

/// Draws triangles and points. Over heights, edges are faint, and border triangles are not filled.
fn draw_mesh(svg: &mut Svg, legend: &mut Legend, scene: &Scene, page: &Page, has_heights: bool) {
    let pixels: Vec<_> = scene.points.iter().map(|&p| page.pixel(p)).collect();
    for (triangles, colour, text, is_seen) in [
        (&scene.border, BORDER, "border triangles", !has_heights),
        (&scene.holes, HOLE, "holes", true),
    ] {
        if is_seen && !triangles.is_empty() {
            let path = Path::polygons(triangles.iter().map(|t| t.map(|corner| pixels[corner as usize])));
            legend.path(svg, &path, &fill(colour), Sign::Patch(colour), text);
        }
    }
    // A finer mesh has thinner lines.
    let (width, height) = scene.bounds.size();
    let area = page.length(width) * page.length(height);
    let spacing = (area / pixels.len().max(1) as f64).sqrt();
    let edges = if has_heights { (INK, OVER_HEIGHTS) } else { (EDGE, 1.0) };
    draw_edges(svg, legend, scene, &pixels, spacing, edges);
    if pixels.len() <= MAX_DOTS || scene.triangles == 0 {
        let radius = match pixels.len() {
            ..=100 => 3.5,
            101..=MAX_DOTS => (0.06 * spacing).clamp(1.4, 3.5),
            _ => 1.0,
        };
        let path = Path::discs(pixels.iter().copied(), radius);
        if !path.is_empty() {
            legend.path(svg, &path, &fill(INK), Sign::Dot(INK), "vertices");
        }
    }
    if !scene.sites.is_empty() {
        let path = Path::discs(scene.sites.iter().map(|&site| pixels[site as usize]), 4.5);
        legend.path(svg, &path, &fill(SITE), Sign::Dot(SITE), "sites");
    }
}

fn draw_edges(
    svg: &mut Svg,
    legend: &mut Legend,
    scene: &Scene,
    pixels: &[(f64, f64)],
    spacing: f64,
    (edge, edge_opacity): (&'static str, f64),
) {
    let width = (0.045 * spacing).clamp(0.4, 1.1);
    let others = match scene.walls.is_empty() {
        true => "constraints",
        false => "break lines",
    };
    // In a finer mesh, edges are also fainter, so that bundles of them are no blots.
    let edge_opacity = edge_opacity * (spacing / OPAQUE).clamp(0.5, 1.0);
    let area = spacing * spacing * pixels.len() as f64;
    let width_of = |edges: &[[u32; 2]], most: f64| widths::of_many(widths::count(pixels, edges), area, most);
    for (edges, colour, width, opacity, text) in [
        (&scene.edges, edge, width, edge_opacity, "edges"),
        (&scene.outline, HULL, 1.8, 1.0, "hull"),
        (
            &scene.constraints,
            CONSTRAINT,
            width_of(&scene.constraints, 1.2 + width),
            1.0,
            others,
        ),
        (&scene.walls, WALL, width_of(&scene.walls, 2.2 + width), 1.0, "walls"),
    ] {
        if edges.is_empty() {
            continue;
        }
        let of_lines = || widths::by_size(pixels, edges, width);
        let classes = match text {
            "edges" | "hull" => vec![(width, edges.clone())],
            _ => of_lines(),
        };
        for (width, edges) in classes {
            let mut path = Path::default();
            path.trails(pixels, &edges);
            let mut style = stroke(colour, width);
            if opacity < 1.0 {
                style += &format!(" stroke-opacity=\"{opacity:.2}\"");
            }
            svg.path(&path, &style);
        }
        legend.add(Sign::Line(colour, width.max(0.9)), text);
    }
}

/// Draws each cut of the k-d tree once. The cuts are the sides of the cells.
fn draw_cells(svg: &mut Svg, legend: &mut Legend, directory: &Directory, page: &Page) {
    let tree = &directory.tree;
    let mut path = Path::default();
    for (node, cell) in tree.nodes().iter().zip(tree.node_cells()) {
        let seen = page.cell(cell);
        if seen.is_empty() {
            continue;
        }
        let (width, height) = seen.size();
        match *node {
            KdNode::X { cut, .. } if width >= MIN_CELL => {
                let (x, _) = page.pixel(Point::new(cut, 0.0));
                path.line([(x, seen.min_y), (x, seen.max_y)]);
            }
            KdNode::Y { cut, .. } if height >= MIN_CELL => {
                let (_, y) = page.pixel(Point::new(0.0, cut));
                path.line([(seen.min_x, y), (seen.max_x, y)]);
            }
            _ => {}
        }
    }
    if tree.tiles() < 2 {
        return;
    }
    let (width, height) = page.frame.size();
    let size = (width * height / f64::from(tree.tiles())).sqrt();
    let line = (size / 70.0).clamp(0.4, 1.8);
    let sign = Sign::Line(CELL, line.max(0.9));
    legend.path(svg, &path, &stroke(CELL, line), sign, "cells of the tiles");
}

/// Writes the numbers of tiles into their cells, where there is enough room.
fn draw_labels(svg: &mut Svg, directory: &Directory, page: &Page) {
    let cells = directory.tree.cells().into_iter();
    let cells: Vec<(u32, Rect)> = cells.map(|(id, cell)| (id.0, page.cell(cell))).collect();
    if !(2..=MAX_LABELS).contains(&cells.len()) {
        return;
    }
    let mut sizes: Vec<f64> = cells.iter().map(|(_, c)| c.size().0.min(c.size().1)).collect();
    sizes.sort_by(f64::total_cmp);
    let size = (0.18 * sizes[sizes.len() / 2]).clamp(13.0, 26.0);
    let style = format!(
        "{} stroke=\"#fff\" stroke-opacity=\"0.85\" stroke-width=\"{:.1}\" stroke-linejoin=\"round\" paint-order=\"stroke\"",
        fill(CELL),
        size / 4.0
    );
    for (id, cell) in &cells {
        let label = id.to_string();
        let (width, height) = cell.size();
        let size = size
            .min(0.9 * height)
            .min(size * 0.9 * width / text_width(&label, size));
        if size >= 8.0 {
            let (x, y) = ((cell.min_x + cell.max_x) / 2.0, (cell.min_y + cell.max_y) / 2.0);
            svg.text((x, y + 0.36 * size), size, Anchor::Middle, &style, &label);
        }
    }
}

pub fn draw_axes(svg: &mut Svg, page: &Page) {
    let f = page.frame;
    let (x, y) = ((f.min_x + f.max_x) / 2.0, (f.min_y + f.max_y) / 2.0);
    let mut path = Path::default();
    for (at, _) in &page.x_axis.ticks {
        path.line([(x + at, f.max_y), (x + at, f.max_y + 6.0)]);
        path.line([(x + at, f.min_y), (x + at, f.min_y + 6.0)]);
    }
    for (at, _) in &page.y_axis.ticks {
        path.line([(f.min_x - 6.0, y - at), (f.min_x, y - at)]);
        path.line([(f.max_x - 6.0, y - at), (f.max_x, y - at)]);
    }
    svg.in_units("", |svg| svg.path(&path, &stroke(INK, 1.2)));
    for (at, label) in &page.x_axis.ticks {
        svg.text((x + at, f.max_y + 24.0), TICK_TEXT, Anchor::Middle, &fill(INK), label);
    }
    for (at, label) in &page.y_axis.ticks {
        svg.text(
            (f.min_x - 12.0, y - at + 0.36 * TICK_TEXT),
            TICK_TEXT,
            Anchor::End,
            &fill(INK),
            label,
        );
    }
}

/// Returns the counts of a file, for the line below the title.
pub fn subtitle(directory: &Directory) -> String {
    let m = &directory.metadata;
    [
        counted(m.vertices, "vertex", "vertices"),
        counted(m.triangles, "triangle", "triangles"),
        counted(m.tiles.into(), "tile", "tiles"),
    ]
    .join("  ·  ")
}

fn caption(directory: &Directory) -> String {
    let m = &directory.metadata;
    if m.vertices == 0 {
        return "The file has no vertices".to_owned();
    }
    let all = counted(m.vertices, "vertex", "vertices");
    match (m.triangles, m.vertices) {
        (0, ..3) => format!("{all}; no triangles"),
        (0, _) => format!("{all}, all collinear; no triangles"),
        _ if m.constraint_edges > 0 => {
            let edges = counted(m.constraint_edges, "constraint edge", "constraint edges");
            format!("The whole constrained Delaunay triangulation of {all} and {edges}")
        }
        _ => format!("The whole Delaunay triangulation of {all}"),
    }
}
