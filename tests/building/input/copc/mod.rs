//! COPC by level and rectangle: what is read equals a filter of all points, and the rest of the
//! file is not read.

mod cloud;

use crate::input::copc::cloud::{CENTRE, Cloud, HALF, Placed, SPACING, entry, meets};
use crate::input::hostile::Random;
use crate::input::{Read, assert_says, data, drain, file, stream};
use crate::support::cases::cases;
use delaunay_tiles::geometry::Rect;
use delaunay_tiles::input::{InputError, InputOptions, PointSource};

const NAME: &str = "cloud.copc.laz";

fn options() -> InputOptions {
    InputOptions::default()
}

fn read(bytes: &[u8], options: &InputOptions) -> Read {
    file(NAME, bytes, options).unwrap()
}

fn rect([min_x, min_y, max_x, max_y]: [f64; 4]) -> Rect {
    Rect::new(min_x, min_y, max_x, max_y)
}

fn holds([min_x, min_y, max_x, max_y]: [f64; 4], point: &Placed) -> bool {
    let (x, y) = point.point;
    (min_x..=max_x).contains(&x) && (min_y..=max_y).contains(&y)
}

/// Checks that a file gives the points with these records.
fn assert_points(cloud: &Cloud, read: &Read, records: &[u64]) {
    assert_eq!(read.records, records);
    let points = records.iter().map(|n| &cloud.points[*n as usize]);
    assert!(points.clone().map(|point| point.point).eq(read.points.iter().copied()));
    assert!(points.map(|point| point.z).eq(read.z.iter().copied()));
    let counts = read.source.counts();
    assert_eq!(counts.records, cloud.points.len() as u64);
    assert_eq!(counts.filtered, counts.records - records.len() as u64);
    assert_eq!(read.source.bytes_read(), cloud.bytes.len() as u64);
    assert_eq!(read.source.expected_points(), Some(0));
}

/// Returns a random box with corners at quarters of a unit, some of them on borders of cubes.
fn random_box(random: &mut Random) -> [f64; 4] {
    let mut range = |centre: f64| {
        let [a, b] = [0, 1].map(|_| centre - 1.25 * HALF + random.below(1280) as f64 * HALF / 512.0);
        [a.min(b), a.max(b)]
    };
    let ([min_x, max_x], [min_y, max_y]) = (range(CENTRE[0]), range(CENTRE[1]));
    [min_x, min_y, max_x, max_y]
}

#[test]
fn levels_and_boxes_select_what_a_filter_of_all_points_does() {
    let mut random = Random(11);
    for round in 0..10 {
        let (count, most) = (1 + random.below(4000), 1 + random.below(200));
        let cloud = Cloud::new(&mut random, count, most, round % 7);
        assert_points(&cloud, &read(&cloud.bytes, &options()), &cloud.records(|_| true));
        for level in 0..=7 {
            let up_to = |point: &Placed| point.key[0] <= i32::from(level);
            let records = cloud.records(up_to);
            assert_points(&cloud, &read(&cloud.bytes, &options().copc_level(level)), &records);
            // The level at which the spacing is at most the resolution.
            let spacing = SPACING / f64::from(1 << level);
            for resolution in [spacing, spacing * 1.9] {
                let options = options().copc_resolution(resolution);
                assert_points(&cloud, &read(&cloud.bytes, &options), &records);
            }
            let bounds = random_box(&mut random);
            let options = options().bounds(rect(bounds));
            let within = cloud.records(|point| holds(bounds, point));
            assert_points(&cloud, &read(&cloud.bytes, &options), &within);
            let both = cloud.records(|point| holds(bounds, point) && up_to(point));
            assert_points(&cloud, &read(&cloud.bytes, &options.copc_level(level)), &both);
        }
    }
}

