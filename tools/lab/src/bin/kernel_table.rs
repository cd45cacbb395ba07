//! Prints a Markdown table of nanoseconds and bytes per point: the library's kernel and its peers.
//!
//! The triangulators, all single-threaded, alternate on the same input, round by round, so that
//! noise affects all of them; the table has medians. The time is the thread's processor time, which
//! other processes lengthen far less than the wall-clock time. In every run the library's kernel
//! and spade must give the same number of triangles.

use clap::Parser;
use cpu_time::ThreadTime;
use delaunay_tiles::mesh::{Engine as _, Triangulation};
use distributions::Kind;
use lab::kernels::incremental::{Incremental, Order};
use lab::kernels::{Contender, Input, KINDS, Outcome, Peer};
use lab::median;
use peakmem_alloc::{INSTRUMENTED_SYSTEM, PeakMemAlloc, PeakMemAllocTrait};

#[global_allocator]
static MEMORY: &PeakMemAlloc<std::alloc::System> = &INSTRUMENTED_SYSTEM;

/// Triangulate the same points with each triangulator alternately, and print medians.
#[derive(Parser)]
struct Arguments {
    /// Number of points
    #[arg(long, default_value_t = 1 << 20, value_parser = clap::value_parser!(u64).range(1..1 << 29))]
    points: u64,
    /// Number of rounds for each triangulator; the table has medians
    #[arg(long, default_value_t = 7, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// Make new engines in every round, so that the memory that the library keeps between calls is
    /// allocated again
    #[arg(long)]
    fresh: bool,
    /// Add the shares of the second candidate's steps in its time
    #[arg(long)]
    parts: bool,
    /// Only these distributions
    #[arg(long = "kind", default_values_t = KINDS)]
    kinds: Vec<Kind>,
    /// Only these triangulators, for a profiler
    #[arg(long = "only", value_enum, default_values_t = Peer::ALL)]
    peers: Vec<Peer>,
}

/// The measurements of one triangulator on one input.
#[derive(Default)]
struct Measured {
    nanoseconds: Vec<f64>,
    triangles: usize,
    /// Peak of the heap without the input, and the part of it that is the result, if that can be
    /// distinguished from the rest.
    peak: usize,
    result: Option<usize>,
}

impl Measured {
    fn median(&self) -> f64 {
        median(&self.nanoseconds)
    }
}

fn measure(arguments: &Arguments, input: &Input) -> Vec<(Peer, Measured)> {
    let n = input.points.len() as f64;
    let mut table: Vec<_> = arguments.peers.iter().map(|&p| (p, Measured::default())).collect();
    let mut contenders: Vec<_> = arguments.peers.iter().map(|&p| Contender::new(p)).collect();
    // The first round measures memory, and warms up.
    for round in 0..=arguments.rounds {
        for ((peer, measured), contender) in table.iter_mut().zip(&mut contenders) {
            if arguments.fresh {
                *contender = Contender::new(*peer);
            }
            let owned = contender.owned(input);
            MEMORY.reset_peak_memory();
            let begin = ThreadTime::now();
            let outcome = contender.run(input, owned);
            let time = begin.elapsed();
            if round > 0 {
                measured.nanoseconds.push(time.as_nanos() as f64 / n);
            } else {
                measured.peak = MEMORY.get_peak_memory();
                measured.triangles = outcome.triangles();
                measured.result = result_bytes(contender, &outcome);
            }
            assert_eq!(
                outcome.triangles(),
                measured.triangles,
                "{peer} counts differently each time"
            );
        }
        let triangles = |peer| table.iter().find(|row| row.0 == peer).map(|row| row.1.triangles);
        if let (Some(native), Some(spade)) = (triangles(Peer::Native), triangles(Peer::Spade)) {
            assert_eq!(native, spade, "native and spade count differently");
        }
    }
    table
}

