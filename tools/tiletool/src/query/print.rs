//! Answers for people and programs.

use std::fmt::Write as _;
use std::io::{self, BufWriter, Stdout, Write};

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{Bend, Distance, Near, Path, SiteFound};
use serde_json::{Value, json};

use super::answer::{Answer, Found, Status, name, shown_name, spot};
use super::args::Format;
use super::ask::Ask;
use super::batch::Question;
use super::stage::Stage;
use super::values::{COLLECTION, COLLECTION_END, bounds, line_string, pair, position, with_distance, write_feature};
use super::{along, area};
use crate::common::cell;

/// Prints answers, one after the other.
pub struct Printer {
    format: Format,
    out: BufWriter<Stdout>,
    features: u64,
}

impl Printer {
    /// Prints what comes before all answers, which may come in stages.
    pub fn new(format: Format, ask: Ask, in_stages: bool) -> anyhow::Result<Self> {
        let mut out = BufWriter::new(io::stdout());
        match format {
            Format::Csv if in_stages => writeln!(out, "{},{}", header(ask), Stage::HEADER)?,
            Format::Csv => writeln!(out, "{}", header(ask))?,
            Format::GeoJson => write!(out, "{COLLECTION}")?,
            Format::Text | Format::Json => {}
        }
        Ok(Self {
            format,
            out,
            features: 0,
        })
    }

    /// Prints an answer.
    pub fn print(&mut self, answer: &Answer) -> anyhow::Result<()> {
        match self.format {
            Format::Text => write!(self.out, "{}", text(answer))?,
            Format::Json => writeln!(self.out, "{}", object(answer))?,
            Format::Csv => {
                for row in rows(answer) {
                    writeln!(self.out, "{row}")?;
                }
            }
            Format::GeoJson => self.print_features(features(answer))?,
        }
        Ok(())
    }

    /// Prints one of two answers, at once. Before the first one all may go wrong, which is of no stage.
    pub fn print_stage(&mut self, answer: &Answer, stage: Option<Stage>) -> anyhow::Result<()> {
        match self.format {
            Format::Text => write!(
                self.out,
                "{}{}",
                stage.map(Stage::text).unwrap_or_default(),
                text(answer)
            )?,
            Format::Json => {
                let mut object = object(answer);
                stage.into_iter().for_each(|stage| stage.tell(&mut object));
                writeln!(self.out, "{object}")?;
            }
            Format::Csv => {
                let cells = stage.map_or_else(|| ",,".to_owned(), Stage::cells);
                for row in rows(answer) {
                    writeln!(self.out, "{row},{cells}")?;
                }
            }
            Format::GeoJson => {
                let mut features = features(answer);
                for feature in &mut features {
                    stage
                        .into_iter()
                        .for_each(|stage| stage.tell(&mut feature["properties"]));
                }
                self.print_features(features)?;
            }
        }
        Ok(self.out.flush()?)
    }

    fn print_features(&mut self, features: Vec<Value>) -> anyhow::Result<()> {
        for feature in features {
            write_feature(&mut self.out, self.features, &feature)?;
            self.features += 1;
        }
        Ok(())
    }

    /// Prints what comes behind all answers.
    pub fn finish(mut self) -> anyhow::Result<()> {
        if self.format == Format::GeoJson {
            writeln!(self.out, "{COLLECTION_END}")?;
        }
        Ok(self.out.flush()?)
    }
}

fn header(ask: Ask) -> String {
    let columns = match ask {
        Ask::Locate => "x,y,status,where,a,b,c",
        Ask::Nearest { .. } => "x,y,rank,vertex,site,to_x,to_y,distance",
        Ask::Knn { .. } | Ask::Range { .. } => "x,y,status,rank,site,to_x,to_y,distance,lower,upper",
        Ask::Path => "from_x,from_y,to_x,to_y,status,distance,lower,upper",
        Ask::Along { .. } => return format!("line_from_x,line_from_y,line_to_x,line_to_y,{}", along::COLUMNS),
    };
    columns.to_owned()
}

