//! Answers as JSON and GeoJSON.

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{Near, Path, SiteFound};
use serde_json::{Value, json};

use crate::answer::{Answer, Area, QueryResult, Status, name};
use crate::asked::Asked;
use crate::question::Question;
use crate::values::{line_string, position, with_distance};
use crate::{along, area};

/// Returns where a path bends, and round which lines.
fn bends(path: &Path) -> Value {
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
    bends.collect()
}

fn path_value(path: &Path) -> Value {
    json!({
        "points": path.points.iter().map(|&point| position(point)).collect::<Vec<_>>(),
        "bends": bends(path),
        "certified": path.is_certified,
    })
}

/// Returns an object with the question and how it ended.
fn header_object(asked: Asked, answer: &Answer) -> Value {
    let mut value = match answer.question {
        Question::At(at) => json!({"at": position(at)}),
        Question::Way(from, to) => json!({"from": position(from), "to": position(to)}),
    };
    answer.status.add_to(&mut value);
    if let Some(note) = asked.note(answer) {
        value["note"] = note.into();
    }
    value
}

impl Status {
    /// Adds to an object how a query ended.
    pub fn add_to(self, value: &mut Value) {
        value["status"] = self.name().into();
        match self {
            Self::Inside(point, nearest) => {
                value["inside_point"] = position(point);
                value["nearest_free"] = nearest.map_or(Value::Null, position);
            }
            Self::Budget(lower_bound) => value["lower_bound"] = lower_bound.into(),
            Self::Ok | Self::Unreachable => {}
        }
    }
}

/// Returns the found items as objects, each with its point and its path, if any.
fn items<'a>(answer: &'a Answer) -> Vec<(Value, Option<Point>, Option<&'a Path>)> {
    match &answer.found {
        QueryResult::Location(located) => {
            let vertex_z: Vec<_> = located.vertices.iter().map(|(_, z)| z).collect();
            let at = if let Question::At(at) = answer.question {
                Some(at)
            } else {
                None
            };
            let (element, vertices) = (located.element(), located.ids());
            let points: Vec<_> = located
                .vertices
                .iter()
                .map(|(vertex, _)| position(vertex.point))
                .collect();
            let value = json!({
                "element": element,
                "vertices": vertices,
                "points": points,
                "region": located.region,
                "z": located.z,
                "vertex_z": vertex_z,
            });
            vec![(value, at, None)]
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

/// Returns the JSON object of an answer.
pub fn object(asked: Asked, answer: &Answer) -> Value {
    let mut value = header_object(asked, answer);
    if let Some(area) = &answer.area {
        value["area"] = area.size.into();
    }
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

/// Returns the members of an answer's [`object`] that are no lists of found items and no path: what is
/// not in [`features`] alone. Of a path, also where it bends.
pub fn members(asked: Asked, answer: &Answer) -> Value {
    let mut value = header_object(asked, answer);
    if let Some(area) = &answer.area {
        value["area"] = area.size.into();
    }
    let found = matches!(&answer.found, QueryResult::Location(_) | QueryResult::Path(_));
    for (item, _, _) in items(answer).into_iter().filter(|_| found) {
        if let Value::Object(item) = item {
            item.into_iter().for_each(|(key, item)| value[key] = item);
        }
    }
    if let QueryResult::Path(Some(path)) = &answer.found {
        value["bends"] = bends(path);
    }
    value
}

/// Returns the GeoJSON features of intervals or of an area, which have geometries of their own.
fn shapes(asked: Asked, answer: &Answer) -> Option<Vec<Value>> {
    match (&answer.found, &answer.area) {
        (QueryResult::Along(intervals), _) if !intervals.is_empty() => {
            let feature = |interval| {
                let properties = along::object(interval);
                json!({"type": "Feature", "properties": properties, "geometry": along::geometry(interval)})
            };
            Some(intervals.iter().map(feature).collect())
        }
        (_, Some(Area { polygons, size })) => {
            let mut properties = header_object(asked, answer);
            properties["area"] = (*size).into();
            properties["tolerance"] = area::TOLERANCE.into();
            let feature = json!({"type": "Feature", "properties": properties, "geometry": area::geometry(polygons)});
            Some(vec![feature])
        }
        _ => None,
    }
}

/// Returns the GeoJSON features of an answer.
pub fn features(asked: Asked, answer: &Answer) -> Vec<Value> {
    let mut features = shapes(asked, answer).unwrap_or_default();
    if features.is_empty() || matches!(&answer.found, QueryResult::Sites(sites) if !sites.is_empty()) {
        features.extend(items_as_features(asked, answer));
    }
    features
}

fn items_as_features(asked: Asked, answer: &Answer) -> Vec<Value> {
    let header_object = header_object(asked, answer);
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
