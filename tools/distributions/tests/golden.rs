//! The same arguments give the same bits, on every platform and with every later version.
//!
//! If a digest changes here, published measurements and other people's test cases change with it: add a kind instead.

use distributions::{Kind, LongSegments, Pslg, points, points3};

/// FNV-1a over 64-bit words.
fn digest(words: impl IntoIterator<Item = u64>) -> u64 {
    words.into_iter().fold(0xcbf2_9ce4_8422_2325, |hash, word| {
        (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

fn digest_of<const D: usize>(points: impl Iterator<Item = [f64; D]>) -> u64 {
    digest(points.flatten().map(f64::to_bits))
}

#[test]
fn first_points() {
    let first = |kind| points(kind, 1000, 1).next().unwrap();
    assert_eq!(first(Kind::Uniform), [0.0; 2]);
    assert_eq!(first(Kind::Kuzmin), [0.0; 2]);
    assert_eq!(first(Kind::LineSingularity), [0.0; 2]);
    assert_eq!(first(Kind::Grid), [0.0; 2]);
    assert_eq!(first(Kind::Circle), [0.0; 2]);
    assert_eq!(points3(Kind::Lidar, 1000, 1).next().unwrap(), [0.0; 3]);
}

#[test]
fn digests_of_points() {
    let digests = Kind::ALL.map(|kind| (kind, digest_of(points3(kind, 2000, 42))));
    assert_eq!(digests.to_vec(), vec![]);
}

#[test]
fn digest_of_many_points_on_a_circle() {
    assert_eq!(digest_of(points(Kind::Circle, 400_000, 42).take(2000)), 0);
}

#[test]
fn digests_of_pslgs() {
    for (kind, expected) in [
        (Kind::Uniform, [0, 0]),
        (Kind::Kuzmin, [0, 0]),
        (Kind::LineSingularity, [0, 0]),
    ] {
        let pslg = Pslg::new(kind, 2000, 0.5, 42).unwrap();
        let segments = digest(pslg.segments().flatten().map(u64::from));
        assert_eq!([digest_of(pslg.points()), segments], expected, "{kind}");
    }
}

#[test]
fn digests_of_long_segments() {
    let long = LongSegments::new(1000, 500, 42).unwrap();
    assert_eq!(digest_of(long.points()), 0);
    assert_eq!(digest(long.segments().flatten().map(u64::from)), 0);
}
