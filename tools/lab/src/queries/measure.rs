//! The same queries by all methods, one after the other.

use anyhow::bail;
use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::baselines::{Measured, Method, Statistics};
use delaunay_tiles::query::{QueryOptions, SiteFound};
use delaunay_tiles::store::TileReader;
use lab::median;

/// Which sites are asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wanted {
    /// So many, the nearest.
    Nearest(u32),
    /// All within a distance: the median of that of the nearest so many.
    Within(u32, f64),
}

/// What a query cost by a method.
#[derive(Clone, Debug)]
pub struct Cost {
    pub wanted: Wanted,
    pub method: Method,
    /// The number of the place, from 0.
    pub place: usize,
    pub found: usize,
    pub milliseconds: f64,
    pub statistics: Statistics,
}

/// Lengths that differ by more than this part are not the same.
const SAME: f64 = 1e-9;

/// Asks all places for all numbers of sites, by all methods, of which the first is what the others are compared with.
///
/// Fails if two methods do not say the same.
pub async fn measure(
    reader: &TileReader,
    places: &[Point],
    k: &[u32],
    methods: &[Method],
) -> anyhow::Result<Vec<Cost>> {
    let mut costs = Vec::new();
    for &k in k {
        let farthest = ask(reader, places, Wanted::Nearest(k), methods, &mut costs).await?;
        let radius = median(&farthest);
        ask(reader, places, Wanted::Within(k, radius), methods, &mut costs).await?;
    }
    Ok(costs)
}

/// Asks all places for the same, and returns how far the farthest of the sites is.
async fn ask(
    reader: &TileReader,
    places: &[Point],
    wanted: Wanted,
    methods: &[Method],
    costs: &mut Vec<Cost>,
) -> anyhow::Result<Vec<f64>> {
    let mut farthest = Vec::new();
    for (place, &at) in places.iter().enumerate() {
        // Once without measuring, so that no method finds tiles in the cache that another one had to read.
        let expected = query(reader, at, wanted, methods[0]).await?.answer;
        farthest.extend(expected.last().map(|site| site.distance.value));
        // In turn each one is the first.
        for turn in 0..methods.len() {
            let method = methods[(turn + place) % methods.len()];
            let Measured { answer, statistics, .. } = query(reader, at, wanted, method).await?;
            if !is_same(&answer, &expected) {
                bail!(
                    "{} and {} do not say the same from ({}, {})",
                    name(method),
                    name(methods[0]),
                    at.x,
                    at.y
                );
            }
            costs.push(Cost {
                wanted,
                method,
                place,
                found: answer.len(),
                milliseconds: 1e3 * statistics.time().as_secs_f64(),
                statistics,
            });
        }
    }
    Ok(farthest)
}

async fn query(
    reader: &TileReader,
    at: Point,
    wanted: Wanted,
    method: Method,
) -> anyhow::Result<Measured<Vec<SiteFound>>> {
    let options = QueryOptions::default();
    Ok(match wanted {
        Wanted::Nearest(k) => reader.nearest_sites_by(method, at, k as usize, options).await?,
        Wanted::Within(_, radius) => reader.sites_within_by(method, at, radius, options).await?,
    })
}

fn is_same(found: &[SiteFound], expected: &[SiteFound]) -> bool {
    let is_near = |a: f64, b: f64| (a - b).abs() <= SAME * b;
    let mut pairs = found.iter().zip(expected);
    found.len() == expected.len() && pairs.all(|(a, b)| is_near(a.distance.value, b.distance.value))
}

/// The name of a method in tables and legends.
pub fn name(method: Method) -> String {
    match method {
        Method::Wave => "wave".to_owned(),
        Method::Visibility { stretch } => format!("visibility, t = {}", stretch.get()),
        Method::EuclidZhang => "Zhang et al.".to_owned(),
        Method::EuclidXia => "Xia et al.".to_owned(),
    }
}
