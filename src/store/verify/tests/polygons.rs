//! Models in which the obstacles together cover what they should, but one of them does not.

use crate::store::format::edge_source::{EdgeSource, LineKind};
use crate::store::format::line_part::{LinePart, join_equal};
use crate::store::format::polygon_lines::PolygonLine;
use crate::store::verify::error::VerifyError;
use crate::store::verify::tests::model::Model;
use crate::store::verify::tests::town::{Town, towns};

/// Changes all sources of obstacles, each of which may become any number of sources.
fn change(town: &Town, with: impl Fn(EdgeSource) -> Vec<EdgeSource>) -> Model {
    town.but(|m| {
        for sources in m.tiles.iter_mut().flat_map(|tile| tile.sources.values_mut()) {
            let others = |part: &LinePart| {
                let [begins, ends] = part.end_bits();
                let others = with(part.source()).into_iter();
                others.map(move |source| LinePart::of(source, begins, ends))
            };
            *sources = sources.iter().flat_map(others).collect();
            sources.sort_unstable();
            join_equal(sources);
        }
    })
}

/// Returns a source with another number.
fn renumbered(source: EdgeSource, number: u64) -> EdgeSource {
    let new = EdgeSource::new(LineKind::Obstacle, number);
    if source.depth_change() > 0 { new } else { new.reversed() }
}

#[test]
fn an_obstacle_that_covers_a_part_twice_or_is_inside_out_under_others_is_found() {
    let (mut overlaps, mut inverted) = (0, 0);
    for town in towns() {
        let obstacles = town.model.directory.lists.lines[2].clone();
        let (first, last) = (obstacles.first, obstacles.first + obstacles.lines - 1);
        // Two obstacles have one number, as lines of their own or as rings of one polygon.
        let same = change(&town, |source| match source.number() {
            number if number == last => vec![renumbered(source, first)],
            _ => vec![source],
        });
        let rings = town.but(|m| {
            m.directory.lists.polygon_lines = vec![PolygonLine {
                line: last,
                polygon: first,
            }];
        });
        // Whether the two overlap depends on the town.
        let found = [same, rings].map(|model| match model.verify() {
            Ok(()) => None,
            Err(VerifyError::Polygon {
                polygon,
                file,
                line,
                reason,
            }) => {
                assert_eq!((polygon, &*file, line), (first, "obstacle", 0));
                assert!(reason.starts_with("covers a part more than once at ("), "{reason}");
                Some(reason)
            }
            Err(error) => panic!("{error}"),
        });
        assert_eq!(found[0], found[1]);
        overlaps += u32::from(found[0].is_some());
        // One obstacle takes away what two others cover once more.
        let turned = change(&town, |source| match source.number() {
            number if number == last => {
                let more = [first + 1, first + 2].map(|number| renumbered(source, number));
                vec![source.reversed(), more[0], more[1]]
            }
            _ => vec![source],
        });
        match turned.verify() {
            Err(VerifyError::Polygon { polygon, reason, .. }) if polygon == last => {
                assert!(reason.starts_with("is inside out at ("), "{reason}");
                inverted += 1;
            }
            // One of the others covers a part of it anyway.
            Err(VerifyError::Polygon { polygon, reason, .. }) => {
                assert!([first + 1, first + 2].contains(&polygon));
                assert!(reason.starts_with("covers a part more than once at ("), "{reason}");
            }
            other => panic!("{other:?}"),
        }
        // Without the list of lines nobody knows which sources belong together.
        let mut unknown = turned;
        unknown.directory.lists.lines.clear();
        unknown.verify().unwrap();
    }
    assert!(overlaps > 0 && inverted > 0, "{overlaps}, {inverted}");
}
