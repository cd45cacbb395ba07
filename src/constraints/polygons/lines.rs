//! The lines that belong together because they are rings of one polygon.

use crate::constraints::polygons::counter::Begins;
use crate::store::PolygonLine;

/// A collector of the lines that belong to the polygon of a smaller line.
#[derive(Debug, Default)]
pub(crate) struct PolygonLines {
    /// The lines of the current obstacle.
    current: Vec<u64>,
    found: Vec<PolygonLine>,
}

impl PolygonLines {
    /// Takes the line of the next segment, and what begins with that segment.
    pub(crate) fn take(&mut self, begins: Begins, line: u64) {
        if begins == Begins::Obstacle {
            self.end_obstacle();
        }
        if self.current.last() != Some(&line) {
            self.current.push(line);
        }
    }

    fn end_obstacle(&mut self) {
        if self.current.len() > 1 {
            self.current.sort_unstable();
            self.current.dedup();
            let (polygon, others) = (self.current[0], &self.current[1..]);
            self.found
                .extend(others.iter().map(|&line| PolygonLine { line, polygon }));
        }
        self.current.clear();
    }

    /// Returns the lines found, in any order.
    pub(crate) fn finish(mut self) -> Vec<PolygonLine> {
        self.end_obstacle();
        self.found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(lines: &[(Begins, u64)]) -> Vec<(u64, u64)> {
        let mut all = PolygonLines::default();
        lines.iter().for_each(|&(begins, line)| all.take(begins, line));
        all.finish().iter().map(|line| (line.line, line.polygon)).collect()
    }

    #[test]
    fn rings_belong_to_the_smallest_line_of_their_polygon() {
        use Begins::{Nothing, Obstacle, Polygon};
        assert_eq!(found(&[]), []);
        assert_eq!(found(&[(Obstacle, 4), (Nothing, 4), (Polygon, 4), (Obstacle, 2)]), []);
        let rings = [
            (Obstacle, 8),
            (Nothing, 9),
            (Nothing, 7),
            (Obstacle, 2),
            (Nothing, 5),
            (Nothing, 2),
        ];
        assert_eq!(found(&rings), [(8, 7), (9, 7), (5, 2)]);
    }
}
