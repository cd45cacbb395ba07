//! The regions of a file, largest first.
//!
//! All tiles are scanned once. A region within one tile is complete with that tile. For each region
//! that spans several tiles, a sum is kept. So memory holds these sums and the rows that are shown.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};

use anyhow::ensure;
use delaunay_tiles::store::{Tile, TileReader};
use futures::TryStreamExt;
use serde::Serialize;

use crate::common::{counted, thousands};
use crate::numbers::Table;

/// Number of regions that are shown without `--all`.
const SHOWN: usize = 20;

/// A region. Its field names are stable keys of `--json`.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct RegionRow {
    region: u64,
    area: f64,
    triangles: u64,
    hole: bool,
    depth: i32,
}

/// The totals of regions. Its field names are stable keys of `--json`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct RegionTotal {
    regions: u64,
    hole_regions: u64,
    area: f64,
    hole_area: f64,
    triangles: u64,
    hole_triangles: u64,
}

/// The largest regions, and the totals of all regions.
#[derive(Serialize)]
pub struct Regions {
    #[serde(rename = "region_list")]
    rows: Vec<RegionRow>,
    #[serde(rename = "region_totals")]
    total: RegionTotal,
}

/// A row, ordered by decreasing area and then by increasing region number.
#[derive(Clone, Copy, Debug)]
struct ByArea(RegionRow);

impl Ord for ByArea {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_area = other.0.area.total_cmp(&self.0.area);
        by_area.then(self.0.region.cmp(&other.0.region))
    }
}

impl PartialOrd for ByArea {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for ByArea {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for ByArea {}

/// The first `limit` rows in order, and the totals of all rows.
struct Ranking {
    limit: usize,
    /// The rows, with the last one in order at the top.
    rows: BinaryHeap<ByArea>,
    total: RegionTotal,
}

impl Ranking {
    fn new(limit: usize) -> Self {
        Self {
            limit,
            rows: BinaryHeap::new(),
            total: RegionTotal::default(),
        }
    }

    fn add(&mut self, row: RegionRow) {
        let total = &mut self.total;
        total.regions += 1;
        total.area += row.area;
        total.triangles += row.triangles;
        if row.hole {
            total.hole_regions += 1;
            total.hole_area += row.area;
            total.hole_triangles += row.triangles;
        }
        self.rows.push(ByArea(row));
        if self.rows.len() > self.limit {
            self.rows.pop();
        }
    }

    fn finish(self) -> Regions {
        Regions {
            rows: self.rows.into_sorted_vec().into_iter().map(|row| row.0).collect(),
            total: self.total,
        }
    }
}

/// Collects the regions of a file. A file without regions gives none.
pub async fn gather(reader: &TileReader, all: bool) -> anyhow::Result<Regions> {
    let metadata = reader.metadata();
    let mut ranking = Ranking::new(if all { usize::MAX } else { SHOWN });
    if metadata.regions == 0 {
        return Ok(ranking.finish());
    }
    let mut spanning: BTreeMap<u64, RegionRow> = BTreeMap::new();
    let mut tiles = reader.tiles();
    while let Some(tile) = tiles.try_next().await? {
        for (region, row) in regions_of_tile(&tile) {
            ensure!(
                region < metadata.regions,
                "{}: tile {} has triangles of region {region}, but the directory has {} regions; run tiletool verify for details",
                reader.name(),
                tile.id(),
                metadata.regions
            );
            if region < metadata.spanning_regions {
                let sum = spanning.entry(region).or_insert(RegionRow {
                    area: 0.0,
                    triangles: 0,
                    ..row
                });
                sum.area += row.area;
                sum.triangles += row.triangles;
            } else {
                ranking.add(row);
            }
        }
    }
    spanning.into_values().for_each(|row| ranking.add(row));
    Ok(ranking.finish())
}

/// Returns the triangles that belong to a tile, summed by region.
fn regions_of_tile(tile: &Tile) -> BTreeMap<u64, RegionRow> {
    let mut regions = BTreeMap::new();
    for triangle in tile.owned_triangles() {
        let region = tile.region(triangle);
        let row = regions.entry(region).or_insert_with(|| RegionRow {
            region,
            area: 0.0,
            triangles: 0,
            hole: tile.is_hole(triangle),
            depth: tile.depth(triangle),
        });
        let [a, b, c] = tile.triangle_points(triangle);
        row.area += ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)) / 2.0;
        row.triangles += 1;
    }
    regions
}

