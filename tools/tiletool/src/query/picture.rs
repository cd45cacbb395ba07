//! Answers as a picture.

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::Explored;

use super::answer::{Answer, Found, Status};
use super::ask::Ask;
use super::batch::Question;
use crate::common::thousands;
use crate::plot::Overlay;

/// Gathers answers for a picture.
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

    /// Takes an answer.
    pub fn take(&mut self, ask: Ask, answer: &Answer) {
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
            Found::Location(_) => {}
            Found::Near(near) => overlay.sites.extend(near.iter().map(|near| near.vertex.point)),
            Found::Sites(sites) => {
                overlay.sites.extend(sites.iter().map(|site| site.vertex.point));
                overlay
                    .paths
                    .extend(sites.iter().filter_map(|site| site.path.as_ref()).map(path_of));
            }
            Found::Path(path) => overlay.paths.extend(path.iter().map(path_of)),
            Found::Along(intervals) => {
                let mut number = 0;
                for interval in intervals {
                    let its = interval.sites.is_some().then_some(number);
                    number += usize::from(its.is_some());
                    overlay.intervals.push(([interval.from, interval.to], its));
                    for site in interval.sites.iter().flatten() {
                        if !overlay.sites.contains(&site.vertex.point) {
                            overlay.sites.push(site.vertex.point);
                        }
                    }
                }
            }
        }
        overlay.areas.extend(answer.area.iter().flatten().cloned());
        self.last = said(ask, answer);
    }

    /// The picture of all answers.
    pub fn finish(mut self, explored: &Explored) -> Overlay {
        self.overlay.explored = explored.triangles();
        self.overlay.title = match self.answers {
            1 => self.last,
            answers => format!("{} queries", thousands(answers)),
        };
        let searched = self.overlay.explored.len() as u64;
        if searched > 0 {
            self.overlay.title += &format!("  ·  {} triangles searched", thousands(searched));
        }
        self.overlay
    }
}

/// A number with a few digits.
fn short(v: f64) -> String {
    let digits = (5 - v.abs().max(1e-9).log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{v:.digits$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

fn place(p: Point) -> String {
    format!("({}, {})", short(p.x), short(p.y))
}

/// What was asked and what came of it, in a line.
fn said(ask: Ask, answer: &Answer) -> String {
    let question = match answer.question {
        Question::At(at) => place(at),
        Question::Way(from, to) => format!("{} to {}", place(from), place(to)),
    };
    let ended = match answer.status {
        Status::Ok => String::new(),
        Status::Unreachable => "  ·  no way leads there".to_owned(),
        Status::Inside(..) => "  ·  in an obstacle".to_owned(),
        Status::Budget(_) => "  ·  stopped early".to_owned(),
    };
    let found = match &answer.found {
        Found::Location(_) => String::new(),
        Found::Near(near) => format!("  ·  {} found", near.len()),
        Found::Sites(sites) => format!("  ·  {} sites", sites.len()),
        Found::Path(Some(path)) => format!("  ·  length {}", short(path.distance.value)),
        Found::Path(None) => String::new(),
        Found::Along(intervals) => format!("  ·  {} intervals", intervals.len()),
    };
    let what = match ask {
        Ask::Locate => "Where is".to_owned(),
        Ask::Nearest { k, .. } => format!("The {k} nearest as the crow flies to"),
        Ask::Knn { k } => format!("The {k} nearest by walking distance from"),
        Ask::Range { radius, .. } => format!("Within {} of", short(radius)),
        Ask::Path => "The shortest path from".to_owned(),
        Ask::Along { k } => format!("The {k} nearest along"),
    };
    format!("{what} {question}{found}{ended}")
}
