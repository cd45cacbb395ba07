//! The distances of sites as functions of the position on a line, and which of them are the
//! smallest where.
//!
//! A site's distance is the minimum of some arcs. An arc is a range of the line that a root sees;
//! the length of the path from the root to the site is known. Between the ends of arcs, the arcs of
//! two sites are equal at two positions at most, the roots of a quadratic equation. Between these
//! positions the order of the sites does not change.

use super::line::QueryLine;
use crate::geometry::Point;
use crate::query::answer::distance;

/// Distances whose relative difference is less than this count as equal.
const TIE: f64 = 1e-12;
/// Ranges shorter than this fraction of the line are skipped.
const SHORT: f64 = 1e-15;

/// A range of the line that a root sees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arc {
    /// The index of the site that the root leads to, in a list.
    pub(super) site: usize,
    /// The number of the root, in the search for this site.
    pub(super) root: u32,
    pub(super) range: [f64; 2],
    /// The position of the root, and the length of the path from there to the site.
    pub(super) at: Point,
    pub(super) length: f64,
}

/// A range of the line with its nearest sites, and their distances at its start and at its end.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Span {
    pub(super) range: [f64; 2],
    pub(super) sites: Vec<(usize, [f64; 2])>,
}

impl Arc {
    fn value(&self, line: QueryLine, t: f64) -> f64 {
        self.length + distance(line.at(t), self.at)
    }
}

/// Joins arcs of one root and site that meet end to end.
pub(crate) fn joined(mut arcs: Vec<Arc>) -> Vec<Arc> {
    arcs.sort_by(|a, b| {
        (a.site, a.root)
            .cmp(&(b.site, b.root))
            .then(a.range[0].total_cmp(&b.range[0]))
    });
    let mut joined: Vec<Arc> = Vec::new();
    for arc in arcs {
        match joined.last_mut() {
            Some(last) if (last.site, last.root) == (arc.site, arc.root) && arc.range[0] <= last.range[1] => {
                last.range[1] = last.range[1].max(arc.range[1]);
            }
            _ => joined.push(arc),
        }
    }
    joined
}

/// Returns the `k` nearest sites along the range `run` of the line. `order` ranks sites with equal
/// distances.
pub(crate) fn nearest(line: QueryLine, run: [f64; 2], arcs: &[Arc], k: usize, order: &[u64]) -> Vec<Span> {
    let clipped = |arc: &Arc| [arc.range[0].max(run[0]), arc.range[1].min(run[1])];
    let mut cuts: Vec<f64> = arcs.iter().flat_map(clipped).chain(run).collect();
    cuts.retain(|t| (run[0]..=run[1]).contains(t));
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    let mut by_start: Vec<&Arc> = arcs.iter().filter(|arc| arc.range[1] > run[0]).collect();
    by_start.sort_by(|a, b| a.range[0].total_cmp(&b.range[0]));
    let mut coming = by_start.into_iter().peekable();
    let mut active: Vec<&Arc> = Vec::new();
    let mut spans = Vec::new();
    for range in cuts.windows(2).map(|cuts| [cuts[0], cuts[1]]) {
        active.retain(|arc| arc.range[1] >= range[1]);
        while let Some(arc) = coming.next_if(|arc| arc.range[0] <= range[0]) {
            if arc.range[1] >= range[1] {
                active.push(arc);
            }
        }
        let interval = ElementaryInterval { line, k, order, range };
        interval.collect(&active, &mut spans);
    }
    spans
}

/// A range in which the set of arcs is the same from end to end.
struct ElementaryInterval<'o> {
    line: QueryLine,
    k: usize,
    order: &'o [u64],
    range: [f64; 2],
}

