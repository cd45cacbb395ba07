//! Prints a Markdown table of changes of a file on disk: many insertions and deletions beside spade's in
//! memory, single commits beside the same writes on the device, and queries while a file is edited
//! beside queries while it is not.

use std::fs::File;
use std::hint::black_box;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow, ensure};
use bytesize::ByteSize;
use clap::Parser;
use delaunay_tiles::input::PointBatch;
use delaunay_tiles::{
    BuildOptions, Builder, Durability, EditOptions, EditSummary, Editor, OpenOptions, Point, TileReader,
};
use distributions::{Kind, mix};
use lab::median;
use spade::handles::FixedVertexHandle;
use spade::{DelaunayTriangulation, LastUsedVertexHintGenerator, Point2, Triangulation};

/// Insert and delete points in a file of uniform points, and in spade; commit single points; and query
/// the file meanwhile.
#[derive(Parser)]
struct Arguments {
    /// Number of points in the file
    #[arg(long, default_value_t = 10_000_000, value_parser = clap::value_parser!(u64).range(1000..1 << 29))]
    points: u64,
    /// Number of vertices of a tile
    #[arg(long, default_value_t = 32_768)]
    tile_vertices: usize,
    /// Number of points that come and go at once
    #[arg(long, default_value_t = 1_000_000, value_parser = clap::value_parser!(u64).range(1..1 << 29))]
    changes: u64,
    /// Number of rounds of these changes; the table has medians
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// Number of single commits, in the file and by the log
    #[arg(long, default_value_t = 300, value_parser = clap::value_parser!(u32).range(10..))]
    commits: u32,
    /// Memory of the editor
    #[arg(long, default_value = "256MiB")]
    memory: ByteSize,
    /// Folder for the file, on the device to measure
    #[arg(long, default_value = ".")]
    folder: PathBuf,
}

/// A row of the table: what was done, the figures of the library and of what it is beside, and the bar
/// for their ratio.
struct Row(&'static str, String, String, f64, &'static str);

/// Time between looks at the clock, where nothing is written.
const PAUSE: Duration = Duration::from_millis(20);

type Spade = DelaunayTriangulation<Point2<f64>, (), (), (), LastUsedVertexHintGenerator>;

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let folder = tempfile::tempdir_in(&arguments.folder)
        .with_context(|| format!("cannot make a folder in {}", arguments.folder.display()))?;
    let runtime = tokio::runtime::Runtime::new()?;
    let rows = runtime.block_on(measure(&arguments, folder.path()))?;
    println!(
        "| {} uniform points, {} | found | beside | ratio | at most |",
        arguments.points, arguments.memory
    );
    println!("|---|--:|--:|--:|--:|");
    for Row(name, found, beside, ratio, most) in rows {
        println!("| {name} | {found} | {beside} | {ratio:.2} | {most} |");
    }
    Ok(())
}

async fn measure(arguments: &Arguments, folder: &Path) -> Result<Vec<Row>> {
    let path = folder.join("edited.tiles");
    let mut builder = Builder::new(&path, BuildOptions::default().tile_vertices(arguments.tile_vertices))?;
    let all: Vec<Point> = uniform(arguments.points, 1);
    for (batch, first) in all.chunks(1 << 16).zip((0..).step_by(1 << 16)) {
        builder.push(&batch_of(batch, first)).await?;
    }
    let built = builder.finish().await?;
    let tile_bytes = built.file_bytes / built.tiles.max(1);
    let mut rows = many(arguments, &path, &all).await?;
    drop(all);
    rows.extend(queries(arguments, &path, tile_bytes).await?);
    rows.push(single(arguments, &path, Some(tile_bytes)).await?);
    rows.push(single(arguments, &path, None).await?);
    TileReader::open(&path, OpenOptions::default())
        .await?
        .verify(true)
        .await?;
    Ok(rows)
}

fn uniform(count: u64, seed: u64) -> Vec<Point> {
    let points = distributions::points(Kind::Uniform, count, seed);
    points.map(|[x, y]| Point::new(x, y)).collect()
}

fn batch_of(points: &[Point], first: u64) -> PointBatch {
    PointBatch {
        records: (first..first + points.len() as u64).collect(),
        points: points.to_vec(),
        z: Vec::new(),
    }
}

/// Returns points of the square in the order of a Hilbert curve.
fn in_hilbert_order(mut points: Vec<Point>) -> Vec<Point> {
    let cell = |x: f64| (x * f64::from(1 << 16)) as u32;
    points.sort_by_cached_key(|p| fast_hilbert::xy2h(cell(p.x), cell(p.y), 16));
    points
}

