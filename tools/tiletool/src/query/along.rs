//! Output of the nearest sites along a line.

use std::fmt::Write as _;

use delaunay_tiles::query::{AlongInterval, SiteAlong};
use delaunay_tiles::shown;
use serde_json::{Value, json};

use super::answer::name;
use super::values::{pair, position};
use crate::common::cell;

/// The CSV columns of an interval.
pub const COLUMNS: &str = "from_t,to_t,from_x,from_y,to_x,to_y,status,sites";

const fn status(interval: &AlongInterval) -> &'static str {
    match interval.sites {
        Some(_) => "ok",
        None => "inside_obstacle",
    }
}

fn names(interval: &AlongInterval) -> Vec<String> {
    let of = |site: &SiteAlong| name(Some(site.number), site.id.as_deref());
    interval.sites.iter().flatten().map(of).collect()
}

/// Returns the CSV row of an interval, with all sites in one cell.
pub fn row(interval: &AlongInterval) -> String {
    let positions = [interval.from_t, interval.to_t].map(|t| t.to_string()).join(",");
    let points = [interval.from, interval.to].map(pair).join(",");
    format!(
        "{positions},{points},{},{}",
        status(interval),
        cell(&names(interval).join(";"))
    )
}

/// Returns the JSON object of an interval.
pub fn object(interval: &AlongInterval) -> Value {
    let sites = interval.sites.as_ref().map(|sites| {
        let of = |site: &SiteAlong| {
            json!({
                "site": name(Some(site.number), site.id.as_deref()),
                "to": position(site.vertex.point),
                "distances": site.distances,
            })
        };
        sites.iter().map(of).collect::<Vec<_>>()
    });
    json!({
        "from_t": interval.from_t,
        "to_t": interval.to_t,
        "from": position(interval.from),
        "to": position(interval.to),
        "status": status(interval),
        "sites": sites,
    })
}

/// Returns the GeoJSON geometry of an interval.
pub fn geometry(interval: &AlongInterval) -> Value {
    json!({"type": "LineString", "coordinates": [position(interval.from), position(interval.to)]})
}

/// Appends a line of text about an interval.
pub fn push_interval(text: &mut String, interval: &AlongInterval) {
    let names = match &interval.sites {
        None => "inside an obstacle".to_owned(),
        Some(sites) if sites.is_empty() => "no site can be reached".to_owned(),
        Some(_) => shown::text(&names(interval).join(", ")).into_owned(),
    };
    _ = writeln!(text, "  {:<20} to {:<20} {names}", interval.from_t, interval.to_t);
}
