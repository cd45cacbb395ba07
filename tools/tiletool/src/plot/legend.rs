//! The legend: signs and their meanings.

use super::axis::text_width;
use super::style::{EDGE, INK, fill};
use super::svg::{Anchor, Path, Svg};

pub enum Sign {
    Line(&'static str, f64),
    Dot(&'static str),
    Patch(&'static str),
}

/// Signs and their meanings, from left to right.
#[derive(Default)]
pub struct Legend(Vec<(Sign, &'static str)>);

impl Legend {
    pub fn add(&mut self, sign: Sign, text: &'static str) {
        self.0.push((sign, text));
    }

    /// Draws a path in a style, and adds its sign to the legend.
    pub fn path(&mut self, svg: &mut Svg, path: &Path, style: &str, sign: Sign, text: &'static str) {
        svg.path(path, style);
        self.add(sign, text);
    }

    /// Draws the legend itself.
    pub fn draw(&self, svg: &mut Svg, (mut x, y): (f64, f64)) {
        let (middle, size) = (y - 5.0, 15.0);
        for (sign, text) in &self.0 {
            let end = x + 30.0;
            svg.raw(&match *sign {
                Sign::Line(colour, width) => {
                    format!("<path d=\"M{x:.1} {middle}h30\" stroke=\"{colour}\" stroke-width=\"{width:.1}\"/>")
                }
                Sign::Dot(colour) => format!("<circle cx=\"{:.1}\" cy=\"{middle}\" r=\"3.5\" fill=\"{colour}\"/>", x + 24.0),
                Sign::Patch(colour) => format!(
                    "<rect x=\"{x:.1}\" y=\"{}\" width=\"30\" height=\"14\" fill=\"{colour}\" stroke=\"{EDGE}\" stroke-width=\"0.6\"/>",
                    middle - 7.0
                ),
            });
            svg.text((end + 9.0, y), size, Anchor::Start, &fill(INK), text);
            x = end + 9.0 + text_width(text, size) + 32.0;
        }
    }
}
