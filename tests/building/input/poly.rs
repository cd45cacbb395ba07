//! The `.poly` files of Triangle: points by [`PointSource`], segments and holes by [`PolySource`].

use crate::input::{data, drain, message, shared};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::{InputError, InputOptions, PointSource, PolySource, SegmentBatch};
use std::fs;
use std::path::{Path, PathBuf};

type Read = (Vec<[u64; 2]>, Vec<Point>);

/// Reads the segments and the holes.
pub fn read(path: &Path) -> Result<Read, InputError> {
    let mut source = PolySource::open(path)?;
    let (mut batch, mut segments) = (SegmentBatch::default(), Vec::new());
    while source.next_batch(&mut batch)? {
        assert!((1..=8192).contains(&batch.records.len()));
        let first = segments.len() as u64;
        assert!(
            batch
                .lines
                .iter()
                .copied()
                .eq(first..first + batch.records.len() as u64)
        );
        assert!(batch.ends.is_empty() && batch.z.is_empty());
        assert!(
            batch
                .records
                .as_flattened()
                .iter()
                .all(|&record| record < source.points())
        );
        segments.extend_from_slice(&batch.records);
    }
    assert_eq!(source.segments(), segments.len() as u64);
    Ok((segments, source.holes()?))
}

fn points(path: &Path) -> Result<crate::input::Read, InputError> {
    PointSource::open(&[path.to_owned()], &InputOptions::default()).and_then(drain)
}

fn write(folder: &tempfile::TempDir, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    path
}

/// A square with a diagonal and two holes, numbered from 1.
const SQUARE: &str = "# a square\n4 2 1 1\n1 0 0 7 1\n 2 1 0 7 1 # here\n3 1 1 7 1\n4 0 1 7 1\n\n5 1\n1 1 2 1\n2 2 3 1\n3 3 4 1\n4 4 1 1\n\
                      9 1 3\n# holes\n2\n1 0.25 0.5\n2 0.75 -0.0\n";

#[test]
fn indices_may_start_at_zero_or_one() {
    let folder = tempfile::tempdir().unwrap();
    let from_one = SQUARE.to_owned();
    let from_zero =
        "4 2 0 0\n0 0 0\n1 1 0\n2 1 1\n3 0 1\n5 0\n0 0 1\n1 1 2\n2 2 3\n3 3 0\n4 0 2\n2\n0 .25 .5\n1 .75 0\n";
    for text in [
        from_one.clone(),
        from_zero.to_owned(),
        format!("{from_one}1\n1 0.5 0.5 3 0.1\n"),
        from_one + "0\n",
    ] {
        let path = write(&folder, "a.poly", &text);
        let found = points(&path).unwrap();
        assert_eq!(found.points, [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]);
        assert_eq!(found.records, [0, 1, 2, 3]);
        let (segments, holes) = read(&path).unwrap();
        assert_eq!(segments, [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2]]);
        assert_eq!(holes, [Point::new(0.25, 0.5), Point::new(0.75, 0.0)]);
        assert!(holes[1].y.is_sign_positive());
    }
}

#[test]
fn points_are_read_from_the_node_file_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(&folder, "a.poly", "0 2 0 0\n2 0\n1 1 2\n2 2 3\n0\n");
    let node = write(&folder, "a.node", "3 2 0 0\n1 5 6\n2 7 8\n3 9 1\n");
    let found = points(&path).unwrap();
    assert_eq!(found.points, [(5.0, 6.0), (7.0, 8.0), (9.0, 1.0)]);
    assert_eq!(found.source.sources(), [("a.node".to_owned(), 3)]);
    assert_eq!(read(&path).unwrap(), (vec![[0, 1], [1, 2]], Vec::new()));
    // A change of either file changes the identity.
    let identity = || {
        PointSource::open(std::slice::from_ref(&path), &InputOptions::default())
            .unwrap()
            .identity()
    };
    let before = identity().unwrap();
    assert_eq!(identity().unwrap(), before);
    fs::write(&node, "3 2 0 0\n0 5 6\n1 7 8\n2 9 12\n").unwrap();
    assert_ne!(identity().unwrap(), before);
    let before = identity().unwrap();
    assert!(
        read(&path)
            .unwrap_err()
            .to_string()
            .contains("there is no point 3; they are 0 to 2")
    );
    fs::write(&path, "0 2 0 0\n1 0\n1 1 2\n0\n").unwrap();
    assert_ne!(identity().unwrap(), before);
    // Record numbers continue over the other inputs.
    let first = write(&folder, "first.node", "1 2\n0 1 1\n");
    let both = PointSource::open(&[first, path.clone()], &InputOptions::default())
        .and_then(drain)
        .unwrap();
    assert_eq!(both.records, [0, 1, 2, 3]);
    assert_eq!(both.points[1..], [(5.0, 6.0), (7.0, 8.0), (9.0, 12.0)]);

    fs::remove_file(&node).unwrap();
    let words = [
        "a.poly: by its first line its points are in the .node file",
        "a.node cannot be opened",
        "put that file there",
    ];
    for error in [message(points(&path)), read(&path).unwrap_err().to_string()] {
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    }
    let options = crate::input::with_format(delaunay_tiles::input::Format::Poly);
    let stream = crate::input::stream("0 2 0 0\n0\n0\n", &options);
    assert!(message(stream).contains("a stream has none"));
    let odd = write(&folder, "odd.txt", "0 2 0 0\n0\n0\n");
    let odd = PointSource::open(&[odd], &options).and_then(drain);
    assert!(message(odd).contains("its name does not end in .poly"));
    let own = crate::input::stream(SQUARE, &options).unwrap();
    assert_eq!(own.points.len(), 4);
}

