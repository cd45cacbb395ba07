//! Answers as rows of CSV.

use delaunay_tiles_answers::answer::{Answer, QueryResult, Status, name};
use delaunay_tiles_answers::ask::Ask;
use delaunay_tiles_answers::question::Question;
use delaunay_tiles_answers::values::{bounds, pair};

use super::along;
use crate::common::cell;

/// Returns the names of the columns.
pub fn header(ask: Ask) -> String {
    let columns = match ask {
        Ask::Locate => "x,y,status,element,vertex_0,vertex_1,vertex_2,z,z_0,z_1,z_2",
        Ask::Nearest { .. } => "x,y,status,rank,vertex,site,to_x,to_y,distance",
        Ask::Range { area: true, .. } => "x,y,status,rank,site,to_x,to_y,distance,lower,upper,area",
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

/// Returns the rows of an answer. A quoted cell may contain line breaks.
pub fn rows(ask: Ask, answer: &Answer) -> Vec<String> {
    let (question_cells, status) = (question_cells(answer.question), answer.status.name());
    let is_ok = answer.status == Status::Ok;
    let mut rows = Vec::new();
    match &answer.found {
        QueryResult::Location(located) => {
            let z_cell = |z: Option<f64>| z.map_or_else(String::new, |z| z.to_string());
            let mut vertices = located.ids();
            let mut heights: Vec<String> = located.vertices.iter().map(|(_, z)| z_cell(*z)).collect();
            vertices.resize(3, String::new());
            heights.resize(3, String::new());
            let (element, vertices, heights) = (located.element(), vertices.join(","), heights.join(","));
            let z = z_cell(located.z);
            rows.push(format!("{question_cells},{status},{element},{vertices},{z},{heights}"));
        }
        QueryResult::Near(all) => {
            for (near, rank) in all.iter().zip(1..) {
                let (vertex, at) = (near.vertex.id, pair(near.vertex.point));
                let site = cell(&name(near.site, near.id.as_deref()));
                let distance = near.distance;
                rows.push(format!("{question_cells},ok,{rank},{vertex},{site},{at},{distance}"));
            }
            if !is_ok {
                rows.push(format!("{question_cells},{status},,,,,,"));
            }
        }
        QueryResult::Sites(_) => rows = rows_of_sites(ask, answer, &question_cells),
        QueryResult::Path(path) => {
            let bounds = match (path, answer.status) {
                (Some(path), _) => bounds(&path.distance),
                (None, Status::Budget(lower_bound)) => format!(",{lower_bound},"),
                (None, _) => ",,".to_owned(),
            };
            rows.push(format!("{question_cells},{status},{bounds}"));
        }
        QueryResult::Along(intervals) => {
            for row in intervals.iter().flat_map(along::rows) {
                rows.push(format!("{question_cells},{row}"));
            }
            if !is_ok {
                rows.push(format!("{question_cells},,,,,,,{status},,,,"));
            }
        }
    }
    rows
}

/// Returns a row for each site, and one for an unsuccessful end or an area without sites.
fn rows_of_sites(ask: Ask, answer: &Answer, question_cells: &str) -> Vec<String> {
    let mut rows = Vec::new();
    if let QueryResult::Sites(sites) = &answer.found {
        for (site, rank) in sites.iter().zip(1..) {
            let name = cell(&name(Some(site.number), site.id.as_deref()));
            let (at, distance) = (pair(site.vertex.point), bounds(&site.distance));
            rows.push(format!("{question_cells},ok,{rank},{name},{at},{distance}"));
        }
    }
    if answer.status != Status::Ok || (rows.is_empty() && answer.area.is_some()) {
        let lower = match answer.status {
            Status::Budget(lower_bound) => lower_bound.to_string(),
            _ => String::new(),
        };
        rows.push(format!("{question_cells},{},,,,,,{lower},", answer.status.name()));
    }
    if matches!(ask, Ask::Range { area: true, .. }) {
        let area = answer
            .area
            .as_ref()
            .map_or_else(String::new, |area| area.size.to_string());
        rows.iter_mut().for_each(|row| *row += &format!(",{area}"));
    }
    rows
}
