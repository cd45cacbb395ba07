//! SVG as text: elements, and path data in as few characters as possible.

use std::fmt::Write;

/// Units of path data per pixel. Paths are in a group that is scaled down by this factor.
pub const UNITS: f64 = 10.0;
/// Maximum coordinate in units. Points farther away are moved to this distance, because nothing of
/// them is visible.
const FAR: f64 = 1e7;

/// An SVG document that is written element by element.
pub struct Svg {
    width: u32,
    height: u32,
    title: String,
    text: String,
}

/// The alignment of a text at its position.
#[derive(Clone, Copy)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

impl Svg {
    /// Creates an empty document.
    pub fn new(width: u32, height: u32, title: &str) -> Self {
        Self {
            width,
            height,
            title: escaped(title),
            text: String::new(),
        }
    }

    /// Makes the document higher by a number of pixels. Returns its height.
    pub fn grow(&mut self, pixels: u32) -> u32 {
        self.height += pixels;
        self.height
    }

    /// Appends an element, or the start or end of one, unchanged.
    pub fn raw(&mut self, element: &str) {
        self.text += element;
        self.text.push('\n');
    }

    /// Appends a group in this style, in which coordinates are in the units of paths.
    pub fn in_units(&mut self, style: &str, inside: impl FnOnce(&mut Self)) {
        let space = if style.is_empty() { "" } else { " " };
        self.raw(&format!("<g transform=\"scale({})\"{space}{style}>", 1.0 / UNITS));
        inside(self);
        self.raw("</g>");
    }

    /// Appends a path, unless it is empty.
    pub fn path(&mut self, path: &Path, style: &str) {
        if !path.data.is_empty() {
            self.raw(&format!("<path d=\"{}\" {style}/>", path.data));
        }
    }

    /// Appends a line of text.
    pub fn text(&mut self, (x, y): (f64, f64), size: f64, anchor: Anchor, style: &str, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let text = escaped(text);
        self.raw(&format!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size:.1}\"{anchor} {style}>{text}</text>"
        ));
    }

    /// Returns the whole document.
    pub fn finish(mut self) -> String {
        let Self {
            width, height, title, ..
        } = &self;
        let start = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"DejaVu Sans, Verdana, sans-serif\">\n<title>{title}</title>\n"
        );
        self.text.insert_str(0, &start);
        self.text += "</svg>\n";
        self.text
    }
}

/// Escapes a text for XML. Characters that XML does not allow become U+FFFD.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// Path data in whole units, relative to the previous position, such as `m12 34 5 6-7 8z`. Steps of
/// length 0 are left out.
#[derive(Default)]
pub struct Path {
    data: String,
    /// The position at the end of the data.
    position: (i64, i64),
    /// The start of the next line, if it is not yet written.
    pending_start: Option<(i64, i64)>,
    /// The start of the current line.
    start: (i64, i64),
}

impl Path {
    /// Returns whether the path is empty.
    pub fn is_empty(&self) -> bool {
        self.data.is_empty()
    }

    /// Starts a line at a position in pixels.
    pub fn move_to(&mut self, pixel: (f64, f64)) {
        self.pending_start = Some(units(pixel));
    }

    /// Continues the line to a position in pixels.
    pub fn line_to(&mut self, pixel: (f64, f64)) {
        let to = units(pixel);
        if let Some(from) = self.pending_start {
            if from == to {
                return;
            }
            self.pending_start = None;
            self.data.push('m');
            self.step(from);
            self.start = from;
        }
        if to != self.position {
            self.step(to);
        }
    }

    /// Closes the line.
    pub fn close(&mut self) {
        if self.pending_start.take().is_none() && !self.data.is_empty() {
            self.data.push('z');
            self.position = self.start;
        }
    }

    /// Creates a path of discs of the same radius.
    pub fn discs(centres: impl IntoIterator<Item = (f64, f64)>, radius: f64) -> Self {
        let mut path = Self::default();
        centres.into_iter().for_each(|centre| path.disc(centre, radius));
        path
    }

    /// Creates a path of squares whose sides are twice as long as `radius`.
    pub fn squares(centres: impl IntoIterator<Item = (f64, f64)>, radius: f64) -> Self {
        let corners = [
            (-radius, -radius),
            (radius, -radius),
            (radius, radius),
            (-radius, radius),
        ];
        let square = |(x, y): (f64, f64)| corners.map(|(right, down)| (x + right, y + down));
        Self::polygons(centres.into_iter().map(square))
    }

    /// Creates a path of closed lines.
    pub fn polygons(rings: impl IntoIterator<Item = impl IntoIterator<Item = (f64, f64)>>) -> Self {
        let mut path = Self::default();
        rings.into_iter().for_each(|ring| path.polygon(ring));
        path
    }

