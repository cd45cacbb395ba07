//! SVG as text: elements, and path data in as few characters as it takes.

use std::fmt::Write;

/// Units of path data per pixel: paths stand in a group that is scaled down by it.
pub const UNITS: f64 = 10.0;
/// Beyond this many units from the origin a place is moved in, as nothing of it can be seen.
const FAR: f64 = 1e7;

/// An SVG document that grows.
pub struct Svg {
    text: String,
}

/// How a text stands at its place.
#[derive(Clone, Copy)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

impl Svg {
    /// An empty document.
    pub fn new(width: u32, height: u32, title: &str) -> Self {
        let text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"DejaVu Sans, Verdana, sans-serif\">\n<title>{}</title>\n",
            escaped(title)
        );
        Self { text }
    }

    /// Appends an element, or the start or end of one, as it stands.
    pub fn raw(&mut self, element: &str) {
        self.text += element;
        self.text.push('\n');
    }

    /// Appends a group in which coordinates are those of paths, in this style.
    pub fn in_units(&mut self, style: &str, inside: impl FnOnce(&mut Self)) {
        let space = if style.is_empty() { "" } else { " " };
        self.raw(&format!("<g transform=\"scale({})\"{space}{style}>", 1.0 / UNITS));
        inside(self);
        self.raw("</g>");
    }

    /// Appends a path, unless there is nothing in it.
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

    /// The whole document.
    pub fn finish(mut self) -> String {
        self.text += "</svg>\n";
        self.text
    }
}

/// Text as XML wants it; characters that XML does not allow become U+FFFD.
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

/// Path data in whole units, relative to the place before, as `m12 34 5 6-7 8z`. Steps of no length are left out.
#[derive(Default)]
pub struct Path {
    data: String,
    /// Where the data ends, where the line would start that is announced, and where the last one started.
    at: (i64, i64),
    announced: Option<(i64, i64)>,
    start: (i64, i64),
}

impl Path {
    /// Whether there is nothing in it.
    pub fn is_empty(&self) -> bool {
        self.data.is_empty()
    }

    /// Starts a line, at a place in pixels.
    pub fn move_to(&mut self, pixel: (f64, f64)) {
        self.announced = Some(units(pixel));
    }

    /// Draws a line on.
    pub fn line_to(&mut self, pixel: (f64, f64)) {
        let to = units(pixel);
        if let Some(from) = self.announced {
            if from == to {
                return;
            }
            self.announced = None;
            self.data.push('m');
            self.step(from);
            self.start = from;
        }
        if to != self.at {
            self.step(to);
        }
    }

    /// Joins the line to its start.
    pub fn close(&mut self) {
        if self.announced.take().is_none() && !self.data.is_empty() {
            self.data.push('z');
            self.at = self.start;
        }
    }

    /// Discs of one radius.
    pub fn discs(centres: impl IntoIterator<Item = (f64, f64)>, radius: f64) -> Self {
        let mut path = Self::default();
        centres.into_iter().for_each(|centre| path.disc(centre, radius));
        path
    }

    /// Closed lines.
    pub fn polygons(rings: impl IntoIterator<Item = impl IntoIterator<Item = (f64, f64)>>) -> Self {
        let mut path = Self::default();
        rings.into_iter().for_each(|ring| path.polygon(ring));
        path
    }

    /// A line.
    pub fn line(&mut self, pixels: impl IntoIterator<Item = (f64, f64)>) {
        for (number, pixel) in pixels.into_iter().enumerate() {
            match number {
                0 => self.move_to(pixel),
                _ => self.line_to(pixel),
            }
        }
    }

    /// A closed line.
    pub fn polygon(&mut self, pixels: impl IntoIterator<Item = (f64, f64)>) {
        self.line(pixels);
        self.close();
    }

    /// A disc, of two arcs.
    pub fn disc(&mut self, (x, y): (f64, f64), radius: f64) {
        let (r, to) = ((radius * UNITS).round().max(1.0) as i64, units((x - radius, y)));
        self.data.push('m');
        self.step(to);
        let d = 2 * r;
        let _ = write!(self.data, "a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0-{d} 0z");
        self.announced = None;
    }

    /// All edges, in as few lines as come of going on wherever an edge is left.
    pub fn trails(&mut self, pixels: &[(f64, f64)], edges: &[[u32; 2]]) {
        let mut first = vec![0u32; pixels.len() + 1];
        edges.iter().flatten().for_each(|&v| first[v as usize] += 1);
        let mut sum = 0;
        for count in &mut first {
            sum += *count;
            *count = sum;
        }
        // Backwards, so that each vertex' edges end up behind its `first`.
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
            let mut at = start;
            self.move_to(pixels[start]);
            loop {
                let range = next[at] as usize..first[at + 1] as usize;
                let Some(found) = around[range.clone()].iter().position(|&e| !drawn[e as usize]) else {
                    next[at] = range.end as u32;
                    if at == start {
                        break;
                    }
                    at = start;
                    self.move_to(pixels[start]);
                    continue;
                };
                let edge = around[range.start + found] as usize;
                next[at] = (range.start + found + 1) as u32;
                drawn[edge] = true;
                let [a, b] = edges[edge].map(|v| v as usize);
                at = if a == at { b } else { a };
                self.line_to(pixels[at]);
            }
        }
        self.announced = None;
    }

    fn step(&mut self, to: (i64, i64)) {
        for (number, distance) in [to.0 - self.at.0, to.1 - self.at.1].into_iter().enumerate() {
            let joined = distance < 0 || (number == 0 && self.data.ends_with('m'));
            let _ = if joined {
                write!(self.data, "{distance}")
            } else {
                write!(self.data, " {distance}")
            };
        }
        self.at = to;
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
    fn path_data_is_short() {
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
        // Walks the data again: sums of steps, in units.
        let mut drawn = Vec::new();
        let mut at = 0i64;
        for line in path.data.split('m').skip(1) {
            let spaced = line.replace('-', " -");
            let steps: Vec<i64> = spaced
                .split_whitespace()
                .step_by(2)
                .map(|n| n.parse().unwrap())
                .collect();
            at += steps[0];
            for step in &steps[1..] {
                drawn.push([at.min(at + step) as u32 / 10, at.max(at + step) as u32 / 10]);
                at += step;
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
