//! Tests of cutting, against fractions.

use super::*;

type Spot = [i64; 2];
/// A fraction: numerator and denominator, which is above 0.
type Fraction = [i64; 2];

fn point([x, y]: Spot) -> Point {
    Point::new(x as f64, y as f64)
}

fn ring(corners: &[Spot]) -> Vec<[Spot; 2]> {
    (0..corners.len())
        .map(|i| [corners[i], corners[(i + 1) % corners.len()]])
        .collect()
}

fn square(x: i64, y: i64, size: i64) -> Vec<[Spot; 2]> {
    ring(&[[x, y], [x + size, y], [x + size, y + size], [x, y + size]])
}

fn turned(edges: Vec<[Spot; 2]>) -> Vec<[Spot; 2]> {
    edges.into_iter().map(|[a, b]| [b, a]).collect()
}

/// Returns the pieces of a line, and checks that its side agrees.
fn pieces(edges: &[[Spot; 2]], line: &[Spot]) -> Vec<Piece> {
    let clip = Arc::new(Clip::new(edges.iter().map(|ends| ends.map(point)).collect()));
    let line: Vec<Point> = line.iter().map(|&spot| point(spot)).collect();
    let is_closed = line.len() > 1 && line.first() == line.last();
    let found: Vec<Piece> = Cut::new(Arc::clone(&clip), line.clone(), is_closed).collect();
    match clip.side_of_line(&line) {
        Side::Outside => assert_eq!(found, []),
        Side::Inside => assert_eq!(
            found,
            [Piece {
                points: line,
                is_closed
            }]
        ),
        Side::Both => {}
    }
    found
}

#[test]
fn lines_end_at_the_boundary_and_run_along_it() {
    let mut hollow = square(0, 0, 12);
    hollow.extend(turned(square(4, 4, 4)));
    let both = [square(0, 0, 4), square(2, 0, 4), square(6, 0, 4)].concat();
    for (edges, line, expected) in [
        // Through a hole, its corner, along its side, and to its side and back.
        (
            &hollow,
            vec![[-3, 6], [20, 6]],
            vec![vec![[0, 6], [4, 6]], vec![[8, 6], [12, 6]]],
        ),
        (&hollow, vec![[0, 8], [8, 0]], vec![vec![[0, 8], [8, 0]]]),
        (&hollow, vec![[0, 4], [12, 4]], vec![vec![[0, 4], [12, 4]]]),
        (&hollow, vec![[5, 5], [4, 6], [5, 7]], vec![]),
        (
            &hollow,
            vec![[5, 3], [6, 4], [7, 3]],
            vec![vec![[5, 3], [6, 4], [7, 3]]],
        ),
        // Along the outer side, and from it on both sides.
        (&hollow, vec![[-5, 0], [20, 0]], vec![vec![[0, 0], [12, 0]]]),
        (
            &hollow,
            vec![[3, -1], [3, 0], [5, 0], [5, 1]],
            vec![vec![[3, 0], [5, 0], [5, 1]]],
        ),
        (
            &hollow,
            vec![[13, -1], [-1, 13]],
            vec![vec![[12, 0], [8, 4]], vec![[4, 8], [0, 12]]],
        ),
        // Borders of polygons that overlap or touch cut nothing.
        (&both, vec![[-1, 1], [11, 1]], vec![vec![[0, 1], [10, 1]]]),
        (&both, vec![[6, -1], [6, 5]], vec![vec![[6, 0], [6, 4]]]),
        // Touching from outside, and beside.
        (&both, vec![[-1, 5], [1, 3]], vec![vec![[0, 4], [1, 3]]]),
        (&both, vec![[-1, 3], [1, 5]], vec![]),
        (&both, vec![[-4, 3], [-1, 3]], vec![]),
    ] {
        let expected = |turned: bool| {
            let mut lines: Vec<Vec<Point>> = expected
                .iter()
                .map(|spots: &Vec<Spot>| spots.iter().map(|&spot| point(spot)).collect())
                .collect();
            if turned {
                lines.iter_mut().for_each(|line| line.reverse());
                lines.reverse();
            }
            lines
        };
        for is_turned in [false, true] {
            let mut line = line.clone();
            if is_turned {
                line.reverse();
            }
            let found: Vec<_> = pieces(edges, &line).into_iter().map(|piece| piece.points).collect();
            assert_eq!(found, expected(is_turned), "{line:?}");
        }
    }
}

