//! Power cuts, replayed from a log of everything that the tool does to its files.
//!
//! A round runs one command that replaces or changes a file, and logs its writes. Then power is cut
//! at many points of the log (`disk.rs`). After each cut the old file or the new one must be under
//! the final name, whole. After some cuts the command runs again, which must make the new file and
//! leave nothing else behind.

mod disk;

use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, ensure};
use delaunay_tiles::input::PointBatch;
use delaunay_tiles::io::MemoryFile;
use delaunay_tiles::store::{OpenOptions, TileReader};
use delaunay_tiles::{Durability, EditOptions, Editor, Point};
use rand_chacha::ChaCha8Rng;
use xxhash_rust::xxh3::xxh3_128;

use crate::campaign::{Context, Counts, below};
use disk::{Disk, Record, Tree, records};

/// The number of cuts in a round, and the number of cuts after which the command runs again.
const CUTS: usize = 300;
const RERUNS: usize = 4;

/// The file that the commands write, and its log.
const OUTPUT: &str = "x.tiles";
const LOG: &str = "x.tiles.log";

/// A command, and the folder in which it runs.
struct Scene {
    folder: tempfile::TempDir,
    root: PathBuf,
    args: String,
    /// Whether the command changes the file in place; then the new file may have other bytes than
    /// expected.
    is_edit: bool,
    can_resume: bool,
    /// The files that are there before and after the command.
    names: Vec<PathBuf>,
    old: Vec<u8>,
    new: Vec<u8>,
    digests: [String; 2],
}

/// Cuts power during one command.
pub fn round(context: &Context, mut random: ChaCha8Rng) -> anyhow::Result<Counts> {
    let random = &mut random;
    let mut scene = Scene::prepare(context, random)?;
    let before = Disk::of(&scene.root)?;
    let log = scene.run(context)?;
    let log = records(&log)?;
    let mut cuts: Vec<usize> = (1..CUTS)
        .map(|_| below(random, log.len() as u64 + 1) as usize)
        .collect();
    cuts.push(log.len());
    cuts.sort_unstable();
    let (mut checked, mut reruns, mut blocks) = (HashMap::new(), 0, 0);
    let mut disk = before;
    let mut done = 0;
    let reruns_wanted = if scene.can_resume { 4 * RERUNS } else { RERUNS };
    let step = CUTS / reruns_wanted;
    for (number, &cut) in cuts.iter().enumerate() {
        log[done..cut].iter().for_each(|record: &Record| disk.take(record));
        done = cut;
        let is_rerun = number % step == step / 2;
        let tree = disk.cut(random, |path| is_rerun || path == Path::new(OUTPUT));
        let story = format!("tiletool {}, cut after {cut} of {} records", scene.args, log.len());
        let is_new = scene.check(&tree, &mut checked).with_context(|| story.clone())?;
        ensure!(
            cut < log.len() || is_new,
            "{story}: the old file came back after the end"
        );
        if is_rerun {
            blocks += scene.rerun(context, &tree, is_new).context(story)?;
            reruns += 1;
        }
    }
    Ok(vec![
        ("cuts", cuts.len() as u64),
        ("records", log.len() as u64),
        ("commands run again", reruns),
        ("blocks gone on from", blocks),
    ])
}

impl Scene {
    fn prepare(context: &Context, random: &mut ChaCha8Rng) -> anyhow::Result<Self> {
        let folder = tempfile::tempdir()?;
        let root = folder.path().join("root");
        fs::create_dir(&root)?;
        let root = root.canonicalize()?;
        let run = |args: &str| context.run(&root, args);
        let walls: String = (1..4).map(|i| format!("0.2,0.{0}1,0.7,0.{0}2\n", 2 * i)).collect();
        fs::write(root.join("w.csv"), walls)?;
        let kind = below(random, 5);
        let (before, args) = commands(kind, random);
        before.iter().try_for_each(|args| run(args).map(drop))?;
        if args.starts_with("checkpoint") {
            log_changes(&root.join(OUTPUT), random)?;
        }
        let old = fs::read(root.join(OUTPUT))?;
        Ok(Self {
            digests: [run(&format!("digest --recompute {OUTPUT}"))?, String::new()],
            names: names(&root)?,
            folder,
            root,
            args,
            is_edit: kind == 3,
            can_resume: kind == 1,
            old,
            new: Vec::new(),
        })
    }

