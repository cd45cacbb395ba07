//! Prints answers for people and programs.

use std::fmt::Write as _;
use std::io::{BufWriter, Write};

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{Bend, Distance, Near, Path, SiteFound};
use serde_json::{Value, json};

use super::answer::{Answer, QueryResult, Status, displayed_name, location_parts, name};
use super::args::Format;
use super::ask::Ask;
use super::batch::Question;
use super::stage::Stage;
use super::values::{COLLECTION, COLLECTION_END, bounds, line_string, pair, position, with_distance, write_feature};
use super::{along, area};
use crate::common::cell;
use crate::output::StandardOutput;

/// Prints answers, one after the other.
pub struct Printer {
    format: Format,
    out: BufWriter<StandardOutput>,
    features: u64,
}

impl Printer {
    /// Creates a printer and prints what precedes all answers. `in_stages` says whether answers
    /// come in stages.
    pub fn new(format: Format, ask: Ask, in_stages: bool) -> anyhow::Result<Self> {
        let mut out = BufWriter::new(StandardOutput::of("the answers"));
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

    /// Prints one of the two answers to a question, without delay. `stage` is `None` for an error
    /// before the first answer.
    pub fn print_stage(&mut self, answer: &Answer, stage: Option<Stage>) -> anyhow::Result<()> {
        match self.format {
            Format::Text => write!(
                self.out,
                "{}{}",
                stage.map(Stage::prefix).unwrap_or_default(),
                text(answer)
            )?,
            Format::Json => {
                let mut object = object(answer);
                stage.into_iter().for_each(|stage| stage.add_to(&mut object));
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
                        .for_each(|stage| stage.add_to(&mut feature["properties"]));
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

    /// Prints what follows all answers.
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

fn question_cells(question: Question) -> String {
    match question {
        Question::At(at) => pair(at),
        Question::Way(from, to) => format!("{},{}", pair(from), pair(to)),
    }
}

/// Returns the CSV rows of an answer. A quoted cell may contain line breaks.
fn rows(answer: &Answer) -> Vec<String> {
    let (question_cells, status) = (question_cells(answer.question), answer.status.name());
    let mut rows = Vec::new();
    match &answer.found {
        QueryResult::Location(location) => {
            let (what, mut vertices) = location_parts(location);
            vertices.resize(3, String::new());
            rows.push(format!("{question_cells},{status},{what},{}", vertices.join(",")));
        }
        QueryResult::Near(all) => {
            for (near, rank) in all.iter().zip(1..) {
                let (vertex, at) = (near.vertex.id, pair(near.vertex.point));
                let site = cell(&name(near.site, near.id.as_deref()));
                rows.push(format!(
                    "{question_cells},{rank},{vertex},{site},{at},{}",
                    near.distance
                ));
            }
        }
        QueryResult::Sites(sites) => {
            for (site, rank) in sites.iter().zip(1..) {
                let name = cell(&name(Some(site.number), site.id.as_deref()));
                let (at, distance) = (pair(site.vertex.point), bounds(&site.distance));
                rows.push(format!("{question_cells},ok,{rank},{name},{at},{distance}"));
            }
            if answer.status != Status::Ok {
                let lower = if let Status::Budget(at_least) = answer.status {
                    at_least.to_string()
                } else {
                    String::new()
                };
                rows.push(format!("{question_cells},{status},,,,,,{lower},"));
            }
        }
        QueryResult::Path(path) => {
            let bounds = match (path, answer.status) {
                (Some(path), _) => bounds(&path.distance),
                (None, Status::Budget(at_least)) => format!(",{at_least},"),
                (None, _) => ",,".to_owned(),
            };
            rows.push(format!("{question_cells},{status},{bounds}"));
        }
        QueryResult::Along(intervals) => {
            for interval in intervals {
                rows.push(format!("{question_cells},{}", along::row(interval)));
            }
            if answer.status != Status::Ok {
                rows.push(format!("{question_cells},,,,,,,{status},"));
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

/// Returns an object with the question and how it ended.
fn header_object(answer: &Answer) -> Value {
    let mut value = match answer.question {
        Question::At(at) => json!({"at": position(at)}),
        Question::Way(from, to) => json!({"from": position(from), "to": position(to)}),
    };
    answer.status.add_to(&mut value);
    value
}

impl Status {
    /// Adds to an object how a query ended.
    pub fn add_to(self, value: &mut Value) {
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

/// Returns the found items as objects, each with its point and its path, if any.
fn items<'a>(answer: &'a Answer) -> Vec<(Value, Option<Point>, Option<&'a Path>)> {
    match &answer.found {
        QueryResult::Location(location) => {
            let (what, vertices) = location_parts(location);
            let at = if let Question::At(at) = answer.question {
                Some(at)
            } else {
                None
            };
            vec![(json!({"where": what, "vertices": vertices}), at, None)]
        }
        QueryResult::Near(all) => {
            let item = |near: &Near| {
                let point = near.vertex.point;
                let site = near.site.map(|number| name(Some(number), near.id.as_deref()));
                let (vertex, distance) = (near.vertex.id.to_string(), near.distance);
                let value = json!({"vertex": vertex, "site": site, "to": position(point), "distance": distance});
                (value, Some(point), None)
            };
            all.iter().map(item).collect()
        }
        QueryResult::Sites(sites) => {
            let item = |site: &'a SiteFound| {
                let point = site.vertex.point;
                let value = json!({"site": name(Some(site.number), site.id.as_deref()), "to": position(point)});
                (with_distance(value, &site.distance), Some(point), site.path.as_ref())
            };
            sites.iter().map(item).collect()
        }
        QueryResult::Path(path) => path
            .iter()
            .map(|path| (with_distance(json!({}), &path.distance), None, Some(path)))
            .collect(),
        QueryResult::Along(intervals) => {
            let item = |interval| (along::object(interval), None, None);
            intervals.iter().map(item).collect()
        }
    }
}

fn object(answer: &Answer) -> Value {
    let mut value = header_object(answer);
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
        (QueryResult::Location(_) | QueryResult::Path(_), Some(Value::Object(item))) => {
            item.into_iter().for_each(|(key, item)| value[key] = item);
        }
        (found, last) => {
            let key = match found {
                QueryResult::Near(_) => "nearest",
                QueryResult::Along(_) => "intervals",
                _ => "sites",
            };
            items.extend(last);
            if !matches!(found, QueryResult::Path(_)) {
                value[key] = items.into();
            }
        }
    }
    value
}

/// Returns the GeoJSON features of intervals or of an area, which have geometries of their own.
fn shapes(answer: &Answer) -> Option<Vec<Value>> {
    match (&answer.found, &answer.area) {
        (QueryResult::Along(intervals), _) if !intervals.is_empty() => {
            let feature = |interval| {
                let properties = along::object(interval);
                json!({"type": "Feature", "properties": properties, "geometry": along::geometry(interval)})
            };
            Some(intervals.iter().map(feature).collect())
        }
        (_, Some(polygons)) => {
            let mut properties = header_object(answer);
            properties["tolerance"] = area::TOLERANCE.into();
            let feature = json!({"type": "Feature", "properties": properties, "geometry": area::geometry(polygons)});
            Some(vec![feature])
        }
        _ => None,
    }
}

fn features(answer: &Answer) -> Vec<Value> {
    let mut features = shapes(answer).unwrap_or_default();
    if features.is_empty() || matches!(&answer.found, QueryResult::Sites(sites) if !sites.is_empty()) {
        features.extend(items_as_features(answer));
    }
    features
}

fn items_as_features(answer: &Answer) -> Vec<Value> {
    let header_object = header_object(answer);
    let mut items = items(answer);
    if items.is_empty() {
        items.push((json!({}), None, None));
    }
    let feature = |(mut item, point, path): (Value, Option<Point>, Option<&Path>)| {
        if let (Value::Object(item), Value::Object(header_object)) = (&mut item, &header_object) {
            item.extend(header_object.clone());
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

/// Returns the bounds as text, if they differ by more than rounding.
fn uncertainty(distance: &Distance) -> String {
    if distance.upper > distance.lower * (1.0 + 1e-9) {
        format!(", between {} and {}", distance.lower, distance.upper)
    } else {
        String::new()
    }
}

/// Appends to a line of text how a query ended, if it was not successful.
pub fn push_status(text: &mut String, status: Status) {
    match status {
        Status::Ok => {}
        Status::Unreachable => text.push_str(": no path exists"),
        Status::Inside(point, nearest) => {
            _ = write!(text, ": ({}, {}) is inside an obstacle", point.x, point.y);
            if let Some(nearest) = nearest {
                _ = write!(text, "; the nearest free point is ({}, {})", nearest.x, nearest.y);
            }
        }
        Status::Budget(at_least) => {
            _ = write!(
                text,
                ": stopped at a limit; what was not found is at least {at_least} away"
            )
        }
    }
}

fn text(answer: &Answer) -> String {
    let mut text = match answer.question {
        Question::At(at) => format!("({}, {})", at.x, at.y),
        Question::Way(from, to) => format!("({}, {}) to ({}, {})", from.x, from.y, to.x, to.y),
    };
    match (answer.status, &answer.found) {
        (Status::Budget(_), QueryResult::Along(_)) => {
            text.push_str(": stopped at a limit; the rest of the line is unknown")
        }
        (status, _) => push_status(&mut text, status),
    }
    match &answer.found {
        QueryResult::Location(location) => {
            let (what, vertices) = location_parts(location);
            text += &match what {
                "outside" => ": outside the convex hull".to_owned(),
                "triangle" => format!(": in triangle {}", vertices.join(" ")),
                what => format!(": on {what} {}", vertices.join(" ")),
            };
        }
        QueryResult::Path(Some(path)) => {
            text += &format!(": {}{}", path.distance.value, uncertainty(&path.distance));
            path.bends.iter().for_each(|bend| push_bend(&mut text, bend));
        }
        QueryResult::Near(_) | QueryResult::Sites(_) | QueryResult::Path(None) | QueryResult::Along(_) => {}
    }
    text.push('\n');
    match &answer.found {
        QueryResult::Near(all) => {
            for (near, rank) in all.iter().zip(1..) {
                let what = match near.site {
                    Some(number) => format!("site {}", displayed_name(Some(number), near.id.as_deref())),
                    None => format!("vertex {}", near.vertex.id),
                };
                push_item(&mut text, rank, near.distance, &what, near.vertex.point);
                text.push('\n');
            }
        }
        QueryResult::Sites(sites) => {
            for (site, rank) in sites.iter().zip(1..) {
                let what = format!("site {}", displayed_name(Some(site.number), site.id.as_deref()));
                push_item(&mut text, rank, site.distance.value, &what, site.vertex.point);
                text += &format!("{}\n", uncertainty(&site.distance));
            }
        }
        QueryResult::Along(intervals) => intervals
            .iter()
            .for_each(|interval| along::push_interval(&mut text, interval)),
        QueryResult::Location(_) | QueryResult::Path(_) => {}
    }
    text
}

/// Appends the start of a line about a found item.
fn push_item(text: &mut String, rank: u32, distance: f64, what: &str, Point { x, y }: Point) {
    _ = write!(text, "{rank:4}  {distance:<20} {what} at ({x}, {y})");
}

/// Appends a line about a bend of a path.
fn push_bend(text: &mut String, bend: &Bend) {
    let Point { x, y } = bend.vertex.point;
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
    _ = write!(text, "\n      {turn} at ({x}, {y}), around {around}");
}
