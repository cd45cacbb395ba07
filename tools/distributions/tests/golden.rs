//! The same arguments give the same bits, on every platform and in every later version.
//!
//! If a digest changes here, published measurements and other people's test cases change with it.
//! Add a kind instead.

use distributions::{Kind, LongSegments, Map, MapKind, Pslg, points, points3};

/// FNV-1a over 64-bit words, with a rotation because integers as f64 differ in their upper bits
/// only.
fn digest(words: impl IntoIterator<Item = u64>) -> u64 {
    let step = |hash: u64, word: u64| (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(29);
    words.into_iter().fold(0xcbf2_9ce4_8422_2325, step)
}

fn digest_of<const D: usize>(points: impl Iterator<Item = [f64; D]>) -> u64 {
    digest(points.flatten().map(f64::to_bits))
}

#[test]
fn first_points_never_change() {
    let first = |kind| points(kind, 1000, 1).next().unwrap();
    assert_eq!(first(Kind::Uniform), [0.381489413238261, 0.2949273257816749]);
    assert_eq!(first(Kind::Kuzmin), [-0.3538824853190135, 1.2201508259321943]);
    assert_eq!(first(Kind::LineSingularity), [0.025794834344706787, 0.2949273257816749]);
    assert_eq!(first(Kind::Grid), [15.0, 26.0]);
    assert_eq!(first(Kind::Circle), [31024577.0, 37424964.0]);
    assert_eq!(
        points3(Kind::Lidar, 1000, 1).next().unwrap(),
        [600000.04, 4900000.05, 335.74]
    );
}

#[test]
fn digests_of_points_never_change() {
    let expected = [
        (Kind::Uniform, 0x02c6_b552_2be5_df96),
        (Kind::Kuzmin, 0x3b8b_d117_d834_df96),
        (Kind::LineSingularity, 0x6961_9511_cf87_81ed),
        (Kind::Grid, 0x7c00_f6ce_eeef_3d23),
        (Kind::Lidar, 0x88a9_d79c_646b_8c81),
        (Kind::Circle, 0x753e_8277_a5c5_1f17),
        (Kind::Parabola, 0xaa1f_210a_45cf_4996),
        (Kind::Line, 0xc89c_fed0_737c_1014),
        (Kind::FourLines, 0x0b53_7926_e518_385c),
        (Kind::Clusters, 0xae5e_af3c_b355_3134),
        (Kind::Duplicates, 0xe0a2_b4dc_6445_aa5d),
        (Kind::Contours, 0xe546_6778_e0c9_8872),
        (Kind::Streets, 0xdbd2_8bc4_07f7_86c9),
        (Kind::Tracks, 0x38b9_3fe3_6b6c_c447),
        (Kind::Offset, 0x7acb_31a3_712e_2e06),
        (Kind::NearlyCollinear, 0x0ced_452e_5912_b2ad),
    ];
    assert_eq!(expected.map(|(kind, _)| kind), Kind::ALL);
    for (kind, expected) in expected {
        assert_eq!(digest_of(points3(kind, 2000, 42)), expected, "{kind}");
    }
}

#[test]
fn the_digest_of_many_points_on_a_circle_never_changes() {
    assert_eq!(
        digest_of(points(Kind::Circle, 400_000, 42).take(2000)),
        0xa937_4620_4dd1_9981
    );
}

#[test]
fn digests_of_pslgs_never_change() {
    for (kind, expected) in [
        (Kind::Uniform, [0x8b3e_a3d6_4351_4d4d, 0xe6f9_6df1_2f5c_46af]),
        (Kind::Kuzmin, [0x6543_bd66_7171_4e39, 0xe6f9_6df1_2f5c_46af]),
        (Kind::LineSingularity, [0xf49b_93ed_1c12_2e00, 0xe6f9_6df1_2f5c_46af]),
    ] {
        let pslg = Pslg::new(kind, 2000, 0.5, 42).unwrap();
        let segments = digest(pslg.segments().flatten().map(u64::from));
        assert_eq!([digest_of(pslg.points()), segments], expected, "{kind}");
    }
}

#[test]
fn digests_of_long_segments_never_change() {
    let long = LongSegments::new(1000, 500, 42).unwrap();
    assert_eq!(digest_of(long.points()), 0x972c_e915_84bb_cf7e);
    assert_eq!(digest(long.segments().flatten().map(u64::from)), 0x7fd2_3514_7e9d_e43c);
}

#[test]
fn digests_of_maps_never_change() {
    for (kind, expected) in [
        (MapKind::City, [7_593_682_169_711_008_344, 6_749_845_274_438_895_259]),
        (MapKind::Parks, [12_758_643_345_187_268_952, 10_735_119_998_054_322_937]),
    ] {
        let map = Map::new(kind, 500, 42);
        let corners = digest_of(map.obstacles().flatten());
        assert_eq!([corners, digest_of(map.sites(500))], expected, "{kind:?}");
    }
}
