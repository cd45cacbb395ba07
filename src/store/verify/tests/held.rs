//! Files that are wrong about what holds a vertex or an edge.

use crate::geometry::Point;
use crate::store::format::edge_source::{EdgeSource, LineKind};
use crate::store::format::ids::VertexId;
use crate::store::format::line_part::LinePart;
use crate::store::format::line_source::LineSource;
use crate::store::format::polygon_lines::PolygonLine;
use crate::store::open_options::OpenOptions;
use crate::store::verify::error::VerifyError;
use crate::store::verify::lines::LineBatch;
use crate::store::verify::tests::grid;
use crate::store::verify::tests::model::{Model, Sourced, run};

fn at(x: f64, y: f64) -> Point {
    Point::new(x, y)
}

/// Returns the ring of a rectangle from a corner to the opposite one.
fn ring(low: Point, high: Point, number: u64) -> impl Iterator<Item = Sourced> + Clone {
    let obstacle = EdgeSource::new(LineKind::Obstacle, number).into();
    let corners = [low, at(high.x, low.y), high, at(low.x, high.y)];
    (0..4).map(move |i| ([corners[i], corners[(i + 1) % 4]], obstacle))
}

/// A break line and a wall that pass vertices of a grid, the ends of the wall between them; and
/// three obstacles, two of which are the same and have the same number.
fn lines() -> Vec<Sourced> {
    let same = ring(at(5.0, 6.0), at(8.0, 8.0), 2);
    let other = ring(at(1.0, 6.0), at(3.0, 8.0), 3);
    let mut lines: Vec<Sourced> = same.clone().chain(other).chain(same).collect();
    lines.push((
        [at(0.0, 5.0), at(9.0, 5.0)],
        EdgeSource::new(LineKind::BreakLine, 0).into(),
    ));
    lines.push(([at(8.5, 3.0), at(0.5, 3.0)], EdgeSource::new(LineKind::Wall, 1).into()));
    lines
}

fn model(tile_vertices: usize) -> Model {
    let model = Model::with_lines(&grid(), &lines(), &[(at(2.5, 7.25), 4)], tile_vertices);
    model.verify().unwrap();
    assert_eq!(model.directory.metadata.ends, 3);
    model
}

fn compare(model: &Model) -> Result<(), VerifyError> {
    let (ends, sources) = lines().into_iter().unzip();
    let mut all = Some(LineBatch { ends, sources });
    let next = |batch: &mut LineBatch| Ok::<_, String>(all.take().map(|all| *batch = all).is_some());
    run(async { model.open().await.verify_lines(next).await }).map(|_| ())
}

#[track_caller]
fn complaint(found: Result<(), VerifyError>, words: &str) {
    let text = found.expect_err("something is wrong").to_string();
    assert!(text.contains(words), "{text}");
}

/// Returns the tile and the edge of each source of a line, and its index there.
fn parts(model: &Model, line: u64) -> Vec<(usize, [VertexId; 2], usize, LinePart)> {
    let tiles = model.tiles.iter().enumerate();
    let edges = tiles.flat_map(|(tile, its)| its.sources.iter().map(move |(edge, parts)| (tile, *edge, parts)));
    let all = edges.flat_map(|(tile, edge, parts)| {
        let numbered = parts.iter().enumerate();
        numbered.map(move |(index, part)| (tile, edge, index, *part))
    });
    all.filter(|(.., part)| part.number() == line).collect()
}

/// Returns how many edges at a point have lines.
fn parts_at(model: &Model, point: Point) -> usize {
    let edges = model.tiles.iter().flat_map(|tile| tile.sources.keys());
    edges
        .filter(|edge| edge.iter().any(|&end| model.point(end) == point))
        .count()
}

