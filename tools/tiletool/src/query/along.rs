//! Output of the nearest sites along a line.

use std::fmt::Write as _;

use delaunay_tiles::query::{AlongInterval, SiteAlong};
use serde_json::{Value, json};

use super::answer::{displayed_name, name};
use super::values::{pair, position};
use crate::common::cell;
use crate::units::number;

/// The CSV columns of a site of an interval.
pub const COLUMNS: &str = "from_t,to_t,from_x,from_y,to_x,to_y,status,rank,site,from_distance,to_distance";

const fn status(interval: &AlongInterval) -> &'static str {
    match interval.sites {
        Some(_) => "ok",
        None => "inside_obstacle",
    }
}

/// Returns the CSV rows of an interval: one for each site, or one without a site.
pub fn rows(interval: &AlongInterval) -> Vec<String> {
    let positions = [interval.from_t, interval.to_t].map(|t| t.to_string()).join(",");
    let points = [interval.from, interval.to].map(pair).join(",");
    let start = format!("{positions},{points},{}", status(interval));
    let row = |(site, rank): (&SiteAlong, u32)| {
        let [from, to] = site.distances;
        let site = cell(&name(Some(site.number), site.id.as_deref()));
        format!("{start},{rank},{site},{from},{to}")
    };
    match interval.sites.as_deref() {
        None | Some([]) => vec![format!("{start},,,,")],
        Some(sites) => sites.iter().zip(1..).map(row).collect(),
    }
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
        Some(sites) => {
            let names = sites
                .iter()
                .map(|site| displayed_name(Some(site.number), site.id.as_deref()));
            names.collect::<Vec<_>>().join(", ")
        }
    };
    let [from, to] = [interval.from_t, interval.to_t].map(number);
    _ = writeln!(text, "  {from:<8} to {to:<8}  {names}");
}
