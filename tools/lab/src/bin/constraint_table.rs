//! Prints a Markdown table of constrained triangulations: the library's kernel and spade's
//! `bulk_load_cdt`.
//!
//! Both are single-threaded and alternate on the same input. The table has medians of the thread's
//! processor time.

use clap::Parser;
use cpu_time::ThreadTime;
use delaunay_tiles::geometry::Point;
use delaunay_tiles::mesh::{Constrained, EngineKind, Inserter, Triangulation};
use distributions::{Kind, LongSegments, Pslg};
use lab::median;
use spade::{ConstrainedDelaunayTriangulation, Point2};

/// Triangulate PSLGs of the thesis with α = 0.5 and 0.9 segments per point, and 1000 segments that
/// each cross the whole square.
#[derive(Parser)]
struct Arguments {
    /// Number of points
    #[arg(long, default_value_t = 1 << 20, value_parser = clap::value_parser!(u64).range(1..1 << 29))]
    points: u64,
    /// Number of rounds; the table has medians
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// Leave out spade, for a profiler
    #[arg(long)]
    no_spade: bool,
}

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

/// Returns the seconds that the library takes for the triangulation and for the constraints, and
/// the number of constraint edges.
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

fn main() {
    let Arguments {
        points,
        rounds,
        no_spade,
    } = Arguments::parse();
    println!("Seconds, {points} points, medians of {rounds} rounds\n");
    println!("| | segments | native | of it constraints | ns per segment | spade | native/spade |");
    println!("|---|--:|--:|--:|--:|--:|--:|");
    for input in inputs(points) {
        let (mut whole, mut inserting, mut others) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..rounds {
            let (triangulated, inserted, edges) = native(&input);
            whole.push(triangulated + inserted);
            inserting.push(inserted);
            if !no_spade {
                let (time, its) = spade(&input);
                assert_eq!(edges, its, "native and spade count constraint edges differently");
                others.push(time);
            }
        }
        let (whole, inserting) = (median(&whole), median(&inserting));
        let per_segment = inserting * 1e9 / input.segments.len().max(1) as f64;
        let beside = match others.is_empty() {
            true => "| |".to_owned(),
            false => {
                let spade = median(&others);
                format!("{spade:.3} | {:.2} |", whole / spade)
            }
        };
        println!(
            "| {} | {} | {whole:.3} | {inserting:.3} | {per_segment:.0} | {beside}",
            input.name,
            input.segments.len()
        );
    }
}
