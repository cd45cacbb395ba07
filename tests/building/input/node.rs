//! The `.node` files of Triangle and TetGen.

use crate::input::{assert_says, file, skipping};
use delaunay_tiles::input::InputOptions;

#[test]
fn indices_may_start_at_zero_or_one() {
    for text in [
        "# points\n3 2 0 0\n0 1 2\n1 3 4 # here\n\n2 5 6\n",
        "3  2  0  1\n1  1 2  0\n  2  3 4  1\r\n3  5 6  0\n# made by hand",
        "3 2\n1 1 2\n2 3 4\n3 5 6",
    ] {
        let read = file("a.node", text, &InputOptions::default()).unwrap();
        assert_eq!(read.points, [(1.0, 2.0), (3.0, 4.0), (5.0, 6.0)], "{text:?}");
        assert_eq!(read.records, [0, 1, 2]);
        assert!(!read.source.has_z() && read.source.notes().is_empty());
    }
}

#[test]
fn a_node_file_gives_z_and_ignores_attributes() {
    let read = file("a.node", "1 2 2 0\n1 1 2 8 9\n", &InputOptions::default()).unwrap();
    assert_eq!(read.points, [(1.0, 2.0)]);
    assert!(read.source.notes()[0].contains("a.node: 2 attributes per point are not read"));
    let solid = file("a.node", "1 3 0 0\n0 1 2 3\n", &InputOptions::default()).unwrap();
    assert_eq!(solid.z, [3.0]);
    assert_eq!(
        file("a.node", "0 2 0 0\n", &InputOptions::default()).unwrap().points,
        []
    );
}

#[test]
fn a_wrong_first_line_is_quoted_in_the_error() {
    for (text, found) in [
        ("", "nothing"),
        ("# none\n", "nothing"),
        ("5\n", "`5`"),
        ("5 4 0 0\n", "`5 4 0 0`"),
        ("-5 2 0 0\n", "`-5 2 0 0`"),
        ("3 2 x\n", "`3 2 x`"),
        ("1e3 2\n", "`1e3 2`"),
    ] {
        let found = format!("the first line is {found}; the first line is: number of points");
        assert_says(file("a.node", text, &InputOptions::default()), &["a.node: ", &found]);
    }
}

#[test]
fn false_counts_and_indices_are_refused_with_their_line() {
    let default = InputOptions::default();
    assert_says(
        file("a.node", "18446744073709551615 2 0 0\n0 1 2\n1 3 4\n", &default),
        &["line 4: the file ends after 2 of 18446744073709551615 points; it is cut short"],
    );
    assert_says(
        file("a.node", "1 2 0 0\n0 1 2\n1 3 4\n", &skipping()),
        &["line 3: a row after the last of 1 points: `1 3 4`"],
    );
    assert_says(
        file("a.node", "2 2\n1 1 2\n3 3 4\n", &default),
        &["line 3: the index is not 2: `3 3 4`"],
    );
    assert_says(
        file("a.node", "2 2\n7 1 2\n", &default),
        &["line 2: the first point's index is neither 0 nor 1"],
    );
    assert_says(
        file("a.node", "2 2\nx 1 2\n", &default),
        &["line 2: the first point's index is neither 0 nor 1"],
    );
}

#[test]
fn a_broken_row_is_refused_or_skipped() {
    let text = "4 2 0 0\n1 1 2\n2 1 up\n3 1\n4 inf 4\n";
    assert_says(
        file("a.node", text, &InputOptions::default()),
        &[
            "record 1 (line 3): `2 1 up` is not an index and 2 numbers",
            "`skip_invalid`",
        ],
    );
    let read = file("a.node", text, &skipping()).unwrap();
    assert_eq!((read.points.len(), read.source.counts().invalid), (1, 3));
}