fn asked(question: Question) -> String {
    match question {
        Question::At(at) => pair(at),
        Question::Way(from, to) => format!("{},{}", pair(from), pair(to)),
    }
}

/// Rows of a table. A cell in quotes may have line ends in it.
fn rows(answer: &Answer) -> Vec<String> {
    let (asked, status) = (asked(answer.question), answer.status.name());
    let mut rows = Vec::new();
    match &answer.found {
        Found::Location(location) => {
            let (what, mut vertices) = spot(location);
            vertices.resize(3, String::new());
            rows.push(format!("{asked},{status},{what},{}", vertices.join(",")));
        }
        Found::Near(all) => {
            for (near, rank) in all.iter().zip(1..) {
                let (vertex, at) = (near.vertex.id, pair(near.vertex.point));
                let site = cell(&name(near.site, near.id.as_deref()));
                rows.push(format!("{asked},{rank},{vertex},{site},{at},{}", near.distance));
            }
        }
        Found::Sites(sites) => {
            for (site, rank) in sites.iter().zip(1..) {
                let name = cell(&name(Some(site.number), site.id.as_deref()));
                let (at, distance) = (pair(site.vertex.point), bounds(&site.distance));
                rows.push(format!("{asked},ok,{rank},{name},{at},{distance}"));
            }
            if answer.status != Status::Ok {
                let lower = if let Status::Budget(at_least) = answer.status {
                    at_least.to_string()
                } else {
                    String::new()
                };
                rows.push(format!("{asked},{status},,,,,,{lower},"));
            }
        }
        Found::Path(path) => {
            let bounds = match (path, answer.status) {
                (Some(path), _) => bounds(&path.distance),
                (None, Status::Budget(at_least)) => format!(",{at_least},"),
                (None, _) => ",,".to_owned(),
            };
            rows.push(format!("{asked},{status},{bounds}"));
        }
        Found::Along(intervals) => {
            for interval in intervals {
                rows.push(format!("{asked},{}", along::row(interval)));
            }
            if answer.status != Status::Ok {
                rows.push(format!("{asked},,,,,,,{status},"));
            }
        }
    }
    rows
}

fn path_value(path: &Path) -> Value {
    let bends = path.bends.iter().map(|bend| {
        let sources = bend.sources.iter();
        let lines = sources.map(|source| json!({"kind": source.kind().to_string(), "line": source.number()}));
        json!({
            "vertex": bend.vertex.id.to_string(),
            "at": position(bend.vertex.point),
            "turns": if bend.turns_left { "left" } else { "right" },
            "edge_to": bend.edge_to.map(|end| end.id.to_string()),
            "lines": lines.collect::<Vec<_>>(),
        })
    });
    json!({
        "points": path.points.iter().map(|&point| position(point)).collect::<Vec<_>>(),
        "bends": bends.collect::<Vec<_>>(),
        "certified": path.is_certified,
    })
}

/// The question and how it ended, as the head of an object.
fn head(answer: &Answer) -> Value {
    let mut value = match answer.question {
        Question::At(at) => json!({"at": position(at)}),
        Question::Way(from, to) => json!({"from": position(from), "to": position(to)}),
    };
    answer.status.put(&mut value);
    value
}

impl Status {
    /// Says in an object how a query ended.
    pub fn put(self, value: &mut Value) {
        value["status"] = self.name().into();
        match self {
            Self::Inside(point, nearest) => {
                value["inside"] = position(point);
                value["nearest_free"] = nearest.map_or(Value::Null, position);
            }
            Self::Budget(at_least) => value["at_least"] = at_least.into(),
            Self::Ok | Self::Unreachable => {}
        }
    }
}

