//! The page about both distances.

use delaunay_tiles::query::baselines::Stretch;
use delaunay_tiles::store::TileReader;

use super::pairs::{Drawn, Pair};
use super::pictures::{Figures, Named, worst};
use crate::folder::Folder;
use crate::machine;
use crate::pictures::Pictures;
use crate::plot::chart::Histogram;
use crate::table::{Cell, Column, Table};
use tiletool::common::thousands;

/// The maximum and the minimum number of bins of the histogram.
const BINS: (usize, usize) = (60, 10);

/// The columns of the table of all pairs.
pub const COLUMNS: &[Column<Pair>] = &[
    ("from_x", |pair| Cell::Number(pair.from.x, 6)),
    ("from_y", |pair| Cell::Number(pair.from.y, 6)),
    ("to_x", |pair| Cell::Number(pair.to.x, 6)),
    ("to_y", |pair| Cell::Number(pair.to.y, 6)),
    ("straight", |pair| Cell::Number(pair.straight(), 6)),
    ("geodesic", |pair| Cell::Number(pair.geodesic, 6)),
    ("cdt", |pair| Cell::Number(pair.cdt, 6)),
    ("ratio", |pair| Cell::Number(pair.ratio(), 6)),
];

/// Keeps the page, the histogram and the figures.
pub fn keep(
    reader: &TileReader,
    name: &str,
    drawn: &Drawn,
    figures: Figures,
    pictures: Pictures,
    folder: &mut Folder,
) -> anyhow::Result<()> {
    let mut text = introduction(reader, name, drawn);
    text += &ratios(&drawn.pairs);
    let histogram = histogram(&drawn.pairs, name);
    text += &pictures.keep("ratios", &histogram.title, histogram.draw(), folder)?;
    for Named { stem, figure } in figures.drawn {
        text += &pictures.keep(stem, &figure.title, figure.draw()?, folder)?;
    }
    for note in figures.notes {
        text += &format!("\n{note}\n");
    }
    folder.keep("README.md", text);
    Ok(())
}

/// Returns the introduction: the conditions, and the meaning of the terms.
fn introduction(reader: &TileReader, name: &str, drawn: &Drawn) -> String {
    let metadata = reader.metadata();
    format!(
        "# Stretch: {name}\n\n`{}`\n\nThe file has {} vertices, {} triangles, {} of them in obstacles, and {} constraint edges. {} pairs of its vertices were \
         drawn at random; {} more were not connected. *Geodesic* is the length of the shortest path among the obstacles, by the wavefront search; *CDT* that of the shortest path along edges \
         of the constrained Delaunay triangulation. Their ratio is between 1 and {} (Bose and Keil 2006) for each pair; otherwise the experiment fails. \
         A pair is *blocked* if an obstacle is between its vertices. All pairs are in [pairs.csv](pairs.csv).\n\n",
        machine::command(),
        thousands(metadata.vertices),
        thousands(metadata.triangles),
        thousands(metadata.hole_triangles),
        thousands(metadata.constraint_edges),
        thousands(drawn.pairs.len() as u64),
        thousands(drawn.apart as u64),
        Stretch::PROVED.get(),
    )
}

/// Returns the ratios of all pairs and of the blocked pairs, and the largest ratio.
fn ratios(pairs: &[Pair]) -> String {
    let blocked: Vec<Pair> = pairs.iter().copied().filter(Pair::is_blocked).collect();
    let mut table = Table::new([
        "",
        "pairs",
        "mean",
        "median",
        "90 %",
        "99 %",
        "largest",
        "ratio 1",
        "geodesic / straight line, mean",
    ]);
    for (pairs, what) in [(pairs, "all"), (&blocked, "blocked")] {
        if let Some(row) = summary(pairs, what) {
            table.push(row);
        }
    }
    let mut text = table.markdown();
    if let Some(worst) = worst(pairs) {
        text += &format!(
            "\nThe largest ratio is **{:.6}**, from ({}, {}) to ({}, {}).\n",
            worst.ratio(),
            worst.from.x,
            worst.from.y,
            worst.to.x,
            worst.to.y
        );
    }
    text
}

/// Returns statistics of some pairs' ratios, or `None` if there are no pairs.
fn summary(pairs: &[Pair], what: &str) -> Option<[Cell; 9]> {
    let mut ratios: Vec<f64> = pairs.iter().map(Pair::ratio).collect();
    ratios.sort_by(f64::total_cmp);
    let largest = *ratios.last()?;
    let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / pairs.len() as f64;
    // The least ratio that `percent` per cent of the ratios do not exceed.
    let quantile = |percent: usize| ratios[(ratios.len() * percent).div_ceil(100).saturating_sub(1)];
    let equal = ratios.iter().filter(|ratio| **ratio <= 1.0 + 1e-12).count();
    let share = 100.0 * equal as f64 / ratios.len() as f64;
    Some([
        what.into(),
        (pairs.len() as u64).into(),
        Cell::Number(mean(&mut ratios.iter().copied()), 4),
        Cell::Number(quantile(50), 4),
        Cell::Number(quantile(90), 4),
        Cell::Number(quantile(99), 4),
        Cell::Number(largest, 4),
        Cell::Text(format!("{share:.1} %")),
        Cell::Number(mean(&mut pairs.iter().map(|pair| pair.geodesic / pair.straight())), 4),
    ])
}

/// Returns the histogram of the ratios.
fn histogram(pairs: &[Pair], name: &str) -> Histogram {
    let largest = pairs.iter().map(Pair::ratio).fold(1.0, f64::max);
    let width = if largest > 1.0 + 0.01 * BINS.0 as f64 {
        0.05
    } else {
        0.01
    };
    let bins = ((largest - 1.0) / width).floor() as usize + 1;
    let mut counts = vec![0; bins.max(BINS.1)];
    for pair in pairs {
        counts[((pair.ratio() - 1.0) / width).floor() as usize] += 1;
    }
    Histogram {
        title: "CDT distance by geodesic distance".to_owned(),
        subtitle: format!("{} random pairs of vertices of {name}", thousands(pairs.len() as u64)),
        x: "ratio".to_owned(),
        y: "pairs".to_owned(),
        start: 1.0,
        width,
        counts,
    }
}

#[cfg(test)]
mod tests {
    use delaunay_tiles::geometry::Point;

    use super::*;

    fn pair(geodesic: f64, cdt: f64) -> Pair {
        Pair {
            from: Point::new(0.0, 0.0),
            to: Point::new(1.0, 0.0),
            geodesic,
            cdt,
        }
    }

    #[test]
    fn every_pair_is_in_a_bin() {
        for cdts in [vec![1.0], vec![1.0, 1.005, 1.3], vec![1.0, 2.41]] {
            let pairs: Vec<_> = cdts.iter().map(|&cdt| pair(1.0, cdt)).collect();
            let histogram = histogram(&pairs, "test");
            assert_eq!(histogram.counts.iter().sum::<u64>(), pairs.len() as u64);
            assert!((BINS.1..=BINS.0 + 1).contains(&histogram.counts.len()));
        }
    }

    #[test]
    fn the_summary_has_the_quantiles_of_the_ratios() {
        let pairs: Vec<_> = (0..100).map(|i| pair(1.0, 1.0 + f64::from(i) / 100.0)).collect();
        let row = summary(&pairs, "all").unwrap();
        let Cell::Number(median, _) = row[3] else { panic!() };
        let Cell::Number(most, _) = row[5] else { panic!() };
        assert_eq!((median, most), (1.49, 1.98));
        assert_eq!(row[7], Cell::Text("1.0 %".to_owned()));
        assert!(summary(&[], "none").is_none());
    }
}
