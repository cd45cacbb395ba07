//! Random PSLGs on small integer grids, triangulated by the tool and checked by brute force.
//!
//! The check shares no code with the library. It reads the exported triangles and decides with
//! integers that
//! - all triangles are counter-clockwise, and form a disc whose boundary is convex;
//! - each pair of consecutive vertices on a segment is an edge, and nothing else is a constraint;
//! - each other edge is locally Delaunay, where ties count the lexicographically largest point as
//!   outside.
//!
//! Only the constrained Delaunay triangulation has these properties (Lawson 1977; Lee and Lin
//! 1986).

use std::collections::{BTreeSet, HashMap};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Context as _, bail, ensure};
use rand_chacha::ChaCha8Rng;

use crate::campaign::{Context, Counts, below};

type P = [i64; 2];

/// Points, and segments between them that cross only in points.
struct Pslg {
    points: Vec<P>,
    segments: Vec<[usize; 2]>,
}

/// Builds one PSLG, at once or with some of its segments added later, and checks it.
pub fn round(context: &Context, mut random: ChaCha8Rng) -> anyhow::Result<Counts> {
    let random = &mut random;
    let pslg = Pslg::random(random);
    let folder = tempfile::tempdir()?;
    let path = folder.path();
    let points = pslg.points.iter().flatten().flat_map(|&c| (c as f64).to_le_bytes());
    fs::write(path.join("p.f64"), points.collect::<Vec<u8>>())?;
    let spread = pslg
        .points
        .iter()
        .any(|&p| orient(pslg.points[0], pslg.points[1], p) != 0);
    // An edit needs triangles.
    let first = match below(random, 3) {
        0 if spread => below(random, pslg.segments.len() as u64 + 1) as usize,
        _ => pslg.segments.len(),
    };
    let (built, edited) = pslg.segments.split_at(first);
    let pairs = built.iter().flatten().flat_map(|&end| (end as u32).to_le_bytes());
    fs::write(path.join("s.u32"), pairs.collect::<Vec<u8>>())?;
    let kind = ["--segments", "--walls"][below(random, 2) as usize];
    let mut build = format!(
        "build p.f64 -o x.tiles --tile-vertices {} --memory {}MiB --threads {} --quiet",
        4 + below(random, 40),
        1 + below(random, 3),
        1 + below(random, 2),
    );
    if !built.is_empty() {
        write!(build, " {kind} s.u32")?;
    }
    context.run(path, &build)?;
    if !edited.is_empty() {
        let row = |&[a, b]: &[usize; 2]| {
            let ([ax, ay], [bx, by]) = (pslg.points[a], pslg.points[b]);
            format!("{ax},{ay},{bx},{by}\n")
        };
        fs::write(path.join("later.csv"), edited.iter().map(row).collect::<String>())?;
        context.run(path, &format!("constrain x.tiles {kind} later.csv --quiet"))?;
    }
    context.run(path, "verify --deep x.tiles")?;
    context.run(path, "export x.tiles -o x.node --all")?;
    let triangles = read(path)?;
    pslg.check(&triangles)?;
    let constraints = context.run(path, "inspect x.tiles --json")?;
    let expected = pslg.subsegments().len();
    ensure!(
        constraints.contains(&format!("\"constraint_edges\": {expected},"))
            || constraints.contains(&format!("\"constraint_edges\":{expected},")),
        "{expected} edges are constraints, and the file says otherwise: {constraints}"
    );
    Ok(vec![
        ("triangles", triangles.len() as u64),
        ("segments", pslg.segments.len() as u64),
    ])
}