#[test]
fn the_lower_of_a_level_and_a_resolution_is_the_limit() {
    let cloud = Cloud::new(&mut Random(12), 3000, 20, 6);
    for (level, resolution, limit) in [
        (2, SPACING / 16.0, 2),
        (4, SPACING / 2.0, 1),
        (0, 1e-300, 0),
        (255, 1e300, 0),
    ] {
        let options = options().copc_level(level).copc_resolution(resolution);
        let records = cloud.records(|point| point.key[0] <= limit);
        assert_points(&cloud, &read(&cloud.bytes, &options), &records);
    }
}

#[test]
fn the_announced_points_are_those_of_the_nodes_that_are_read() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join(NAME);
    let mut random = Random(13);
    let cloud = Cloud::new(&mut random, 5000, 50, 6);
    std::fs::write(&path, &cloud.bytes).unwrap();
    for level in 0..6u8 {
        let bounds = random_box(&mut random);
        let options = options().copc_level(level).bounds(rect(bounds));
        let source = PointSource::open(std::slice::from_ref(&path), &options).unwrap();
        let chosen = cloud.records(|point| point.key[0] <= i32::from(level) && meets(point.key, bounds));
        assert_eq!(source.expected_points(), Some(chosen.len() as u64));
    }
}

#[test]
fn records_are_numbered_over_several_files_as_if_all_were_read() {
    let mut random = Random(14);
    let clouds = [0, 1].map(|_| Cloud::new(&mut random, 2000, 40, 5));
    let files = clouds.each_ref().map(|cloud| ("a.copc.laz", &cloud.bytes[..]));
    let bounds = random_box(&mut random);
    let options = options()
        .copc_level(3)
        .bounds(rect(bounds))
        .every(3.try_into().unwrap());
    let files = [files[0], ("b.copc.laz", files[1].1)];
    let read = crate::input::files(&files, &options).unwrap();
    let both = clouds.iter().flat_map(|cloud| &cloud.points).enumerate();
    let chosen = both.filter(|(n, point)| point.key[0] <= 3 && holds(bounds, point) && n % 3 == 0);
    let records: Vec<u64> = chosen.map(|(n, _)| n as u64).collect();
    assert!(records.len() > 10);
    assert_eq!(read.records, records);
}

#[test]
fn nodes_that_are_left_out_are_not_read() {
    let cloud = Cloud::new(&mut Random(15), 150_000, 2000, 5);
    let bytes = |options: &InputOptions| {
        let read = read(&cloud.bytes, options);
        (read.source.reading().bytes(), read.points.len())
    };
    let size = cloud.bytes.len() as u64;
    // Fields that become no part of a point are not read.
    let (all, points) = bytes(&options());
    assert!(all > size / 2 && points == 150_000, "{all} of {size}, {points} points");
    // The header, the tables and the pages, in blocks of 8 KiB.
    let nowhere = Rect::new(0.0, 0.0, 1.0, 1.0);
    let (tables, points) = bytes(&options().bounds(nowhere));
    assert!(tables < size / 3 && points == 0, "{tables} of {size}");
    let (root, points) = bytes(&options().copc_level(0));
    assert!(root - tables < size / 20 && points == 2000, "{root} of {size}");
    let corner = [0.9, 1.0].map(|part| [CENTRE[0] + part * HALF, CENTRE[1] + part * HALF]);
    let (corner, points) = bytes(&options().bounds(rect([corner[0][0], corner[0][1], corner[1][0], corner[1][1]])));
    assert!(corner - tables < size / 5 && points > 0, "{corner} of {size}");
    // What excludes no node costs the pages alone.
    let everywhere = Rect::new(-1e6, -1e6, 1e6, 1e6);
    let (with_pages, points) = bytes(&options().bounds(everywhere).copc_level(9));
    assert!(with_pages < all + tables && points == 150_000, "{with_pages}, {all}");
}

