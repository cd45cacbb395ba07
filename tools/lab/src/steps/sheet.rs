//! A picture of the window: a title, layers of triangles, lines and dots over coordinates, labels,
//! and a legend. The background is white, so that it is read on dark pages too.

use delaunay_tiles::geometry::{Point, Rect};
use delaunay_tiles::store::TileId;

use super::ground::WINDOW;
use super::triangles::Triangle;
use tiletool::plot::legend::{Legend, Sign};
use tiletool::plot::style::{GREY, INK, LINES, fill, stroke};
use tiletool::plot::svg::{Anchor, Path, Svg, UNITS};

/// Width of the page in pixels.
const WIDTH: f64 = 1000.0;
/// Pixels beside the frame.
const MARGIN: f64 = 16.0;
/// Pixels above the frame, for the title.
const HEADER: f64 = 68.0;
/// Pixels below the frame, for the legend.
const FOOTER: f64 = 46.0;

/// How triangles look: the colour inside, and that of their edges with the width in pixels.
#[derive(Clone, Copy)]
pub struct Look {
    pub inside: Option<&'static str>,
    pub edge: &'static str,
    pub width: f64,
}

/// A picture that is drawn layer by layer, the lowest first.
pub struct Sheet {
    svg: Svg,
    legend: Legend,
    /// The frame of the map in pixels, y downwards.
    frame: Rect,
    labels: Vec<(Point, String, &'static str)>,
}

impl Sheet {
    /// Begins a picture.
    pub fn new(title: &str, caption: &str) -> Self {
        let (width, height) = WINDOW.size();
        let frame_height = (height * (WIDTH - 2.0 * MARGIN) / width).round();
        let frame = Rect::new(MARGIN, HEADER, WIDTH - MARGIN, HEADER + frame_height);
        let mut svg = Svg::new(WIDTH as u32, (frame.max_y + FOOTER) as u32, title);
        svg.raw("<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>");
        svg.text((MARGIN, 32.0), 23.0, Anchor::Start, &fill(INK), title);
        svg.text((MARGIN, 55.0), 15.0, Anchor::Start, &fill(GREY), caption);
        svg.raw(&format!("<clipPath id=\"frame\"><rect {}/></clipPath>", place(frame)));
        svg.raw("<g clip-path=\"url(#frame)\">");
        svg.raw(&format!(
            "<g transform=\"scale({})\" {LINES} stroke-linecap=\"round\">",
            1.0 / UNITS
        ));
        Self {
            svg,
            legend: Legend::default(),
            frame,
            labels: Vec::new(),
        }
    }

    /// Draws triangles. A layer without a name is not in the legend.
    pub fn triangles<'a>(&mut self, name: &'static str, look: Look, triangles: impl IntoIterator<Item = &'a Triangle>) {
        let rings = triangles
            .into_iter()
            .map(|corners| corners.map(|corner| self.pixel(corner)));
        let path = Path::polygons(rings);
        let mut style = stroke(look.edge, look.width);
        if let Some(inside) = look.inside {
            style = format!("{} {style}", fill(inside));
        }
        self.svg.path(&path, &style);
        self.sign(name, Sign::Patch(look.inside.unwrap_or("#fff")));
    }

    /// Draws lines between two points each, `width` pixels wide.
    pub fn lines(&mut self, name: &'static str, colour: &'static str, width: f64, lines: &[[Point; 2]]) {
        let mut path = Path::default();
        for ends in lines {
            path.line(ends.map(|end| self.pixel(end)));
        }
        self.svg.path(&path, &stroke(colour, width));
        self.sign(name, Sign::Line(colour, width));
    }

    /// Draws a line through points.
    pub fn polyline(&mut self, name: &'static str, colour: &'static str, width: f64, points: &[Point]) {
        let lines: Vec<_> = points.windows(2).map(|ends| [ends[0], ends[1]]).collect();
        self.lines(name, colour, width, &lines);
    }