#[test]
fn a_vertex_that_nothing_holds_is_found() {
    for tile_vertices in [9, 1000] {
        let right = model(tile_vertices);
        let mut unheld = 0;
        for (tile, its) in right.tiles.iter().enumerate() {
            for (index, &p) in its.points.iter().enumerate() {
                let mut wrong = right.clone();
                let bit = &mut wrong.tiles[tile].input_points[index];
                *bit = !*bit;
                let is_point = *bit;
                let shallow = run(async { wrong.open().await.verify(false).await.map(|_| ()) });
                complaint(
                    shallow,
                    "vertices without a point of the input, but the directory says 3",
                );
                // The count is right too.
                let ends = &mut wrong.directory.metadata.ends;
                *ends = if is_point { *ends - 1 } else { *ends + 1 };
                let is_corner = [6.0, 8.0].contains(&p.y) && [1.0, 3.0, 5.0, 8.0].contains(&p.x);
                let is_end = is_corner || p.y == 5.0 && [0.0, 9.0].contains(&p.x);
                if is_point || is_end {
                    wrong.verify().unwrap();
                } else {
                    unheld += 1;
                    let words = "is no point of the input, no site, and no end of a segment";
                    complaint(wrong.verify(), words);
                    // It may be a point at which a line was split.
                    wrong.directory.metadata.crossings = 1;
                    match parts_at(&wrong, p) {
                        0 => complaint(wrong.verify(), words),
                        _ => wrong.verify().unwrap(),
                    }
                }
            }
        }
        assert_eq!(unheld, 90);
    }
}

#[test]
fn a_line_that_ends_where_the_file_says_that_it_passes_is_found() {
    for tile_vertices in [9, 1000] {
        check_ends(&model(tile_vertices));
    }
}

/// Changes each bit that says whether a segment ends.
fn check_ends(right: &Model) {
    let (mut hidden, mut false_ends) = (0, 0);
    for line in [0, 1, 2] {
        for (tile, edge, index, part) in parts(right, line) {
            let with = |begins, ends| {
                let mut wrong = right.clone();
                let parts = wrong.tiles[tile].sources.get_mut(&edge).unwrap();
                let part = LinePart::of(part.source(), begins, ends);
                let source = part.source();
                assert_eq!(parts[index].source(), source);
                parts
                    .iter_mut()
                    .filter(|part| part.source() == source)
                    .for_each(|other| *other = part);
                wrong
            };
            for wrong in [with(!part.begins(), part.ends()), with(part.begins(), !part.ends())] {
                let is_hidden = compare(&wrong).unwrap_err().to_string().contains("does not say so");
                if is_hidden {
                    hidden += 1;
                    complaint(
                        compare(&wrong),
                        "has an end of a segment of its line, but the file does not say so",
                    );
                    // The corners of the ring have another edge.
                    match line {
                        2 => wrong.verify().unwrap(),
                        _ => complaint(wrong.verify(), "but runs along one edge there only"),
                    }
                } else {
                    false_ends += 1;
                    complaint(
                        compare(&wrong),
                        "has no end of a segment of its line where the file says so",
                    );
                    // Another segment could end there.
                    wrong.verify().unwrap();
                }
            }
        }
    }
    // Both lines, and four sides, each of which is stored twice.
    assert_eq!((hidden, false_ends), (2 + 2 + 16, 16 + 16 + 24));
}

#[test]
fn equal_sources_that_differ_in_their_ends_are_found() {
    for tile_vertices in [9, 1000] {
        let right = model(tile_vertices);
        let doubled = parts(&right, 2);
        assert_eq!(doubled.len(), 20);
        for (tile, edge, index, part) in doubled {
            let mut wrong = right.clone();
            let parts = wrong.tiles[tile].sources.get_mut(&edge).unwrap();
            parts[index] = LinePart::of(part.source(), !part.begins(), part.ends());
            complaint(wrong.verify(), "with different ends");
        }
    }
}