#[test]
fn a_file_of_another_program_gives_the_same_points_by_level_and_box() {
    let path = data("las/autzen.copc.laz");
    let open = |options: &InputOptions| PointSource::open(std::slice::from_ref(&path), options).and_then(drain);
    let all = open(&options()).unwrap();
    assert_eq!(open(&options().copc_level(0)).unwrap().records, all.records);
    let (x, y) = all.points[0];
    for far in [0.0, 100.0, 1000.0] {
        let bounds = Rect::new(x - far, y - far, x + far, y + far);
        let within = |(_, point): &(&u64, &(f64, f64))| (point.0 - x).abs() <= far && (point.1 - y).abs() <= far;
        let records: Vec<u64> = all
            .records
            .iter()
            .zip(&all.points)
            .filter(within)
            .map(|(n, _)| *n)
            .collect();
        assert_eq!(open(&options().bounds(bounds)).unwrap().records, records);
    }
}

#[test]
fn the_identity_of_inputs_contains_the_choice() {
    let path = [data("las/autzen.copc.laz")];
    let choices = [
        options(),
        options().copc_level(0),
        options().copc_level(1),
        options().copc_resolution(1.0),
        options().copc_resolution(1.0 + f64::EPSILON),
    ];
    let identity = |options: &InputOptions| PointSource::open(&path, options).unwrap().identity().unwrap();
    let identities: std::collections::BTreeSet<String> = choices.iter().map(identity).collect();
    assert_eq!(identities.len(), choices.len());
}

#[test]
fn a_level_or_a_resolution_of_what_is_not_copc_is_an_error() {
    for options in [options().copc_level(3), options().copc_resolution(2.0)] {
        for name in ["autzen.las", "autzen.laz"] {
            let bytes = std::fs::read(data(&format!("las/{name}"))).unwrap();
            assert_says(
                file(name, bytes, &options),
                &[name, "this is not a COPC file", "leave these options out"],
            );
        }
        for (name, bytes) in [
            ("p.csv", &b"1,2\n"[..]),
            ("p.f64", &[0; 16]),
            ("p.geojson", b"{}"),
            ("p.obj", b"v 1 2 3"),
        ] {
            assert_says(file(name, bytes, &options), &[name, "this is not a COPC file"]);
        }
        assert_says(stream("1,2\n", &options), &["stream: this is not a COPC file"]);
    }
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_says(
            stream("1,2\n", &options().copc_resolution(wrong)),
            &["invalid copc_resolution", "expected a finite number above 0"],
        );
    }
}

/// The offset of the COPC record in the file.
const INFO: usize = 375 + 54;

#[test]
fn an_octree_that_does_not_belong_to_the_points_is_an_error() {
    let cloud = Cloud::new(&mut Random(16), 3000, 60, 5);
    let size = cloud.bytes.len() as u64;
    let says = |bytes: Vec<u8>, parts: &[&str]| {
        for options in [options().copc_level(1), options().bounds(Rect::new(0.0, 0.0, 1e4, 1e4))] {
            let result = file(NAME, &bytes, &options);
            assert_says(result, &[&[NAME], parts].concat());
        }
        // Without a choice, the octree is not needed.
        assert_eq!(read(&bytes, &options()).points.len(), 3000);
    };
    let number = |at: usize, value: f64| cloud.with(INFO + at, &value.to_le_bytes());
    says(number(0, f64::NAN), &["octree around NaN"]);
    says(number(24, 0.0), &["half a side of 0"]);
    says(number(24, f64::INFINITY), &["half a side of inf"]);
    says(
        cloud.with(INFO + 40, &[0xff; 8]),
        &["the COPC record: a page of", "not within the file"],
    );
    says(
        cloud.with(INFO + 48, &[0; 8]),
        &["a page of 0 bytes", "no whole number of entries"],
    );
    says(cloud.with(INFO + 48, &size.to_le_bytes()), &["not within the file"]);

    let root = cloud.root;
    let at = |n: usize| root + 32 * n;
    let place = format!("byte {}: ", at(0));
    let first = |offset: u64, bytes: i32, points: i32| cloud.with(at(0), &entry([0; 4], offset, bytes, points));
    let itself = first(root as u64, 32, -1);
    says(itself, &[&place, "a page of 32 bytes at byte", "overlaps another one"]);
    says(first(root as u64 - 64, 96, -1), &[&place, "overlaps another one"]);
    says(first(size - 31, 32, -1), &[&place, "not within the file"]);
    says(first(0, -32, -1), &[&place, "a node of -1 points in -32 bytes"]);
    says(first(0, 32, -2), &[&place, "a node of -2 points"]);
    says(
        first(2000, i32::MAX, 7),
        &[&place, "a node of 7 points in 2147483647 bytes", "not a chunk"],
    );
    says(
        first(0, 0, 0),
        &["no node of the octree has the chunk of points at byte"],
    );
    let second = &cloud.bytes[at(1)..at(2)];
    says(cloud.with(at(0), second), &["one of another node"]);
    for key in [[-1, 0, 0, 0], [32, 0, 0, 0], [1, 2, 0, 0], [1, 0, -1, 0], [i32::MAX; 4]] {
        let level = format!("{place}the octree has no node {}-", key[0]);
        says(cloud.with(at(0), &entry(key, 0, 0, 0)), &[&level]);
    }
    for resolution in [f64::NAN, 0.0, -1.0] {
        let bytes = cloud.with(INFO + 32, &resolution.to_le_bytes());
        assert_says(file(NAME, bytes, &options().copc_resolution(1.0)), &["a spacing of"]);
    }
}

