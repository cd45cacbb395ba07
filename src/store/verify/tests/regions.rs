//! Models in which regions, holes or sources are wrong in one respect each.

use crate::geometry::Point;
use crate::store::format::component_table::Component;
use crate::store::format::digest::{Digest, DigestSum};
use crate::store::format::edge_source::{EdgeSource, LineKind};
use crate::store::format::ids::TileId;
use crate::store::verify::tests::model::{Model, pair, run};
use crate::store::verify::tests::town::{centroid, half_edges, owner, towns};

/// Asserts that verification fails, with `words` in the error.
#[track_caller]
fn found(wrong: &Model, words: &str) {
    let text = match wrong.verify() {
        Ok(()) => panic!("it is not found: {words}"),
        Err(error) => error.to_string(),
    };
    assert!(text.contains(words), "{text:?} is not about {words:?}");
}

#[test]
fn unchanged_towns_are_valid() {
    for town in towns() {
        town.model.verify().unwrap();
        let m = &town.model.directory.metadata;
        let local = m.regions - m.spanning_regions;
        assert!(
            local > 5
                && m.hole_regions > 3
                && m.hole_regions < m.regions
                && !town.model.directory.lists.hole_points.is_empty()
        );
        assert_eq!(
            m.spanning_regions > 5,
            town.model.tiles.len() > 1,
            "{}",
            m.spanning_regions
        );
    }
}

#[test]
fn a_constraint_without_a_source_and_a_source_without_a_constraint_are_found() {
    for town in towns() {
        for edge in town.edges().into_iter().step_by(5) {
            let owner = owner(&town.model, edge);
            found(
                &town.but(|m| _ = m.tiles[owner].sources.remove(&edge)),
                "is a constraint without a source",
            );
            let no_constraint = |m: &mut Model| {
                m.tiles.iter_mut().for_each(|tile| {
                    tile.constraints.remove(&edge);
                    tile.walls.remove(&edge);
                })
            };
            assert!(town.but(no_constraint).verify().is_err());
        }
        // A source for an edge that is no constraint, and so separates no regions.
        let all = town
            .model
            .triangles()
            .into_iter()
            .flat_map(half_edges)
            .map(|[a, b]| pair(a, b));
        for edge in all.filter(|edge| !town.sources.contains_key(edge)).step_by(7) {
            let owner = owner(&town.model, edge);
            let source = vec![EdgeSource::new(LineKind::BreakLine, 0).into()];
            found(
                &town.but(|m| _ = m.tiles[owner].sources.insert(edge, source)),
                "it has sources for edges that are no constraints of its own",
            );
        }
    }
}

#[test]
fn sources_in_a_tile_that_does_not_own_the_edge_are_found() {
    let mut tried = 0;
    for town in towns() {
        for edge in town.edges() {
            let owner = owner(&town.model, edge);
            for other in edge
                .map(|v| v.tile.0 as usize)
                .into_iter()
                .filter(|&tile| tile != owner)
            {
                let sources = town.sources[&edge].clone();
                found(
                    &town.but(|m| _ = m.tiles[other].sources.insert(edge, sources)),
                    "it has sources for edges that are no constraints of its own",
                );
                tried += 1;
            }
        }
    }
    assert!(tried > 20, "{tried}");
}

#[test]
fn a_wall_that_disagrees_with_its_sources_is_found() {
    for town in towns() {
        for edge in town.edges().into_iter().step_by(4) {
            let flip = |m: &mut Model| {
                for tile in &mut m.tiles {
                    if !tile.walls.remove(&edge) {
                        tile.walls.insert(edge);
                    }
                }
            };
            found(&town.but(flip), "disagree on whether it is a wall");
            // In one tile only, if several tiles have the edge.
            for tile in edge.map(|v| v.tile.0 as usize) {
                let flip = |m: &mut Model| {
                    let walls = &mut m.tiles[tile].walls;
                    if !walls.remove(&edge) {
                        walls.insert(edge);
                    }
                };
                assert!(town.but(flip).verify().is_err());
            }
        }
    }
}

#[test]
fn depths_that_disagree_with_the_sources_are_found() {
    for town in towns() {
        for edge in town.edges() {
            let owner = owner(&town.model, edge);
            let Some(index) = town.sources[&edge]
                .iter()
                .position(|source| source.kind() == LineKind::Obstacle)
            else {
                continue;
            };
            found(
                &town.but(|m| {
                    let source = &mut m.tiles[owner].sources.get_mut(&edge).unwrap()[index];
                    *source = source.reversed();
                }),
                "changes the depth by",
            );
        }
        for (_, label) in town.regions().into_iter().step_by(3) {
            for step in [-1, 1, i32::MAX] {
                let deeper = |m: &mut Model| {
                    let labels = m.tiles.iter_mut().flat_map(|tile| tile.labels.values_mut());
                    labels
                        .filter(|other| other.region == label.region)
                        .for_each(|other| other.depth = other.depth.wrapping_add(step));
                };
                assert!(town.but(deeper).verify().is_err());
            }
        }
    }
}

