//! Charts: lines over linear or logarithmic axes, and histograms.
//!
//! The input is named numbers. The output is an SVG. Points that are not finite, or not positive on
//! a logarithmic axis, are left out.

use tiletool::plot::axis::{fitted_text, label, round_above, text_width};
use tiletool::plot::style::{GREY, INK, LINES, fill, stroke};
use tiletool::plot::svg::{Anchor, Path, Svg, UNITS};

const GRID: &str = "#e3e6e8";
/// Colours that are distinguishable with any kind of colour vision (Okabe and Ito 2008).
const COLOURS: [&str; 7] = [
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000",
];

const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 560.0;
const LEFT: f64 = 92.0;
const TOP: f64 = 78.0;
const BOTTOM: f64 = 66.0;
const RIGHT: f64 = 28.0;
/// The width of the sign of a legend's entry, with the gap before its text.
const SIGN: f64 = 34.0;
const TITLE_TEXT: f64 = 22.0;
const TEXT: f64 = 15.0;
/// The approximate number of ticks along an axis.
const TICKS: f64 = 6.0;

/// An axis.
#[derive(Clone, Debug)]
pub struct Dimension {
    label: String,
    spacing: Spacing,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Spacing {
    /// From zero, unless there are negative numbers.
    FromZero,
    /// From the least number to the greatest.
    Fitted,
    Logarithmic,
}

impl Dimension {
    /// Creates an axis that begins at zero.
    pub fn from_zero(label: &str) -> Self {
        Self::new(label, Spacing::FromZero)
    }

    /// Creates an axis from the least number to the greatest.
    pub fn fitted(label: &str) -> Self {
        Self::new(label, Spacing::Fitted)
    }

    /// Creates a logarithmic axis.
    pub fn logarithmic(label: &str) -> Self {
        Self::new(label, Spacing::Logarithmic)
    }