/// Makes many changes in one transaction, and in spade, by turns.
async fn many(arguments: &Arguments, path: &Path, all: &[Point]) -> Result<Vec<Row>> {
    let mut spade = Spade::bulk_load(all.iter().map(|p| Point2::new(p.x, p.y)).collect())?;
    let (mut ours, mut theirs) = ([Vec::new(), Vec::new()], [Vec::new(), Vec::new()]);
    let mut touched = (0, 0, 0);
    for round in 0..arguments.rounds {
        let new = in_hilbert_order(uniform(arguments.changes, 2 + u64::from(round)));
        let batch = batch_of(&new, 0);
        let (inserted, seconds) = edit(path, arguments.memory, |tx| tx.insert(&batch)).await?;
        ours[0].push(seconds);
        let (deleted, seconds) = edit(path, arguments.memory, |tx| tx.delete(&new)).await?;
        ours[1].push(seconds);
        ensure!(inserted.points.inserted == deleted.points.deleted, "points were lost");
        let tiles = TileReader::open(path, OpenOptions::default()).await?.metadata().tiles;
        touched = (inserted.tile_reads, inserted.tiles_written, tiles);

        let began = Instant::now();
        let handles: Vec<FixedVertexHandle> = new
            .iter()
            .map(|p| spade.insert(Point2::new(p.x, p.y)))
            .collect::<Result<_, _>>()?;
        theirs[0].push(began.elapsed().as_secs_f64());
        let began = Instant::now();
        // From the last one on, since spade gives the number of the last vertex to another one.
        for &vertex in handles.iter().rev() {
            black_box(spade.remove(vertex));
        }
        theirs[1].push(began.elapsed().as_secs_f64());
    }
    let (reads, written, tiles) = touched;
    println!("Insertions read {reads} tiles and wrote {written}; the file has {tiles}.\n");
    let row = |name, which: usize, most| {
        let [found, beside] = [&ours[which], &theirs[which]].map(|times| median(times));
        Row(
            name,
            format!("{found:.2} s"),
            format!("spade {beside:.2} s"),
            found / beside,
            most,
        )
    };
    Ok(vec![
        row("insertions at once", 0, "2"),
        row("deletions at once", 1, "1.5"),
    ])
}

/// Makes changes in one transaction. Returns the summary and the seconds.
async fn edit(
    path: &Path,
    memory: ByteSize,
    change: impl FnOnce(&mut delaunay_tiles::Transaction) -> Result<(), delaunay_tiles::EditError>,
) -> Result<(EditSummary, f64)> {
    let began = Instant::now();
    let editor = Editor::open(path, EditOptions::default().memory(memory.as_u64())).await?;
    let mut transaction = editor.begin().await?;
    change(&mut transaction)?;
    let summary = transaction.commit().await?;
    Ok((summary, began.elapsed().as_secs_f64()))
}

/// The writes of a commit alone, without what computes them.
struct Device {
    file: File,
    bytes: Vec<u8>,
    end: u64,
}

impl Device {
    fn create(path: &Path, bytes: u64) -> Result<Self> {
        Ok(Self {
            file: File::create(path.with_extension("device"))?,
            bytes: vec![7; usize::try_from(bytes)?],
            end: 0,
        })
    }

    /// Writes a tile and, once it is on the medium, a superblock.
    fn write_tile(&self) -> Result<()> {
        self.file.write_all_at(&self.bytes, 0)?;
        self.file.sync_data()?;
        self.file.write_all_at(&self.bytes[..4096.min(self.bytes.len())], 0)?;
        Ok(self.file.sync_data()?)
    }

    fn append(&mut self) -> Result<()> {
        self.file.write_all_at(&self.bytes, self.end)?;
        self.end += self.bytes.len() as u64;
        Ok(self.file.sync_data()?)
    }
}

