//! CSV and text of the nearest sites along a line.

use std::fmt::Write as _;

use delaunay_tiles::query::{AlongInterval, SiteAlong};
use delaunay_tiles_answers::along::status;
use delaunay_tiles_answers::answer::{displayed_name, name};
use delaunay_tiles_answers::units::number;
use delaunay_tiles_answers::values::pair;

use crate::common::cell;

/// The CSV columns of a site of an interval.
pub const COLUMNS: &str = "from_t,to_t,from_x,from_y,to_x,to_y,status,rank,site,from_distance,to_distance";

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
