//! Holes of polygons.

use super::shape::{Shape, ShapeRing};

/// Adds holes to the disjoint shapes in which they lie. Each hole lies in one shape.
pub(super) fn cut_out(shapes: &mut [Shape], holes: impl Iterator<Item = ShapeRing>) {
    let bounds: Vec<Bounds> = shapes.iter().map(|shape| Bounds::of(shape)).collect();
    for hole in holes {
        let Some(&at) = hole.first() else { continue };
        let mut around = (0..shapes.len()).filter(|&shape| bounds[shape].contain(at)).peekable();
        while let Some(shape) = around.next() {
            // If there is no other one, it is this one.
            if around.peek().is_none() || is_in(&shapes[shape], at) {
                shapes[shape].push(hole);
                break;
            }
        }
    }
}

/// The bounds of a shape.
struct Bounds {
    least: [f64; 2],
    greatest: [f64; 2],
}

impl Bounds {
    fn of(shape: &[ShapeRing]) -> Self {
        let mut this = Self {
            least: [f64::INFINITY; 2],
            greatest: [f64::NEG_INFINITY; 2],
        };
        for point in shape.first().into_iter().flatten() {
            for (axis, &x) in point.iter().enumerate() {
                this.least[axis] = this.least[axis].min(x);
                this.greatest[axis] = this.greatest[axis].max(x);
            }
        }
        this
    }

    fn contain(&self, at: [f64; 2]) -> bool {
        (0..2).all(|axis| self.least[axis] <= at[axis] && at[axis] <= self.greatest[axis])
    }
}

/// Returns whether a point is in a shape: a ray to the right crosses its edges an odd number of
/// times.
fn is_in(shape: &[ShapeRing], [x, y]: [f64; 2]) -> bool {
    let edges = shape
        .iter()
        .flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)));
    let crossed =
        edges.filter(|&(&[ax, ay], &[bx, by])| (ay <= y) != (by <= y) && x < ax + (y - ay) / (by - ay) * (bx - ax));
    crossed.count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(at: [f64; 2], size: f64) -> ShapeRing {
        let corners = [[0.0, 0.0], [size, 0.0], [size, size], [0.0, size]];
        corners.map(|[x, y]| [at[0] + x, at[1] + y]).to_vec()
    }

    #[test]
    fn holes_go_to_the_shapes_around_them() {
        let hole = |x| square([x, x], 0.5).into_iter().rev().collect::<ShapeRing>();
        // One shape lies in the hole of another one.
        let outer = vec![square([0.0, 0.0], 10.0), square([3.0, 3.0], 4.0)];
        let inner = vec![square([4.0, 4.0], 2.0)];
        for (mut shapes, [first, second]) in [([outer.clone(), inner.clone()], [0, 1]), ([inner, outer], [1, 0])] {
            cut_out(&mut shapes, [hole(1.0), hole(5.0), hole(8.0)].into_iter());
            assert_eq!(shapes[first][2..], [hole(1.0), hole(8.0)]);
            assert_eq!(shapes[second][1..], [hole(5.0)]);
        }
        cut_out(&mut [], [hole(1.0)].into_iter());
    }
}
