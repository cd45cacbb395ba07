//! What a query found, and what it did not find.

use std::collections::HashSet;

use delaunay_tiles::geometry::Point;

use super::distances;
use super::labels::{Labels, cut};
use super::legend::{Legend, Sign};
use super::overlay::{Mark, Overlay, Piece};
use super::page::Page;
use super::style::{GREY, INK, PAPER, SITE, fill, stroke};
use super::svg::{Path, Svg};

const AREA: &str = "#f0b23e";
/// The colour of the transparent area over the paper, for the legend.
const AREA_SEEN: &str = "#f7dfb5";
const AREA_EDGE: &str = "#b06f00";
const WAY: &str = "#d1352b";
const START: &str = "#1f4fa8";
/// Colours of keys, used cyclically.
const KEYS: [&str; 12] = [
    "#1b7f79", "#d1352b", "#6a4fb3", "#c77f0a", "#2f6fb8", "#a8327a", "#5d8a1f", "#7a4a2b", "#e0699a", "#3aa6c9",
    "#8f8b00", "#1d3f8f",
];
/// Maximum number of keys in the legend.
const MAX_KEYS: usize = 36;
/// Maximum number of paths that are drawn with thick lines.
const FEW: usize = 12;
/// Maximum number of other sites that are drawn as large as those of few.
const FEW_SITES: usize = 400;
/// Width of pieces of lines.
const PIECE: f64 = 5.0;
const SITE_RADIUS: f64 = 5.0;
const END_RADIUS: f64 = 6.5;
/// Half the side of the square of an end, which looks as large as the disc of a start.
const SQUARE_RADIUS: f64 = 5.8;

/// Draws the answer over the base map, whose sites are `sites`. Its texts are written by [`write`].
pub fn draw(svg: &mut Svg, legend: &mut Legend, overlay: &Overlay, sites: &[Point], page: &Page) {
    add_points(legend, overlay);
    let pixel = |&point: &Point| page.pixel(point);
    let areas = Path::polygons(overlay.areas.iter().map(|ring| ring.iter().map(pixel)));
    if !areas.is_empty() {
        let style = format!(
            "{} fill-opacity=\"0.38\" fill-rule=\"evenodd\" {}",
            fill(AREA),
            stroke(AREA_EDGE, 1.6)
        );
        legend.path(svg, &areas, &style, Sign::Patch(AREA_SEEN), "within reach");
    }
    let mut paths = Path::default();
    for way in &overlay.paths {
        paths.line(way.points.iter().map(pixel));
    }
    if !paths.is_empty() {
        let width = if overlay.paths.len() <= FEW { 2.8 } else { 1.2 };
        let text = if overlay.paths.len() == 1 { "path" } else { "paths" };
        svg.path(&paths, &stroke("#fff", 2.0 * width));
        legend.path(svg, &paths, &stroke(WAY, width), Sign::Line(WAY, width), text);
    }
    draw_missing(svg, legend, overlay, page);
    draw_pieces(svg, legend, overlay, page);
    draw_other_sites(svg, legend, overlay, sites, page);
    draw_points(svg, overlay, page);
}

/// Adds the signs of points to the legend: starts before ends.
fn add_points(legend: &mut Legend, overlay: &Overlay) {
    if !overlay.starts.is_empty() {
        let text = if overlay.starts_are_ends { "from and to" } else { "from" };
        legend.add(Sign::Dot(START), text);
    }
    if !overlay.ends.is_empty() {
        legend.add(Sign::Square(WAY), "to");
    }
    if overlay.sites.iter().any(|site| site.key.is_none()) {
        legend.add(Sign::Dot(SITE), "sites found");
    }
}

fn draw_points(svg: &mut Svg, overlay: &Overlay, page: &Page) {
    let edge = stroke("#fff", 1.5);
    let centres = |marks: &[Mark], key: Option<usize>| -> Vec<_> {
        let marks = marks.iter().filter(|mark| mark.key.map(|key| key % KEYS.len()) == key);
        marks.map(|mark| page.pixel(mark.at)).collect()
    };
    let keys = (0..KEYS.len()).map(|key| (Some(key), KEYS[key]));
    for (key, colour) in keys.chain([(None, SITE)]) {
        let discs = Path::discs(centres(&overlay.sites, key), SITE_RADIUS);
        svg.path(&discs, &format!("{} {edge}", fill(colour)));
    }
    let squares = Path::squares(centres(&overlay.ends, None), SQUARE_RADIUS);
    svg.path(&squares, &format!("{} {edge}", fill(WAY)));
    let discs = Path::discs(overlay.starts.iter().map(|&start| page.pixel(start)), END_RADIUS);
    svg.path(&discs, &format!("{} {edge}", fill(START)));
}