    fn new(label: &str, spacing: Spacing) -> Self {
        Self {
            label: label.to_owned(),
            spacing,
        }
    }
}

/// A line with its name.
#[derive(Clone, Debug)]
pub struct ChartLine {
    /// The name in the legend.
    pub name: String,
    /// Lines of the same number have the same colour.
    pub colour: usize,
    /// Whether the line is dashed.
    pub is_dashed: bool,
    /// The points, in the order in which they are connected.
    pub points: Vec<(f64, f64)>,
    /// The x values of failed measurements; each is a cross at the top, without a point.
    pub failures: Vec<f64>,
}

/// A chart of lines.
#[derive(Clone, Debug)]
pub struct Chart {
    /// What it shows.
    pub title: String,
    /// The conditions of the measurement.
    pub subtitle: String,
    /// The horizontal axis.
    pub x: Dimension,
    /// The vertical axis.
    pub y: Dimension,
    /// The lines that are drawn.
    pub lines: Vec<ChartLine>,
}

impl Chart {
    /// Draws the chart as an SVG.
    pub fn draw(&self) -> String {
        let names = self.lines.iter().map(|line| text_width(&line.name, TEXT));
        let legend = names.fold(0.0, f64::max) + SIGN + 26.0;
        let right = WIDTH - RIGHT - legend;
        let points = || self.lines.iter().flat_map(|line| &line.points);
        let failures = self.lines.iter().flat_map(|line| &line.failures);
        let x = Scale::new(
            self.x.spacing,
            points().map(|p| p.0).chain(failures.copied()),
            (LEFT, right),
        );
        let y = Scale::new(self.y.spacing, points().map(|p| p.1), (HEIGHT - BOTTOM, TOP));
        let mut svg = begin(&self.title, &self.subtitle);
        draw_axes(&mut svg, (&self.x.label, &x), (&self.y.label, &y));
        for line in &self.lines {
            draw_line(&mut svg, line, &x, &y);
        }
        for (line, place) in self.lines.iter().zip(0..) {
            let (left, middle) = (right + 22.0, TOP + 12.0 + 24.0 * f64::from(place));
            let mut sign = Path::default();
            sign.line([(left, middle), (left + SIGN - 8.0, middle)]);
            draw_paths(&mut svg, &[(&sign, line_style(line))]);
            svg.text((left + SIGN, middle + 5.0), TEXT, Anchor::Start, &fill(INK), &line.name);
        }
        svg.finish()
    }
}

/// A histogram: the count of numbers in each of equally wide bins.
#[derive(Clone, Debug)]
pub struct Histogram {
    /// What it shows.
    pub title: String,
    /// The conditions of the measurement.
    pub subtitle: String,
    /// The label of the horizontal axis: the quantity of the numbers.
    pub x: String,
    /// The label of the vertical axis: what is counted.
    pub y: String,
    /// The start of the first bin.
    pub start: f64,
    /// The width of the bins.
    pub width: f64,
    /// The count in each bin.
    pub counts: Vec<u64>,
}

impl Histogram {
    /// Draws the histogram as an SVG. Heights are logarithmic, from a half, so that a single number
    /// is visible beside thousands.
    pub fn draw(&self) -> String {
        let end = self.start + self.width * self.counts.len() as f64;
        let x = Scale::new(Spacing::Fitted, [self.start, end].into_iter(), (LEFT, WIDTH - RIGHT));
        let most = self.counts.iter().copied().max().unwrap_or(0).max(1);
        let heights = [0.5, 1.2 * most as f64].into_iter();
        let y = Scale::new(Spacing::Logarithmic, heights, (HEIGHT - BOTTOM, TOP));
        let mut svg = begin(&self.title, &self.subtitle);
        draw_axes(&mut svg, (&self.x, &x), (&self.y, &y));
        let mut bars = Path::default();
        for (&count, place) in self.counts.iter().zip(0..) {
            if let Some(top) = y.pixel(count as f64) {
                let from = self.start + self.width * f64::from(place);
                let sides = x.pixel(from).zip(x.pixel(from + self.width));
                let Some((left, right)) = sides else { continue };
                let bottom = HEIGHT - BOTTOM;
                bars.polygon([(left, bottom), (left, top), (right, top), (right, bottom)]);
            }
        }
        let style = format!("{} {}", fill(COLOURS[0]), stroke("#fff", 0.8));
        draw_paths(&mut svg, &[(&bars, style)]);
        svg.finish()
    }
}

/// The mapping from numbers to pixels along an axis.
struct Scale {
    spacing: Spacing,
    /// The ends of the axis; of a logarithmic axis, their logarithms.
    low: f64,
    high: f64,
    /// The pixels of the ends.
    start: f64,
    end: f64,
}

impl Scale {
    fn new(spacing: Spacing, values: impl Iterator<Item = f64>, (start, end): (f64, f64)) -> Self {
        let is_logarithmic = spacing == Spacing::Logarithmic;
        let values = values.map(|v| if is_logarithmic { v.log10() } else { v });
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.filter(|v| v.is_finite()) {
            (low, high) = (low.min(value), high.max(value));
        }
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        if spacing == Spacing::FromZero {
            low = low.min(0.0);
        }
        if low == high {
            high += if is_logarithmic || low == 0.0 { 1.0 } else { low.abs() };
        }
        let room = 0.04 * (high - low);
        high += room;
        if spacing != Spacing::FromZero || low < 0.0 {
            low -= room;
        }
        Self {
            spacing,
            low,
            high,
            start,
            end,
        }
    }

    /// Returns the pixel of a value, or `None` if it is not on the axis.
    fn pixel(&self, value: f64) -> Option<f64> {
        let value = match self.spacing {
            Spacing::Logarithmic => value.log10(),
            _ => value,
        };
        let inside = (self.low..=self.high).contains(&value);
        let share = (value - self.low) / (self.high - self.low);
        inside.then_some(self.start + share * (self.end - self.start))
    }

    /// Returns pixels with their labels.
    fn ticks(&self) -> Vec<(f64, String)> {
        let is_seen = |value: &(f64, String)| self.pixel(value.0).is_some();
        let values = match self.spacing {
            Spacing::Logarithmic => {
                let powers = self.powers();
                // Within less than a decade there may be hardly any power.
                match powers.iter().filter(|power| is_seen(power)).count() {
                    0..3 => steps(10f64.powf(self.low), 10f64.powf(self.high)),
                    _ => powers,
                }
            }
            _ => steps(self.low, self.high),
        };
        let ticks = values.into_iter();
        ticks
            .filter_map(|(value, text)| Some((self.pixel(value)?, text)))
            .collect()
    }

