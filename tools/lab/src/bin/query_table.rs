//! Prints a Markdown table of microseconds per shortest path: the library's wavefront search, from
//! a warm cache of tiles, and crate polyanya, which gets the same free triangles in memory, merged
//! and baked. With `--threads`, also prints the number of k-ONN queries per second on one thread,
//! on two, and on two that share nothing.
//!
//! Both answer the same pairs of points alternately. The time is the thread's processor time,
//! except with `--threads`. polyanya computes in f32, and may miss points at the very edge of its
//! mesh: such pairs, and those with a path longer by more than a part in a thousand, are counted
//! and left out.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use anyhow::{Result, anyhow, bail};
use clap::Parser;
use cpu_time::ThreadTime;
use delaunay_tiles::geometry::{Point, Rect};
use delaunay_tiles::input::{
    InputOptions, PointBatch, PointSource, PolySource, SegmentBatch, SegmentSource, SiteBatch, SiteId,
};
use delaunay_tiles::query::{Footing, PathOutcome, QueryOptions};
use delaunay_tiles::store::{Cache, LineKind, OpenOptions, TileReader};
use delaunay_tiles::{BuildOptions, Builder};
use distributions::mix;
use futures::{StreamExt, TryStreamExt};
use lab::median;
use polyanya::{Mesh, Polygon, Vertex};
use tokio::runtime::{Builder as RuntimeBuilder, Runtime};

/// Compute shortest paths with the library and with crate polyanya alternately, on a map of a game
/// and on the islands of Indonesia, and print medians.
#[derive(Parser)]
struct Arguments {
    /// Number of paths
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..))]
    pairs: u32,
    /// Number of rounds for each path
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// Add queries for the 10 nearest of 1,000 sites, on one thread, on two, and on two that share
    /// nothing
    #[arg(long)]
    threads: bool,
}

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../tests/data")
        .join(name)
}

/// Random numbers from a seed (SplitMix64).
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        (mix(self.0) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn within(&mut self, bounds: Rect) -> Point {
        let (width, height) = bounds.size();
        Point::new(bounds.min_x + width * self.unit(), bounds.min_y + height * self.unit())
    }
}

async fn arena(folder: &Path) -> Result<TileReader> {
    let path = folder.join("arena.tiles");
    let options = BuildOptions::default().exterior_is_hole(true);
    let mut builder = Builder::new(&path, options)?;
    let file = data("arena/arena.poly");
    let mut batch = SegmentBatch::default();
    let mut source = PolySource::open(&file)?;
    while source.next_batch(&mut batch)? {
        builder.push_lines(LineKind::Wall, 0, &batch)?;
    }
    builder.push_seeds(&source.holes()?)?;
    let mut points = PointSource::open(&[file], &InputOptions::default())?;
    let mut batch = PointBatch::default();
    while points.next_batch(&mut batch)? {
        builder.push(&batch).await?;
    }
    finish(builder, &path).await
}

async fn islands(folder: &Path, sites: &[Point]) -> Result<TileReader> {
    let path = folder.join(format!("islands-{}.tiles", sites.len()));
    let mut builder = Builder::new(&path, BuildOptions::default())?;
    let mut batch = SegmentBatch::default();
    let mut source = SegmentSource::open_obstacles(&[data("indonesia/indonesia_ne10m.geojson")])?;
    while source.next_batch(&mut batch)? {
        builder.push_lines(LineKind::Obstacle, 0, &batch)?;
    }
    builder.push_sites(&SiteBatch {
        points: sites.to_vec(),
        ids: (0..sites.len() as u64).map(SiteId::Number).collect(),
        ..SiteBatch::default()
    })?;
    finish(builder, &path).await
}

async fn finish(builder: Builder, path: &Path) -> Result<TileReader> {
    builder.finish().await?;
    let cache = Cache::new(1 << 30);
    Ok(TileReader::open(path, OpenOptions::default().cache(&cache)).await?)
}

/// Returns the mesh of the free triangles, merged and baked.
async fn mesh(reader: &TileReader) -> Result<Mesh> {
    let (points, triangles) = free_triangles(reader).await?;
    let vertices = points.iter().zip(triangles_round(&points, &triangles));
    let vertices = vertices.map(|(&p, round)| Vertex::new(peer_point(p), round));
    let polygons = triangles.iter().map(|corners| Polygon::new(corners.to_vec(), false));
    let mut mesh = Mesh::new(vertices.collect(), polygons.collect())?;
    while mesh.merge_polygons() {}
    mesh.bake();
    Ok(mesh)
}

/// Returns the corners of the free triangles, each once, and the triangles by the indices of their
/// corners.
async fn free_triangles(reader: &TileReader) -> Result<(Vec<Point>, Vec<[u32; 3]>)> {
    let mut numbers: HashMap<[u64; 2], u32> = HashMap::new();
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    let mut tiles = reader.tiles();
    while let Some(tile) = tiles.try_next().await? {
        for triangle in tile.owned_triangles().filter(|&triangle| !tile.is_hole(triangle)) {
            triangles.push(tile.triangle_points(triangle).map(|p| {
                *numbers.entry([p.x.to_bits(), p.y.to_bits()]).or_insert_with(|| {
                    points.push(p);
                    points.len() as u32 - 1
                })
            }));
        }
    }
    Ok((points, triangles))
}