    /// Runs the command, and returns the log of its writes.
    fn run(&mut self, context: &Context) -> anyhow::Result<Vec<u8>> {
        let log = self.folder.path().join("log");
        let mut command = context.command(&self.root, &self.args);
        command
            .env("LD_PRELOAD", context.preload()?)
            .env("FAULTS_LOG", &log)
            .env("FAULTS_LOG_ROOT", &self.root);
        let output = command.output()?;
        let errors = String::from_utf8_lossy(&output.stderr);
        ensure!(output.status.success(), "tiletool {}: {errors}", self.args);
        self.new = fs::read(self.root.join(OUTPUT))?;
        self.digests[1] = context.run(&self.root, &format!("digest --recompute {OUTPUT}"))?;
        Ok(fs::read(log)?)
    }

    /// Fails unless the old file or the new one is there, whole. Returns whether it is the new one.
    fn check(&self, tree: &Tree, checked: &mut HashMap<u128, bool>) -> anyhow::Result<bool> {
        let found = tree.get(Path::new(OUTPUT)).and_then(Option::as_ref);
        let found = found.context("there is no file any more")?;
        if *found == self.old || *found == self.new {
            return Ok(*found == self.new);
        }
        ensure!(self.is_edit, "the file is neither the old one nor the new one");
        let hash = xxh3_128(found);
        if let Some(&is_new) = checked.get(&hash) {
            return Ok(is_new);
        }
        let digest = verified_digest(found)?;
        let [old, new] = [&self.old, &self.new].map(|bytes| verified_digest(bytes));
        let is_new = digest == new?;
        ensure!(
            is_new || digest == old?,
            "the file is whole, but neither the old one nor the new one"
        );
        checked.insert(hash, is_new);
        Ok(is_new)
    }

    /// Runs the command on the files after a cut. Returns the number of blocks that it resumed.
    fn rerun(&self, context: &Context, tree: &Tree, is_new: bool) -> anyhow::Result<u64> {
        for entry in fs::read_dir(&self.root)? {
            let path = entry?.path();
            match path.is_dir() {
                true => fs::remove_dir_all(&path)?,
                // Inputs keep their modification times, by which a build recognizes them.
                false if self.is_input(path.strip_prefix(&self.root)?) => {}
                false => fs::remove_file(&path)?,
            }
        }
        for (path, content) in tree {
            match content {
                None => fs::create_dir(self.root.join(path))?,
                Some(_) if self.is_input(path) => {}
                Some(bytes) => fs::write(self.root.join(path), bytes)?,
            }
        }
        let mut blocks = 0;
        let resumed = format!("{} --resume --json", self.args.replace(" --quiet", ""));
        let is_resumed = self.can_resume && {
            let output = context.command(&self.root, &resumed).output()?;
            let errors = String::from_utf8_lossy(&output.stderr);
            match output.status.code() {
                Some(0) => {
                    let text = String::from_utf8_lossy(&output.stdout).into_owned();
                    let count = text.split("\"resumed_blocks\":").nth(1).and_then(|rest| {
                        rest.trim_start()
                            .split(|c: char| !c.is_ascii_digit())
                            .next()?
                            .parse::<u64>()
                            .ok()
                    });
                    blocks = count.context("the summary names no resumed blocks")?;
                }
                Some(1) => ensure!(
                    errors.lines().last().is_some_and(|line| line.starts_with("error: ")),
                    "{errors}"
                ),
                _ => anyhow::bail!("tiletool {resumed}: {}: {errors}", output.status),
            }
            output.status.success()
        };
        // A second edit adds lines to those in the file, and the digest counts lines. A second checkpoint
        // must find nothing to do.
        let is_repeatable = !self.is_edit || self.args.starts_with("checkpoint");
        if !(is_resumed || is_new && !is_repeatable) {
            context.run(&self.root, &self.args)?;
        }
        let digest = context.run(&self.root, &format!("digest --recompute {OUTPUT}"))?;
        ensure!(digest == self.digests[1], "the command made another file: {digest}");
        context.run(&self.root, &format!("verify --deep {OUTPUT}"))?;
        if is_repeatable || !is_new {
            let (found, mut expected) = (names(&self.root)?, self.names.clone());
            expected.retain(|name| name != Path::new(LOG));
            ensure!(found == expected, "files stay behind: {found:?}, not {expected:?}");
        }
        Ok(blocks)
    }

    fn is_input(&self, path: &Path) -> bool {
        ![OUTPUT, LOG].map(Path::new).contains(&path) && self.names.iter().any(|name| name == path)
    }
}