    /// Draws discs of `radius` pixels.
    pub fn dots(&mut self, name: &'static str, colour: &'static str, radius: f64, dots: &[Point]) {
        let path = Path::discs(dots.iter().map(|&dot| self.pixel(dot)), radius);
        self.svg.path(&path, &fill(colour));
        self.sign(name, Sign::Dot(colour));
    }

    /// Draws a circle through a point.
    pub fn circle(&mut self, name: &'static str, colour: &'static str, centre: Point, through: Point) {
        let ((x, y), (to_x, to_y)) = (self.pixel(centre), self.pixel(through));
        let radius = ((x - to_x) * (x - to_x) + (y - to_y) * (y - to_y)).sqrt();
        let path = Path::discs([(x, y)], radius);
        self.svg.path(&path, &stroke(colour, 2.2));
        self.sign(name, Sign::Line(colour, 2.2));
    }

    /// Draws the part of cells that lies in the frame: their outlines of this width, or else their areas.
    pub fn cells<'a>(
        &mut self,
        name: &'static str,
        colour: &'static str,
        outline: Option<f64>,
        cells: impl IntoIterator<Item = &'a Rect>,
    ) {
        let rings = cells.into_iter().map(|&cell| {
            let seen = self.seen(cell);
            [
                (seen.min_x, seen.min_y),
                (seen.max_x, seen.min_y),
                (seen.max_x, seen.max_y),
                (seen.min_x, seen.max_y),
            ]
        });
        let path = Path::polygons(rings);
        let (style, sign) = match outline {
            Some(width) => (stroke(colour, width), Sign::Line(colour, width)),
            None => (fill(colour), Sign::Patch(colour)),
        };
        self.svg.path(&path, &style);
        self.sign(name, sign);
    }

    /// Writes a number into each cell, over everything.
    pub fn label(&mut self, cell: Rect, id: TileId, colour: &'static str) {
        let seen = self.seen(cell);
        let middle = Point::new((seen.min_x + seen.max_x) / 2.0, (seen.min_y + seen.max_y) / 2.0);
        self.labels.push((middle, id.to_string(), colour));
    }

    /// Ends the picture. Returns the SVG.
    pub fn finish(mut self) -> String {
        self.svg.raw("</g>");
        for (middle, text, colour) in &self.labels {
            let style = format!(
                "{} stroke=\"#fff\" stroke-opacity=\"0.85\" stroke-width=\"5\" stroke-linejoin=\"round\" paint-order=\"stroke\"",
                fill(colour)
            );
            self.svg
                .text((middle.x, middle.y + 7.0), 20.0, Anchor::Middle, &style, text);
        }
        self.svg.raw("</g>");
        self.svg.raw(&format!(
            "<rect {} fill=\"none\" stroke=\"{INK}\" stroke-width=\"1.2\"/>",
            place(self.frame)
        ));
        self.legend
            .draw(&mut self.svg, (self.frame.min_x, self.frame.max_y + 29.0));
        self.svg.finish()
    }

    fn sign(&mut self, name: &'static str, sign: Sign) {
        if !name.is_empty() {
            self.legend.add(sign, name);
        }
    }

    fn pixel(&self, point: Point) -> (f64, f64) {
        let scale = self.frame.size().0 / WINDOW.size().0;
        (
            self.frame.min_x + (point.x - WINDOW.min_x) * scale,
            self.frame.max_y - (point.y - WINDOW.min_y) * scale,
        )
    }

    /// Returns the part of a cell within the frame, in pixels. Its sides may be at infinity.
    fn seen(&self, cell: Rect) -> Rect {
        let (left, top) = self.pixel(Point::new(cell.min_x, cell.max_y));
        let (right, bottom) = self.pixel(Point::new(cell.max_x, cell.min_y));
        let frame = self.frame;
        Rect::new(
            left.max(frame.min_x),
            top.max(frame.min_y),
            right.min(frame.max_x),
            bottom.min(frame.max_y),
        )
    }
}

/// Returns the attributes of a rectangle's place.
fn place(rect: Rect) -> String {
    let (width, height) = rect.size();
    format!(
        "x=\"{}\" y=\"{}\" width=\"{width}\" height=\"{height}\"",
        rect.min_x, rect.min_y
    )
}