/// Returns the triangles around each vertex, counter-clockwise, with a mark in each gap.
fn triangles_round(points: &[Point], triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let mut left: HashMap<[u32; 2], u32> = HashMap::new();
    let mut of_vertex: Vec<Vec<(u32, u32)>> = vec![Vec::new(); points.len()];
    for (&[a, b, c], number) in triangles.iter().zip(0..) {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            left.insert([from, to], number);
            of_vertex[from as usize].push((to, number));
        }
    }
    let apex = |from: u32, number: u32| {
        let corners = triangles[number as usize];
        let index = corners.iter().position(|&corner| corner == from).unwrap_or(0);
        corners[(index + 2) % 3]
    };
    let round = |(vertex, edges): (u32, Vec<(u32, u32)>)| {
        // Fans that begin where there is no triangle on the right; or the only fan, which goes all
        // round.
        let is_start = |&(to, _): &(u32, u32)| !left.contains_key(&[to, vertex]);
        let mut starts: Vec<_> = edges.iter().copied().filter(is_start).collect();
        let angle = |to: u32| {
            let (p, q) = (points[vertex as usize], points[to as usize]);
            (q.y - p.y).atan2(q.x - p.x)
        };
        starts.sort_by(|a, b| angle(a.0).total_cmp(&angle(b.0)));
        let is_closed = starts.is_empty();
        if is_closed {
            starts.extend(edges.first());
        }
        let mut round = Vec::new();
        for (_, start) in starts {
            let mut number = start;
            loop {
                round.push(number);
                match left.get(&[vertex, apex(vertex, number)]) {
                    Some(&next) if next != start => number = next,
                    _ => break,
                }
            }
            if !is_closed {
                round.push(u32::MAX);
            }
        }
        round
    };
    (0..).zip(of_vertex).map(round).collect()
}

fn peer_point(p: Point) -> glam::Vec2 {
    glam::vec2(p.x as f32, p.y as f32)
}

/// Returns free pairs of points.
async fn pairs(reader: &TileReader, count: usize) -> Result<Vec<[Point; 2]>> {
    let mut random = Random(1);
    let bounds = reader.metadata().bounds;
    let mut points = Vec::new();
    while points.len() < 2 * count {
        // Points that f32 represents exactly, so that both answer the same question.
        let p = random.within(bounds);
        let p = Point::new(f64::from(p.x as f32), f64::from(p.y as f32));
        if reader.footing(p, QueryOptions::default()).await? == Footing::Free && is_inside(reader, p).await? {
            points.push(p);
        }
    }
    Ok(points.chunks(2).map(|pair| [pair[0], pair[1]]).collect())
}

/// Returns whether a point is in the hull: polyanya has no outside.
async fn is_inside(reader: &TileReader, p: Point) -> Result<bool> {
    use delaunay_tiles::query::Location;
    Ok(!matches!(reader.locate(p.x, p.y).await?, Location::Outside))
}

/// The microseconds that a measurement should take, so that reading the clock is negligible: faster
/// queries are repeated.
const LONG_ENOUGH: f64 = 50.0;