/// Returns the bytes of the arrays that form the result. spade works within its result.
fn result_bytes(contender: &Contender, outcome: &Outcome) -> Option<usize> {
    match (contender, outcome) {
        (Contender::Engine(_, mesh), _) => {
            Some(12 * (mesh.triangles.capacity() + mesh.neighbours.capacity()) + 4 * mesh.hull.capacity())
        }
        (_, Outcome::Delaunator(t)) => {
            Some(size_of::<usize>() * (t.triangles.capacity() + t.halfedges.capacity() + t.hull.capacity()))
        }
        _ => None,
    }
}

/// Prints the shares of ordering, inserting, and writing the result in the second candidate's time.
fn print_parts(arguments: &Arguments) {
    println!("\n| | order | ordering | inserting | writing |\n|---|---|--:|--:|--:|");
    for &kind in &arguments.kinds {
        let input = Input::new(kind, arguments.points);
        for order in [Order::Brio, Order::Hilbert] {
            let (mut engine, mut mesh) = (Incremental::new(order), Triangulation::default());
            let mut parts = [0.0; 3];
            for _ in 0..arguments.rounds {
                engine.triangulate(&input.points, &mut mesh);
                for (sum, part) in parts.iter_mut().zip(engine.parts) {
                    *sum += 100.0 * part.as_secs_f64();
                }
            }
            let whole = parts.iter().sum::<f64>() / 100.0;
            let [ordering, inserting, writing] = parts.map(|part| part / whole);
            println!("| {kind} | {order:?} | {ordering:.0} % | {inserting:.0} % | {writing:.0} % |");
        }
    }
}

/// The measurements of a kind: the kind, its points, and each peer.
type Table = (Kind, f64, Vec<(Peer, Measured)>);

/// Prints the times, and returns all measurements.
fn print_times(arguments: &Arguments, names: &str) -> Vec<Table> {
    let ratios = arguments.peers.len() == Peer::ALL.len();
    let columns = arguments.peers.len() + 1 + 3 * usize::from(ratios);
    let ratio_names = if ratios {
        " native/spade | native/delaunator | native/brio |"
    } else {
        ""
    };
    println!(
        "ns per point, {} points, median of {} rounds{}\n",
        arguments.points,
        arguments.rounds,
        if arguments.fresh { ", fresh engines" } else { "" }
    );
    println!("| |{names}{ratio_names}");
    println!("|---|{}", "--:|".repeat(columns - 1));
    let mut tables = Vec::new();
    for &kind in &arguments.kinds {
        let input = Input::new(kind, arguments.points);
        let table = measure(arguments, &input);
        print!("| {kind} |");
        for (_, measured) in &table {
            print!(" {:.0} |", measured.median());
        }
        if ratios {
            for other in &table[1..4] {
                print!(" {:.2} |", table[0].1.median() / other.1.median());
            }
        }
        println!();
        tables.push((kind, input.points.len() as f64, table));
    }
    tables
}

/// Prints the memory, and names the peers whose number of triangles differs from that of the first.
fn print_memory(tables: Vec<Table>, names: &str) {
    println!("\nBytes per point at the peak beside the input: work + result\n");
    println!("| |{names}");
    println!("|---|{}", "--:|".repeat(names.matches('|').count()));
    let mut wrong = Vec::new();
    for (kind, n, table) in tables {
        print!("| {kind} |");
        for (peer, measured) in &table {
            match measured.result {
                Some(result) => print!(
                    " {:.0} + {:.0} |",
                    measured.peak.saturating_sub(result) as f64 / n,
                    result as f64 / n
                ),
                None => print!(" {:.0} |", measured.peak as f64 / n),
            }
            let expected = table[0].1.triangles;
            if measured.triangles != expected {
                wrong.push(format!(
                    "{kind}: {peer} has {} triangles, not {expected}",
                    measured.triangles
                ));
            }
        }
        println!();
    }
    for line in wrong {
        println!("\n{line}");
    }
}

fn main() {
    let arguments = Arguments::parse();
    let names = arguments.peers.iter().map(|p| format!(" {p} |")).collect::<String>();
    let tables = print_times(&arguments, &names);
    print_memory(tables, &names);
    if arguments.parts {
        print_parts(&arguments);
    }
}
