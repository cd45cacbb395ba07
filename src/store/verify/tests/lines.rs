//! Lines and sites that are wrong in one thing each, in the file or in the input.

use crate::geometry::{Point, VertexIndex};
use crate::input::{SiteBatch, SiteId};
use crate::store::format::edge_source::{EdgeSource, LineKind};
use crate::store::format::ids::VertexId;
use crate::store::pass::Needs;
use crate::store::verify::error::VerifyError;
use crate::store::verify::lines::{LineBatch, count};
use crate::store::verify::tests::grid;
use crate::store::verify::tests::model::{Model, Sourced, pair, run};
use LineKind::{BreakLine, Obstacle, Wall};

/// Segments and sites on a grid of 100 points, and the file of them.
struct Town {
    model: Model,
    lines: Vec<Sourced>,
    sites: Vec<(Point, u64)>,
}

fn at((x, y): (f64, f64)) -> Point {
    Point::new(x, y)
}

fn chain(source: EdgeSource, corners: &[(f64, f64)]) -> Vec<Sourced> {
    let segments = corners.windows(2).map(|ends| ([at(ends[0]), at(ends[1])], source));
    segments.collect()
}

impl Town {
    fn new(tile_vertices: usize) -> Self {
        let line = EdgeSource::new;
        let lines = [
            // Across everything; a part of it once more, and the other way.
            chain(line(BreakLine, 0), &[(0.0, 0.0), (9.0, 9.0)]),
            chain(line(BreakLine, 0), &[(6.0, 6.0), (3.0, 3.0)]),
            // The same line is another edge's source too.
            chain(line(BreakLine, 0), &[(0.0, 9.0), (3.0, 9.0), (3.0, 9.0), (7.0, 7.0)]),
            chain(line(BreakLine, 1), &[(5.0, 9.0), (5.0, 0.0)]),
            chain(line(Wall, 2), &[(9.0, 5.0), (0.0, 5.0)]),
            chain(line(Wall, 3), &[(5.0, 5.0), (5.0, 2.0), (9.0, 2.0)]),
            // Rings that share a side; a spike; a ring that goes round twice.
            chain(
                line(Obstacle, 4),
                &[(1.0, 1.0), (4.0, 1.0), (4.0, 4.0), (1.0, 4.0), (1.0, 1.0)],
            ),
            chain(
                line(Obstacle, 5),
                &[(4.0, 1.0), (8.0, 1.0), (8.0, 4.0), (4.0, 4.0), (4.0, 1.0)],
            ),
            chain(
                line(Obstacle, 6),
                &[(6.0, 6.0), (8.0, 6.0), (8.0, 8.0), (8.0, 9.0), (8.0, 8.0), (6.0, 6.0)],
            ),
            chain(
                line(Obstacle, 7),
                &[(1.0, 6.0), (3.0, 6.0), (3.0, 8.0), (1.0, 8.0), (1.0, 6.0)],
            ),
            chain(
                line(Obstacle, 7),
                &[(1.0, 6.0), (3.0, 6.0), (3.0, 8.0), (1.0, 8.0), (1.0, 6.0)],
            ),
        ];
        let lines = lines.concat();
        let sites = [
            (2.0, 2.0, 7),
            (2.0, 2.0, 7),
            (2.0, 2.0, 8),
            (2.5, 7.25, 9),
            (9.0, 9.0, 7),
        ];
        let sites = sites.map(|(x, y, number)| (Point::new(x, y), number)).to_vec();
        Self {
            model: Model::with_lines(&grid(), &lines, &sites, tile_vertices),
            lines,
            sites,
        }
    }

    fn all() -> [Self; 3] {
        [8, 16, 1000].map(Self::new)
    }

    /// A file that is wrong in one thing.
    fn but(&self, change: impl FnOnce(&mut Model)) -> Model {
        let mut wrong = self.model.clone();
        change(&mut wrong);
        wrong
    }

    /// The edges and their sources, each with the tile that has them.
    fn edges(&self) -> Vec<(usize, [VertexId; 2], Vec<EdgeSource>)> {
        let tiles = self.model.tiles.iter().enumerate();
        let edges = tiles.flat_map(|(tile, its)| its.sources.iter().map(move |(e, s)| (tile, *e, s.clone())));
        let mut edges: Vec<_> = edges.collect();
        edges.sort_unstable_by_key(|(_, edge, _)| *edge);
        edges
    }