#[test]
fn closed_lines_stay_closed_if_nothing_cuts_them_and_else_begin_where_they_are_cut() {
    let mut hollow = square(0, 0, 12);
    hollow.extend(turned(square(4, 4, 4)));
    // Inside, round the hole, along both boundaries.
    for (from, size) in [(1, 2), (2, 8), (4, 4), (0, 12)] {
        let [piece] = &pieces(&hollow, &closed(&square(from, from, size)))[..] else {
            panic!("{from} {size}")
        };
        assert!(piece.is_closed && piece.points.len() == 5);
    }
    // It begins in the polygon, is cut by the hole, and its start is inside its second part.
    let found = pieces(&hollow, &closed(&square(2, 6, 4)));
    let expected = [[6, 8], [6, 10], [2, 10], [2, 6], [4, 6]].map(point);
    assert!(found.len() == 1 && !found[0].is_closed);
    assert_eq!(found[0].points, expected);
}

fn closed(edges: &[[Spot; 2]]) -> Vec<Spot> {
    let mut line: Vec<Spot> = edges.iter().map(|&[from, _]| from).collect();
    line.push(line[0]);
    line
}

/// Random lines and rings with small whole coordinates, so that most of what can degenerate does,
/// against fractions.
#[test]
fn the_pieces_are_those_between_all_crossings_as_fractions() {
    let mut state = 1u64;
    let mut below = |limit: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        ((state >> 33) % limit) as i64
    };
    let mut counts = [0; 4];
    for round in 0..6000 {
        let side = 3 + round % 6;
        let mut spots = |count: i64| {
            let mut spots: Vec<Spot> = (0..count).map(|_| [0; 2].map(|_: i64| below(side))).collect();
            spots.dedup();
            spots
        };
        let edges: Vec<_> = (0..1 + round as i64 % 3).flat_map(|_| ring(&spots(4))).collect();
        let mut line = spots(5);
        if round % 2 == 0 {
            line.push(line[0]);
            line.dedup();
        }
        if line.len() < 2 {
            continue;
        }
        let (found, expected) = (pieces(&edges, &line), by_fractions(edges.clone(), &line));
        counts[found.len().min(2)] += 1;
        counts[3] += usize::from(found.iter().any(|piece| piece.is_closed));
        let same = found.len() == expected.len()
            && found.iter().zip(&expected).all(|(found, (points, is_closed))| {
                let close = |(p, [x, y]): (&Point, &[f64; 2])| (p.x - x).abs() < 1e-12 && (p.y - y).abs() < 1e-12;
                let all_close = found.points.len() == points.len() && found.points.iter().zip(points).all(close);
                all_close && found.is_closed == *is_closed
            });
        assert!(same, "{edges:?} {line:?}: {found:?}, not {expected:?}");
    }
    assert!(
        counts[..3].iter().all(|&count| count > 1000) && counts[3] > 10,
        "{counts:?}"
    );
}

