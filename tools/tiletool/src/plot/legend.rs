//! The legend: signs and their meanings.

use super::axis::text_width;
use super::style::{EDGE, GREY, INK, fill};
use super::svg::{Anchor, Path, Svg};

const TEXT: f64 = 15.0;
/// Pixels between the baselines of two rows.
const ROW: f64 = 30.0;
/// Width of a sign in pixels, and the pixels between it and its text, and between two entries.
const SIGN: f64 = 30.0;
const GAP: f64 = 9.0;
const BETWEEN: f64 = 32.0;

pub enum Sign {
    Line(&'static str, f64),
    /// A dashed line.
    Dashes(&'static str, f64),
    Dot(&'static str),
    Square(&'static str),
    Ring(&'static str),
    Patch(&'static str),
    /// No sign: a text about the entries after it, which begins a row.
    Heading,
}

impl Sign {
    /// Returns the element of the sign, from `x` to the right, with its middle at `y`.
    fn element(&self, x: f64, y: f64) -> String {
        let (round, end) = (x + 24.0, x + SIGN);
        match *self {
            Self::Line(colour, width) => {
                format!("<path d=\"M{x:.1} {y}h30\" stroke=\"{colour}\" stroke-width=\"{width:.1}\"/>")
            }
            Self::Dashes(colour, width) => format!(
                "<path d=\"M{x:.1} {y}H{end:.1}\" stroke=\"{colour}\" stroke-width=\"{width:.1}\" stroke-dasharray=\"6 4\"/>"
            ),
            Self::Dot(colour) => format!("<circle cx=\"{round:.1}\" cy=\"{y}\" r=\"3.5\" fill=\"{colour}\"/>"),
            Self::Square(colour) => format!(
                "<rect x=\"{:.1}\" y=\"{}\" width=\"8\" height=\"8\" fill=\"{colour}\"/>",
                round - 4.0,
                y - 4.0
            ),
            Self::Ring(colour) => format!(
                "<circle cx=\"{round:.1}\" cy=\"{y}\" r=\"3.5\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.2\"/>"
            ),
            Self::Patch(colour) => format!(
                "<rect x=\"{x:.1}\" y=\"{}\" width=\"30\" height=\"14\" fill=\"{colour}\" stroke=\"{EDGE}\" stroke-width=\"0.6\"/>",
                y - 7.0
            ),
            Self::Heading => String::new(),
        }
    }
}

/// Signs and their meanings, from left to right.
#[derive(Default)]
pub struct Legend(Vec<(Sign, String)>);

impl Legend {
    pub fn add(&mut self, sign: Sign, text: impl Into<String>) {
        self.0.push((sign, text.into()));
    }

    /// Adds all entries of another legend.
    pub fn append(&mut self, other: Self) {
        self.0.extend(other.0);
    }

    /// Draws a path in a style, and adds its sign to the legend.
    pub fn path(&mut self, svg: &mut Svg, path: &Path, style: &str, sign: Sign, text: &'static str) {
        svg.path(path, style);
        self.add(sign, text);
    }

    /// Draws the legend itself, in one row.
    pub fn draw(&self, svg: &mut Svg, start: (f64, f64)) {
        self.draw_within(svg, start, f64::INFINITY);
    }

    /// Draws the legend itself, in as many rows as it needs to end at `right`. Returns the pixels
    /// that the rows after the first one take.
    pub fn draw_within(&self, svg: &mut Svg, (left, top): (f64, f64), right: f64) -> f64 {
        let (mut x, mut y) = (left, top);
        for (sign, text) in &self.0 {
            let is_heading = matches!(sign, Sign::Heading);
            let start = if is_heading { 0.0 } else { SIGN + GAP };
            let width = start + text_width(text, TEXT);
            if x > left && (is_heading || x + width > right) {
                (x, y) = (left, y + ROW);
            }
            if !is_heading {
                svg.raw(&sign.element(x, y - 5.0));
            }
            let colour = if is_heading { GREY } else { INK };
            svg.text((x + start, y), TEXT, Anchor::Start, &fill(colour), text);
            x += width + BETWEEN;
        }
        y - top
    }
}
