//! Segments joined to lines.

use std::collections::HashMap;

use crate::map_tiles::window::Unit;

/// Joins segments at positions where two of them end. The order of the segments does not matter;
/// each must be there once.
pub(super) fn chains(mut segments: Vec<[Unit; 2]>) -> Vec<Vec<Unit>> {
    segments.sort_unstable();
    let mut at: HashMap<Unit, Vec<usize>> = HashMap::with_capacity(segments.len());
    for (number, ends) in segments.iter().enumerate() {
        for end in ends {
            at.entry(*end).or_default().push(number);
        }
    }
    let mut is_used = vec![false; segments.len()];
    let mut lines = Vec::new();
    let follow = |start: Unit, number: usize, is_used: &mut Vec<bool>| {
        let (mut line, mut end, mut next) = (vec![start], start, Some(number));
        while let Some(number) = next {
            is_used[number] = true;
            let [a, b] = segments[number];
            end = if a == end { b } else { a };
            line.push(end);
            next = match &at[&end][..] {
                &[one, other] => [one, other].into_iter().find(|&number| !is_used[number]),
                _ => None,
            };
        }
        line
    };
    // First lines with ends, then rings.
    for is_ring in [false, true] {
        for (number, &ends) in segments.iter().enumerate() {
            for end in ends {
                if !is_used[number] && (is_ring || at[&end].len() != 2) {
                    lines.push(follow(end, number, &mut is_used));
                }
            }
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_where_others_begin_and_rings_close() {
        let [a, b, c, d, e] = [[0, 0], [1, 0], [2, 0], [2, 1], [2, -1]];
        let [p, q, r] = [[9, 0], [9, 1], [8, 0]];
        let segments = vec![[b, a], [b, c], [c, d], [e, c], [p, q], [q, r], [r, p]];
        let mut lines = chains(segments.clone());
        let reversed = segments.into_iter().rev().collect();
        assert_eq!(lines, chains(reversed));
        assert_eq!(lines.len(), 4);
        assert!(lines.contains(&vec![a, b, c]));
        let ring = lines.pop().unwrap();
        assert!(ring.len() == 4 && ring[0] == ring[3]);
    }
}
