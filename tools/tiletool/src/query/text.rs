//! Answers as text for people.

use std::fmt::Write as _;

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{Bend, Distance};
use delaunay_tiles_answers::answer::{Answer, QueryResult, Status, displayed_name};
use delaunay_tiles_answers::ask::Ask;
use delaunay_tiles_answers::asked::Asked;
use delaunay_tiles_answers::question::Question;
use delaunay_tiles_answers::units::{Measure, Unit, number};

use super::along;
use crate::common::counted;

/// Returns an answer as text, with a line break at its end.
pub fn text(asked: Asked, answer: &Answer) -> String {
    let mut text = match answer.question {
        Question::At(at) => point(at),
        Question::Way(from, to) => format!("{} to {}", point(from), point(to)),
    };
    match (answer.status, &answer.found) {
        (Status::Budget(_), QueryResult::Along(_)) => {
            text.push_str(": stopped at a limit; the rest of the line is unknown");
        }
        (status, _) => push_status(&mut text, status, asked.unit),
    }
    if let Some(note) = asked.note(answer) {
        _ = write!(text, ": {note}");
    } else if answer.status == Status::Ok {
        text += &heading(asked, answer);
    }
    if let QueryResult::Location(located) = &answer.found {
        let vertices = located.ids().join(" ");
        text += &match located.element() {
            "outside" => ": outside the convex hull".to_owned(),
            "triangle" => format!(": in triangle {vertices}"),
            element => format!(": on {element} {vertices}"),
        };
        if let Some(z) = located.z {
            _ = write!(text, "; z {z}");
        }
    }
    if let Some(area) = &answer.area {
        let at_least = if answer.status == Status::Ok { "" } else { "at least " };
        _ = write!(text, "; area {at_least}{}", asked.unit.area(area.size));
    }
    text.push('\n');
    push_items(&mut text, answer);
    text
}

/// Returns what the first line says about the items that were found.
fn heading(asked: Asked, answer: &Answer) -> String {
    let unit = asked.unit.name();
    match (&answer.found, asked.ask) {
        (QueryResult::Near(near), _) => {
            let count = near.len() as u64;
            let count = match near.first().and_then(|near| near.site) {
                Some(_) => counted(count, "site", "sites"),
                None => counted(count, "vertex", "vertices"),
            };
            format!(": {count} by Euclidean distance, in {unit}")
        }
        (QueryResult::Sites(sites), Ask::Range { radius, .. }) => {
            let count = counted(sites.len() as u64, "site", "sites");
            format!(": {count} within a walking distance of {}", asked.unit.distance(radius))
        }
        (QueryResult::Sites(sites), _) => {
            let count = counted(sites.len() as u64, "site", "sites");
            format!(": {count} by walking distance, in {unit}")
        }
        (QueryResult::Path(Some(path)), _) => {
            let distance = asked.unit.distance(path.distance.value);
            format!(": {distance}{}", uncertainty(&path.distance))
        }
        (QueryResult::Along(_), _) => ": the nearest sites, from 0 at the start to 1 at the end".to_owned(),
        (QueryResult::Location(_) | QueryResult::Path(None), _) => String::new(),
    }
}

/// Appends the lines after the first one.
fn push_items(text: &mut String, answer: &Answer) {
    match &answer.found {
        QueryResult::Near(all) => {
            for (near, rank) in all.iter().zip(1..) {
                let what = match near.site {
                    Some(number) => format!("site {}", displayed_name(Some(number), near.id.as_deref())),
                    None => format!("vertex {}", near.vertex.id),
                };
                push_item(text, rank, near.distance, &what, near.vertex.point);
                text.push('\n');
            }
        }
        QueryResult::Sites(sites) => {
            for (site, rank) in sites.iter().zip(1..) {
                let what = format!("site {}", displayed_name(Some(site.number), site.id.as_deref()));
                push_item(text, rank, site.distance.value, &what, site.vertex.point);
                text.push_str(&uncertainty(&site.distance));
                text.push('\n');
            }
        }
        QueryResult::Path(path) => path
            .iter()
            .flat_map(|path| &path.bends)
            .for_each(|bend| push_bend(text, bend)),
        QueryResult::Along(intervals) => intervals
            .iter()
            .for_each(|interval| along::push_interval(text, interval)),
        QueryResult::Location(located) => {
            for (vertex, z) in &located.vertices {
                if let Some(z) = z {
                    _ = writeln!(text, "      vertex {} at {}, z {z}", vertex.id, point(vertex.point));
                }
            }
        }
    }
}

/// Formats a point with the shortest digits that read back as its coordinates.
pub fn point(Point { x, y }: Point) -> String {
    format!("({x}, {y})")
}

/// Returns the bounds as text, if they differ in the digits that people see.
fn uncertainty(distance: &Distance) -> String {
    let [lower, upper] = [distance.lower, distance.upper].map(number);
    match lower == upper {
        true => String::new(),
        false => format!(", between {lower} and {upper}"),
    }
}

/// Appends to a line of text how a query ended, if it was not successful.
pub fn push_status(text: &mut String, status: Status, unit: Unit) {
    match status {
        Status::Ok => {}
        Status::Unreachable => text.push_str(": no path exists"),
        Status::Inside(at, nearest) => {
            _ = write!(text, ": {} is inside an obstacle", point(at));
            if let Some(nearest) = nearest {
                _ = write!(text, "; the nearest free point is {}", point(nearest));
            }
        }
        Status::Budget(lower_bound) => {
            let distance = unit.distance(lower_bound);
            _ = write!(
                text,
                ": stopped at a limit; what was not found is at least {distance} away"
            );
        }
    }
}

/// Appends the start of a line about a found item.
fn push_item(text: &mut String, rank: u32, distance: f64, what: &str, at: Point) {
    _ = write!(text, "{rank:4}  {:<12} {what} at {}", number(distance), point(at));
}

/// Appends a line about a bend of a path.
fn push_bend(text: &mut String, bend: &Bend) {
    let turn = if bend.turns_left { "left" } else { "right" };
    let lines = bend.sources.iter();
    let lines: Vec<_> = lines
        .map(|source| format!("{} {}", source.kind(), source.number()))
        .collect();
    let around = match (bend.edge_to, lines.is_empty()) {
        (None, _) => "nothing: there is a shorter path".to_owned(),
        (_, true) => "a hole".to_owned(),
        _ => lines.join(", "),
    };
    _ = writeln!(text, "      {turn} at {}, around {around}", point(bend.vertex.point));
}