#[test]
fn lines_that_the_directory_does_not_list_are_found() {
    for town in towns() {
        for source in 0..3 {
            found(
                &town.but(|m| {
                    let lines = &mut m.directory.lists.lines;
                    lines[source].kind = match lines[source].kind {
                        LineKind::BreakLine => LineKind::Wall,
                        _ => LineKind::BreakLine,
                    };
                }),
                "which the directory does not know",
            );
        }
        found(
            &town.but(|m| m.directory.lists.lines[2].lines -= 1),
            "which the directory does not know",
        );
        // A build whose lines have no names has no lines in the directory.
        town.but(|m| m.directory.lists.lines.clear()).verify().unwrap();
    }
}

#[test]
fn a_triangle_with_a_wrong_region_depth_or_kind_is_found() {
    for town in towns() {
        let regions = town.regions();
        let mut triangles: Vec<_> = town.labels.keys().copied().collect();
        triangles.sort_unstable();
        for (t, number) in triangles.into_iter().step_by(9).zip(0usize..) {
            let right = town.labels[&t];
            let other = regions[(right.region as usize + 1) % regions.len()].1.region;
            let wrong = [
                Component { region: other, ..right },
                Component {
                    depth: right.depth + 1,
                    ..right
                },
                Component {
                    is_hole: !right.is_hole,
                    ..right
                },
            ];
            for wrong in wrong {
                // In all tiles, and in one.
                let everywhere = |m: &mut Model| m.tiles.iter_mut().for_each(|tile| _ = tile.labels.insert(t, wrong));
                assert!(town.but(everywhere).verify().is_err(), "{t:?} {wrong:?}");
                let tile = t[number % 3].tile;
                let once = |m: &mut Model| _ = m.tiles[tile.0 as usize].labels.insert(t, wrong);
                assert!(town.but(once).verify().is_err(), "{t:?} {wrong:?} in {tile}");
            }
        }
    }
}

#[test]
fn holes_without_a_reason_and_regions_that_should_be_holes_are_found() {
    for town in towns() {
        for (_, label) in town.regions() {
            let filled = |m: &mut Model| {
                let labels = m.tiles.iter_mut().flat_map(|tile| tile.labels.values_mut());
                labels
                    .filter(|other| other.region == label.region)
                    .for_each(|other| other.is_hole = !other.is_hole);
                let triangles = town
                    .labels
                    .values()
                    .filter(|other| other.region == label.region)
                    .count() as u64;
                let metadata = &mut m.directory.metadata;
                let sign = if label.is_hole { 1u64.wrapping_neg() } else { 1 };
                metadata.hole_regions = metadata.hole_regions.wrapping_add(sign);
                metadata.hole_triangles = metadata.hole_triangles.wrapping_add(sign.wrapping_mul(triangles));
            };
            let words = if label.is_hole {
                "is no hole, but should be"
            } else {
                "nothing makes it one"
            };
            found(&town.but(filled), words);
        }
        for seed in 0..town.model.directory.lists.hole_points.len() {
            let removed = town.but(|m| _ = m.directory.lists.hole_points.remove(seed));
            // The region may be covered by an obstacle too, or be outside, so it may have another
            // reason.
            if let Err(error) = removed.verify() {
                assert!(error.to_string().contains("nothing makes it one"), "{error}");
            }
        }
        found(
            &town.but(|m| m.directory.lists.hole_points.clear()),
            "nothing makes it one",
        );
        let free = town.regions().into_iter().find(|(_, label)| !label.is_hole).unwrap().0;
        found(
            &town.but(|m| m.directory.lists.hole_points.push(centroid(&town.model, free))),
            "is no hole, but should be",
        );
        assert!(
            town.but(|m| m.directory.metadata.exterior_is_hole ^= true)
                .verify()
                .is_err()
        );
    }
}