impl ElementaryInterval<'_> {
    fn collect(&self, active: &[&Arc], spans: &mut Vec<Span>) {
        let [low, high] = self.range;
        let arcs = self.competing(active);
        let mut cuts = vec![low, high];
        for (index, a) in arcs.iter().enumerate() {
            for b in arcs[index + 1..].iter().filter(|b| b.site != a.site) {
                cuts.extend(self.crossings(a, b));
            }
        }
        cuts.sort_by(f64::total_cmp);
        for cuts in cuts.windows(2).filter(|cuts| cuts[0] < cuts[1]) {
            let range = [cuts[0], cuts[1]];
            match spans.last_mut() {
                Some(last) if range[1] - range[0] <= SHORT => last.range[1] = range[1],
                last => {
                    let found = self.sorted(&arcs, range);
                    let is_same = |last: &&mut Span| {
                        let sites = last.sites.iter().map(|&(site, _)| site);
                        sites.eq(found.iter().map(|&(site, _)| site))
                    };
                    if let Some(last) = last.filter(is_same) {
                        last.range[1] = range[1];
                        for (site, (_, [_, end])) in last.sites.iter_mut().zip(found) {
                            site.1[1] = end;
                        }
                    } else {
                        spans.push(Span { range, sites: found });
                    }
                }
            }
        }
    }

    /// Returns the arcs that can be among the `k` nearest somewhere in the range.
    fn competing<'a>(&self, active: &[&'a Arc]) -> Vec<&'a Arc> {
        // An upper bound of the distance of each site.
        let mut most: Vec<(usize, f64)> = active
            .iter()
            .map(|arc| {
                (
                    arc.site,
                    self.range
                        .map(|t| arc.value(self.line, t))
                        .into_iter()
                        .fold(0.0, f64::max),
                )
            })
            .collect();
        most.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        most.dedup_by_key(|(site, _)| *site);
        most.sort_by(|a, b| a.1.total_cmp(&b.1));
        let Some(&(_, bound)) = most.get(self.k.saturating_sub(1)) else {
            return active.to_vec();
        };
        let slack = bound * (1.0 + 4.0 * TIE);
        active.iter().copied().filter(|arc| self.least(arc) <= slack).collect()
    }

    /// Returns the least value of an arc in the range.
    fn least(&self, arc: &Arc) -> f64 {
        let (from, to) = (self.line.from, self.line.to);
        let (dx, dy) = (to.x - from.x, to.y - from.y);
        let foot = ((arc.at.x - from.x) * dx + (arc.at.y - from.y) * dy) / (dx * dx + dy * dy);
        arc.value(self.line, foot.clamp(self.range[0], self.range[1]))
    }

    /// Returns the positions where two arcs have the same value.
    fn crossings(&self, a: &Arc, b: &Arc) -> Vec<f64> {
        // The coordinates are lengths along the line, from the middle of the range, and heights
        // above it.
        let length = self.line.length();
        let (ux, uy) = (
            (self.line.to.x - self.line.from.x) / length,
            (self.line.to.y - self.line.from.y) / length,
        );
        let middle = 0.5 * (self.range[0] + self.range[1]);
        let origin = self.line.at(middle);
        let local = |p: Point| {
            let (dx, dy) = (p.x - origin.x, p.y - origin.y);
            (dx * ux + dy * uy, dx * uy - dy * ux)
        };
        let ((x, h), (u, g)) = (local(a.at), local(b.at));
        let more = b.length - a.length;
        // sqrt((s-x)² + h²) = sqrt((s-u)² + g²) + more, squared twice.
        let slope = 2.0 * (u - x);
        let offset = (x - u) * (x + u) + (h - g) * (h + g) - more * more;
        let (square, linear, constant) = (
            slope * slope - 4.0 * more * more,
            2.0 * (slope * offset + 4.0 * more * more * u),
            offset * offset - 4.0 * more * more * (u * u + g * g),
        );
        let [low, high] = self.range.map(|t| (t - middle) * length);
        let apart = |s: f64| ((s - x).hypot(h) - (s - u).hypot(g)) - more;
        let mut found = Vec::new();
        for s in solve(square, linear, constant) {
            // Two steps of Newton's method regain the precision that squaring lost.
            let mut s = s;
            for _ in 0..2 {
                let rise = (s - x) / (s - x).hypot(h) - (s - u) / (s - u).hypot(g);
                let step = apart(s) / rise;
                if step.is_finite() && (s - step).abs() <= 2.0 * (s.abs() + high - low) {
                    s -= step;
                }
            }
            if low < s && s < high {
                found.push((middle + s / length).clamp(self.range[0], self.range[1]));
            }
        }
        found
    }

    /// Returns the nearest sites in a range without crossings.
    fn sorted(&self, arcs: &[&Arc], range: [f64; 2]) -> Vec<(usize, [f64; 2])> {
        let middle = 0.5 * (range[0] + range[1]);
        let mut sites: Vec<(usize, f64)> = arcs
            .iter()
            .map(|arc| (arc.site, arc.value(self.line, middle)))
            .collect();
        sites.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        sites.dedup_by_key(|(site, _)| *site);
        sites.sort_by(|a, b| a.1.total_cmp(&b.1));
        for equal in sites.chunk_by_mut(|a, b| b.1 - a.1 <= TIE * b.1) {
            equal.sort_by_key(|&(site, _)| self.order[site]);
        }
        sites.truncate(self.k);
        let value = |site: usize, t: f64| {
            let its = arcs.iter().filter(|arc| arc.site == site);
            its.map(|arc| arc.value(self.line, t)).fold(f64::INFINITY, f64::min)
        };
        let with_ends = |(site, _)| (site, range.map(|t| value(site, t)));
        sites.into_iter().map(with_ends).collect()
    }
}