    /// An edge between two places.
    fn edge(&self, from: (f64, f64), to: (f64, f64)) -> [VertexId; 2] {
        let vertex = |p: Point| {
            let found = self.model.tiles.iter().zip(0..).find_map(|(tile, number)| {
                let index = VertexIndex(tile.points.iter().position(|&q| q == p)? as u32);
                let tile = crate::store::format::ids::TileId(number);
                Some(VertexId { tile, index })
            });
            found.unwrap()
        };
        pair(vertex(at(from)), vertex(at(to)))
    }
}

/// What comes of the comparison, which is the same in whatever parts the segments are looked for.
#[track_caller]
fn compare(model: &Model, lines: &[Sourced]) -> Result<u64, VerifyError> {
    let reader = run(model.open());
    let all = [1, 9, 1000].map(|at_once| {
        run(async {
            let mut batches = lines.chunks(4);
            let next = |batch: &mut LineBatch| -> Result<bool, String> {
                let Some(chunk) = batches.next() else { return Ok(false) };
                (batch.ends, batch.sources) = chunk.iter().copied().unzip();
                Ok(true)
            };
            let counts = reader.count_in_tiles(count).await?;
            let plan = reader.plan(Needs::default())?;
            let report = reader.verify_in_parts(next, counts, plan, at_once).await?;
            Ok(report.segments)
        })
    });
    let texts = all
        .each_ref()
        .map(|found: &Result<u64, VerifyError>| format!("{found:?}"));
    assert!(texts.iter().all(|text| *text == texts[0]), "{texts:#?}");
    all.into_iter().next().unwrap()
}

#[track_caller]
fn complaint(model: &Model, lines: &[Sourced]) -> String {
    compare(model, lines).expect_err("something is wrong").to_string()
}

#[test]
fn lines_that_are_right_in_any_order_and_direction() {
    for town in Town::all() {
        town.model.verify().unwrap();
        let mut lines = town.lines.clone();
        for round in 0..20 {
            assert_eq!(compare(&town.model, &lines).unwrap(), lines.len() as u64);
            let count = lines.len();
            for i in 0..count {
                lines.swap(i, (7 * i + 5 * round) % count);
                if (i + round) % 3 == 0 {
                    let ([from, to], source) = lines[i];
                    lines[i] = ([to, from], source.reversed());
                }
            }
        }
        // Break lines and walls may come once more.
        lines.extend(town.lines.iter().filter(|(_, source)| source.kind() != Obstacle));
        assert_eq!(compare(&town.model, &lines).unwrap(), lines.len() as u64);
    }
}

#[test]
fn an_edge_without_one_of_its_sources() {
    for town in Town::all() {
        let mut shared = 0;
        for (tile, edge, sources) in town.edges() {
            for place in 0..sources.len() {
                let wrong = town.but(|m| _ = m.tiles[tile].sources.get_mut(&edge).unwrap().remove(place));
                let expected = match sources.len() {
                    1 => "is a constraint without a source",
                    _ if sources[..place].contains(&sources[place]) => "run along more often than the file says",
                    _ if sources[place + 1..].contains(&sources[place]) => "run along more often than the file says",
                    _ => "is no chain of edges that come from it",
                };
                let text = complaint(&wrong, &town.lines);
                assert!(text.contains(expected), "{text}: {sources:?}");
                shared += usize::from(sources.len() > 1);
            }
        }
        assert!(shared > 10, "{shared}");
    }
}

#[test]
fn a_source_too_many() {
    for town in Town::all() {
        let lines = town.lines.iter().map(|(_, source)| *source);
        let unknown = [BreakLine, Wall, Obstacle].map(|kind| EdgeSource::new(kind, 99));
        let all: Vec<EdgeSource> = lines
            .chain(unknown)
            .flat_map(|source| [source, source.reversed()])
            .collect();
        let edges = town.edges();
        let pairs = edges
            .iter()
            .flat_map(|edge| all.iter().map(move |source| (edge, *source)));
        let (mut repeated, mut others) = (0, 0);
        for ((tile, edge, sources), source) in pairs.step_by(61) {
            let wrong = town.but(|m| m.tiles[*tile].sources.get_mut(edge).unwrap().push(source));
            let text = complaint(&wrong, &town.lines);
            if sources.contains(&source) && source.kind() != Obstacle {
                repeated += 1;
                assert!(text.contains("more than once"), "{text}: {source:?} beside {sources:?}");
            } else {
                others += 1;
                let expected = "is an edge of the file, but not so in the input";
                assert!(text.contains(expected), "{text}: {source:?} beside {sources:?}");
            }
        }
        assert!(repeated > 1 && others > 20, "{repeated} {others}");
    }
}

