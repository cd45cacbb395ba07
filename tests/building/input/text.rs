//! Rows of text: delimiters, headers, columns, quotes, broken rows.

use crate::input::{assert_says, file, gzip, skipping, stream};
use delaunay_tiles::input::{Columns, InputError, InputOptions};

const TWO: [(f64, f64); 2] = [(1.5, -2.0), (3.0, 4e2)];

fn columns(text: &str) -> InputOptions {
    InputOptions::default().columns(text.parse::<Columns>().unwrap())
}

#[test]
fn every_delimiter_gives_the_same_points() {
    for text in [
        "1.5,-2\n3,4e2\n",
        "1.5;-2\n3;4e2\n",
        "1.5\t-2\n3\t4e2\n",
        "1.5 -2\n3 4e2\n",
        "  1.5   -2\n\t3 \t 4e2  ",
        " 1.5 , -2 \r\n3\t,\t4e2\r\n",
        "\"1.5\",\"-2\"\n\"3\",\"4e2\"",
        "\u{feff}1.5,-2\n3,4e2\n",
        "# x, y\n\n1.5,-2\n   \n  # more\n3,4e2\n#",
        "+1.5,-2.\n3,.4e3\n",
    ] {
        let read = stream(text, &InputOptions::default()).unwrap();
        assert_eq!(read.points, TWO, "{text:?}");
        assert_eq!(read.records, [0, 1]);
        assert!(!read.source.has_z() && read.source.notes().is_empty(), "{text:?}");
    }
}

#[test]
fn headers_name_the_columns_of_x_y_and_z() {
    for text in [
        "x,y\n1.5,-2\n3,4e2\n",
        "Y;X\n-2;1.5\n4e2;3\n",
        "name\tLatitude\tLongitude\na b\t-2\t1.5\n\t4e2\t3\n",
        "id lng lat\n7 1.5 -2\n8 3 4e2\n",
        "\"Easting\",\"Northing\"\n1.5,-2\n3,4e2\n",
        "//X,Y\n1.5,-2\n3,4e2\n",
        "lat,lon,x,y\n0,0,1.5,-2\n0,0,3,4e2\n",
    ] {
        assert_eq!(stream(text, &InputOptions::default()).unwrap().points, TWO, "{text:?}");
    }
    let read = stream("elevation,e,n\n7,1.5,-2\n-0.0,3,4e2\n", &InputOptions::default()).unwrap();
    assert_eq!(read.points, TWO);
    assert_eq!(read.z, [7.0, 0.0]);
    assert!(read.z[1].is_sign_positive());
}

#[test]
fn without_a_header_the_third_column_is_z_in_xyz_files_and_rows_of_three_numbers() {
    let read = stream("1.5 -2 9\n3 4e2 8\n", &InputOptions::default()).unwrap();
    assert_eq!(read.z, [9.0, 8.0]);
    let xyz = file("a.XYZ", "1.5 -2 9 255 0\n3 4e2 8 0 0\n", &InputOptions::default()).unwrap();
    assert_eq!(xyz.z, [9.0, 8.0]);
    assert!(
        xyz.source.notes()[0]
            .ends_with("a.XYZ: no header; columns 1 to 3 of 5 are read, choose others with the option `columns`")
    );
    let csv = file("a.csv", "1.5,-2,9,255\n3,4e2,8,0\n", &InputOptions::default()).unwrap();
    assert!(!csv.source.has_z());
    assert!(csv.source.notes()[0].contains("columns 1 to 2 of 4 are read"));
    let named = file("a.csv", "1.5,-2,church\n3,4e2,mill\n", &InputOptions::default()).unwrap();
    assert_eq!(named.points, TWO);
    assert!(!named.source.has_z());
}

