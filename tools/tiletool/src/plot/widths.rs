//! How wide lines are: thin where there are many, and thin around what is small.

use std::collections::HashMap;

use super::ink::Pixel;

/// Lines this many pixels long, or longer, count as one; shorter ones count less.
const LONG: f64 = 3.0;
/// The share of the mean distance of lines that their width is.
const SHARE: f64 = 0.08;
/// The thinnest lines of a map.
const THINNEST: f64 = 0.5;
/// A closed line is at least this many times as large as it is wide, so that its inside is seen.
const INSIDE: f64 = 6.0;
/// The shares of the width that lines around smaller and smaller things have.
const CLASSES: [f64; 3] = [1.0, 0.5, 0.25];

/// Returns the width of lines, at most `most`, of which there are `count` in an area of pixels.
pub fn of_many(count: f64, area: f64, most: f64) -> f64 {
    let distance = (area / count.max(1.0)).sqrt();
    (SHARE * distance).clamp(THINNEST.min(most), most)
}

/// Returns how many lines there are, where short ones count less.
pub fn count(pixels: &[Pixel], edges: &[[u32; 2]]) -> f64 {
    let length = |[a, b]: [Pixel; 2]| (b.0 - a.0).hypot(b.1 - a.1);
    let share = |edge: &[u32; 2]| (length(edge.map(|end| pixels[end as usize])) / LONG).min(1.0);
    edges.iter().map(share).sum()
}

/// Divides edges by the size of what they are connected with: the smaller it is, the thinner they
/// are. Returns widths, each with its edges.
pub fn by_size(pixels: &[Pixel], edges: &[[u32; 2]], width: f64) -> Vec<(f64, Vec<[u32; 2]>)> {
    let mut groups = Groups::new(pixels.len());
    edges.iter().for_each(|&[a, b]| groups.join(a, b));
    let mut extents: HashMap<u32, [f64; 4]> = HashMap::new();
    for &end in edges.iter().flatten() {
        let (x, y) = pixels[end as usize];
        let e = extents.entry(groups.first(end)).or_insert([x, y, x, y]);
        *e = [e[0].min(x), e[1].min(y), e[2].max(x), e[3].max(y)];
    }
    let mut classes = CLASSES.map(|share| (share * width, Vec::new()));
    let last = CLASSES.len() - 1;
    for &edge in edges {
        let [left, top, right, bottom] = extents[&groups.first(edge[0])];
        let size = (right - left).max(bottom - top);
        let class = CLASSES.iter().position(|share| INSIDE * share * width <= size);
        classes[class.unwrap_or(last)].1.push(edge);
    }
    classes.into_iter().filter(|(_, edges)| !edges.is_empty()).collect()
}

/// Numbers in groups. Each group is known by one of its numbers.
struct Groups(Vec<u32>);

impl Groups {
    fn new(numbers: usize) -> Self {
        Self((0..numbers as u32).collect())
    }

    fn first(&mut self, mut number: u32) -> u32 {
        while self.0[number as usize] != number {
            let above = self.0[number as usize];
            self.0[number as usize] = self.0[above as usize];
            number = above;
        }
        number
    }

    fn join(&mut self, a: u32, b: u32) {
        let [a, b] = [a, b].map(|number| self.first(number));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_lines_are_thinner_than_few() {
        let area = 1500.0 * 1500.0;
        let widths = [10.0, 1e3, 1e4, 1e5].map(|count| of_many(count, area, 3.0));
        assert!(widths.windows(2).all(|pair| pair[0] >= pair[1]), "{widths:?}");
        assert_eq!((widths[0], widths[3]), (3.0, THINNEST));
        let pixels = [(0.0, 0.0), (30.0, 0.0), (30.3, 0.0)];
        assert!((count(&pixels, &[[0, 1], [1, 2]]) - 1.1).abs() < 1e-9);
    }

    #[test]
    fn small_rings_are_thinner_than_large_ones() {
        let ring = |x: f64, size: f64| [(x, 0.0), (x + size, 0.0), (x + size, size), (x, size)];
        let pixels = [ring(0.0, 100.0), ring(200.0, 7.0), ring(300.0, 1.0)].concat();
        let sides = |first: u32| (0..4).map(move |i| [first + i, first + (i + 1) % 4]);
        let edges: Vec<_> = [8, 0, 4].into_iter().flat_map(sides).collect();
        let classes = by_size(&pixels, &edges, 2.0);
        let expected = [(2.0, 0), (1.0, 4), (0.5, 8)].map(|(width, first)| (width, sides(first).collect::<Vec<_>>()));
        assert_eq!(classes, expected);
        assert_eq!(by_size(&pixels, &edges[4..8], 2.0).len(), 1);
    }
}
