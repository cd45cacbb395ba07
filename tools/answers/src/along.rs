//! The nearest sites along a line, as JSON and GeoJSON.

use delaunay_tiles::query::{AlongInterval, SiteAlong};
use serde_json::{Value, json};

use crate::answer::name;
use crate::values::position;

/// Returns how an interval ended: `ok`, or `inside_obstacle`.
pub const fn status(interval: &AlongInterval) -> &'static str {
    match interval.sites {
        Some(_) => "ok",
        None => "inside_obstacle",
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