/// Where rings of a polygon overlap, the file has only one of them.
#[test]
fn a_ring_may_go_on_as_another_ring_of_its_polygon() {
    for tile_vertices in [9, 1000] {
        let mut open = 0;
        let lines: Vec<Sourced> = ring(at(2.0, 3.0), at(7.0, 6.0), 0).collect();
        let mut right = Model::with_lines(&grid(), &lines, &[], tile_vertices);
        right.directory.lists.lines = vec![LineSource {
            name: "rings".to_owned(),
            kind: LineKind::Obstacle,
            first: 0,
            lines: 2,
            edit: 0,
        }];
        right.directory.metadata.line_kinds = right.directory.lists.line_kinds();
        right.verify().unwrap();
        for (tile, edge, index, part) in parts(&right, 0) {
            let mut other = right.clone();
            let turned = EdgeSource::new(LineKind::Obstacle, 1);
            let source = match part.depth_change() {
                1 => turned,
                _ => turned.reversed(),
            };
            let [begins, ends] = part.end_bits();
            other.tiles[tile].sources.get_mut(&edge).unwrap()[index] = LinePart::of(source, begins, ends);
            let text = other.verify().unwrap_err().to_string();
            // Polygons are checked before the vertices that several tiles share.
            let is_open = text.ends_with("has a ring that does not close");
            assert!(is_open || text.contains("but runs along one edge there only"), "{text}");
            open += usize::from(is_open);
            other.directory.lists.polygon_lines = vec![PolygonLine { line: 1, polygon: 0 }];
            other.verify().unwrap();
            // Without a list of lines, nobody knows.
            other.directory.lists.polygon_lines.clear();
            other.directory.lists.lines.clear();
            other.directory.metadata.line_kinds = 0;
            other.verify().unwrap();
        }
        assert_eq!(open > 0, tile_vertices == 9);
    }
}

/// Every vertex but those in corners of the grid has lines of several tiles.
#[test]
fn vertices_of_several_tiles_are_checked_in_parts_if_memory_is_short() {
    const SIDE: usize = 45;
    let points: Vec<Point> = (0..SIDE * SIDE)
        .map(|i| at((i % SIDE) as f64, (i / SIDE) as f64))
        .collect();
    let last = (SIDE - 1) as f64;
    let both = |i: f64| [[at(0.0, i), at(last, i)], [at(i, 0.0), at(i, last)]];
    let ends = (0..SIDE).flat_map(|i| both(i as f64)).zip(0..);
    let lines: Vec<Sourced> = ends
        .map(|(ends, number)| (ends, EdgeSource::new(LineKind::Wall, number).into()))
        .collect();
    let right = Model::with_lines(&points, &lines, &[], 4);
    let verify = |model: &Model, memory: u64| {
        let options = OpenOptions::default().memory(memory);
        run(async { model.open_with(options).await.verify(true).await.map(|_| ()) })
    };
    let little = (1..)
        .map(|step| step << 15)
        .find(|&memory| verify(&right, memory).is_ok());
    let little = little.unwrap();
    assert!(little < 1 << 20, "{little}");
    let is_inner = |p: Point| [p.x, p.y].iter().all(|&c| 0.0 < c && c < last);
    let edges = right.tiles.iter().flat_map(|tile| tile.sources.keys());
    let larger = edges.flat_map(|&[a, b]| {
        let pairs = [[a, b], [b, a]].into_iter();
        pairs.filter(|[a, b]| a.tile != b.tile && right.point(*a).lex_cmp(right.point(*b)).is_lt())
    });
    let mut shared: Vec<VertexId> = larger.map(|[_, b]| b).filter(|&v| is_inner(right.point(v))).collect();
    shared.sort_unstable();
    shared.dedup();
    // More notes than the least number in memory at once, with four lines at each.
    assert!(5 * shared.len() > 1 << 12, "{}", shared.len());
    for first in [0, 1, shared.len() / 2, shared.len() - 1] {
        let mut wrong = right.clone();
        for v in &shared[first..] {
            wrong.tiles[v.tile.0 as usize].input_points[v.index.index()] = false;
        }
        wrong.directory.metadata.ends += (shared.len() - first) as u64;
        let v = shared[first];
        let texts = [little, 1 << 30].map(|memory| verify(&wrong, memory).unwrap_err().to_string());
        assert_eq!(texts[0], texts[1]);
        let expected = format!(
            "vertex {} is no point of the input, no site, and no end of a segment",
            v.index
        );
        assert!(
            texts[0].contains(&format!("tile {}", v.tile)) && texts[0].contains(&expected),
            "{}",
            texts[0]
        );
    }
}
