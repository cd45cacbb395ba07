//! Polygons as rings of coordinates.

use delaunay_tiles::geometry::Point;

/// A polygon as rings of coordinates, for crate i_overlay.
pub(super) type Shape = Vec<ShapeRing>;
pub(super) type ShapeRing = Vec<[f64; 2]>;

/// Returns the area of a ring, negative if it is clockwise. `near` is a point near the ring, because
/// products of large coordinates are rounded more.
pub(super) fn signed_area(ring: &[[f64; 2]], near: Point) -> f64 {
    let next = ring.iter().cycle().skip(1);
    let doubled = ring.iter().zip(next).map(|([ax, ay], [bx, by])| {
        let ([ax, bx], [ay, by]) = ([ax, bx].map(|x| x - near.x), [ay, by].map(|y| y - near.y));
        ax * by - bx * ay
    });
    0.5 * doubled.sum::<f64>()
}

/// Returns a ring without the points that are at most `slack` away from the line between their
/// neighbours.
pub(super) fn straightened(ring: &[[f64; 2]], slack: f64) -> ShapeRing {
    let is_straight = |[ax, ay]: [f64; 2], [bx, by]: [f64; 2], [cx, cy]: [f64; 2]| {
        let (dx, dy) = (cx - ax, cy - ay);
        let off = (dx * (by - ay) - dy * (bx - ax)).abs();
        let along = dx * (bx - ax) + dy * (by - ay);
        let square = dx * dx + dy * dy;
        off <= slack * square.sqrt() && (0.0..=square).contains(&along)
    };
    let mut kept = ShapeRing::new();
    for &point in ring {
        while let [.., before, last] = kept[..]
            && is_straight(before, last, point)
        {
            kept.pop();
        }
        kept.push(point);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_area_of_rings_far_from_the_origin_is_exact() {
        let [x, y] = [4_500_123.25, 5_400_321.75];
        let ring = [[0.0, 0.0], [0.5, 0.0], [0.5, 0.25], [0.0, 0.25]].map(|[u, v]| [x + u, y + v]);
        assert_eq!(signed_area(&ring, Point::new(x, y)), 0.125);
        let reversed: Vec<_> = ring.into_iter().rev().collect();
        assert_eq!(signed_area(&reversed, Point::new(x, y)), -0.125);
        assert_eq!(signed_area(&[], Point::new(x, y)), 0.0);
    }

    #[test]
    fn points_on_straight_lines_are_removed() {
        let ring = [
            [0.0, 0.0],
            [1.0, 1e-10],
            [2.0, 0.0],
            [3.0, 0.0],
            [3.0, 1.0],
            [3.0, 0.5],
            [0.0, 0.5],
        ];
        let kept = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [3.0, 0.5], [0.0, 0.5]];
        assert_eq!(straightened(&ring, 1e-8), kept);
        assert_eq!(straightened(&ring[..2], 1e-8), ring[..2]);
    }
}