impl Regions {
    /// Returns the report for people.
    pub fn report(&self) -> String {
        if self.total.regions == 0 {
            return "The file has no regions\n".to_owned();
        }
        let mut table = Table::new(&["region", "area", "triangles", "kind", "depth"]);
        for row in &self.rows {
            let kind = if row.hole { "hole" } else { "free" };
            table.row([
                thousands(row.region),
                area(row.area),
                thousands(row.triangles),
                kind.to_owned(),
                row.depth.to_string(),
            ]);
        }
        let mut text = table.show(0);
        let total = &self.total;
        let hidden = total.regions - self.rows.len() as u64;
        if hidden > 0 {
            let hidden = counted(hidden, "smaller region", "smaller regions");
            text += &format!("and {hidden}; --all lists them\n");
        }
        text += &format!(
            "{}, area {}, {}; including {}, area {}, {}\n",
            counted(total.regions, "region", "regions"),
            area(total.area),
            counted(total.triangles, "triangle", "triangles"),
            counted(total.hole_regions, "hole", "holes"),
            area(total.hole_area),
            counted(total.hole_triangles, "triangle", "triangles"),
        );
        text
    }
}

/// Formats an area for people: six significant digits, with an exponent instead of many zeros.
fn area(value: f64) -> String {
    let exponent = if value == 0.0 { 0.0 } else { value.abs().log10().floor() };
    if (-4.0..12.0).contains(&exponent) {
        format!("{value:.*}", (5.0 - exponent).clamp(0.0, 9.0) as usize)
    } else {
        format!("{value:.5e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(region: u64, area: f64, hole: bool) -> RegionRow {
        RegionRow {
            region,
            area,
            triangles: 2,
            hole,
            depth: i32::from(hole),
        }
    }

    #[test]
    fn the_largest_regions_are_shown_in_any_input_order() {
        let areas = [3.0, 1.0, 2.0, 3.0, 0.5, 1e30];
        for turn in 0..areas.len() {
            let mut ranking = Ranking::new(4);
            for i in (turn..).take(areas.len()).map(|i| i % areas.len()) {
                ranking.add(row(i as u64, areas[i], i == 2));
            }
            let regions = ranking.finish();
            assert_eq!(regions.rows.iter().map(|r| r.region).collect::<Vec<_>>(), [5, 0, 3, 2]);
            assert_eq!(
                (
                    regions.total.regions,
                    regions.total.hole_regions,
                    regions.total.hole_area
                ),
                (6, 1, 2.0)
            );
            assert_eq!((regions.total.triangles, regions.total.hole_triangles), (12, 2));
        }
    }

    #[test]
    fn the_report_says_how_many_are_hidden() {
        let mut ranking = Ranking::new(2);
        (0..5).for_each(|i| ranking.add(row(i, 1.0 + i as f64, i == 4)));
        let text = ranking.finish().report();
        let lines: Vec<_> = text.lines().collect();
        assert_eq!(lines.len(), 5, "{text}");
        assert!(lines[1].contains("hole") && lines[1].contains("5.00000") && lines[2].contains("free"));
        assert_eq!(lines[3], "and 3 smaller regions; --all lists them");
        assert!(
            lines[4].starts_with("5 regions, area 15.0000, 10 triangles; including 1 hole, area 5.00000, 2 triangles")
        );
        assert_eq!(Ranking::new(2).finish().report(), "The file has no regions\n");
    }

    #[test]
    fn areas_have_six_digits() {
        assert_eq!(
            [0.0, 12.5, 123_456_789.0, 1e-7, 3.25e20].map(area),
            ["0.00000", "12.5000", "123456789", "1.00000e-7", "3.25000e20"]
        );
    }
}