async fn compare(name: &str, reader: &TileReader, arguments: &Arguments) -> Result<()> {
    let mesh = mesh(reader).await?;
    let (mut own, mut peer, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
    let (mut missed, mut longer) = (0, 0);
    let pairs = pairs(reader, arguments.pairs as usize).await?;
    let mut compared = 0;
    for [from, to] in &pairs {
        let (mut own_times, mut peer_times) = (Vec::new(), Vec::new());
        let mut lengths = (None, None);
        let mut times = 1;
        for _ in 0..=arguments.rounds {
            let begin = ThreadTime::now();
            for _ in 0..times {
                let outcome = reader.shortest_path(*from, *to, QueryOptions::default()).await?;
                if let PathOutcome::Found(path) = outcome {
                    lengths.0 = Some(path.distance.value);
                }
            }
            own_times.push(begin.elapsed().as_secs_f64() * 1e6 / f64::from(times));
            let (from, to) = (peer_point(*from), peer_point(*to));
            let begin = ThreadTime::now();
            for _ in 0..times {
                let path = mesh.path(from, to);
                lengths.1 = path.map(|path| f64::from(path.length));
            }
            peer_times.push(begin.elapsed().as_secs_f64() * 1e6 / f64::from(times));
            times = (LONG_ENOUGH / peer_times[0].min(own_times[0])).clamp(1.0, 100.0) as u32;
        }
        match lengths {
            (Some(length), Some(peer_length)) if (peer_length - length).abs() <= 1e-3 * length => {
                compared += 1;
                // The first round warms up.
                let [a, b] = [median(&own_times[1..]), median(&peer_times[1..])];
                own.push(a);
                peer.push(b);
                ratios.push(a / b);
            }
            (Some(_), Some(_)) => longer += 1,
            _ => missed += 1,
        }
    }
    if compared == 0 {
        bail!("no pair could be compared");
    }
    let sums = [own.iter().sum::<f64>(), peer.iter().sum::<f64>()];
    let [a, b, ratio] = [&own, &peer, &ratios].map(|times| median(times));
    println!(
        "| {name} | {compared} | {a:.1} | {b:.1} | {:.2} | {ratio:.2} | {:.2} | {missed} | {longer} |",
        a / b,
        sums[0] / sums[1]
    );
    Ok(())
}

/// The number of times that all points are queried in one measurement, which should be long enough
/// for a clock and a scheduler.
const REPETITIONS: usize = 5;

/// Returns the queries per second on `threads` threads.
fn throughput(threads: usize, path: &Path, from: &Arc<Vec<Point>>) -> Result<f64> {
    let runtime = RuntimeBuilder::new_multi_thread()
        .worker_threads(threads)
        .enable_all()
        .build()?;
    runtime.block_on(async {
        let cache = Cache::new(1 << 30);
        let reader = TileReader::open(path, OpenOptions::default().cache(&cache)).await?;
        // Each task takes the next point when it is ready: fixed shares would differ by some per
        // cent in their time.
        let ask = |next: &Arc<AtomicUsize>, end: usize| {
            let (reader, from, next) = (reader.clone(), Arc::clone(from), Arc::clone(next));
            async move {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= end {
                        break;
                    }
                    let from = from[number % from.len()];
                    let sites = reader.nearest_sites(from, QueryOptions::default()).take(10);
                    sites.try_collect::<Vec<_>>().await?;
                }
                Ok::<_, delaunay_tiles::query::QueryError>(())
            }
        };
        let [warm_up, next] = [(); 2].map(|()| Arc::new(AtomicUsize::new(0)));
        tokio::spawn(ask(&warm_up, 20)).await??;
        let begin = Instant::now();
        let tasks: Vec<_> = (0..threads)
            .map(|_| tokio::spawn(ask(&next, REPETITIONS * from.len())))
            .collect();
        for task in tasks {
            task.await??;
        }
        Ok((REPETITIONS * from.len()) as f64 / begin.elapsed().as_secs_f64())
    })
}

/// Returns the queries per second on two threads that share nothing: the capacity of the machine.
fn unshared(path: &Path, from: &Arc<Vec<Point>>) -> Result<f64> {
    let rates = std::thread::scope(|scope| {
        let one = || throughput(1, path, from);
        [scope.spawn(one), scope.spawn(one)].map(|thread| thread.join())
    });
    let mut sum = 0.0;
    for rate in rates {
        sum += rate.map_err(|_| anyhow!("a thread panicked"))??;
    }
    Ok(sum)
}

fn main() -> Result<()> {
    let arguments = &Arguments::parse();
    let folder = tempfile::tempdir()?;
    let runtime = Runtime::new()?;
    println!(
        "| | pairs | delaunay-tiles, µs | polyanya, µs | ratio of medians | median ratio | ratio of sums | missed by one | other length |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|--:|--:|");
    let maps = runtime.block_on(async {
        let arena = arena(folder.path()).await?;
        compare("arena", &arena, arguments).await?;
        let islands = islands(folder.path(), &[]).await?;
        compare("indonesia_ne10m", &islands, arguments).await?;
        Ok::<_, anyhow::Error>(islands)
    })?;
    if !arguments.threads {
        return Ok(());
    }
    let (sites, from) = runtime.block_on(async {
        let mut random = Random(7);
        let bounds = maps.metadata().bounds;
        let (mut sites, mut from) = (Vec::new(), Vec::new());
        for list in [&mut sites, &mut from] {
            while list.len() < 1000 {
                let p = random.within(bounds);
                if maps.footing(p, QueryOptions::default()).await? == Footing::Free {
                    list.push(p);
                }
            }
        }
        islands(folder.path(), &sites).await?;
        Ok::<_, anyhow::Error>((sites, Arc::new(from)))
    })?;
    let path = folder.path().join(format!("islands-{}.tiles", sites.len()));
    let mut rates = [Vec::new(), Vec::new(), Vec::new()];
    for round in 0..arguments.rounds as usize {
        // The order rotates, so that none is always the first.
        for way in (0..3).map(|way| (way + round) % 3) {
            rates[way].push(match way {
                0 => throughput(1, &path, &from)?,
                1 => throughput(2, &path, &from)?,
                _ => unshared(&path, &from)?,
            });
        }
    }
    let [one, two, unshared] = rates.map(|rates| median(&rates));
    println!(
        "\n10 nearest of 1,000 sites on indonesia_ne10m: {one:.0} queries a second on one thread, {two:.0} on two: {:.2} times; \
         {unshared:.0} on two that share nothing: {:.2} times",
        two / one,
        unshared / one
    );
    Ok(())
}