#[test]
fn chosen_columns_are_read() {
    let rows = "id,a,b,c\n0,1.5,-2,9\n1,3,4e2,8\n";
    for (chosen, z) in [("2,3", false), ("a,b", false), ("A,3,c", true), ("2,3,4", true)] {
        let read = stream(rows, &columns(chosen)).unwrap();
        assert_eq!(read.points, TWO, "{chosen}");
        assert_eq!(read.z, if z { &[9.0, 8.0][..] } else { &[] });
        assert_eq!(read.records, [0, 1]);
        assert_eq!(chosen.parse::<Columns>().unwrap().to_string(), chosen);
    }
    let read = stream("mill,1.5,-2\nchurch,3,4e2\n", &columns("2,3")).unwrap();
    assert_eq!(read.points, TWO);
    assert_says(
        stream(rows, &columns("a,d")),
        &[
            "line 1",
            "no column `d` in the header `id, a, b, c`",
            "option `columns`",
        ],
    );
    assert_says(stream(rows, &columns("2,9")), &["no column 9 in the header"]);
    assert_says(
        stream(rows, &InputOptions::default()),
        &["stream: line 1: ", "no column for x", "option `columns` (x,y"],
    );
    for bad in ["", "1", "0,1", "1,2,3,4", "x,", "99999999999999999999,1"] {
        let error = bad.parse::<Columns>().map(|c| c.to_string());
        if bad != "x," {
            assert!(error.unwrap_err().to_string().contains("invalid columns"), "{bad}");
        } else {
            assert!(error.is_err(), "{bad}");
        }
    }
}

#[test]
fn quoted_fields_may_contain_delimiters_quotes_and_line_breaks() {
    let text = "name,x,y\n\"a, b\",1.5,-2\n\"say \"\"no\"\",\nthen\n\n1,2,3\n\",\"3\",4e2\n5\" pipe,5,6\nlast,7,oops\n";
    let read = stream(text, &skipping()).unwrap();
    assert_eq!(read.points, [(1.5, -2.0), (3.0, 4e2), (5.0, 6.0)]);
    assert_eq!(read.source.counts().invalid, 1);
    assert_says(
        stream(text, &InputOptions::default()),
        &["record 3 (line 9): y is `oops`, not a number"],
    );
    let open = format!("x,y,name\n1,2,\"{}", "never closed\n".repeat(100_000));
    assert_says(
        stream(open, &InputOptions::default()),
        &["line 2: a row of more than 1048576 bytes"],
    );
}

#[test]
fn quotes_in_comments_are_ignored() {
    let text = "# \"so\n1.5 -2\n# \"it\n # \"is\n3 4e2\n";
    assert_eq!(stream(text, &InputOptions::default()).unwrap().points, TWO);
}

#[test]
fn a_broken_row_is_refused_or_skipped() {
    let default = InputOptions::default();
    let cases: [(&str, &[&str]); 9] = [
        (
            "x,y\n1,2\n\n1,abc\n",
            &[
                "stream: record 1 (line 4): y is `abc`, not a number; correct it, or skip",
                "`skip_invalid`",
            ],
        ),
        ("1,2\n3\n", &["record 1 (line 2): the row has 1 of 2 fields: `3`"]),
        ("1,2,5\n3,4\n", &["record 1 (line 2): the row has 2 of 3 fields: `3,4`"]),
        ("1,2\n3,\n", &["record 1 (line 2): y is ``, not a number"]),
        ("nan,2\n", &["record 0 (line 1): x is NaN, not a finite number"]),
        (
            "1,2,3\n1,2,inf\n",
            &["record 1 (line 2): z is inf, not a finite number"],
        ),
        ("1,1e300\n", &["y is 1e300, of greater magnitude than 2^200"]),
        ("1e-60,1\n", &["x is 1e-60, nearer to zero than 2^-142"]),
        (
            "x;y\n1,5;2,5\n",
            &["record 0 (line 2): x is `1,5`, not a number (a decimal comma? write decimal points)"],
        ),
    ];
    for (text, parts) in cases {
        assert_says(stream(text, &default), parts);
        let read = stream(text, &skipping()).unwrap();
        assert!(read.source.counts().invalid > 0, "{text:?}");
    }
}

#[test]
fn skipped_rows_keep_their_numbers() {
    let read = stream("x,y\n1,2\nx,y\n5,6\n,\n7,8", &skipping()).unwrap();
    assert_eq!(read.points, [(1.0, 2.0), (5.0, 6.0), (7.0, 8.0)]);
    assert_eq!(read.records, [0, 2, 4]);
    assert_eq!(read.source.counts().invalid, 2);
}

#[test]
fn files_without_rows_give_no_points() {
    for text in ["", "\n\n", "# nothing\n", "\u{feff}", "x,y\n", "x,y,z"] {
        assert_eq!(
            file("a.csv", text, &InputOptions::default()).unwrap().points,
            [],
            "{text:?}"
        );
    }
}

