//! Growth of seams with their cells, to detect early that a build will run out of memory.
//!
//! A cell of m points has about c·√m seam vertices, which is little. If points are on a curve,
//! every point is on the hull of every cell, seams are whole cells, and the root would hold all
//! points at once. Both are powers of m, so the nodes that are done show which case applies.

use crate::memory::{SEAM_BYTES, SEAM_WORK_BYTES};

/// The sizes of the nodes that are done.
#[derive(Clone, Debug, Default)]
pub(crate) struct SeamGrowth {
    /// By the binary logarithm of the vertices below a node: the number of nodes, and the sums of
    /// these vertices and of seam vertices.
    classes: Vec<[u64; 3]>,
}

impl SeamGrowth {
    /// Adds a node with `below` vertices below it and `seam` vertices in its seam.
    pub(crate) fn observe(&mut self, below: u64, seam: u64) {
        let class = below.max(1).ilog2() as usize;
        if self.classes.len() <= class {
            self.classes.resize(class + 1, [0; 3]);
        }
        let [nodes, vertices, seams] = &mut self.classes[class];
        *nodes += 1;
        *vertices += below;
        *seams += seam;
    }

    /// Estimates the memory that merging the root of `points` points takes, if seams grow nearly as
    /// fast as cells. It extends a line from the largest cells to half of all points; the slope is
    /// that of the regression through the logarithms of cells and seams, at most 1. Returns `None`
    /// if seams grow slower, or if the cells so far are too similar: the largest must have `spread`
    /// times the vertices of the smallest.
    pub(crate) fn root_bytes(&self, points: u64, spread: f64) -> Option<u64> {
        /// Smallest exponent that indicates curves. Areas have an exponent of a half, and few cells
        /// give a rough estimate.
        const STEEP: f64 = 0.8;
        let classes = self.classes.iter().filter(|class| class[0] > 0 && class[2] > 0);
        let mean = |&[nodes, vertices, seams]: &[u64; 3]| {
            let nodes = nodes as f64;
            ((vertices as f64 / nodes).ln(), (seams as f64 / nodes).ln())
        };
        let logarithms: Vec<(f64, f64)> = classes.map(mean).collect();
        let (&(least, _), &(largest, seam)) = (logarithms.first()?, logarithms.last()?);
        if largest - least < spread.ln() {
            return None;
        }
        let count = logarithms.len() as f64;
        let centre = logarithms.iter().map(|p| p.0).sum::<f64>() / count;
        let height = logarithms.iter().map(|p| p.1).sum::<f64>() / count;
        let slope = logarithms.iter().map(|p| (p.0 - centre) * (p.1 - height)).sum::<f64>()
            / logarithms.iter().map(|p| (p.0 - centre).powi(2)).sum::<f64>();
        if slope < STEEP {
            return None;
        }
        let half = (points as f64 / 2.0).ln();
        let root = 2.0 * (seam + slope.min(1.0) * (half - largest).max(0.0)).exp();
        Some((root.min(points as f64) * (SEAM_BYTES + SEAM_WORK_BYTES) as f64) as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_by_the_square_root_and_linear_growth_are_distinguished() {
        let root = |seam: fn(u64) -> u64| {
            let mut growth = SeamGrowth::default();
            for (cells, points) in [(16, 60_000), (4, 240_000), (1, 960_000)] {
                (0..cells).for_each(|_| growth.observe(points, seam(points)));
            }
            let bytes = growth.root_bytes(100_000_000, 7.0)?;
            Some(bytes / (SEAM_BYTES + SEAM_WORK_BYTES))
        };
        assert_eq!(root(|m| 25 * m.isqrt()), None);
        assert!(root(|m| m - 5).is_some_and(|vertices| vertices > 99_000_000));
        let mut alike = SeamGrowth::default();
        alike.observe(60_000, 900);
        alike.observe(70_000, 990);
        assert_eq!(alike.root_bytes(1 << 30, 2.0), None);
    }
}