    /// Returns powers of ten; with few powers also their doubles and quintuples.
    fn powers(&self) -> Vec<(f64, String)> {
        let decades = (self.low.floor() as i32)..=(self.high.ceil() as i32);
        let digits: &[u32] = match self.high - self.low {
            few if few < 2.5 => &[1, 2, 5],
            some if some < 4.0 => &[1, 3],
            _ => &[1],
        };
        let values = decades.flat_map(|decade| digits.iter().map(move |&digit| (digit, decade)));
        values
            .map(|(digit, decade)| (f64::from(digit) * 10f64.powi(decade), power_label(digit, decade)))
            .collect()
    }
}

/// Returns a few round numbers from `low` to `high`.
fn steps(low: f64, high: f64) -> Vec<(f64, String)> {
    let step = round_above((high - low) / TICKS);
    let first = (low / step).ceil();
    let values = (0..=2 * TICKS as u32).map(|k| (first + f64::from(k)) * step);
    let values = values.take_while(|value| *value <= high);
    values
        .map(|value| (value, label(value, step, low.abs().max(high.abs()))))
        .collect()
}

/// Returns a label such as `0.02`, `500`, `20k`, `1M`, `5G`, or beyond these `1e15`.
fn power_label(digit: u32, decade: i32) -> String {
    match decade {
        -4..0 => format!(
            "{:.*}",
            decade.unsigned_abs() as usize,
            f64::from(digit) * 10f64.powi(decade)
        ),
        0..12 => {
            let unit = ["", "k", "M", "G"][decade as usize / 3];
            format!("{}{unit}", digit * 10u32.pow(decade as u32 % 3))
        }
        _ => format!("{digit}e{decade}").replace('-', "\u{2212}"),
    }
}

fn line_style(line: &ChartLine) -> String {
    let colour = COLOURS[line.colour % COLOURS.len()];
    let dashes = match line.is_dashed {
        true => format!(" stroke-dasharray=\"{} {}\"", 7.0 * UNITS, 5.0 * UNITS),
        false => String::new(),
    };
    format!("{LINES} {}{dashes}", stroke(colour, 2.2))
}

fn begin(title: &str, subtitle: &str) -> Svg {
    let mut svg = Svg::new(WIDTH as u32, HEIGHT as u32, title);
    svg.raw("<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>");
    for (text, y, size, colour) in [(title, 34.0, TITLE_TEXT, INK), (subtitle, 58.0, TEXT, GREY)] {
        let size = fitted_text(text, size, WIDTH - LEFT - RIGHT);
        svg.text((LEFT, y), size, Anchor::Start, &fill(colour), text);
    }
    svg
}

/// Draws paths, whose coordinates are in units.
fn draw_paths(svg: &mut Svg, paths: &[(&Path, String)]) {
    svg.in_units("", |svg| paths.iter().for_each(|(path, style)| svg.path(path, style)));
}

fn draw_axes(svg: &mut Svg, (x_label, x): (&str, &Scale), (y_label, y): (&str, &Scale)) {
    let (left, right, bottom, top) = (x.start, x.end, y.start, y.end);
    let (mut grid, mut frame) = (Path::default(), Path::default());
    for (pixel, text) in x.ticks() {
        grid.line([(pixel, bottom), (pixel, top)]);
        svg.text((pixel, bottom + 22.0), TEXT, Anchor::Middle, &fill(INK), &text);
    }
    for (pixel, text) in y.ticks() {
        grid.line([(left, pixel), (right, pixel)]);
        svg.text((left - 10.0, pixel + 0.36 * TEXT), TEXT, Anchor::End, &fill(INK), &text);
    }
    frame.line([(left, top), (left, bottom), (right, bottom)]);
    let line = |colour: &str, width: f64| format!("{LINES} {}", stroke(colour, width));
    draw_paths(svg, &[(&grid, line(GRID, 1.0)), (&frame, line(INK, 1.2))]);
    let middle = (left + right) / 2.0;
    svg.text((middle, HEIGHT - 16.0), TEXT, Anchor::Middle, &fill(INK), x_label);
    let (place, middle) = (24.0, (top + bottom) / 2.0);
    let turned = format!("{} transform=\"rotate(-90 {place:.1} {middle:.1})\"", fill(INK));
    svg.text((place, middle), TEXT, Anchor::Middle, &turned, y_label);
}

fn draw_line(svg: &mut Svg, line: &ChartLine, x: &Scale, y: &Scale) {
    let places = line.points.iter();
    let pixels: Vec<_> = places.filter_map(|&(a, b)| x.pixel(a).zip(y.pixel(b))).collect();
    let (mut path, mut crosses) = (Path::default(), Path::default());
    path.line(pixels.iter().copied());
    let dots = Path::discs(pixels, 3.6);
    for pixel in line.failures.iter().filter_map(|&value| x.pixel(value)) {
        let (middle, arm) = (y.end + 12.0, 7.0);
        for slope in [-1.0, 1.0] {
            crosses.line([-arm, arm].map(|step| (pixel + step, middle + slope * step)));
        }
    }
    let colour = COLOURS[line.colour % COLOURS.len()];
    let style = line_style(line);
    let cross_style = format!("{LINES} {}", stroke(colour, 3.0));
    draw_paths(svg, &[(&path, style), (&dots, fill(colour)), (&crosses, cross_style)]);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(spacing: Spacing, low: f64, high: f64) -> Vec<String> {
        let scale = Scale::new(spacing, [low, high].into_iter(), (0.0, 100.0));
        scale.ticks().into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_few_and_round() {
        assert_eq!(
            labels(Spacing::FromZero, 0.3, 1.0),
            ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]
        );
        assert_eq!(labels(Spacing::Fitted, 0.3, 0.9), ["0.4", "0.6", "0.8"]);
        assert_eq!(
            labels(Spacing::Logarithmic, 1e4, 1e6),
            ["10k", "20k", "50k", "100k", "200k", "500k", "1M"]
        );
        assert_eq!(labels(Spacing::Logarithmic, 1e-3, 1e5)[..2], ["0.001", "0.01"]);
        assert_eq!(labels(Spacing::Logarithmic, 1e-9, 1e20)[0], "1e\u{2212}10");
        assert_eq!(labels(Spacing::Logarithmic, 1.1, 1.9)[..2], ["1.2", "1.4"]);
        // One number, or none, gives a chart too.
        for spacing in [Spacing::FromZero, Spacing::Fitted, Spacing::Logarithmic] {
            assert!((1..=14).contains(&labels(spacing, 5.0, 5.0).len()));
            assert!(!labels(spacing, f64::NAN, f64::INFINITY).is_empty());
        }
    }

    #[test]
    fn points_that_cannot_be_drawn_are_left_out() {
        let line = ChartLine {
            name: "a<b".to_owned(),
            colour: 9,
            is_dashed: true,
            points: vec![(1.0, 0.0), (10.0, 1.0), (f64::NAN, 1.0), (100.0, 2.0), (1000.0, -1.0)],
            failures: vec![1000.0],
        };
        let chart = Chart {
            title: "t".to_owned(),
            subtitle: String::new(),
            x: Dimension::logarithmic("x"),
            y: Dimension::logarithmic("y"),
            lines: vec![line],
        };
        let svg = chart.draw();
        // Two discs of two arcs each.
        assert_eq!(svg.matches("a36 36").count(), 4);
        assert!(svg.contains("a&lt;b") && !svg.contains("NaN") && !svg.contains("inf"));
        assert!(tiletool::plot::png::render(&svg, None).is_ok());
    }

    #[test]
    fn bins_without_numbers_have_no_bar() {
        let histogram = Histogram {
            title: "t".to_owned(),
            subtitle: String::new(),
            x: "x".to_owned(),
            y: "y".to_owned(),
            start: 1.0,
            width: 0.1,
            counts: vec![1000, 0, 1],
        };
        let svg = histogram.draw();
        let bars = svg.lines().find(|line| line.contains("stroke=\"#fff\"")).unwrap();
        assert_eq!(bars.matches('z').count(), 2);
    }
}