#[test]
fn gzipped_poly_and_node_files_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(&folder, "a.POLY.gz", crate::input::gzip(b"0 2 0 0\n1 0\n1 1 2\n0\n"));
    write(&folder, "a.node.gz", crate::input::gzip(b"2 2 0 0\n1 5 6\n2 7 8\n"));
    assert_eq!(points(&path).unwrap().points, [(5.0, 6.0), (7.0, 8.0)]);
    assert_eq!(read(&path).unwrap().0, [[0, 1]]);
}

/// The map of a game: 112 points and 112 segments, in closed rings, and a point in each of 5 holes.
#[test]
fn the_map_of_a_game_has_closed_rings_and_five_holes() {
    let path = data("arena/arena.poly");
    let found = points(&path).unwrap().points;
    assert_eq!(found.len(), 112);
    let (segments, holes) = read(&path).unwrap();
    assert_eq!((segments.len(), holes.len()), (112, 5));
    let mut degrees = vec![0; found.len()];
    for &[from, to] in &segments {
        degrees[from as usize] += 1;
        degrees[to as usize] += 1;
        let [(x1, y1), (x2, y2)] = [from, to].map(|record| found[record as usize]);
        assert!((x1, y1) != (x2, y2));
    }
    assert!(degrees.iter().all(|degree| degree % 2 == 0 && *degree > 0));
    assert_eq!(holes[0], Point::new(24.5, 9.0));
}

/// Islands with a hole point in each, if the data is beside the project.
#[test]
fn a_map_of_islands_has_all_points_segments_and_holes() {
    let Some(path) = shared("indonesia/group1_dense_small.poly") else {
        return;
    };
    assert_eq!(points(&path).unwrap().points.len(), 2477);
    let (segments, holes) = read(&path).unwrap();
    assert_eq!((segments.len(), holes.len()), (2477, 77));
}

#[test]
fn segments_over_several_batches_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let rows: String = (0..20_000)
        .map(|n| format!("{n} {} {}\n", n % 3, (n + 1) % 3))
        .collect();
    let path = write(&folder, "a.poly", format!("3 2\n0 0 0\n1 1 0\n2 0 1\n20000\n{rows}0\n"));
    let (segments, _) = read(&path).unwrap();
    assert!(segments.iter().copied().eq((0..20_000).map(|n| [n % 3, (n + 1) % 3])));
    // The holes can be read without the segments.
    assert_eq!(PolySource::open(&path).unwrap().holes().unwrap(), []);
}