/// A seed in the middle of an edge refers to the region around it. A seed at a vertex or on a
/// constraint may refer to any region there.
#[test]
fn seeds_inside_free_edges_are_binding_and_seeds_on_vertices_or_constraints_are_not() {
    let town = &towns()[3];
    let with = |seed: Point| town.but(|m| m.directory.lists.hole_points.push(seed)).verify();
    let mut wrong = 0;
    for t in town.model.triangles() {
        for half_edge in half_edges(t) {
            let [a, b] = half_edge.map(|v| town.model.point(v));
            let between = Point::new((a.x + b.x) / 2.0, (a.y + b.y) / 2.0);
            let is_free = !town.labels[&t].is_hole && !town.sources.contains_key(&pair(half_edge[0], half_edge[1]));
            assert_eq!(with(between).is_err(), is_free, "{between:?}");
            wrong += u32::from(is_free);
            with(a).unwrap();
        }
    }
    with(Point::new(-1.0, 3.0)).unwrap();
    assert!(wrong > 10, "{wrong}");
}

#[test]
fn skipped_repeated_and_moved_region_numbers_are_found() {
    for town in towns() {
        let m = &town.model.directory.metadata;
        let renumber = |from: u64, to: u64, in_tile: Option<TileId>| {
            town.but(|m| {
                let tiles = m.tiles.iter_mut().zip(0..);
                let tiles = tiles.filter(|(_, number)| in_tile.is_none_or(|tile| tile.0 == *number));
                let labels = tiles.flat_map(|(tile, _)| tile.labels.values_mut());
                labels
                    .filter(|label| label.region == from)
                    .for_each(|label| label.region = to);
            })
        };
        for region in [
            0,
            m.spanning_regions.saturating_sub(1),
            m.spanning_regions,
            m.regions - 1,
        ] {
            found(&renumber(region, m.regions, None), "it is of region");
            let other = (region + 1) % m.regions;
            assert!(renumber(region, other, None).verify().is_err(), "{region}");
        }
        // A region within one tile gets the number of a region within another, so that all counts
        // stay.
        let of_tile = |region: u64| {
            let t = town.labels.iter().find(|(_, label)| label.region == region).unwrap().0;
            t[0].tile
        };
        let (last, before) = (m.regions - 1, m.regions - 2);
        if of_tile(last) != of_tile(before) {
            found(&renumber(last, before, None), "should be within one tile each");
        }
        let one_more = |m: &mut Model| m.directory.metadata.regions += 1;
        found(&town.but(one_more), "should be within one tile each");
        let spanning = |m: &mut Model| m.directory.metadata.spanning_regions = m.directory.metadata.regions;
        // Such regions may extend over several tiles, but need not.
        town.but(spanning).verify().unwrap();
        if m.spanning_regions > 0 {
            let fewer = |m: &mut Model| m.directory.metadata.spanning_regions -= 1;
            found(&town.but(fewer), "the number of a region within one tile");
        }
        found(
            &town.but(|m| {
                let metadata = &mut m.directory.metadata;
                (metadata.regions, metadata.spanning_regions, metadata.hole_regions) = (0, 0, 0);
            }),
            "the directory says that there are no regions",
        );
    }
}

/// Each sum of the stored digest may have a wrong count or a wrong sum.
#[test]
fn a_stored_digest_that_is_not_that_of_the_tiles_is_found() {
    type SumOf = fn(&mut Digest) -> &mut DigestSum;
    let sums: [(&str, SumOf); 7] = [
        ("triangles", |digest| &mut digest.triangles),
        ("vertices", |digest| &mut digest.vertices),
        ("constraint-edges", |digest| &mut digest.constraint_edges),
        ("holes", |digest| &mut digest.holes),
        ("vertices-with-z", |digest| &mut digest.vertices_with_z),
        ("edge-sources", |digest| &mut digest.edge_sources),
        ("sites", |digest| &mut digest.sites),
    ];
    for town in towns() {
        for (name, of) in sums {
            for (count, sum) in [(1, 0), (u64::MAX, 0), (0, 1), (0, 1 << 64), (0, 1 << 127)] {
                let wrong = town.but(|m| *of(&mut m.surplus) = DigestSum { count, sum });
                for deep in [false, true] {
                    let error = run(async { wrong.open().await.verify(deep).await })
                        .unwrap_err()
                        .to_string();
                    let is_named = error.contains(&format!("the digest of its tiles is \"{name} "));
                    assert!(is_named && error.contains("but the directory says"), "{error}");
                }
            }
        }
    }
}

#[test]
fn wrong_counts_are_found() {
    for town in towns() {
        found(
            &town.but(|m| m.directory.metadata.hole_regions -= 1),
            "regions are holes",
        );
        found(
            &town.but(|m| m.directory.metadata.hole_triangles -= 1),
            "triangles in holes",
        );
        found(&town.but(|m| m.directory.metadata.sites += 1), "sites");
        found(&town.but(|m| m.tiles[0].sites.clear()), "sites");
    }
}