/// The file says that an edge is a constraint, and all its tiles agree.
#[test]
fn an_edge_that_is_no_constraint_of_the_input() {
    for town in Town::all() {
        for (from, to) in [
            ((0.0, 1.0), (0.0, 2.0)),
            ((7.0, 3.0), (7.0, 2.0)),
            ((0.0, 8.0), (1.0, 9.0)),
        ] {
            let edge = town.edge(from, to);
            let is_edge = town
                .model
                .triangles()
                .iter()
                .any(|t| edge.iter().all(|v| t.contains(v)));
            if !is_edge {
                continue;
            }
            let marked = |source: Option<EdgeSource>| {
                town.but(|m| {
                    let point = |v: VertexId| m.point(v);
                    let owner = if point(edge[0]).lex_cmp(point(edge[1])).is_lt() {
                        edge[0]
                    } else {
                        edge[1]
                    };
                    if let Some(source) = source {
                        m.tiles[owner.tile.0 as usize].sources.insert(edge, vec![source]);
                    }
                    m.tiles.iter_mut().for_each(|tile| _ = tile.constraints.insert(edge));
                })
            };
            let without = complaint(&marked(None), &town.lines);
            assert!(without.contains("is a constraint without a source"), "{without}");
            for line in [0, 1, 50] {
                let wrong = marked(Some(EdgeSource::new(BreakLine, line)));
                // The file agrees with itself.
                if line < 50 {
                    wrong.verify().unwrap();
                }
                let text = complaint(&wrong, &town.lines);
                let [low, high] = if at(from).lex_cmp(at(to)).is_lt() {
                    [from, to]
                } else {
                    [to, from]
                };
                let expected = format!(
                    "break line {line} from ({}, {}) to ({}, {}) is an edge of the file, but not so in the input",
                    low.0, low.1, high.0, high.1
                );
                assert_eq!(text, expected);
            }
        }
    }
}

#[test]
fn a_segment_missing_from_the_input() {
    for town in Town::all() {
        for missing in 0..town.lines.len() {
            let mut lines = town.lines.clone();
            let (ends, _) = lines.remove(missing);
            // Others run along it, or it has no length.
            if ends == [at((6.0, 6.0)), at((3.0, 3.0))] || ends[0] == ends[1] {
                compare(&town.model, &lines).unwrap();
                continue;
            }
            let text = complaint(&town.model, &lines);
            assert!(text.contains("but not so in the input"), "{missing}: {text}");
        }
        assert!(complaint(&town.model, &[]).contains("but not so in the input"));
    }
}

#[test]
fn a_segment_that_the_file_does_not_have() {
    for town in Town::all() {
        let wall = EdgeSource::new(Wall, 2);
        for (from, to) in [
            // Another wall's, none's, beside the plane, beyond an edge, short of a vertex, with an end that is none.
            ((5.0, 5.0), (5.0, 2.0)),
            ((0.0, 2.0), (1.0, 2.0)),
            ((-5.0, -5.0), (-5.0, -9.0)),
            ((0.0, 5.0), (10.0, 5.0)),
            ((0.5, 5.0), (4.0, 5.0)),
            ((0.0, 5.0), (4.0, 5.0 + 1e-15)),
            ((0.0, 5.0), (1e200, 1e-40)),
        ] {
            let mut lines = town.lines.clone();
            lines.extend(chain(wall, &[(0.0, 5.0), (4.0, 5.0)]));
            lines.extend(chain(wall, &[from, to]));
            lines.extend(chain(wall, &[(77.0, 77.0), (78.0, 78.0)]));
            let text = complaint(&town.model, &lines);
            let found = text.contains("no chain of edges") || text.contains("no valid point");
            let first = [from, to].iter().any(|(x, y)| text.contains(&format!("({x}, {y})")));
            assert!(found && first, "{text}");
        }
        // The numbers and kinds of lines count.
        let segments = town.lines.iter().enumerate().filter(|(_, (e, _))| e[0] != e[1]);
        for (segment, &(ends, source)) in segments.step_by(2) {
            for kind in [BreakLine, Wall, Obstacle] {
                for number in [source.number(), source.number() + 1] {
                    let other = EdgeSource::new(kind, number);
                    if other != source {
                        let mut lines = town.lines.clone();
                        lines[segment] = (ends, other);
                        complaint(&town.model, &lines);
                    }
                }
            }
        }
    }
}