/// Inserts single points, each in a transaction of its own, in turns with the same writes alone: those of
/// a tile of as many bytes and a superblock, or, without a tile, those of the log.
async fn single(arguments: &Arguments, path: &Path, tile_bytes: Option<u64>) -> Result<Row> {
    let is_log = tile_bytes.is_none();
    let durability = if is_log { Durability::Log } else { Durability::File };
    let options = EditOptions::default().memory(arguments.memory.as_u64());
    let editor = Editor::open(path, options.durability(durability)).await?;
    let mut device = Device::create(path, tile_bytes.unwrap_or(57))?;
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    // By the log, the first commits in a tile read it. As many come before those that count.
    let warm = if is_log {
        arguments.commits * 4
    } else {
        arguments.commits / 10
    };
    for (number, point) in (0..).zip(uniform(u64::from(arguments.commits + warm), 77 + u64::from(is_log))) {
        let began = Instant::now();
        let mut transaction = editor.begin().await?;
        transaction.insert(&batch_of(&[point], 0))?;
        transaction.commit().await?;
        let seconds = began.elapsed().as_secs_f64();
        let began = Instant::now();
        if is_log {
            device.append()?;
        } else {
            device.write_tile()?;
        }
        if number >= warm {
            ours.push(seconds);
            theirs.push(began.elapsed().as_secs_f64());
        }
    }
    editor.checkpoint().await?;
    let [found, beside] = [median(&ours), median(&theirs)];
    let name = if is_log {
        "single commit by the log"
    } else {
        "single commit in the file"
    };
    let [ours, theirs] = [found, beside].map(|seconds| format!("{:.2} ms", seconds * 1e3));
    Ok(Row(name, ours, format!("device {theirs}"), found / beside, "3"))
}

/// Locates points while the file stays as it is, while points come to it, while only as many bytes are
/// written and synced as an edit writes, as often, and while another thread computes. The last two are
/// what the device and the processor make of it.
async fn queries(arguments: &Arguments, path: &Path, tile_bytes: u64) -> Result<[Row; 3]> {
    let editor = Editor::open(path, EditOptions::default().memory(arguments.memory.as_u64())).await?;
    let device = Device::create(path, tile_bytes)?;
    let is_over = Arc::new(AtomicBool::new(false));
    // Several times in each state, since what the system has cached changes.
    let mut p99 = [const { Vec::new() }; 4];
    let mut of_commit = PAUSE;
    for round in 0..12_u64 {
        is_over.store(false, Ordering::Relaxed);
        let reader = TileReader::open(path, OpenOptions::default()).await?;
        let querying = tokio::spawn(locate(reader, Arc::clone(&is_over), round));
        let busy = (round % 4 == 3).then(|| thread::spawn(compute_until(Arc::clone(&is_over))));
        let began = Instant::now();
        let mut commits = 0;
        for point in uniform(u64::from(arguments.commits), 500 + round) {
            if began.elapsed().as_secs() > 10 {
                break;
            }
            commits += 1;
            match round % 4 {
                0 | 3 => tokio::time::sleep(PAUSE).await,
                1 => {
                    let mut transaction = editor.begin().await?;
                    transaction.insert(&batch_of(&[point], 0))?;
                    transaction.commit().await?;
                }
                _ => {
                    let next = tokio::time::Instant::now() + of_commit;
                    tokio::task::block_in_place(|| device.write_tile())?;
                    tokio::time::sleep_until(next).await;
                }
            }
        }
        if round % 4 == 1 {
            of_commit = began.elapsed() / commits.max(1);
        }
        is_over.store(true, Ordering::Relaxed);
        p99[(round % 4) as usize].push(querying.await??);
        if let Some(busy) = busy {
            black_box(busy.join().map_err(|_| anyhow!("a thread is gone"))?);
        }
    }
    let [without, edited, written, beside_busy] = p99.map(|times| median(&times));
    let row = |name, found: f64, most| {
        let [ours, beside] = [found, without].map(|seconds| format!("{:.3} ms", seconds * 1e3));
        Row(name, ours, format!("else {beside}"), found / without, most)
    };
    Ok([
        row("a query in a hundred, while the file is edited", edited, "1.2"),
        row("the same, while as many tiles are written and synced", written, ""),
        row("the same, while another thread computes", beside_busy, ""),
    ])
}

/// Returns what computes, in little memory, until it is over.
fn compute_until(is_over: Arc<AtomicBool>) -> impl FnOnce() -> u64 {
    move || {
        let mut number = 1;
        while !is_over.load(Ordering::Relaxed) {
            number = mix(number);
        }
        number
    }
}

/// Locates points until it is over. Returns the seconds that all but a hundredth take at most.
async fn locate(reader: TileReader, is_over: Arc<AtomicBool>, seed: u64) -> Result<f64> {
    let unit = |number: u64| (mix(number) >> 11) as f64 / (1_u64 << 53) as f64;
    let mut times = Vec::new();
    for number in seed << 40.. {
        if is_over.load(Ordering::Relaxed) {
            break;
        }
        let began = Instant::now();
        black_box(reader.locate(unit(2 * number), unit(2 * number + 1)).await?);
        times.push(began.elapsed().as_secs_f64());
        tokio::task::yield_now().await;
    }
    times.sort_by(f64::total_cmp);
    times.get(times.len() * 99 / 100).copied().context("no query was made")
}