/// Draws straight lines for paths that were not found.
fn draw_missing(svg: &mut Svg, legend: &mut Legend, overlay: &Overlay, page: &Page) {
    let mut path = Path::default();
    for ends in &overlay.missing {
        path.line(ends.map(|end| page.pixel(end)));
    }
    if !path.is_empty() {
        let (width, opacity) = if overlay.missing.len() <= FEW {
            (1.4, 0.8)
        } else {
            (0.7, 0.4)
        };
        let style = stroke(GREY, width);
        let style = format!("{style} stroke-opacity=\"{opacity}\" stroke-dasharray=\"70 50\" stroke-linecap=\"butt\"");
        legend.path(svg, &path, &style, Sign::Dashes(GREY, 1.2), "not found");
    }
}

fn draw_pieces(svg: &mut Svg, legend: &mut Legend, overlay: &Overlay, page: &Page) {
    for &(ends, piece) in &overlay.pieces {
        let ends = ends.map(|end| page.pixel(end));
        let mut path = Path::default();
        path.line(ends);
        let style = match piece {
            Piece::Sites(key) => stroke(KEYS[key % KEYS.len()], PIECE),
            Piece::NoSite => format!("{} stroke-dasharray=\"70 50\"", stroke(GREY, 1.4)),
            Piece::Obstacle => format!("{} stroke-dasharray=\"20 40\"", stroke(INK, 2.0)),
        };
        svg.path(&path, &format!("{style} stroke-linecap=\"butt\""));
        svg.path(&Path::discs([ends[0]], 2.6), &fill(INK));
    }
    let has = |is_it: fn(Piece) -> bool| overlay.pieces.iter().any(|&(_, piece)| is_it(piece));
    if has(|piece| matches!(piece, Piece::Obstacle)) {
        legend.add(Sign::Dashes(INK, 2.0), "inside an obstacle");
    }
    if overlay.missing.is_empty() && has(|piece| matches!(piece, Piece::NoSite)) {
        legend.add(Sign::Dashes(GREY, 1.4), "not found");
    }
}

/// Adds what the colours of pieces mean to the legend, in the order along the lines. Colours are
/// used again after the last one; then the order and the names on the map tell pieces apart.
pub fn add_keys(legend: &mut Legend, overlay: &Overlay) {
    if overlay.keys.is_empty() {
        return;
    }
    legend.add(Sign::Heading, overlay.heading);
    for (key, colour) in overlay.keys.iter().zip(KEYS.iter().cycle()).take(MAX_KEYS) {
        legend.add(Sign::Line(colour, PIECE), cut(key));
    }
    if overlay.keys.len() > MAX_KEYS {
        legend.add(Sign::Heading, format!("and {} more", overlay.keys.len() - MAX_KEYS));
    }
}

fn draw_other_sites(svg: &mut Svg, legend: &mut Legend, overlay: &Overlay, sites: &[Point], page: &Page) {
    let Some(text) = overlay.other_sites else { return };
    let bits = |at: Point| [at.x.to_bits(), at.y.to_bits()];
    let found: HashSet<_> = overlay.sites.iter().map(|mark| bits(mark.at)).collect();
    let others: Vec<_> = sites.iter().filter(|&&site| !found.contains(&bits(site))).collect();
    if others.is_empty() {
        return;
    }
    let radius = if others.len() <= FEW_SITES { 3.5 } else { 2.0 };
    let rings = Path::discs(others.into_iter().map(|&site| page.pixel(site)), radius);
    let style = format!("{} {} stroke-opacity=\"0.55\"", fill(PAPER), stroke(SITE, 1.0));
    legend.path(svg, &rings, &style, Sign::Ring(SITE), text);
}

/// Writes the names of sites beside them and distances on paths, as many as fit.
pub fn write(svg: &mut Svg, overlay: &Overlay, page: &Page) {
    let mut labels = Labels::new(page);
    let marks = || overlay.sites.iter().chain(&overlay.ends);
    for at in marks().map(|mark| mark.at).chain(overlay.starts.iter().copied()) {
        labels.mark(page.pixel(at), SITE_RADIUS);
    }
    for mark in marks() {
        labels.beside(svg, page.pixel(mark.at), END_RADIUS, &mark.text);
    }
    distances::write(svg, &mut labels, &overlay.paths, page);
}
