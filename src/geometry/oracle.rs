//! Slow and obvious exact arithmetic, which the tests of this module compare with.

use std::cmp::Ordering;
use std::ops::{Add, Mul, Sub};

use num_bigint::{BigInt, Sign};

use crate::geometry::point::{Point, Rect};

/// An integer times a power of two. Every finite `f64` has this form, and so do sums and products
/// of such numbers.
#[derive(Clone, Debug)]
pub(super) struct Exact {
    integer: BigInt,
    exponent: i64,
}

impl From<f64> for Exact {
    fn from(v: f64) -> Self {
        assert!(v.is_finite());
        let bits = v.to_bits();
        let biased = i64::try_from((bits >> 52) & 0x7ff).unwrap();
        let fraction = bits & ((1 << 52) - 1);
        let significand = if biased == 0 { fraction } else { fraction | 1 << 52 };
        let sign = if v < 0.0 { Sign::Minus } else { Sign::Plus };
        Self {
            integer: BigInt::from(significand) * BigInt::from_biguint(sign, 1u8.into()),
            exponent: biased.max(1) - 1075,
        }
    }
}

impl Exact {
    fn aligned(&self, other: &Self) -> (BigInt, BigInt, i64) {
        let exponent = self.exponent.min(other.exponent);
        let at = |v: &Self| &v.integer << u64::try_from(v.exponent - exponent).unwrap();
        (at(self), at(other), exponent)
    }

    pub(super) fn sign(&self) -> Ordering {
        match self.integer.sign() {
            Sign::Minus => Ordering::Less,
            Sign::NoSign => Ordering::Equal,
            Sign::Plus => Ordering::Greater,
        }
    }

    pub(super) fn sign_of_difference(&self, other: &Self) -> Ordering {
        (self - other).sign()
    }
}

impl Add for &Exact {
    type Output = Exact;

    fn add(self, other: &Exact) -> Exact {
        let (a, b, exponent) = self.aligned(other);
        Exact {
            integer: a + b,
            exponent,
        }
    }
}

impl Sub for &Exact {
    type Output = Exact;

    fn sub(self, other: &Exact) -> Exact {
        let (a, b, exponent) = self.aligned(other);
        Exact {
            integer: a - b,
            exponent,
        }
    }
}

impl Mul for &Exact {
    type Output = Exact;

    fn mul(self, other: &Exact) -> Exact {
        Exact {
            integer: &self.integer * &other.integer,
            exponent: self.exponent + other.exponent,
        }
    }
}

/// Returns the vector from `origin` to `p`.
fn vector(origin: Point, p: Point) -> [Exact; 2] {
    let difference = |to: f64, from: f64| &Exact::from(to) - &Exact::from(from);
    [difference(p.x, origin.x), difference(p.y, origin.y)]
}

fn cross([ux, uy]: &[Exact; 2], [vx, vy]: &[Exact; 2]) -> Exact {
    &(ux * vy) - &(uy * vx)
}

fn square([ux, uy]: &[Exact; 2]) -> Exact {
    &(ux * ux) + &(uy * uy)
}

/// Returns the sign of the orientation determinant.
pub(super) fn orient2d(a: Point, b: Point, c: Point) -> Ordering {
    cross(&vector(a, b), &vector(a, c)).sign()
}

/// Returns the sign of the cross product of the vectors ab and cd.
pub(super) fn turn([a, b]: [Point; 2], [c, d]: [Point; 2]) -> Ordering {
    cross(&vector(a, b), &vector(c, d)).sign()
}

/// Returns the sign of the incircle determinant in the textbook form, expanded along its column of
/// squares.
pub(super) fn incircle(a: Point, b: Point, c: Point, d: Point) -> Ordering {
    let [a, b, c] = [a, b, c].map(|p| vector(d, p));
    let by_a = &square(&a) * &cross(&b, &c);
    let by_b = &square(&b) * &cross(&c, &a);
    let by_c = &square(&c) * &cross(&a, &b);
    (&(&by_a + &by_b) + &by_c).sign()
}

/// Returns whether the closed circumdisc of the counter-clockwise triangle lies in the open
/// rectangle.
///
/// With `a` as the origin, the centre is (x, y) / d and the squared radius q / d². So the disc is
/// left of a line at distance g if and only if g·d - x > 0 and (g·d - x)² > q.
pub(super) fn disc_strictly_inside(a: Point, b: Point, c: Point, cell: Rect) -> bool {
    let (u, v, w) = (vector(a, b), vector(a, c), vector(b, c));
    let (uu, vv) = (square(&u), square(&v));
    let two = Exact::from(2.0);
    let d = &two * &cross(&u, &v);
    assert_eq!(d.sign(), Ordering::Greater, "the triangle must be counter-clockwise");
    let x = &(&v[1] * &uu) - &(&u[1] * &vv);
    let y = &(&u[0] * &vv) - &(&v[0] * &uu);
    let q = &(&uu * &vv) * &square(&w);
    let clear = |side: f64, from: f64, centre: &Exact, sign: f64| {
        if side.is_infinite() {
            return side * sign > 0.0;
        }
        let sign = Exact::from(sign);
        let gap = &(&Exact::from(side) - &Exact::from(from)) * &d;
        let room = &(&gap - centre) * &sign;
        room.sign() == Ordering::Greater && (&room * &room).sign_of_difference(&q) == Ordering::Greater
    };
    clear(cell.max_x, a.x, &x, 1.0)
        && clear(cell.min_x, a.x, &x, -1.0)
        && clear(cell.max_y, a.y, &y, 1.0)
        && clear(cell.min_y, a.y, &y, -1.0)
}
