//! The points of a contour: merging of equal ones, and where a closed contour begins.

use std::cmp::Ordering;

use crate::geometry::Point;

/// Appends a point to a contour, unless it is the last one already.
pub(crate) fn push(points: &mut Vec<Point>, point: Point) {
    if points.last() != Some(&point) {
        points.push(point);
    }
}

/// Makes a contour complete: a closed one begins and ends with its lexicographically smallest point.
/// If it has that point several times, the following points decide. No two consecutive points of
/// `points` are equal. Returns whether the contour is longer than a point.
pub(crate) fn complete(points: &mut Vec<Point>, is_closed: bool) -> bool {
    if is_closed {
        while points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        let start = least_rotation(points);
        points.rotate_left(start);
        // Not twice the room, as `push` would take.
        points.reserve_exact(1);
        points.extend_from_within(..points.len().min(1));
    }
    points.len() > usize::from(is_closed) + 1
}

/// Returns how far a cyclic sequence must be rotated to be the least of its rotations.
fn least_rotation(points: &[Point]) -> usize {
    let count = points.len();
    // Two candidates, which agree on `length` points.
    let (mut first, mut second, mut length) = (0, 1, 0);
    while first < count && second < count && length < count {
        let at = |start: usize| points[(start + length) % count];
        // No rotation that starts before the next point of the larger candidate is the least.
        match at(first).lex_cmp(at(second)) {
            Ordering::Equal => length += 1,
            Ordering::Less => (second, length) = (second + length + 1, 0),
            Ordering::Greater => (first, length) = (first + length + 1, 0),
        }
        if first == second {
            second += 1;
        }
    }
    first.min(second)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(numbers: &[u8]) -> Vec<Point> {
        numbers
            .iter()
            .map(|&n| Point::new(f64::from(n / 4), f64::from(n % 4)))
            .collect()
    }

    /// All short sequences, against the least of all rotations.
    #[test]
    fn closed_contours_begin_at_the_least_rotation() {
        for count in 1..=7u32 {
            for code in 0..3u32.pow(count) {
                let numbers: Vec<u8> = (0..count).map(|i| (code / 3u32.pow(i) % 3) as u8).collect();
                let rotated = (0..numbers.len()).map(|by| [&numbers[by..], &numbers[..by]].concat());
                let sequence = points(&numbers);
                let by = least_rotation(&sequence);
                let found = [&sequence[by..], &sequence[..by]].concat();
                assert_eq!(found, points(&rotated.min().unwrap()), "{numbers:?}");
            }
        }
    }

    #[test]
    fn complete_contours_have_no_equal_neighbours_and_are_longer_than_a_point() {
        let of = |numbers: &[u8], is_closed| {
            let mut chain = Vec::new();
            points(numbers).into_iter().for_each(|p| push(&mut chain, p));
            complete(&mut chain, is_closed).then_some(chain)
        };
        assert_eq!(of(&[3, 1, 1, 2, 3], true), Some(points(&[1, 2, 3, 1])));
        assert_eq!(of(&[3, 1, 1, 2, 3], false), Some(points(&[3, 1, 2, 3])));
        assert_eq!(of(&[2, 1, 1, 2], true), Some(points(&[1, 2, 1])));
        for is_closed in [false, true] {
            assert_eq!(of(&[2, 2, 2], is_closed), None);
            assert_eq!(of(&[], is_closed), None);
        }
    }
}