/// Returns the pieces of a line, and whether each is closed.
fn by_fractions(mut edges: Vec<[Spot; 2]>, line: &[Spot]) -> Vec<(Vec<[f64; 2]>, bool)> {
    edges.retain(|[a, b]| a != b);
    // Opposite edges cancel out.
    while let Some((i, j)) =
        (0..edges.len()).find_map(|i| edges.iter().position(|&[a, b]| [b, a] == edges[i]).map(|j| (i, j)))
    {
        edges.remove(i.max(j));
        edges.remove(i.min(j));
    }
    let mut pieces: Vec<Vec<[f64; 2]>> = Vec::new();
    let (mut is_open, mut is_cut, mut begins_covered) = (false, false, false);
    for ends in line.windows(2) {
        let (p, q) = (ends[0], ends[1]);
        let at = |[n, d]: Fraction| [0, 1].map(|i| p[i] as f64 + (q[i] - p[i]) as f64 * n as f64 / d as f64);
        let all = shares([p, q], &edges);
        let mut covered: Vec<(Fraction, Fraction, bool)> = Vec::new();
        for pair in all.windows(2) {
            let ([n, d], [m, e]) = (pair[0], pair[1]);
            let (middle, scale) = (n * e + m * d, 2 * d * e);
            let spot = [0, 1].map(|i| p[i] * scale + (q[i] - p[i]) * middle);
            let is_covered = covers(&edges, spot, scale);
            match covered.last_mut() {
                Some((_, end, before)) if *before == is_covered => *end = pair[1],
                _ => covered.push((pair[0], pair[1], is_covered)),
            }
        }
        for (from, to, is_covered) in covered {
            begins_covered |= is_covered && pieces.is_empty() && !is_cut;
            match is_covered {
                true if is_open => pieces.last_mut().unwrap().push(at(to)),
                true => pieces.push(vec![at(from), at(to)]),
                false => is_cut = true,
            }
            is_open = is_covered;
        }
    }
    let is_closed = line.first() == line.last();
    // The part from the start comes last, behind that to the start if there is one.
    if is_closed && is_cut && begins_covered {
        let first = pieces.remove(0);
        match pieces.last_mut() {
            Some(last) if is_open => last.extend_from_slice(&first[1..]),
            _ => pieces.push(first),
        }
    }
    let whole = is_closed && !is_cut;
    pieces.into_iter().map(|piece| (piece, whole)).collect()
}

fn cross(a: Spot, b: Spot, c: Spot) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Returns 0, 1 and what is between them where edges meet the line through a segment, in order.
fn shares([p, q]: [Spot; 2], edges: &[[Spot; 2]]) -> Vec<Fraction> {
    let mut shares = vec![[0, 1], [1, 1]];
    let length = (0..2).map(|i| (q[i] - p[i]).pow(2)).sum::<i64>();
    for &[a, b] in edges {
        let [of_p, of_q] = [cross(a, b, p), cross(a, b, q)];
        if of_p != of_q {
            let sign = (of_p - of_q).signum();
            shares.push([of_p * sign, (of_p - of_q) * sign]);
        } else if of_p == 0 {
            shares.extend([a, b].map(|end| [(0..2).map(|i| (end[i] - p[i]) * (q[i] - p[i])).sum(), length]));
        }
    }
    shares.retain(|&[n, d]| (0..=d).contains(&n));
    shares.sort_by(|[n, d], [m, e]| (n * e).cmp(&(m * d)));
    shares.dedup_by(|[n, d], [m, e]| *n * *e == *m * *d);
    shares
}

/// Returns whether a point with coordinates in units of `1 / scale` is in polygons or on an edge.
fn covers(edges: &[[Spot; 2]], spot: Spot, scale: i64) -> bool {
    let mut winding = 0;
    for ends in edges {
        let [a, b] = ends.map(|end| end.map(|v| v * scale));
        let side = cross(a, b, spot);
        let is_within = |i: usize| (a[i].min(b[i])..=a[i].max(b[i])).contains(&spot[i]);
        if side == 0 && is_within(0) && is_within(1) {
            return true;
        }
        winding += i64::from(a[1] <= spot[1] && spot[1] < b[1] && side > 0);
        winding -= i64::from(b[1] <= spot[1] && spot[1] < a[1] && side < 0);
    }
    winding > 0
}