#[test]
fn a_broken_poly_file_is_refused_with_its_line_and_reason() {
    let folder = tempfile::tempdir().unwrap();
    let start = "2 2 0 0\n1 0 0\n2 1 0\n";
    for (rest, parts) in [
        ("", &["line 4: the file ends before the number of segments"][..]),
        (
            "1 0\n",
            &["the file ends after 0 of 1 segments; the file is cut short, or one of its counts is wrong"],
        ),
        ("1 0\n1 1 2\n", &["the file ends before the number of holes"]),
        ("0 0\n1\n", &["the file ends after 0 of 1 holes"]),
        ("0\n0\n2\n1 0 0 0 0\n", &["the file ends after 1 of 2 regions"]),
        (
            "0\n0\n1\n1 0 0 0 0\n2 0 0 0 0\n",
            &["line 8: a row after the last of 1 regions: `2 0 0 0 0`"],
        ),
        (
            "3 1 1\n",
            &["line 4: expected the number of segments, found the row `3 1 1`"],
        ),
        (
            "1 0\n1 1 2\n2 2 1\n0\n",
            &["line 6: expected the number of holes, found the row `2 2 1`"],
        ),
        (
            "2 0\n1 1 2\n0\n",
            &["segment 1 (line 6): expected a number and the indices of two points, found the row `0`"],
        ),
        (
            "0 0\n1\n1 0 0\n2 0 0\n",
            &["line 7: expected the number of regions, found the row `2 0 0`"],
        ),
        ("-1 0\n", &["expected the number of segments, found the row `-1 0`"]),
        (
            "1 0\n1 0 2\n0\n",
            &["segment 0 (line 5): there is no point 0; they are 1 to 2"],
        ),
        (
            "1 0\n1 1 3\n0\n",
            &["segment 0 (line 5): there is no point 3; they are 1 to 2"],
        ),
        (
            "1 0\n1 1 18446744073709551615\n0\n",
            &["there is no point 18446744073709551615"],
        ),
        (
            "1 0\n1 1 -1\n0\n",
            &["the indices of two points, found the row `1 1 -1`"],
        ),
        ("1 0\n1 1.0 2\n0\n", &["the indices of two points, found the row"]),
        (
            "0\n1\n1 0\n",
            &["line 6: hole 0: expected a number, x and y, found the row `1 0`"],
        ),
        (
            "0\n2\n1 0 0\n2 nan 0\n",
            &["line 7: hole 1: x is NaN, not a finite number"],
        ),
        (
            "0\n18446744073709551615\n1 0 0\n",
            &["the file ends after 1 of 18446744073709551615 holes"],
        ),
        (
            "18446744073709551615\n1 1 2\n",
            &["the file ends after 1 of 18446744073709551615 segments"],
        ),
    ] {
        let path = write(&folder, "a.poly", format!("{start}{rest}"));
        assert_eq!(points(&path).unwrap().points.len(), 2, "the points are all there");
        let error = read(&path).unwrap_err().to_string();
        assert!(error.contains("a.poly: "), "{error}");
        for part in parts {
            assert!(error.contains(part), "`{part}` is not in: {error}");
        }
    }
    for (text, part) in [
        ("", "the first line is nothing"),
        (
            "2 3 0 0\n",
            "the first line is `2 3 0 0`: points with three coordinates; the dimension of a .poly file is 2",
        ),
        ("3 2 0 0\n1 0 0\n2 1 0\n1 0\n", "line 4: the index is not 3: `1 0`"),
        ("2 2 0 0\n1 0 0\n", "the file ends after 1 of 2 points"),
        ("2 2 0 0\n7 0 0\n", "the first point's index is neither 0 nor 1"),
        (
            "1 2\n0 0 up\n0\n0\n",
            "record 0 (line 2): `0 0 up` is not an index and 2 numbers",
        ),
    ] {
        let path = write(&folder, "a.poly", text);
        let error = message(points(&path));
        assert!(error.contains(part), "`{part}` is not in: {error}");
        // An error in a coordinate appears only when the points are read.
        assert!(read(&path).is_err() || part.starts_with("record"), "{text}");
    }
    let missing = PolySource::open(&folder.path().join("no.poly"))
        .map(|_| ())
        .unwrap_err();
    assert!(matches!(missing, InputError::Open { .. }), "{missing}");
    let no_file = PolySource::open(folder.path()).map(|_| ()).unwrap_err().to_string();
    assert!(no_file.contains("not a regular file"), "{no_file}");
}

/// After an error there are no more segments.
#[test]
fn an_error_ends_the_segments() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(&folder, "a.poly", "2 2\n0 0 0\n1 1 0\n3\n0 0 1\n1 0 7\n2 0 1\n0\n");
    let mut source = PolySource::open(&path).unwrap();
    let mut batch = SegmentBatch::default();
    assert!(source.next_batch(&mut batch).is_err());
    assert!(batch.is_empty());
    assert!(!source.next_batch(&mut batch).unwrap());
}