    /// Adds a line.
    pub fn line(&mut self, pixels: impl IntoIterator<Item = (f64, f64)>) {
        for (number, pixel) in pixels.into_iter().enumerate() {
            match number {
                0 => self.move_to(pixel),
                _ => self.line_to(pixel),
            }
        }
    }

    /// Adds a closed line.
    pub fn polygon(&mut self, pixels: impl IntoIterator<Item = (f64, f64)>) {
        self.line(pixels);
        self.close();
    }

    /// Adds a disc, as two arcs.
    pub fn disc(&mut self, (x, y): (f64, f64), radius: f64) {
        let (r, to) = ((radius * UNITS).round().max(1.0) as i64, units((x - radius, y)));
        self.data.push('m');
        self.step(to);
        let d = 2 * r;
        let _ = write!(self.data, "a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0-{d} 0z");
        self.pending_start = None;
    }

    /// Adds all edges. A line continues as long as its end has an edge that is not yet drawn, so
    /// that there are few lines.
    pub fn trails(&mut self, pixels: &[(f64, f64)], edges: &[[u32; 2]]) {
        let mut first = vec![0u32; pixels.len() + 1];
        edges.iter().flatten().for_each(|&v| first[v as usize] += 1);
        let mut sum = 0;
        for count in &mut first {
            sum += *count;
            *count = sum;
        }
        // In reverse order, so that the edges of each vertex start at its `first`, in ascending
        // order.
        let mut around = vec![0u32; 2 * edges.len()];
        for (number, edge) in edges.iter().enumerate().rev() {
            for &v in edge {
                first[v as usize] -= 1;
                around[first[v as usize] as usize] = number as u32;
            }
        }
        let mut next = first.clone();
        let mut drawn = vec![false; edges.len()];
        for start in 0..pixels.len() {
            let mut vertex = start;
            self.move_to(pixels[start]);
            loop {
                let range = next[vertex] as usize..first[vertex + 1] as usize;
                let Some(found) = around[range.clone()].iter().position(|&e| !drawn[e as usize]) else {
                    next[vertex] = range.end as u32;
                    if vertex == start {
                        break;
                    }
                    vertex = start;
                    self.move_to(pixels[start]);
                    continue;
                };
                let edge = around[range.start + found] as usize;
                next[vertex] = (range.start + found + 1) as u32;
                drawn[edge] = true;
                let [a, b] = edges[edge].map(|v| v as usize);
                vertex = if a == vertex { b } else { a };
                self.line_to(pixels[vertex]);
            }
        }
        self.pending_start = None;
    }

    fn step(&mut self, to: (i64, i64)) {
        for (number, distance) in [to.0 - self.position.0, to.1 - self.position.1].into_iter().enumerate() {
            let joined = distance < 0 || (number == 0 && self.data.ends_with('m'));
            let _ = if joined {
                write!(self.data, "{distance}")
            } else {
                write!(self.data, " {distance}")
            };
        }
        self.position = to;
    }
}

fn units((x, y): (f64, f64)) -> (i64, i64) {
    let unit = |v: f64| (v * UNITS).round().clamp(-FAR, FAR) as i64;
    (unit(x), unit(y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn path_data_is_relative_and_short() {
        let mut path = Path::default();
        path.move_to((9.0, 9.0));
        path.polygon([(1.0, 2.0), (1.0, 2.0), (3.0, 2.04), (3.0, 1.0)]);
        path.move_to((1.0, 2.0));
        path.line_to((0.0, 0.0));
        assert_eq!(path.data, "m10 20 20 0 0-10zm0 0-10-20");
    }

    #[test]
    fn trails_draw_each_edge_once() {
        let pixels: Vec<_> = (0..4).map(|i| (f64::from(i), 0.0)).collect();
        let edges = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
        let mut path = Path::default();
        path.trails(&pixels, &edges);
        // Reads the data: sums of steps, in units.
        let mut drawn = Vec::new();
        let mut position = 0i64;
        for line in path.data.split('m').skip(1) {
            let spaced = line.replace('-', " -");
            let steps: Vec<i64> = spaced
                .split_whitespace()
                .step_by(2)
                .map(|n| n.parse().unwrap())
                .collect();
            position += steps[0];
            for step in &steps[1..] {
                drawn.push([
                    position.min(position + step) as u32 / 10,
                    position.max(position + step) as u32 / 10,
                ]);
                position += step;
            }
        }
        drawn.sort_unstable();
        assert_eq!(drawn, edges);
    }

    #[test]
    fn text_is_escaped() {
        assert_eq!(escaped("a<&>\u{1b}"), "a&lt;&amp;&gt;\u{fffd}");
    }
}
