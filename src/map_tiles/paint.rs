//! Lines and dots, painted over a picture.

use bytes::Bytes;
use tiny_skia::{FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, Transform};

use crate::map_tiles::chains::chains;
use crate::map_tiles::colours::{BREAK, Colour, OUTLINE, SITE, VERTEX, WALL};
use crate::map_tiles::grid::PIXELS;
use crate::map_tiles::image::png;
use crate::map_tiles::shade::Shade;
use crate::map_tiles::shapes::{Kind, Shapes};
use crate::map_tiles::window::{PER_PIXEL, Unit};

/// How far outside a tile a shape may be and still be seen in it, in units.
pub(super) const REACH: i32 = 8 * PER_PIXEL;

/// The same in pixels: the margin of the image that shapes are drawn into. What is drawn at the
/// border of an image differs from what is drawn inside.
const MARGIN: u32 = (REACH / PER_PIXEL) as u32;
/// The width of this image.
const WIDTH: u32 = PIXELS + 2 * MARGIN;

/// The radius of the dot of a site, and of the ring around it, in pixels.
const DOT: f32 = 2.6;
const RING: f32 = 3.8;
/// The typical distance of sites in pixels from which on dots have their full size, and the least
/// size as a share.
const FAR: f64 = 24.0;
const SMALL: f64 = 0.25;
/// The typical distance of sites in pixels from which on dots are opaque, and the least opacity. Closer
/// ones would hide everything else.
const APART: f64 = 6.0;
const PALE: f64 = 0.08;
/// The radius of a vertex, where there is nothing else.
const POINT: f32 = 1.1;
/// The least opacity and width of lines, as shares, where they are dense.
const FAINT: f32 = 0.35;
/// The typical length of edges in pixels from which on lines have their full width.
const SPARSE: f64 = 8.0;

/// How dense shapes are: typical distances in pixels, the same for a whole zoom.
#[derive(Clone, Copy, Debug)]
pub(super) struct Density {
    /// The length of edges.
    pub(super) edge: f64,
    /// The distance between sites.
    pub(super) site: f64,
}

/// Paints shapes over a picture, and returns it as PNG. All shapes must have been
/// [joined](Shapes::join).
pub(super) fn paint(shades: &[Shade], shapes: &Shapes, density: Density) -> Bytes {
    let mut pixels: Vec<[u8; 4]> = shades
        .iter()
        .map(|&(colour, opacity)| {
            let [r, g, b] = colour.map(|c| c.round() as u8);
            [r, g, b, (opacity * 255.0).round() as u8]
        })
        .collect();
    let strength = (density.edge / SPARSE).clamp(FAINT.into(), 1.0) as f32;
    for kind in Kind::ALL {
        let (colour, width) = match kind {
            Kind::Break => (BREAK, 1.1),
            Kind::Obstacle => (OUTLINE, 1.0),
            Kind::Wall => (WALL, 1.6),
        };
        if let Some(path) = lines(shapes.lines(kind)) {
            let stroke = Stroke {
                width: width * strength.max(0.6),
                line_cap: LineCap::Round,
                line_join: LineJoin::Round,
                ..Stroke::default()
            };
            cover(&mut pixels, colour, strength, |image, paint| {
                image.stroke_path(&path, paint, &stroke, Transform::identity(), None);
            });
        }
    }
    let size = (density.site / FAR).clamp(SMALL, 1.0) as f32;
    let opacity = (density.site / APART).clamp(PALE, 1.0) as f32;
    let sites = || shapes.sites().iter().map(|site| site.at);
    for (colour, radius, opacity, points) in [
        (VERTEX, POINT, 1.0, shapes.vertices().to_vec()),
        (
            [255; 3],
            RING * size,
            1.0,
            if size < 1.0 { Vec::new() } else { sites().collect() },
        ),
        (SITE, DOT * size, opacity, sites().collect()),
    ] {
        if let Some(path) = dots(points, radius) {
            cover(&mut pixels, colour, opacity, |image, paint| {
                image.fill_path(&path, paint, FillRule::Winding, Transform::identity(), None);
            });
        }
    }
    png(&pixels)
}

/// Draws with a colour into an image of its own, where overlapping shapes are as opaque as single
/// ones, and puts it over the pixels with an opacity.
fn cover(pixels: &mut [[u8; 4]], colour: Colour, opacity: f32, draw: impl FnOnce(&mut Pixmap, &Paint<'_>)) {
    let Some(mut image) = Pixmap::new(WIDTH, WIDTH) else {
        return;
    };
    let mut paint = Paint {
        anti_alias: true,
        ..Paint::default()
    };
    paint.set_color_rgba8(255, 255, 255, 255);
    draw(&mut image, &paint);
    let rows = image.pixels().chunks_exact(WIDTH as usize).skip(MARGIN as usize);
    let inner = rows.flat_map(|row| &row[MARGIN as usize..][..PIXELS as usize]);
    for (pixel, ink) in pixels.iter_mut().zip(inner) {
        let share = f32::from(ink.alpha()) / 255.0 * opacity;
        if share > 0.0 {
            *pixel = over(*pixel, colour, share);
        }
    }
}

/// Returns a pixel with a colour over it.
fn over([r, g, b, a]: [u8; 4], colour: Colour, share: f32) -> [u8; 4] {
    let below = f32::from(a) / 255.0 * (1.0 - share);
    let opacity = share + below;
    let mix = |under: u8, ink: u8| ((f32::from(ink) * share + f32::from(under) * below) / opacity).round() as u8;
    [
        mix(r, colour[0]),
        mix(g, colour[1]),
        mix(b, colour[2]),
        (opacity * 255.0).round() as u8,
    ]
}

/// Returns a position in the image.
fn pixel(v: i32) -> f32 {
    v as f32 / PER_PIXEL as f32 + MARGIN as f32
}

/// Returns the path of segments.
fn lines(segments: Vec<[Unit; 2]>) -> Option<Path> {
    let mut path = PathBuilder::new();
    for line in chains(segments) {
        let mut points = line.iter();
        let first = points.next()?;
        path.move_to(pixel(first[0]), pixel(first[1]));
        let mut last = *first;
        for point in points {
            // Shorter than a quarter of a pixel is nothing, unless it ends the line.
            let far = (point[0] - last[0]).abs().max((point[1] - last[1]).abs());
            if far * 4 >= PER_PIXEL || Some(point) == line.last() {
                path.line_to(pixel(point[0]), pixel(point[1]));
                last = *point;
            }
        }
    }
    path.finish()
}

/// Returns the path of dots. Of several in the same quarter of a pixel there is one.
fn dots(mut points: Vec<Unit>, radius: f32) -> Option<Path> {
    points.sort_unstable();
    points.dedup_by_key(|point| point.map(|v| v.div_euclid(PER_PIXEL / 4)));
    let mut path = PathBuilder::new();
    for [x, y] in points {
        path.push_circle(pixel(x), pixel(y), radius);
    }
    path.finish()
}