#[test]
fn obstacles_the_wrong_way_round_or_too_often() {
    for town in Town::all() {
        for (segment, &(ends, source)) in town.lines.iter().enumerate() {
            if source.kind() != Obstacle {
                continue;
            }
            let mut turned = town.lines.clone();
            turned[segment] = (ends, source.reversed());
            complaint(&town.model, &turned);
            let mut twice = town.lines.clone();
            twice.insert(segment / 2, (ends, source));
            let text = complaint(&town.model, &twice);
            assert!(text.contains("more often than the file says"), "{text}");
        }
        for (tile, edge, sources) in town.edges() {
            for (place, source) in sources.iter().enumerate() {
                if source.kind() == Obstacle {
                    let turn = |m: &mut Model| {
                        let source = &mut m.tiles[tile].sources.get_mut(&edge).unwrap()[place];
                        *source = source.reversed();
                    };
                    complaint(&town.but(turn), &town.lines);
                }
            }
        }
    }
}

#[test]
fn input_that_is_none() {
    let town = Town::new(16);
    let text = |next: &dyn Fn(&mut LineBatch) -> Result<bool, String>| {
        let verified = run(async { town.model.open().await.verify_lines(next).await });
        verified.unwrap_err().to_string()
    };
    assert_eq!(text(&|_| Err("it is torn".to_owned())), "it is torn");
    let unequal = |batch: &mut LineBatch| {
        batch.ends.push([Point::default(); 2]);
        Ok(true)
    };
    assert!(text(&unequal).contains("1 segments and 0 sources"));
}

/// Sites with their ids.
type Named = Vec<(Point, SiteId)>;

/// What comes of the comparison of sites, in whatever parts they are looked up.
#[track_caller]
fn compare_sites(model: &Model, sites: &[(Point, SiteId)]) -> Result<u64, String> {
    let all = [1, 2, 100].map(|at_once| {
        run(async {
            let reader = model.open().await;
            let mut batches = sites.chunks(3);
            let next = |batch: &mut SiteBatch| -> Result<bool, String> {
                let Some(chunk) = batches.next() else { return Ok(false) };
                (batch.points, batch.ids) = chunk.iter().cloned().unzip();
                Ok(true)
            };
            let counts = model.tiles.iter().map(|tile| tile.sites.len() as u32).collect();
            let plan = reader.plan(Needs::default()).unwrap();
            let report = reader.verify_sites_in_parts(next, counts, plan, at_once).await;
            report.map(|report| report.sites).map_err(|error| error.to_string())
        })
    });
    assert!(all.iter().all(|found| *found == all[0]), "{all:#?}");
    all.into_iter().next().unwrap()
}

#[test]
fn sites_that_are_missing_moved_or_too_many() {
    for town in Town::all() {
        let number = |&(p, number): &(Point, u64)| (p, SiteId::Number(number));
        let right: Vec<_> = town.sites.iter().map(number).collect();
        assert_eq!(compare_sites(&town.model, &right), Ok(5));
        let mut turned = right.clone();
        turned.reverse();
        assert_eq!(compare_sites(&town.model, &turned), Ok(5));
        for place in 0..right.len() {
            let wrong = |change: &dyn Fn(&mut Named)| {
                let mut sites = right.clone();
                change(&mut sites);
                compare_sites(&town.model, &sites).unwrap_err()
            };
            let text = wrong(&|sites| _ = sites.remove(place));
            assert!(text.contains("of the file is not in the input"), "{text}");
            for text in [
                wrong(&|sites| sites[place].1 = SiteId::Number(70)),
                wrong(&|sites| sites[place].1 = SiteId::Text("7".to_owned())),
                wrong(&|sites| sites[place].0.x -= 1.0),
                wrong(&|sites| sites.insert(place, sites[place].clone())),
            ] {
                assert!(text.contains("is not in the file, or not as often"), "{text}");
            }
        }
        let first = |m: &Model| m.tiles.iter().position(|tile| !tile.sites.is_empty()).unwrap();
        let tile = first(&town.model);
        for wrong in [
            town.but(|m| _ = m.tiles[tile].sites.pop()),
            town.but(|m| m.tiles[tile].sites[0].1 -= 1),
            town.but(|m| m.tiles[tile].sites.push((7, 99))),
        ] {
            compare_sites(&wrong, &right).unwrap_err();
        }
        let public = run(async { town.model.open().await.verify_sites(|_| Ok::<_, String>(false)).await });
        assert!(public.unwrap_err().to_string().starts_with("site "));
    }
}