/// What was found, as objects, and where each is.
fn items<'a>(answer: &'a Answer) -> Vec<(Value, Option<Point>, Option<&'a Path>)> {
    match &answer.found {
        Found::Location(location) => {
            let (what, vertices) = spot(location);
            let at = if let Question::At(at) = answer.question {
                Some(at)
            } else {
                None
            };
            vec![(json!({"where": what, "vertices": vertices}), at, None)]
        }
        Found::Near(all) => {
            let item = |near: &Near| {
                let point = near.vertex.point;
                let site = near.site.map(|number| name(Some(number), near.id.as_deref()));
                let (vertex, distance) = (near.vertex.id.to_string(), near.distance);
                let value = json!({"vertex": vertex, "site": site, "to": position(point), "distance": distance});
                (value, Some(point), None)
            };
            all.iter().map(item).collect()
        }
        Found::Sites(sites) => {
            let item = |site: &'a SiteFound| {
                let point = site.vertex.point;
                let value = json!({"site": name(Some(site.number), site.id.as_deref()), "to": position(point)});
                (with_distance(value, &site.distance), Some(point), site.path.as_ref())
            };
            sites.iter().map(item).collect()
        }
        Found::Path(path) => path
            .iter()
            .map(|path| (with_distance(json!({}), &path.distance), None, Some(path)))
            .collect(),
        Found::Along(intervals) => {
            let item = |interval| (along::object(interval), None, None);
            intervals.iter().map(item).collect()
        }
    }
}

fn object(answer: &Answer) -> Value {
    let mut value = head(answer);
    if let Some(cost) = &answer.cost {
        value["statistics"] = cost.object.clone();
    }
    let items = items(answer).into_iter().map(|(mut item, _, path)| {
        if let Some(path) = path {
            item["path"] = path_value(path);
        }
        item
    });
    let mut items: Vec<Value> = items.collect();
    match (&answer.found, items.pop()) {
        (Found::Location(_) | Found::Path(_), Some(Value::Object(item))) => {
            item.into_iter().for_each(|(key, item)| value[key] = item);
        }
        (found, last) => {
            let key = match found {
                Found::Near(_) => "nearest",
                Found::Along(_) => "intervals",
                _ => "sites",
            };
            items.extend(last);
            if !matches!(found, Found::Path(_)) {
                value[key] = items.into();
            }
        }
    }
    value
}

/// Intervals and areas have a place of their own.
fn shapes(answer: &Answer) -> Option<Vec<Value>> {
    match (&answer.found, &answer.area) {
        (Found::Along(intervals), _) if !intervals.is_empty() => {
            let feature = |interval| {
                let properties = along::object(interval);
                json!({"type": "Feature", "properties": properties, "geometry": along::geometry(interval)})
            };
            Some(intervals.iter().map(feature).collect())
        }
        (_, Some(polygons)) => {
            let mut properties = head(answer);
            properties["tolerance"] = area::TOLERANCE.into();
            let feature = json!({"type": "Feature", "properties": properties, "geometry": area::geometry(polygons)});
            Some(vec![feature])
        }
        _ => None,
    }
}

fn features(answer: &Answer) -> Vec<Value> {
    let mut features = shapes(answer).unwrap_or_default();
    if features.is_empty() || matches!(&answer.found, Found::Sites(sites) if !sites.is_empty()) {
        features.extend(items_as_features(answer));
    }
    features
}

fn items_as_features(answer: &Answer) -> Vec<Value> {
    let head = head(answer);
    let mut items = items(answer);
    if items.is_empty() {
        items.push((json!({}), None, None));
    }
    let feature = |(mut item, point, path): (Value, Option<Point>, Option<&Path>)| {
        if let (Value::Object(item), Value::Object(head)) = (&mut item, &head) {
            item.extend(head.clone());
        }
        let geometry = match (path, point) {
            (Some(path), _) => line_string(path),
            (None, Some(point)) => json!({"type": "Point", "coordinates": position(point)}),
            (None, None) => Value::Null,
        };
        json!({"type": "Feature", "properties": item, "geometry": geometry})
    };
    items.into_iter().map(feature).collect()
}