impl Pslg {
    fn random(random: &mut ChaCha8Rng) -> Self {
        // The sets have from a few points on a tiny grid, full of ties, to some hundreds.
        let most = [8, 30, 120, 400][below(random, 4) as usize];
        let count = 3 + below(random, most);
        let largest = [3, 12, 60, 1000][below(random, 4) as usize];
        let grid = 2 + below(random, largest);
        let mut all: BTreeSet<P> = BTreeSet::new();
        for _ in 0..count {
            all.insert([below(random, grid) as i64, below(random, grid) as i64]);
        }
        while all.len() < 3 {
            all.insert([below(random, 9) as i64, below(random, 9) as i64]);
        }
        let mut points: Vec<P> = all.into_iter().collect();
        for i in (1..points.len()).rev() {
            points.swap(i, below(random, i as u64 + 1) as usize);
        }
        let mut pslg = Self {
            points,
            segments: Vec::new(),
        };
        let count = pslg.points.len() as u64;
        // Half of the sets have a hub, where many segments meet.
        let hub = (below(random, 2) == 0).then(|| below(random, count) as usize);
        for _ in 0..below(random, 2 * count) {
            let from = hub.filter(|_| below(random, 2) == 0);
            let from = from.unwrap_or_else(|| below(random, count) as usize);
            let segment = [from, below(random, count) as usize];
            if segment[0] != segment[1] && !pslg.segments.iter().any(|&other| pslg.cross(segment, other)) {
                pslg.segments.push(segment);
            }
        }
        pslg
    }

    /// Returns whether two segments cross at a position that is not a point of the set.
    fn cross(&self, one: [usize; 2], other: [usize; 2]) -> bool {
        let [[a, b], [c, d]] = [one, other].map(|ends| ends.map(|end| self.points[end]));
        let sides = |p, q, r, s| orient(p, q, r).signum() * orient(p, q, s).signum() < 0;
        let is_on_both = |&p: &P| orient(a, b, p) == 0 && orient(c, d, p) == 0;
        sides(a, b, c, d) && sides(c, d, a, b) && !self.points.iter().any(is_on_both)
    }

    /// Returns the pairs of consecutive points on each segment, the smaller point first.
    fn subsegments(&self) -> BTreeSet<[P; 2]> {
        let mut subsegments = BTreeSet::new();
        for &ends in &self.segments {
            let [a, b] = ends.map(|end| self.points[end]);
            let [low, high] = [a.min(b), a.max(b)];
            let is_on = |p: &&P| orient(a, b, **p) == 0 && low <= **p && **p <= high;
            let mut on: Vec<P> = self.points.iter().filter(is_on).copied().collect();
            on.sort_unstable();
            subsegments.extend(on.windows(2).map(|pair| [pair[0], pair[1]]));
        }
        subsegments
    }

    /// Checks that these are the triangles of the constrained Delaunay triangulation.
    fn check(&self, triangles: &[[P; 3]]) -> anyhow::Result<()> {
        let constraints = self.subsegments();
        // The third corner of the triangle on the left of each edge.
        let mut apexes: HashMap<[P; 2], P> = HashMap::new();
        for &[a, b, c] in triangles {
            ensure!(orient(a, b, c) > 0, "{a:?} {b:?} {c:?} is not counter-clockwise");
            for [from, to, apex] in [[a, b, c], [b, c, a], [c, a, b]] {
                let before = apexes.insert([from, to], apex);
                ensure!(before.is_none(), "two triangles on the left of {from:?} {to:?}");
            }
        }
        let hull: Vec<[P; 2]> = apexes
            .keys()
            .filter(|[a, b]| !apexes.contains_key(&[*b, *a]))
            .copied()
            .collect();
        for &[a, b] in &hull {
            let outside = self.points.iter().find(|&&p| orient(a, b, p) < 0);
            ensure!(
                outside.is_none(),
                "{outside:?} lies outside of the hull edge {a:?} {b:?}"
            );
        }
        let is_flat = self
            .points
            .iter()
            .all(|&p| orient(self.points[0], self.points[1], p) == 0);
        // Euler's formula for a triangulated disc with all points.
        let expected = if is_flat {
            0
        } else {
            2 * self.points.len() - 2 - hull.len()
        };
        ensure!(
            triangles.len() == expected,
            "{} triangles instead of {expected}",
            triangles.len()
        );
        for &[a, b] in constraints.iter().filter(|_| !is_flat) {
            let is_edge = apexes.contains_key(&[a, b]) || apexes.contains_key(&[b, a]);
            ensure!(is_edge, "the subsegment {a:?} {b:?} is not an edge");
        }
        for (&[a, b], &c) in &apexes {
            let Some(&d) = apexes.get(&[b, a]) else { continue };
            let is_constraint = constraints.contains(&[a.min(b), a.max(b)]);
            ensure!(
                is_constraint || !is_inside([a, b, c], d),
                "{d:?} lies in the circle of {a:?} {b:?} {c:?}"
            );
        }
        Ok(())
    }
}

