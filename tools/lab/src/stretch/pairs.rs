//! Random pairs of vertices, and both distances between them.

use std::collections::BinaryHeap;

use anyhow::{Context, bail};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::baselines::Stretch;
use delaunay_tiles::query::{PathOutcome, QueryError, QueryOptions};
use delaunay_tiles::store::TileReader;
use distributions::mix;
use futures::{StreamExt, TryStreamExt, stream};

/// The maximum number of vertices from which pairs are drawn.
const SAMPLE: usize = 1 << 16;
/// The maximum number of draws for each pair: if most vertices are in obstacles or unconnected,
/// there may be no pair.
const DRAWS: usize = 50;

/// Two vertices that are connected by a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    pub from: Point,
    pub to: Point,
    /// The length of the shortest path among obstacles.
    pub geodesic: f64,
    /// The length of the shortest path along edges of the triangulation.
    pub cdt: f64,
}

impl Pair {
    /// Returns the Euclidean distance.
    pub fn straight(&self) -> f64 {
        (self.from.x - self.to.x).hypot(self.from.y - self.to.y)
    }

    /// Returns the ratio of the distance along edges to the walking distance.
    pub fn ratio(&self) -> f64 {
        // If both are the same path, rounding may give a ratio slightly below 1.
        (self.cdt / self.geodesic).max(1.0)
    }

    /// Returns whether an obstacle is between the two: the path is longer than the straight line,
    /// by more than rounding.
    pub fn is_blocked(&self) -> bool {
        self.geodesic > self.straight() * (1.0 + 1e-12)
    }
}

/// The drawn pairs.
pub struct Drawn {
    pub pairs: Vec<Pair>,
    /// The number of pairs that no path connects, or one of which is not free; others were drawn
    /// instead.
    pub apart: usize,
}

/// Draws `count` pairs. They depend only on the file's vertices and the seed, not on its tiles.
pub async fn draw(reader: &TileReader, count: usize, seed: u64, at_once: usize) -> anyhow::Result<Drawn> {
    let points = sample(reader, seed).await?;
    if points.len() < 2 {
        bail!("{} has fewer than two vertices", reader.name());
    }
    let mut random = Random(seed);
    let most = DRAWS * count;
    let ends = std::iter::repeat_with(|| [random.below(points.len()), random.below(points.len())]);
    let ends = ends.filter(|[from, to]| from != to).take(most);
    let tries = stream::iter(ends).map(|[from, to]| {
        let (reader, from, to) = (reader.clone(), points[from], points[to]);
        let task = tokio::spawn(async move { measure(&reader, from, to).await });
        async move { task.await.context("a query panicked")? }
    });
    // In the order in which they were drawn, whichever is measured first.
    let mut tries = tries.buffered(at_once);
    let (mut pairs, mut apart) = (Vec::new(), 0);
    while pairs.len() < count {
        match tries.try_next().await? {
            Some(Some(pair)) => pairs.push(pair),
            Some(None) => apart += 1,
            None => bail!(
                "{}: of {most} random pairs of vertices only {} are connected; ask for fewer with --pairs",
                reader.name(),
                pairs.len()
            ),
        }
    }
    Ok(Drawn { pairs, apart })
}

/// Returns both distances, or `None` if there is no path.
async fn measure(reader: &TileReader, from: Point, to: Point) -> anyhow::Result<Option<Pair>> {
    let path = match reader.shortest_path(from, to, QueryOptions::default()).await? {
        PathOutcome::Found(path) => path,
        PathOutcome::Unreachable | PathOutcome::InsideObstacle { .. } => return Ok(None),
    };
    let along = match reader.cdt_distance(from, to, QueryOptions::default()).await {
        Ok(Some(along)) => along,
        Ok(None) => bail!("no edges lead from {from:?} to {to:?}, but there is a path: {path:?}"),
        Err(error @ QueryError::InsideObstacle { .. }) => bail!("there is a path from {from:?} to {to:?}, but {error}"),
        Err(error) => return Err(error.into()),
    };
    let pair = Pair {
        from,
        to,
        geodesic: path.distance.value,
        cdt: along.distance.value,
    };
    let is_bounded = along.distance.upper >= path.distance.lower && pair.ratio() <= Stretch::PROVED.get();
    if !is_bounded {
        bail!(
            "from {from:?} to {to:?} it is {} along edges and {} in all: the ratio is not from 1 to {}",
            pair.cdt,
            pair.geodesic,
            Stretch::PROVED.get()
        );
    }
    Ok(Some(pair))
}

/// Returns the vertices with the smallest hashes, in that order: all vertices of a small file.
async fn sample(reader: &TileReader, seed: u64) -> anyhow::Result<Vec<Point>> {
    let mut smallest = BinaryHeap::new();
    let mut tiles = reader.tiles();
    while let Some(tile) = tiles.try_next().await? {
        for point in tile.points() {
            let (x, y) = (point.x.to_bits(), point.y.to_bits());
            let hash = mix(mix(x ^ mix(seed)).wrapping_add(y));
            smallest.push((hash, x, y));
            if smallest.len() > SAMPLE {
                smallest.pop();
            }
        }
    }
    let sorted = smallest.into_sorted_vec().into_iter();
    Ok(sorted
        .map(|(_, x, y)| Point::new(f64::from_bits(x), f64::from_bits(y)))
        .collect())
}

/// Random numbers from a seed (SplitMix64, Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    /// Returns a number below `end`, which must be far less than 2⁶⁴.
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let wide = u128::from(mix(self.0)) * end as u128;
        (wide >> 64) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn random_numbers_are_below_their_end() {
        let mut random = Random(1);
        let mut seen = [0; 7];
        (0..7000).for_each(|_| seen[random.below(7)] += 1);
        assert!(seen.iter().all(|count| (800..1200).contains(count)), "{seen:?}");
    }

    #[test]
    fn ratios_are_not_below_one() {
        let pair = Pair {
            from: Point::new(0.0, 0.0),
            to: Point::new(3.0, 4.0),
            geodesic: 5.0,
            cdt: 5.0f64.next_down(),
        };
        assert_eq!((pair.ratio(), pair.is_blocked(), pair.straight()), (1.0, false, 5.0));
    }
}
