//! Prints a Markdown table of constrained triangulations: the library's kernel beside spade's `bulk_load_cdt`.
//!
//! Both are single-threaded and take turns on the same input; medians count, of the thread's time on the processor.

use std::process::ExitCode;

use cpu_time::ThreadTime;
use delaunay_tiles::geometry::Point;
use delaunay_tiles::mesh::{Constrained, EngineKind, Inserter, Triangulation};
use distributions::{Kind, LongSegments, Pslg};
use spade::{ConstrainedDelaunayTriangulation, Point2};

const USAGE: &str = "usage: constraint-table [--points N] [--rounds R] [--no-spade]

Triangulates N points (default 1048576) R times (default 5): PSLGs of the thesis with about half and with nine tenths as many
segments as points, and 1000 segments that each cross all of the square. --no-spade is for a profiler.";

struct Input {
    name: &'static str,
    points: Vec<Point>,
    segments: Vec<[u32; 2]>,
}

fn inputs(points: u64) -> Vec<Input> {
    let pslg = |name, kind, alpha| {
        let pslg = Pslg::new(kind, points, alpha, 1).expect("the kind has segments");
        Input {
            name,
            points: pslg.points().map(|[x, y]| Point::new(x, y).normalized()).collect(),
            segments: pslg.segments().collect(),
        }
    };
    let long = LongSegments::new(points, 1000, 1).expect("few points");
    vec![
        pslg("uniform, α = 0.5", Kind::Uniform, 0.5),
        pslg("uniform, α = 0.9", Kind::Uniform, 0.9),
        pslg("kuzmin, α = 0.5", Kind::Kuzmin, 0.5),
        Input {
            name: "1000 long segments",
            points: long.points().map(|[x, y]| Point::new(x, y).normalized()).collect(),
            segments: long.segments().collect(),
        },
    ]
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_unstable_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Seconds that the library takes for the triangulation and for the constraints, and constraint edges.
fn native(input: &Input) -> (f64, f64, usize) {
    let begin = ThreadTime::now();
    let mut mesh = Triangulation::default();
    EngineKind::Native.create().triangulate(&input.points, &mut mesh);
    let triangulated = begin.elapsed().as_secs_f64();
    let mut mesh = Constrained::new(mesh, input.points.len());
    let mut inserter = Inserter::default();
    for &segment in &input.segments {
        inserter
            .insert(&input.points, &mut mesh, segment)
            .expect("nothing crosses");
    }
    let all = begin.elapsed().as_secs_f64();
    (triangulated, all - triangulated, mesh.constraints().count())
}

fn spade(input: &Input) -> (f64, usize) {
    let points = input.points.iter().map(|p| Point2::new(p.x, p.y)).collect();
    let segments = input.segments.iter().map(|s| s.map(|v| v as usize)).collect();
    let begin = ThreadTime::now();
    let mesh = ConstrainedDelaunayTriangulation::<Point2<f64>>::bulk_load_cdt(points, segments).expect("valid points");
    (begin.elapsed().as_secs_f64(), mesh.num_constraints())
}

fn main() -> ExitCode {
    let (mut points, mut rounds, mut with_spade) = (1 << 20, 5, true);
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut number = || words.next().and_then(|word| word.parse::<u64>().ok());
        let known = match word.as_str() {
            "--points" => number().filter(|n| (1..1 << 29).contains(n)).map(|n| points = n),
            "--rounds" => number().filter(|n| *n > 0).map(|n| rounds = n),
            "--no-spade" => {
                with_spade = false;
                Some(())
            }
            _ => None,
        };
        if known.is_none() {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    }
    println!("Seconds, {points} points, medians of {rounds} rounds\n");
    println!("| | segments | native | of it constraints | ns per segment | spade | native/spade |");
    println!("|---|--:|--:|--:|--:|--:|--:|");
    for input in inputs(points) {
        let (mut whole, mut inserting, mut others) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..rounds {
            let (triangulated, inserted, edges) = native(&input);
            whole.push(triangulated + inserted);
            inserting.push(inserted);
            if with_spade {
                let (time, its) = spade(&input);
                assert_eq!(edges, its, "native and spade count constraint edges differently");
                others.push(time);
            }
        }
        let (whole, inserting) = (median(&mut whole), median(&mut inserting));
        let per_segment = inserting * 1e9 / input.segments.len().max(1) as f64;
        let beside = match others.is_empty() {
            true => "| |".to_owned(),
            false => {
                let spade = median(&mut others);
                format!("{spade:.3} | {:.2} |", whole / spade)
            }
        };
        println!(
            "| {} | {} | {whole:.3} | {inserting:.3} | {per_segment:.0} | {beside}",
            input.name,
            input.segments.len()
        );
    }
    ExitCode::SUCCESS
}