/// The bounds, if more than rounding is between them.
fn uncertainty(distance: &Distance) -> String {
    if distance.upper > distance.lower * (1.0 + 1e-9) {
        format!(", between {} and {}", distance.lower, distance.upper)
    } else {
        String::new()
    }
}

/// Says in a line of text how a query ended, if not well.
pub fn say(text: &mut String, status: Status) {
    match status {
        Status::Ok => {}
        Status::Unreachable => text.push_str(": no way leads there"),
        Status::Inside(point, nearest) => {
            _ = write!(text, ": ({}, {}) lies in an obstacle", point.x, point.y);
            if let Some(nearest) = nearest {
                _ = write!(text, "; the nearest free point is ({}, {})", nearest.x, nearest.y);
            }
        }
        Status::Budget(at_least) => _ = write!(text, ": stopped early; what is not here is at least {at_least} away"),
    }
}

fn text(answer: &Answer) -> String {
    let mut text = match answer.question {
        Question::At(at) => format!("({}, {})", at.x, at.y),
        Question::Way(from, to) => format!("({}, {}) to ({}, {})", from.x, from.y, to.x, to.y),
    };
    match (answer.status, &answer.found) {
        (Status::Budget(_), Found::Along(_)) => text.push_str(": stopped early; what comes behind is not known"),
        (status, _) => say(&mut text, status),
    }
    match &answer.found {
        Found::Location(location) => {
            let (what, vertices) = spot(location);
            text += &match what {
                "outside" => ": outside the hull".to_owned(),
                "triangle" => format!(": in triangle {}", vertices.join(" ")),
                what => format!(": on {what} {}", vertices.join(" ")),
            };
        }
        Found::Path(Some(path)) => {
            text += &format!(": {}{}", path.distance.value, uncertainty(&path.distance));
            path.bends.iter().for_each(|bend| say_bend(&mut text, bend));
        }
        Found::Near(_) | Found::Sites(_) | Found::Path(None) | Found::Along(_) => {}
    }
    text.push('\n');
    match &answer.found {
        Found::Near(all) => {
            for (near, rank) in all.iter().zip(1..) {
                let what = match near.site {
                    Some(number) => format!("site {}", shown_name(Some(number), near.id.as_deref())),
                    None => format!("vertex {}", near.vertex.id),
                };
                say_found(&mut text, rank, near.distance, &what, near.vertex.point);
                text.push('\n');
            }
        }
        Found::Sites(sites) => {
            for (site, rank) in sites.iter().zip(1..) {
                let what = format!("site {}", shown_name(Some(site.number), site.id.as_deref()));
                say_found(&mut text, rank, site.distance.value, &what, site.vertex.point);
                text += &format!("{}\n", uncertainty(&site.distance));
            }
        }
        Found::Along(intervals) => intervals.iter().for_each(|interval| along::say(&mut text, interval)),
        Found::Location(_) | Found::Path(_) => {}
    }
    text
}

/// Begins a line about what was found.
fn say_found(text: &mut String, rank: u32, distance: f64, what: &str, Point { x, y }: Point) {
    _ = write!(text, "{rank:4}  {distance:<20} {what} at ({x}, {y})");
}

/// A line about a bend of a path.
fn say_bend(text: &mut String, bend: &Bend) {
    let Point { x, y } = bend.vertex.point;
    let turn = if bend.turns_left { "left" } else { "right" };
    let lines = bend.sources.iter();
    let lines: Vec<_> = lines
        .map(|source| format!("{} {}", source.kind(), source.number()))
        .collect();
    let around = match (bend.edge_to, lines.is_empty()) {
        (None, _) => "nothing: a shorter path goes straight on".to_owned(),
        (_, true) => "a hole".to_owned(),
        _ => lines.join(", "),
    };
    _ = write!(text, "\n      {turn} at ({x}, {y}), around {around}");
}