/// Reads the triangles of `x.node` and `x.ele`, by their corners.
fn read(folder: &Path) -> anyhow::Result<Vec<[P; 3]>> {
    let rows = |name: &str| -> anyhow::Result<Vec<Vec<i64>>> {
        let text = fs::read_to_string(folder.join(name))?;
        let lines = text
            .lines()
            .filter(|line| !line.starts_with('#') && !line.trim().is_empty())
            .skip(1);
        lines
            .map(|line| {
                let fields = line.split_whitespace();
                let number = |field: &str| field.parse::<f64>().map(|number| number as i64);
                fields
                    .map(number)
                    .collect::<Result<_, _>>()
                    .with_context(|| format!("{name}: {line}"))
            })
            .collect()
    };
    let nodes: HashMap<i64, P> = rows("x.node")?.iter().map(|row| (row[0], [row[1], row[2]])).collect();
    let mut triangles = Vec::new();
    for row in rows("x.ele")? {
        let corners = [1, 2, 3].map(|i| nodes.get(&row[i]).copied());
        let [Some(a), Some(b), Some(c)] = corners else {
            bail!("x.ele: no such vertex: {row:?}")
        };
        triangles.push([a, b, c]);
    }
    Ok(triangles)
}

/// Returns twice the signed area of a triangle.
fn orient([ax, ay]: P, [bx, by]: P, [cx, cy]: P) -> i128 {
    i128::from(bx - ax) * i128::from(cy - ay) - i128::from(by - ay) * i128::from(cx - ax)
}

/// Returns whether a point is inside the circle of a counter-clockwise triangle. Of four points on
/// a circle, the lexicographically largest counts as outside: its lift is raised by an infinitely
/// small amount.
fn is_inside([a, b, c]: [P; 3], d: P) -> bool {
    let lift = |[x, y]: P| {
        let (x, y) = (i128::from(x - d[0]), i128::from(y - d[1]));
        x * x + y * y
    };
    let exact = lift(a) * orient(d, b, c) + lift(b) * orient(d, c, a) + lift(c) * orient(d, a, b);
    let tie = match [a, b, c, d].into_iter().max() {
        Some(largest) if largest == a => orient(d, b, c),
        Some(largest) if largest == b => orient(d, c, a),
        Some(largest) if largest == c => orient(d, a, b),
        _ => -1,
    };
    exact > 0 || exact == 0 && tie > 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_of_four_cocircular_points_is_outside() {
        let [a, b, c, d] = [[0, 0], [1, 0], [1, 1], [0, 1]];
        assert!(!is_inside([a, b, d], c));
        assert!(is_inside([a, b, c], d));
        assert!(is_inside([[0, 0], [4, 0], [0, 4]], [1, 1]));
        assert!(!is_inside([[0, 0], [4, 0], [0, 4]], [5, 5]));
    }

    #[test]
    fn the_check_rejects_another_diagonal_and_a_missing_triangle() {
        let pslg = Pslg {
            points: vec![[0, 0], [2, 0], [3, 3], [0, 2]],
            segments: Vec::new(),
        };
        let [a, b, c, d] = [[0, 0], [2, 0], [3, 3], [0, 2]];
        let right = [[a, b, d], [b, c, d]];
        assert!(pslg.check(&right).is_ok());
        assert!(pslg.check(&[[a, b, c], [a, c, d]]).is_err());
        assert!(pslg.check(&right[..1]).is_err());
        let constrained = Pslg {
            segments: vec![[0, 2]],
            ..pslg
        };
        assert!(constrained.check(&right).is_err());
        assert!(constrained.check(&[[a, b, c], [a, c, d]]).is_ok());
    }
}
