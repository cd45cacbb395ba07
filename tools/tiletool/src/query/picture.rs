//! Pictures of answers.

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{AreaPolygon, Explored};
use delaunay_tiles_answers::answer::{Answer, QueryResult, Status};
use delaunay_tiles_answers::ask::Ask;
use delaunay_tiles_answers::question::Question;
use delaunay_tiles_answers::units::{Measure, Unit, number};

use crate::common::{counted, thousands};
use crate::plot::Overlay;

/// Collects answers for a picture.
pub struct Picture {
    overlay: Overlay,
    answers: u64,
    last: String,
}

impl Picture {
    pub fn new() -> Self {
        Self {
            overlay: Overlay::default(),
            answers: 0,
            last: String::new(),
        }
    }

    /// Adds an answer. `unit` is the unit of the coordinates.
    pub fn take(&mut self, ask: Ask, unit: Unit, answer: &Answer) {
        self.answers += 1;
        let overlay = &mut self.overlay;
        match answer.question {
            Question::At(at) => overlay.starts.push(at),
            Question::Way(from, to) => {
                overlay.starts.push(from);
                overlay.ends.push(to);
            }
        }
        let path_of = |path: &delaunay_tiles::query::Path| path.points.clone();
        match &answer.found {
            QueryResult::Location(_) => {}
            QueryResult::Near(near) => overlay.sites.extend(near.iter().map(|near| near.vertex.point)),
            QueryResult::Sites(sites) => {
                overlay.sites.extend(sites.iter().map(|site| site.vertex.point));
                overlay
                    .paths
                    .extend(sites.iter().filter_map(|site| site.path.as_ref()).map(path_of));
            }
            QueryResult::Path(path) => overlay.paths.extend(path.iter().map(path_of)),
            QueryResult::Along(intervals) => {
                let mut number = 0;
                for interval in intervals {
                    let number_if_free = interval.sites.is_some().then_some(number);
                    number += usize::from(number_if_free.is_some());
                    overlay.intervals.push(([interval.from, interval.to], number_if_free));
                    for site in interval.sites.iter().flatten() {
                        if !overlay.sites.contains(&site.vertex.point) {
                            overlay.sites.push(site.vertex.point);
                        }
                    }
                }
            }
        }
        let polygons = answer.area.iter().flat_map(|area| &area.polygons);
        let rings = polygons.flat_map(AreaPolygon::rings);
        overlay.areas.extend(rings.map(<[Point]>::to_vec));
        self.last = title(ask, unit, answer);
    }

    /// Returns the picture of all answers.
    pub fn finish(mut self, explored: &Explored) -> Overlay {
        self.overlay.explored = explored.triangles();
        self.overlay.title = match self.answers {
            1 => self.last,
            answers => counted(answers, "query", "queries"),
        };
        let searched = self.overlay.explored.len() as u64;
        if searched > 0 {
            self.overlay.title += &format!("  ·  triangles searched: {}", thousands(searched));
        }
        self.overlay
    }
}

fn point_text(p: Point) -> String {
    format!("({}, {})", number(p.x), number(p.y))
}

/// Returns the title of a picture: a query and its result.
fn title(ask: Ask, unit: Unit, answer: &Answer) -> String {
    let question = match answer.question {
        Question::At(at) => point_text(at),
        Question::Way(from, to) => format!("{} to {}", point_text(from), point_text(to)),
    };
    let ended = match answer.status {
        Status::Ok => String::new(),
        Status::Unreachable => "  ·  no path exists".to_owned(),
        Status::Inside(..) => "  ·  inside an obstacle".to_owned(),
        Status::Budget(_) => "  ·  stopped at a limit".to_owned(),
    };
    let found = match &answer.found {
        QueryResult::Location(_) => String::new(),
        QueryResult::Near(near) => format!("  ·  {} found", near.len()),
        QueryResult::Sites(sites) => format!("  ·  {}", counted(sites.len() as u64, "site", "sites")),
        QueryResult::Path(Some(path)) => format!("  ·  length {}", unit.distance(path.distance.value)),
        QueryResult::Path(None) => String::new(),
        QueryResult::Along(intervals) => format!("  ·  {}", counted(intervals.len() as u64, "interval", "intervals")),
    };
    let nearest = |k: u32| match k {
        1 => "The nearest".to_owned(),
        k => format!("The {k} nearest"),
    };
    let what = match ask {
        Ask::Locate => "Where is".to_owned(),
        Ask::Nearest { k, .. } => format!("{} by Euclidean distance to", nearest(k)),
        Ask::Knn { k, .. } => format!("{} by walking distance from", nearest(k)),
        Ask::Range { radius, .. } => format!("Within {} of", unit.distance(radius)),
        Ask::Path => "The shortest path from".to_owned(),
        Ask::Along { k } => format!("{} along", nearest(k)),
    };
    let area = answer.area.as_ref();
    let area = area.map_or_else(String::new, |area| format!("  ·  area {}", unit.area(area.size)));
    format!("{what} {question}{found}{area}{ended}")
}