/// A program may shift the points of a file and keep what it does not know.
#[test]
fn points_outside_of_their_node_are_an_error() {
    let cloud = Cloud::new(&mut Random(17), 3000, 60, 5);
    let shifted = cloud.with(INFO, &(CENTRE[0] + 3.0).to_le_bytes());
    let bounds = options().bounds(Rect::new(CENTRE[0], CENTRE[1], CENTRE[0] + 9.0, CENTRE[1] + 9.0));
    assert!(file(NAME, &cloud.bytes, &bounds).is_ok());
    assert_says(
        file(NAME, &shifted, &bounds),
        &["point ", "is not within the cube of its node", "does not know COPC"],
    );
}

#[test]
fn damaged_octrees_give_points_or_an_error() {
    let mut random = Random(18);
    let cloud = Cloud::new(&mut random, 800, 10, 5);
    let size = cloud.bytes.len();
    let table = u64::from_le_bytes(cloud.bytes[start(&cloud)..][..8].try_into().unwrap()) as usize;
    let choices = [options().copc_level(2), options().bounds(rect(random_box(&mut random)))];
    let (mut sound, mut failed) = (0, 0);
    let mut check = |bytes: &[u8]| {
        for options in &choices {
            match file(NAME, bytes, options) {
                Ok(read) => {
                    assert!(read.points.len() <= 800);
                    sound += 1;
                }
                Err(error @ InputError::Malformed { .. }) => {
                    assert!(error.to_string().contains(NAME), "{error}");
                    failed += 1;
                }
                Err(error) => panic!("{error}"),
            }
        }
    };
    for length in (0..size).step_by(1 + size / 200).chain(size - 40..size) {
        check(&cloud.bytes[..length]);
    }
    for round in 0..cases(800) {
        let mut bytes = cloud.bytes.clone();
        for _ in 0..=random.below(2) {
            let at = match round % 4 {
                0 => INFO + random.below(56),
                1 => table + random.below(size - table),
                _ => cloud.entries[random.below(cloud.entries.len())] + random.below(32),
            };
            bytes[at] = match random.below(3) {
                0 => 0xff,
                1 => bytes[at] ^ (1 << random.below(8)),
                _ => random.next() as u8,
            };
        }
        check(&bytes);
    }
    println!("{sound} read, {failed} failed");
    assert!(sound > 0 && failed > 0);
}

fn start(cloud: &Cloud) -> usize {
    u32::from_le_bytes(cloud.bytes[96..100].try_into().unwrap()) as usize
}