/// Returns the commands that make the old file and the inputs, and the command that makes the new
/// file.
fn commands(kind: u64, random: &mut ChaCha8Rng) -> (Vec<String>, String) {
    let (points, old_points) = (1000 + below(random, 3000), 500 + below(random, 500));
    let (seed, threads) = (below(random, 1 << 32), 1 + below(random, 2));
    let vertices = 60 + below(random, 300);
    let build = |inputs: &str, vertices| {
        format!("build {inputs} -o {OUTPUT} --force --quiet --tile-vertices {vertices} --threads {threads}")
    };
    let generate = |points, options: &str| format!("generate uniform -n {points} --seed {seed} -o p.f64{options}");
    let old = [generate(old_points, ""), build("p.f64", vertices)];
    let constrain = format!("constrain {OUTPUT} --walls w.csv --quiet");
    let after = |more: &[String]| [&old[..], more].concat();
    match kind {
        0 => (
            after(&[generate(points, " --pslg 0.3")]),
            build("p.f64 --segments p.u32 --memory 4MiB", vertices),
        ),
        // So little memory that points are spilled.
        1 => (
            after(&[generate(points + 7000, "")]),
            match below(random, 2) {
                0 => build("p.f64 --memory 165KiB", 60),
                _ => build("p.f64 --walls w.csv --memory 165KiB", 60),
            },
        ),
        // So little memory that lines are deferred.
        2 => (
            after(&[generate(points, " --long-segments 40")]),
            build("p.f64 --walls p.u32 --memory 1MiB", vertices),
        ),
        3 => {
            let mut before = vec![generate(points, ""), build("p.f64", vertices)];
            let more = |name, seed| format!("generate uniform -n 300 --seed {seed} -o {name}");
            before.extend([more("q.f64", seed + 1), more("r.f64", seed + 2)]);
            let insert = |name| format!("insert {OUTPUT} {name} --quiet");
            let delete = format!("delete {OUTPUT} q.f64 --skip-missing --quiet");
            // After some edits, the next one overwrites bytes of earlier states.
            let edits = [insert("q.f64"), delete.clone(), insert("q.f64")];
            before.extend(edits.into_iter().take(below(random, 4) as usize));
            let command = match below(random, 6) {
                0 => constrain,
                1 => insert("r.f64"),
                2 => delete,
                3 | 4 => format!("checkpoint {OUTPUT}"),
                _ => {
                    // A file without triangles is built anew.
                    before.truncate(4);
                    before.push(format!("delete {OUTPUT} p.f64 --quiet"));
                    insert("r.f64")
                }
            };
            (before, command)
        }
        _ => (
            vec![generate(points, ""), build("p.f64", vertices), constrain],
            format!("compact {OUTPUT}"),
        ),
    }
}

/// Puts some transactions into the log of a file.
fn log_changes(file: &Path, random: &mut ChaCha8Rng) -> anyhow::Result<()> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let at = |random: &mut ChaCha8Rng| below(random, 1 << 20) as f64 / f64::from(1 << 20);
    runtime.block_on(async {
        let options = EditOptions::default().memory(16 << 20).durability(Durability::Log);
        let editor = Editor::open(file, options).await?;
        for _ in 0..1 + below(random, 20) {
            let points: Vec<Point> = (0..1 + below(random, 9))
                .map(|_| Point::new(at(random), at(random)))
                .collect();
            let mut transaction = editor.begin().await?;
            transaction.insert(&PointBatch {
                records: (0..points.len() as u64).collect(),
                points,
                z: Vec::new(),
            })?;
            let summary = transaction.commit().await?;
            ensure!(summary.pending_transactions > 0, "the transaction is not in the log");
        }
        Ok(())
    })
}

/// Returns the names in a folder, sorted.
fn names(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let names: Result<BTreeMap<PathBuf, ()>, _> = fs::read_dir(folder)?
        .map(|entry| entry.map(|entry| (entry.file_name().into(), ())))
        .collect();
    Ok(names?.into_keys().collect())
}

/// Verifies a file, and returns its digest.
fn verified_digest(bytes: &[u8]) -> anyhow::Result<String> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    runtime.block_on(async {
        let file = MemoryFile::new(bytes.to_vec());
        let reader = TileReader::open_source(file, OUTPUT, OpenOptions::default()).await?;
        reader.verify(true).await?;
        Ok(format!("{:?}", reader.recompute_digest().await?))
    })
}
