//! Runs the same queries by all methods, one after the other.

use anyhow::bail;
use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::baselines::{Measured, Method, Statistics};
use delaunay_tiles::query::{QueryOptions, SiteFound};
use delaunay_tiles::store::TileReader;
use lab::median;

/// The sites that are requested.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RequestedSites {
    /// The nearest sites, and their number.
    Nearest(u32),
    /// All sites within a distance. The distance is the median of those of the farthest of the
    /// nearest sites, whose number is first.
    Within(u32, f64),
}

/// The cost of a query by a method.
#[derive(Clone, Debug)]
pub struct Cost {
    pub requested: RequestedSites,
    pub method: Method,
    /// The index of the point.
    pub index: usize,
    pub found: usize,
    pub milliseconds: f64,
    pub statistics: Statistics,
}

/// Lengths are equal if their relative difference is at most this.
const SAME: f64 = 1e-9;

/// Queries all points for all numbers of sites, by all methods; the others are compared with the
/// first.
///
/// Fails if two methods differ.
pub async fn measure(
    reader: &TileReader,
    points: &[Point],
    k: &[u32],
    methods: &[Method],
) -> anyhow::Result<Vec<Cost>> {
    let mut costs = Vec::new();
    for &k in k {
        let farthest = ask(reader, points, RequestedSites::Nearest(k), methods, &mut costs).await?;
        let radius = median(&farthest);
        ask(reader, points, RequestedSites::Within(k, radius), methods, &mut costs).await?;
    }
    Ok(costs)
}

/// Queries all points for the same sites, and returns the distance of the farthest site of each
/// point.
async fn ask(
    reader: &TileReader,
    points: &[Point],
    requested: RequestedSites,
    methods: &[Method],
    costs: &mut Vec<Cost>,
) -> anyhow::Result<Vec<f64>> {
    let mut farthest = Vec::new();
    for (index, &at) in points.iter().enumerate() {
        // An unmeasured query first, so that no method finds tiles in the cache that another method
        // had to read.
        let expected = query(reader, at, requested, methods[0]).await?.answer;
        farthest.extend(expected.last().map(|site| site.distance.value));
        // The first method rotates.
        for turn in 0..methods.len() {
            let method = methods[(turn + index) % methods.len()];
            let Measured { answer, statistics, .. } = query(reader, at, requested, method).await?;
            if !is_same(&answer, &expected) {
                bail!(
                    "{} and {} give different answers from ({}, {})",
                    name(method),
                    name(methods[0]),
                    at.x,
                    at.y
                );
            }
            costs.push(Cost {
                requested,
                method,
                index,
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
    requested: RequestedSites,
    method: Method,
) -> anyhow::Result<Measured<Vec<SiteFound>>> {
    let options = QueryOptions::default();
    Ok(match requested {
        RequestedSites::Nearest(k) => reader.nearest_sites_by(method, at, k as usize, options).await?,
        RequestedSites::Within(_, radius) => reader.sites_within_by(method, at, radius, options).await?,
    })
}

fn is_same(found: &[SiteFound], expected: &[SiteFound]) -> bool {
    let is_near = |a: f64, b: f64| (a - b).abs() <= SAME * b;
    let mut pairs = found.iter().zip(expected);
    found.len() == expected.len() && pairs.all(|(a, b)| is_near(a.distance.value, b.distance.value))
}

/// Returns the name of a method in tables and legends.
pub fn name(method: Method) -> String {
    match method {
        Method::Wavefront => "wavefront".to_owned(),
        Method::Visibility { stretch } => format!("visibility, t = {}", stretch.get()),
        Method::EuclidZhang => "Zhang et al.".to_owned(),
        Method::EuclidXia => "Xia et al.".to_owned(),
    }
}
