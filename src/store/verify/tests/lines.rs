//! Lines and sites that are wrong in one respect each, in the file or in the input.

use crate::geometry::{Point, VertexIndex};
use crate::input::{SiteBatch, SiteId};
use crate::store::format::edge_source::{EdgeSource, LineKind};
use crate::store::format::ids::VertexId;
use crate::store::format::line_part::LinePart;
use crate::store::pass::Needs;
use crate::store::verify::edge_entry::{LineNames, count};
use crate::store::verify::error::VerifyError;
use crate::store::verify::lines::LineBatch;
use crate::store::verify::tests::grid;
use crate::store::verify::tests::model::{Model, Sourced, pair, run};
use LineKind::{BreakLine, Obstacle, Wall};

/// Segments and sites on a grid of 100 points, and the file built from them.
struct Town {
    model: Model,
    lines: Vec<Sourced>,
    sites: Vec<(Point, u64)>,
}

fn at((x, y): (f64, f64)) -> Point {
    Point::new(x, y)
}

fn chain(source: EdgeSource, corners: &[(f64, f64)]) -> Vec<Sourced> {
    let segments = corners
        .windows(2)
        .map(|ends| ([at(ends[0]), at(ends[1])], source.into()));
    segments.collect()
}

impl Town {
    fn new(tile_vertices: usize) -> Self {
        let line = EdgeSource::new;
        let lines = [
            // Across the whole grid; a part of it once more, in the other direction.
            chain(line(BreakLine, 0), &[(0.0, 0.0), (9.0, 9.0)]),
            chain(line(BreakLine, 0), &[(6.0, 6.0), (3.0, 3.0)]),
            // The same line is the source of another edge too.
            chain(line(BreakLine, 0), &[(0.0, 9.0), (3.0, 9.0), (3.0, 9.0), (7.0, 7.0)]),
            chain(line(BreakLine, 1), &[(5.0, 9.0), (5.0, 0.0)]),
            chain(line(Wall, 2), &[(9.0, 5.0), (0.0, 5.0)]),
            chain(line(Wall, 3), &[(5.0, 5.0), (5.0, 2.0), (9.0, 2.0)]),
            // Rings that share an edge; a spike; a spike along the ring.
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
            chain(line(Obstacle, 7), &[(1.0, 6.0), (3.0, 6.0), (1.0, 6.0)]),
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

    /// Returns a copy of the model with `change` applied.
    fn but(&self, change: impl FnOnce(&mut Model)) -> Model {
        let mut wrong = self.model.clone();
        change(&mut wrong);
        wrong
    }

    /// Returns the edges and their sources, each with the tile that has them.
    fn edges(&self) -> Vec<(usize, [VertexId; 2], Vec<LinePart>)> {
        let tiles = self.model.tiles.iter().enumerate();
        let edges = tiles.flat_map(|(tile, its)| its.sources.iter().map(move |(e, s)| (tile, *e, s.clone())));
        let mut edges: Vec<_> = edges.collect();
        edges.sort_unstable_by_key(|(_, edge, _)| *edge);
        edges
    }

    /// Returns the edge between two positions.
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

/// Returns the result of the comparison. Asserts that it does not depend on the parts.
#[track_caller]
fn compare(model: &Model, lines: &[Sourced]) -> Result<u64, VerifyError> {
    let reader = run(async { model.open().await.for_passes().await.unwrap() });
    let names = LineNames::of(&reader.directory().metadata);
    let all = [1, 9, 1000].map(|at_once| {
        run(async {
            let mut batches = lines.chunks(4);
            let next = |batch: &mut LineBatch| -> Result<bool, String> {
                let Some(chunk) = batches.next() else { return Ok(false) };
                (batch.ends, batch.sources) = chunk.iter().copied().unzip();
                Ok(true)
            };
            let counts = reader.count_in_tiles(move |tile| count(tile, names)).await?;
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
fn correct_lines_pass_in_any_order_and_direction() {
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
        // Break lines and walls may occur once more.
        lines.extend(town.lines.iter().filter(|(_, source)| source.kind() != Obstacle));
        assert_eq!(compare(&town.model, &lines).unwrap(), lines.len() as u64);
    }
}

#[test]
fn an_edge_without_one_of_its_sources_is_found() {
    for town in Town::all() {
        let mut shared = 0;
        for (tile, edge, sources) in town.edges() {
            for index in 0..sources.len() {
                let wrong = town.but(|m| _ = m.tiles[tile].sources.get_mut(&edge).unwrap().remove(index));
                let expected = match sources.len() {
                    1 => "is a constraint without a source",
                    _ if sources[..index].contains(&sources[index]) => "covered by more segments than the file says",
                    _ if sources[index + 1..].contains(&sources[index]) => {
                        "covered by more segments than the file says"
                    }
                    _ => "is not a chain of edges that come from it",
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
fn an_additional_source_is_found() {
    for town in Town::all() {
        let lines = town.lines.iter().map(|(_, part)| part.source());
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
            // One more of the same source has the same ends.
            let same = sources.iter().find(|part| part.source() == source);
            let part = same.copied().unwrap_or_else(|| LinePart::whole(source));
            let wrong = town.but(|m| m.tiles[*tile].sources.get_mut(edge).unwrap().push(part));
            let text = complaint(&wrong, &town.lines);
            if same.is_some() && source.kind() != Obstacle {
                repeated += 1;
                assert!(text.contains("more than once"), "{text}: {source:?} beside {sources:?}");
            } else {
                others += 1;
                let expected = "is an edge of the file, but not of the input";
                assert!(text.contains(expected), "{text}: {source:?} beside {sources:?}");
            }
        }
        assert!(repeated > 1 && others > 20, "{repeated} {others}");
    }
}

/// The file says that an edge is a constraint, and all its tiles agree.
#[test]
fn a_constraint_that_is_not_in_the_input_is_found() {
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
                        m.tiles[owner.tile.0 as usize].sources.insert(edge, vec![source.into()]);
                    }
                    m.tiles.iter_mut().for_each(|tile| _ = tile.constraints.insert(edge));
                })
            };
            let without = complaint(&marked(None), &town.lines);
            assert!(without.contains("is a constraint without a source"), "{without}");
            for line in [0, 1, 50] {
                let wrong = marked(Some(EdgeSource::new(BreakLine, line)));
                // The file is consistent.
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
                    "break line {line} from ({}, {}) to ({}, {}) is an edge of the file, but not of the input",
                    low.0, low.1, high.0, high.1
                );
                assert_eq!(text, expected);
            }
        }
    }
}

#[test]
fn a_segment_missing_from_the_input_is_found() {
    for town in Town::all() {
        for missing in 0..town.lines.len() {
            let mut lines = town.lines.clone();
            let (ends, _) = lines.remove(missing);
            if ends[0] == ends[1] {
                compare(&town.model, &lines).unwrap();
                continue;
            }
            let text = complaint(&town.model, &lines);
            let expected = match ends == [at((6.0, 6.0)), at((3.0, 3.0))] {
                // Another segment of the line covers it, but passes its ends.
                true => "has no end of a segment of its line where the file says so",
                false => "but not of the input",
            };
            assert!(text.contains(expected), "{missing}: {text}");
        }
        assert!(complaint(&town.model, &[]).contains("but not of the input"));
    }
}

#[test]
fn a_segment_that_the_file_does_not_have_is_found() {
    for town in Town::all() {
        let wall = EdgeSource::new(Wall, 2);
        for (from, to) in [
            // On another wall, on no edge, off the grid, beyond an edge, short of a vertex, near a
            // vertex, and with an invalid end.
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
            let found = text.contains("not a chain of edges") || text.contains("no valid point");
            let first = [from, to].iter().any(|(x, y)| text.contains(&format!("({x}, {y})")));
            assert!(found && first, "{text}");
        }
        // Numbers and kinds of lines matter.
        let segments = town.lines.iter().enumerate().filter(|(_, (e, _))| e[0] != e[1]);
        for (segment, &(ends, source)) in segments.step_by(2) {
            for kind in [BreakLine, Wall, Obstacle] {
                for number in [source.number(), source.number() + 1] {
                    let other = LinePart::whole(EdgeSource::new(kind, number));
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
fn reversed_and_repeated_obstacle_segments_are_found() {
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
            assert!(text.contains("more segments than the file says"), "{text}");
        }
        for (tile, edge, sources) in town.edges() {
            for (index, source) in sources.iter().enumerate() {
                if source.kind() == Obstacle {
                    let turn = |m: &mut Model| {
                        let source = &mut m.tiles[tile].sources.get_mut(&edge).unwrap()[index];
                        *source = source.reversed();
                    };
                    complaint(&town.but(turn), &town.lines);
                }
            }
        }
    }
}

#[test]
fn an_input_error_and_an_inconsistent_batch_are_reported() {
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
type NamedSites = Vec<(Point, SiteId)>;

/// Returns the result of the comparison of sites. Asserts that it does not depend on the parts.
#[track_caller]
fn compare_sites(model: &Model, sites: &[(Point, SiteId)]) -> Result<u64, String> {
    let all = [1, 2, 100].map(|at_once| {
        run(async {
            let reader = model.open().await.for_passes().await.unwrap();
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
fn missing_moved_and_additional_sites_are_found() {
    for town in Town::all() {
        let number = |&(p, number): &(Point, u64)| (p, SiteId::Number(number));
        let right: Vec<_> = town.sites.iter().map(number).collect();
        assert_eq!(compare_sites(&town.model, &right), Ok(5));
        let mut turned = right.clone();
        turned.reverse();
        assert_eq!(compare_sites(&town.model, &turned), Ok(5));
        for index in 0..right.len() {
            let wrong = |change: &dyn Fn(&mut NamedSites)| {
                let mut sites = right.clone();
                change(&mut sites);
                compare_sites(&town.model, &sites).unwrap_err()
            };
            let text = wrong(&|sites| _ = sites.remove(index));
            assert!(text.contains("of the file is not in the input"), "{text}");
            for text in [
                wrong(&|sites| sites[index].1 = SiteId::Number(70)),
                wrong(&|sites| sites[index].1 = SiteId::Text("7".to_owned())),
                wrong(&|sites| sites[index].0.x -= 1.0),
                wrong(&|sites| sites.insert(index, sites[index].clone())),
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