/// Returns the real roots of a quadratic or linear polynomial; none if it is constant.
fn solve(square: f64, linear: f64, constant: f64) -> Vec<f64> {
    let root = (linear * linear - 4.0 * square * constant).max(0.0).sqrt();
    let sum = -0.5 * (linear + root.copysign(linear));
    [sum / square, constant / sum]
        .into_iter()
        .filter(|s| s.is_finite())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arc(site: usize, at: [f64; 2], length: f64) -> Arc {
        Arc {
            site,
            root: 0,
            range: [0.0, 1.0],
            at: Point::new(at[0], at[1]),
            length,
        }
    }

    const LINE: QueryLine = QueryLine {
        from: Point { x: 0.0, y: 0.0 },
        to: Point { x: 10.0, y: 0.0 },
    };

    /// Returns the sites of each interval, and its end in thousandths of the line.
    fn ends(arcs: &[Arc], k: usize) -> Vec<(Vec<usize>, f64)> {
        let order: Vec<u64> = (0..arcs.len() as u64).collect();
        let spans = nearest(LINE, [0.0, 1.0], arcs, k, &order);
        assert!(spans.windows(2).all(|pair| pair[0].range[1] == pair[1].range[0]));
        let sites = |span: &Span| span.sites.iter().map(|&(site, _)| site).collect();
        let end = |span: &Span| (span.range[1] * 1000.0 * (1.0 + 1e-12)).floor();
        spans.iter().map(|span| (sites(span), end(span))).collect()
    }

    #[test]
    fn arcs_have_no_crossing_one_or_two() {
        let two = [arc(0, [0.0, 3.0], 0.0), arc(1, [10.0, 3.0], 0.0)];
        assert_eq!(ends(&two, 1), [(vec![0], 500.0), (vec![1], 1000.0)]);
        assert_eq!(ends(&two, 2), [(vec![0, 1], 500.0), (vec![1, 0], 1000.0)]);
        // Equal where |5 - s| + 2 = √((5 - s)² + 16): at a distance of three on both sides of 5.
        let bump = [arc(0, [5.0, 4.0], 0.0), arc(1, [5.0, 0.0], 2.0)];
        assert_eq!(ends(&bump, 1), [(vec![0], 200.0), (vec![1], 800.0), (vec![0], 1000.0)]);
        let far = [arc(0, [5.0, 1.0], 0.0), arc(1, [5.0, 1.0], 1.0)];
        assert_eq!(ends(&far, 1), [(vec![0], 1000.0)]);
    }

    #[test]
    fn sites_with_equal_distances_are_ordered_by_number_and_arcs_end() {
        let same = [
            arc(1, [5.0, 1.0], 0.0),
            arc(0, [5.0, -1.0], 0.0),
            arc(2, [0.0, 0.0], 30.0),
        ];
        assert_eq!(ends(&same, 1), [(vec![0], 1000.0)]);
        assert_eq!(ends(&same, 9), [(vec![0, 1, 2], 1000.0)]);
        let mut parts = [arc(0, [5.0, 0.0], 0.0), arc(0, [5.0, 0.0], 0.0)];
        (parts[0].range, parts[1].range) = ([0.25, 0.5], [0.5, 0.75]);
        let expected = [(vec![], 250.0), (vec![0], 750.0), (vec![], 1000.0)];
        assert_eq!(ends(&joined(parts.to_vec()), 1), expected);
        assert_eq!(joined(parts.to_vec()).len(), 1);
    }
}