#[test]
fn gzip_is_recognized_by_name_and_by_content() {
    let members = [gzip(b"x,y\n1.5,-2\n"), gzip(b"3,4e2\n")].concat();
    for name in ["a.csv.gz", "a.CSV.GZ", "a.csv"] {
        assert_eq!(
            file(name, &members, &InputOptions::default()).unwrap().points,
            TWO,
            "{name}"
        );
    }
    assert_eq!(stream(&members, &InputOptions::default()).unwrap().points, TWO);
    let rows = "1.25,2.5\n".repeat(20_000);
    let mut cut = gzip(rows.as_bytes());
    assert_eq!(
        file("a.csv.gz", &cut, &InputOptions::default()).unwrap().points.len(),
        20_000
    );
    cut.truncate(cut.len() - 9);
    assert_says(
        file("a.csv.gz", &cut, &InputOptions::default()),
        &["a.csv.gz: byte 180000: reading failed"],
    );
}

#[test]
fn utf_16_and_overlong_rows_are_refused() {
    let default = InputOptions::default();
    assert_says(
        stream(b"\xff\xfex\0,\0y\0", &default),
        &["this is UTF-16; convert it to UTF-8"],
    );
    assert_says(
        stream(vec![b'7'; 3 << 20], &default),
        &["line 1: a row of more than 1048576 bytes"],
    );
    assert_says(
        stream([&b"1 2\n"[..], &[0; 2 << 20]].concat(), &default),
        &["line 2: a row of more than"],
    );
    assert_says(stream(b"\x00\x01\x02\n", &default), &["no column for x", r"\u{1}\u{2}"]);
}

#[test]
fn rows_across_buffer_ends_are_read_whole() {
    let mut text = String::from("x y z\n");
    for n in 0..200_000 {
        text.push_str(&format!("{n} {}.5 {}\n", n * 2, n % 7));
    }
    let read = stream(text, &InputOptions::default()).unwrap();
    assert_eq!(read.points.len(), 200_000);
    for (n, &(x, y)) in read.points.iter().enumerate() {
        assert_eq!((x, y, read.z[n]), (n as f64, n as f64 * 2.0 + 0.5, (n % 7) as f64));
    }
}

/// Returns 2 MB of rows of all kinds, with a comment or a blank line here and there.
fn many_rows(line_end: &str) -> String {
    let row = |n: u64| match n % 1000 {
        7 => format!("# {n}{line_end}{line_end}"),
        8 => format!(" {n} , {} ,0{line_end}", n * 7919 % 1009),
        _ => format!("{n},{}.25,{}{line_end}", n * 7919 % 1009, n % 13),
    };
    (0..120_000).map(row).collect()
}

/// Returns an error from the name of the file on.
fn without_folder(error: &InputError) -> String {
    let text = error.to_string();
    text.rsplit_once('/').unwrap().1.to_owned()
}

#[test]
fn rows_are_the_same_whatever_the_number_of_threads() {
    let plain = many_rows("\n");
    let quoted_late = format!("{plain}\"5\",\"6\",\"7\"\n\"1\n\",2,3\n{plain}");
    let long_row = format!("{plain}1,2,3{}\n{plain}", " ".repeat(1 << 20));
    let flawed = plain.replace(",7\n", ",seven\n");
    let inputs = [
        ("crlf.csv", many_rows("\r\n")),
        ("tabs.tsv", plain.replace(',', "\t")),
        ("blanks.txt", plain.replace(',', "  ")),
        ("header.csv", format!("x,y,z\n{plain}")),
        ("open.csv", plain.trim_end().to_owned()),
        ("long.csv", long_row),
        ("quoted.csv", quoted_late),
        ("flawed.csv", flawed),
        ("plain.csv", plain),
    ];
    for (name, text) in inputs {
        for skip_invalid in [false, true] {
            let read = |threads| {
                file(
                    name,
                    &text,
                    &InputOptions::default().threads(threads).skip_invalid(skip_invalid),
                )
            };
            let expected = read(1);
            for threads in [0, 2, 9] {
                match (&expected, read(threads)) {
                    (Ok(expected), Ok(read)) => {
                        assert!(expected.points.len() > 100_000);
                        assert!(read.points == expected.points && read.z == expected.z, "{name}");
                        assert_eq!(read.records, expected.records, "{name}");
                        assert_eq!(read.source.counts(), expected.source.counts(), "{name}");
                    }
                    (Err(expected), Err(error)) => assert_eq!(without_folder(&error), without_folder(expected)),
                    (expected, read) => panic!("{name}: {:?} and {:?}", expected.as_ref().err(), read.err()),
                }
            }
            let fails = !skip_invalid && name == "flawed.csv" || name == "long.csv";
            assert_eq!(expected.is_err(), fails, "{name}");
        }
    }
}
