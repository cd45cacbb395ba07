//! Models in which component tables are wrong in one respect each.

use crate::store::format::component_table::ComponentId;
use crate::store::format::ids::TileId;
use crate::store::verify::tests::model::TableChange;
use crate::store::verify::tests::tables::tables;
use crate::store::verify::tests::town::towns;

#[test]
fn a_wrong_record_of_a_component_is_found() {
    let changes: [(&str, TableChange); 8] = [
        ("region", |record| record.component.region ^= 1),
        ("depth", |record| record.component.depth += 1),
        ("hole", |record| record.component.is_hole ^= true),
        ("seeded", |record| record.is_seeded ^= true),
        ("open", |record| record.is_open ^= true),
        ("at the hull", |record| record.is_at_hull ^= true),
        ("count", |record| record.triangles.count += 1),
        ("sum", |record| record.triangles.sum ^= 1 << 100),
    ];
    for town in towns() {
        for (table, id) in tables(&town.model).iter().zip((0..).map(TileId)) {
            for component in (0..table.records.len()).step_by(3) {
                // Without triangles, no sum is stored.
                let is_empty = table.records[component].triangles.count == 0;
                for (what, change) in changes.into_iter().filter(|(what, _)| *what != "sum" || !is_empty) {
                    let wrong = town.but(|m| m.table_changes.push((id, component, change)));
                    assert!(wrong.verify().is_err(), "{what} of component {component} of tile {id}");
                }
            }
        }
    }
}

#[test]
fn a_link_too_many_one_too_few_and_one_to_another_component_are_found() {
    let changes: [(&str, TableChange); 5] = [
        ("the first is missing", |record| _ = record.links.remove(0)),
        ("the last is missing", |record| _ = record.links.pop()),
        ("the first leads elsewhere", |record| record.links[0].number += 1),
        ("the last leads elsewhere", |record| {
            record.links.last_mut().unwrap().number ^= 1;
        }),
        ("there is one more", |record| {
            let mut link = record.links[record.links.len() - 1];
            link.number += 1;
            record.links.push(link);
        }),
    ];
    let mut tried = 0;
    for town in towns() {
        for (table, id) in tables(&town.model).iter().zip((0..).map(TileId)) {
            for (record, component) in table.records.iter().zip(0..) {
                for (what, change) in changes.iter().filter(|_| !record.links.is_empty()) {
                    let wrong = town.but(|m| m.table_changes.push((id, component, *change)));
                    assert!(wrong.verify().is_err(), "{what} in component {component} of tile {id}");
                    tried += 1;
                }
                let to_nowhere: TableChange = |record| {
                    let nowhere = ComponentId {
                        tile: TileId(1_000_000),
                        number: 0,
                    };
                    record.links.push(nowhere);
                };
                let wrong = town.but(|m| m.table_changes.push((id, component, to_nowhere)));
                assert!(wrong.verify().is_err(), "component {component} of tile {id}");
            }
        }
    }
    assert!(tried > 100, "{tried}");
}
