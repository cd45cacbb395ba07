//! Where segments begin and end, as the page describes it.

use delaunay_tiles::geometry::Point;

use crate::format::reader::{File, Twin};

/// Checks that each segment, of a line of its own, begins and ends once, at its ends.
pub fn check_segment_ends(file: &File, segments: &[[Point; 2]]) {
    let mut found: Vec<Vec<Point>> = vec![Vec::new(); segments.len()];
    for (number, tile) in file.tiles.iter().enumerate() {
        let triangles: Vec<[usize; 3]> = tile.triangles().collect();
        let at = |corner: usize| tile.corner(file, corner);
        for half_edge in 0..3 * triangles.len() {
            let [from, to] = [half_edge, half_edge / 3 * 3 + (half_edge + 1) % 3].map(|h| triangles[h / 3][h % 3]);
            let ends = [at(from), at(to)];
            let owner = if ends[0].1.lex_cmp(ends[1].1).is_lt() {
                ends[0].0
            } else {
                ends[1].0
            };
            let is_first = match tile.twin(half_edge) {
                Twin::HalfEdge(twin) => half_edge < twin,
                _ => true,
            };
            if owner == number && is_first {
                for (line, _, is_end) in tile.sources(half_edge) {
                    let here = ends.iter().zip(is_end).filter(|(_, is_end)| *is_end);
                    found[line as usize].extend(here.map(|(end, _)| end.1));
                }
            }
        }
    }
    for (ends, mut found) in segments.iter().zip(found) {
        let mut ends = ends.to_vec();
        ends.sort_by(|a, b| a.lex_cmp(*b));
        found.sort_by(|a, b| a.lex_cmp(*b));
        assert_eq!(found, ends);
    }
}
