//! Pictures of answers.

use std::collections::{HashMap, HashSet};

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{AlongInterval, AreaPolygon, Explored, Near, Path, SiteAlong, SiteFound};
use delaunay_tiles_answers::answer::{Answer, QueryResult, Status, displayed_name};
use delaunay_tiles_answers::ask::Ask;
use delaunay_tiles_answers::question::Question;
use delaunay_tiles_answers::units::{Measure, Unit, number};

use crate::common::{counted, thousands};
use crate::plot::{Mark, Overlay, Piece, Way};

/// Maximum number of names of a list of nearest sites that a picture shows.
const MAX_NAMES: usize = 4;

/// Collects answers for a picture.
pub struct Picture {
    overlay: Overlay,
    /// Whether there is only one question.
    is_single: bool,
    answers: u64,
    last: String,
    /// The sites that are already in the picture.
    marked: HashSet<[u64; 2]>,
    /// The number of each list of nearest sites.
    keys: HashMap<String, usize>,
}

impl Picture {
    /// Creates a picture of the answers to some questions.
    pub fn new(questions: usize) -> Self {
        Self {
            overlay: Overlay::default(),
            is_single: questions == 1,
            answers: 0,
            last: String::new(),
            marked: HashSet::new(),
            keys: HashMap::new(),
        }
    }

    /// Adds an answer. `unit` is the unit of the coordinates.
    pub fn take(&mut self, ask: Ask, unit: Unit, answer: &Answer) {
        self.answers += 1;
        match answer.question {
            Question::At(at) => self.overlay.starts.push(at),
            Question::Way(from, to) => {
                self.overlay.starts.push(from);
                self.overlay.ends.push(mark(to, String::new()));
            }
        }
        match &answer.found {
            QueryResult::Location(_) => {}
            QueryResult::Near(near) => self.take_near(near, unit),
            QueryResult::Sites(sites) => self.take_sites(ask, unit, answer, sites),
            QueryResult::Path(path) => self.take_path(unit, answer, path.as_ref()),
            QueryResult::Along(pieces) => self.take_pieces(ask, answer, pieces),
        }
        let polygons = answer.area.iter().flat_map(|area| &area.polygons);
        let rings = polygons.flat_map(AreaPolygon::rings);
        self.overlay.areas.extend(rings.map(<[Point]>::to_vec));
        self.last = title(ask, unit, answer);
    }

    /// Marks a site, unless it is already marked. The distance is written only if there is one
    /// question, because a site has several distances otherwise.
    fn mark_site(&mut self, at: Point, name: String, distance: Option<String>, key: Option<usize>) {
        if self.marked.insert([at.x.to_bits(), at.y.to_bits()]) {
            let text = match distance.filter(|_| self.is_single) {
                Some(distance) => format!("{name}: {distance}"),
                None => name,
            };
            self.overlay.sites.push(Mark { at, text, key });
        }
    }

    fn take_near(&mut self, near: &[Near], unit: Unit) {
        for near in near {
            let name = match near.site {
                Some(_) => displayed_name(near.site, near.id.as_deref()),
                None => near.vertex.id.to_string(),
            };
            self.mark_site(near.vertex.point, name, Some(short_distance(unit, near.distance)), None);
        }
    }

    fn take_sites(&mut self, ask: Ask, unit: Unit, answer: &Answer, sites: &[SiteFound]) {
        for site in sites {
            let name = displayed_name(Some(site.number), site.id.as_deref());
            let distance = short_distance(unit, site.distance.value);
            self.mark_site(site.vertex.point, name, Some(distance), None);
            self.overlay.paths.extend(site.path.iter().map(|path| Way {
                points: path.points.clone(),
                text: String::new(),
            }));
        }
        let is_complete = matches!(ask, Ask::Knn { k, .. } if sites.len() >= k as usize);
        if !is_complete {
            self.overlay.shows_all |= matches!(ask, Ask::Knn { .. }) && answer.status == Status::Ok;
            self.overlay.other_sites = Some("not found");
        } else if self.overlay.other_sites.is_none() {
            self.overlay.other_sites = Some("other sites");
        }
    }

    fn take_path(&mut self, unit: Unit, answer: &Answer, path: Option<&Path>) {
        match (path, answer.question) {
            (Some(path), _) => self.overlay.paths.push(Way {
                points: path.points.clone(),
                // The title has the length of the only path.
                text: match self.is_single {
                    true => String::new(),
                    false => short_distance(unit, path.distance.value),
                },
            }),
            (None, Question::Way(from, to)) => self.overlay.missing.push([from, to]),
            (None, Question::At(_)) => {}
        }
    }

    fn take_pieces(&mut self, ask: Ask, answer: &Answer, pieces: &[AlongInterval]) {
        let is_one = matches!(ask, Ask::Along { k: 1 });
        self.overlay.heading = if is_one {
            "nearest site"
        } else {
            "nearest sites, nearest first"
        };
        self.overlay.other_sites = Some("other sites");
        if let (true, Question::Way(from, to)) = (pieces.is_empty(), answer.question) {
            self.overlay.missing.push([from, to]);
        }
        for piece in pieces {
            let what = match piece.sites.as_deref() {
                None => Piece::Obstacle,
                Some([]) => Piece::NoSite,
                Some(sites) => Piece::Sites(self.key(sites)),
            };
            self.overlay.pieces.push(([piece.from, piece.to], what));
            for site in piece.sites.iter().flatten() {
                let name = displayed_name(Some(site.number), site.id.as_deref());
                let key = match what {
                    Piece::Sites(key) if is_one => Some(key),
                    _ => None,
                };
                self.mark_site(site.vertex.point, name, None, key);
            }
        }
    }

    /// Returns the number of a list of sites.
    fn key(&mut self, sites: &[SiteAlong]) -> usize {
        let names = sites
            .iter()
            .map(|site| displayed_name(Some(site.number), site.id.as_deref()));
        let names: Vec<_> = names.collect();
        let next = self.keys.len();
        *self.keys.entry(names.join(", ")).or_insert_with(|| {
            let rest = if names.len() > MAX_NAMES { ", …" } else { "" };
            let shown = names[..names.len().min(MAX_NAMES)].join(", ");
            self.overlay.keys.push(shown + rest);
            next
        })
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

fn mark(at: Point, text: String) -> Mark {
    Mark { at, text, key: None }
}

/// Formats a distance for a place with little room: without the unit, unless it has a short name.
pub fn short_distance(unit: Unit, distance: f64) -> String {
    match unit.metres() {
        Some(_) => unit.distance(distance),
        None => number(distance),
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
