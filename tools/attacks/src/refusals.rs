//! Commands of the tool under limits of the system: threads, open files, address space, data,
//! lengths of files, processor time, a full disk.
//!
//! A command has the same result as without the limit; or it ends with exit code 1 and one line
//! `error: …`, and changes nothing under the final name. The next run without a limit succeeds and
//! leaves nothing behind.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context as _, bail, ensure};
use rand_chacha::ChaCha8Rng;

use crate::campaign::{Context, Counts, below};

/// The time within which each run must end.
const LIMIT: Duration = Duration::from_secs(60);

/// The commands. Those that write make or change `out.…`.
const COMMANDS: [&str; 15] = [
    "build p.f64 -o out.tiles --force --quiet --tile-vertices 500 --threads 2",
    "build p.f64 -o out.tiles --force --quiet --tile-vertices 60 --memory 200KiB",
    "build p.f64 --segments p.u32 -o out.tiles --force --quiet --tile-vertices 300 --memory 2MiB",
    "constrain out.tiles --walls w.csv --quiet",
    "compact out.tiles",
    "inspect town.tiles --plot out.svg",
    "inspect town.tiles",
    "verify --deep town.tiles",
    "verify town.tiles --against p.f64 --segments p.u32",
    "digest --recompute town.tiles",
    "query knn town.tiles --at 0.5,0.5 --at 0.2,0.9 -k 3 --csv",
    "query path town.tiles --from 0.1,0.1 --to 0.9,0.9 --csv",
    "export town.tiles -o out.ply",
    "export town.tiles -o out.node",
    "generate kuzmin -n 30k -o out.f64",
];

/// The limited resource, and its limit.
#[derive(Clone, Copy, Debug)]
enum Refusal {
    /// The number of threads beside the first, limited by a preloaded library.
    Threads(u64),
    /// The number of processes and threads, limited by a control group.
    Pids(u64),
    /// A number, or a number of blocks, limited by an option of `ulimit`.
    Limit(char, u64),
    /// The number of free bytes on the disk that the command writes to.
    Disk(u64),
    /// The milliseconds after which the command gets the signal that the system sends when the
    /// processor time is used up.
    Time(u64),
}

impl Refusal {
    fn random(random: &mut ChaCha8Rng) -> Self {
        match below(random, 8) {
            0 => Self::Threads(below(random, 14)),
            1 => Self::Pids(1 + below(random, 20)),
            2 => Self::Limit('n', 4 + below(random, 37)),
            // In kibibytes.
            3 => Self::Limit('v', (24 << 10) + below(random, 200 << 10)),
            4 => Self::Limit('d', (12 << 10) + below(random, 64 << 10)),
            // In blocks of 512 bytes or of 1 KiB.
            5 => Self::Limit('f', below(random, 3000)),
            6 => Self::Disk(below(random, 3 << 20)),
            _ => Self::Time(below(random, 60)),
        }
    }
}

/// Runs one command under one limit.
pub fn round(context: &Context, mut random: ChaCha8Rng) -> anyhow::Result<Counts> {
    let args = COMMANDS[below(&mut random, COMMANDS.len() as u64) as usize];
    let refusal = Refusal::random(&mut random);
    let story = format!("tiletool {args}, {refusal:?}");
    let outer = tempfile::tempdir()?;
    let disk = matches!(refusal, Refusal::Disk(_))
        .then(|| SmallDisk::mount(outer.path()))
        .flatten();
    let group = match refusal {
        Refusal::Pids(most) => Group::new(most),
        _ => None,
    };
    let scene = Scene::prepare(context, outer.path(), args)?;
    if let (Refusal::Disk(bytes), Some(disk)) = (refusal, &disk) {
        disk.leave(bytes)?;
    }
    let command = limited(context, &scene, refusal, group.as_ref())?;
    let ended = end_of(command, refusal).context(story.clone())?;
    if let Some(disk) = &disk {
        disk.leave(1 << 30)?;
    }
    scene.judge(context, &ended).context(story.clone())?;
    // Files that the limited run left behind stay for the next run.
    scene.renew()?;
    let next = end_of(context.command(&scene.folder, args), Refusal::Pids(0))?;
    ensure!(next.code == Some(0), "{story}: the next run fails: {}", next.errors);
    ensure!(
        scene.state(context)? == scene.new,
        "{story}: the next run makes another file"
    );
    let left = names(&scene.folder)?;
    ensure!(left == scene.names, "{story}: files stay behind: {left:?}");
    Ok(vec![
        ("refused", u64::from(ended.code == Some(1))),
        ("done all the same", u64::from(ended.code == Some(0))),
    ])
}

/// Returns the command under its limit.
fn limited(context: &Context, scene: &Scene, refusal: Refusal, group: Option<&Group>) -> anyhow::Result<Command> {
    let tool = context.command(&scene.folder, scene.args);
    let before = match (refusal, group) {
        (Refusal::Limit(option @ ('v' | 'd'), most), _) => {
            format!("ulimit -{option} {}", most.max(least_to_load(context, option)?))
        }
        (Refusal::Limit(option, most), _) => format!("ulimit -{option} {most}"),
        (Refusal::Pids(_), Some(Group(path))) => format!("echo $$ > {}/cgroup.procs", path.display()),
        (Refusal::Threads(most), _) => {
            let mut tool = tool;
            tool.env("LD_PRELOAD", context.preload()?)
                .env("FAULTS_THREADS", most.to_string());
            return Ok(tool);
        }
        _ => return Ok(tool),
    };
    let mut command = Command::new("sh");
    let script = format!("{before} && exec \"$@\"");
    command
        .args(["-c", &script, "sh"])
        .arg(tool.get_program())
        .args(tool.get_args());
    command.current_dir(&scene.folder);
    Ok(command)
}

/// Returns the least limit of memory, in kibibytes, with which the program is loaded at all.
fn least_to_load(context: &Context, option: char) -> anyhow::Result<u64> {
    static LEAST: Mutex<BTreeMap<char, u64>> = Mutex::new(BTreeMap::new());
    let mut least = LEAST.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(&known) = least.get(&option) {
        return Ok(known);
    }
    for kibibytes in (1..200).map(|mebibytes| mebibytes << 10) {
        let script = format!("ulimit -{option} {kibibytes} && exec \"$0\" --version");
        let mut command = Command::new("sh");
        command.args(["-c", &script]).arg(&context.tool);
        if command.output()?.status.success() {
            least.insert(option, kibibytes);
            return Ok(kibibytes);
        }
    }
    bail!("{} cannot be loaded under a limit of memory", context.tool.display())
}

/// How a process ended, and its output.
struct Ended {
    code: Option<i32>,
    output: String,
    errors: String,
}

/// Runs a command to its end. A command that takes too long is killed, which is an error.
fn end_of(mut command: Command, refusal: Refusal) -> anyhow::Result<Ended> {
    let (output, errors) = (tempfile::NamedTempFile::new()?, tempfile::NamedTempFile::new()?);
    command
        .stdin(Stdio::null())
        .stdout(output.reopen()?)
        .stderr(errors.reopen()?);
    let began = Instant::now();
    let mut child = command.spawn()?;
    if let Refusal::Time(milliseconds) = refusal {
        // Before the tool has installed its handler, the signal ends the process.
        while child.try_wait()?.is_none() && !catches_signal(child.id()) {
            thread::sleep(Duration::from_millis(1));
        }
        thread::sleep(Duration::from_millis(milliseconds));
        let kill = format!("kill -s XCPU {}", child.id());
        Command::new("sh").args(["-c", &kill]).stderr(Stdio::null()).status()?;
    }
    let status = loop {
        match child.try_wait()? {
            Some(status) => break status,
            None if began.elapsed() > LIMIT => {
                child.kill()?;
                child.wait()?;
                bail!("it hangs, or takes more than {} s", LIMIT.as_secs());
            }
            None => thread::sleep(Duration::from_millis(2)),
        }
    };
    let text = |file: &Path| anyhow::Ok(String::from_utf8_lossy(&fs::read(file)?).into_owned());
    Ok(Ended {
        code: status.code(),
        output: text(output.path())?,
        errors: text(errors.path())?,
    })
}

/// Returns whether a process has a handler for the signal that its processor time is used up.
fn catches_signal(process: u32) -> bool {
    const SIGXCPU: u32 = 24;
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
    let caught = caught.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    caught.is_some_and(|mask| mask >> (SIGXCPU - 1) & 1 == 1)
}

/// The content under the final names: a digest or the bytes of each file.
type State = Vec<Option<Vec<u8>>>;

/// A command in a folder, and its result without a limit.
struct Scene {
    folder: PathBuf,
    args: &'static str,
    /// The final names.
    outputs: Vec<&'static str>,
    /// The names in the folder before and after the command.
    names: Vec<OsString>,
    /// The content of the files before the command.
    before: Vec<Vec<u8>>,
    old: State,
    new: State,
    output: String,
}

impl Scene {
    fn prepare(context: &Context, outer: &Path, args: &'static str) -> anyhow::Result<Self> {
        let folder = outer.join("work");
        fs::create_dir(&folder)?;
        let run = |args: &str| context.run(&folder, args);
        run("generate uniform -n 8k --pslg 0.3 -o p.f64")?;
        run("build p.f64 --segments p.u32 -o town.tiles --tile-vertices 500 --quiet")?;
        fs::write(folder.join("w.csv"), "0.31,0.1,0.32,0.2\n0.7,0.5,0.71,0.6\n")?;
        let outputs: Vec<&str> = match args.split(' ').find(|word| word.starts_with("out.")) {
            Some("out.node") => vec!["out.node", "out.ele"],
            name => name.into_iter().collect(),
        };
        for output in &outputs {
            match *output {
                "out.tiles" => drop(run("build p.f64 -o out.tiles --tile-vertices 700 --quiet")?),
                other => fs::write(folder.join(other), "what was there before")?,
            }
        }
        let names = names(&folder)?;
        let mut scene = Self {
            before: outputs
                .iter()
                .map(|name| fs::read(folder.join(name)))
                .collect::<Result<_, _>>()?,
            folder: folder.clone(),
            args,
            outputs,
            names,
            old: State::new(),
            new: State::new(),
            output: String::new(),
        };
        scene.old = scene.state(context)?;
        scene.output = run(args)?;
        scene.new = scene.state(context)?;
        scene.renew()?;
        Ok(scene)
    }

    /// Restores the files that were there before.
    fn renew(&self) -> anyhow::Result<()> {
        let files = self.outputs.iter().zip(&self.before);
        Ok(files
            .into_iter()
            .try_for_each(|(name, bytes)| fs::write(self.folder.join(name), bytes))?)
    }

    fn state(&self, context: &Context) -> anyhow::Result<State> {
        let of = |name: &&str| match fs::read(self.folder.join(name)) {
            Err(_) => Ok(None),
            Ok(_) if *name == "out.tiles" => Ok(Some(
                context.run(&self.folder, "digest --recompute out.tiles")?.into_bytes(),
            )),
            Ok(bytes) => Ok(Some(bytes)),
        };
        self.outputs.iter().map(of).collect()
    }

    /// Fails unless a run under a limit did all or nothing, and reported it.
    fn judge(&self, context: &Context, ended: &Ended) -> anyhow::Result<()> {
        let Ended { code, output, errors } = ended;
        let state = self.state(context)?;
        if *code == Some(0) {
            ensure!(answer(output).eq(answer(&self.output)), "another answer: {output}");
            ensure!(state == self.new, "another file");
            return Ok(());
        }
        let is_one_line = errors.lines().count() == 1 && errors.starts_with("error: ");
        ensure!(*code == Some(1) && is_one_line, "exit code {code:?}: {errors}");
        ensure!(
            !errors.contains("panicked") && !errors.contains("internal error"),
            "{errors}"
        );
        // Each of several files is old or new. A file may have its final name although writing its
        // folder or the report failed.
        let is_whole = |((now, old), new): ((&Option<Vec<u8>>, _), _)| now == old || now == new;
        ensure!(
            state.iter().zip(&self.old).zip(&self.new).all(is_whole),
            "another file under the final name"
        );
        Ok(())
    }
}

/// Returns the lines that a command prints, without the one that names the I/O backend: the system
/// may refuse a ring.
fn answer(output: &str) -> impl Iterator<Item = &str> {
    output.lines().filter(|line| !line.starts_with("  read by "))
}

/// Returns the names in a folder, sorted.
fn names(folder: &Path) -> anyhow::Result<Vec<OsString>> {
    let names: Result<Vec<OsString>, _> = fs::read_dir(folder)?
        .map(|entry| entry.map(|entry| entry.file_name()))
        .collect();
    let mut names = names?;
    names.sort_unstable();
    Ok(names)
}

/// A control group that limits threads. There is none if this process may not make one.
struct Group(PathBuf);

impl Group {
    fn new(most: u64) -> Option<Self> {
        let path = PathBuf::from(format!("/sys/fs/cgroup/pids/attacks-{}", std::process::id()));
        fs::create_dir(&path).ok()?;
        let group = Self(path);
        fs::write(group.0.join("pids.max"), most.to_string()).ok()?;
        Some(group)
    }
}

impl Drop for Group {
    fn drop(&mut self) {
        // The group stays if a process in it hangs.
        let _ = fs::remove_dir(&self.0);
    }
}

/// A disk in memory. There is none if this process may not mount one.
struct SmallDisk<'a>(&'a Path);

impl<'a> SmallDisk<'a> {
    fn mount(at: &'a Path) -> Option<Self> {
        let mut command = Command::new("mount");
        command
            .args(["-t", "tmpfs", "-o", "size=256m", "tmpfs"])
            .arg(at)
            .stderr(Stdio::null());
        command.status().ok()?.success().then_some(Self(at))
    }

    /// Fills the disk until `bytes` bytes are free.
    fn leave(&self, bytes: u64) -> anyhow::Result<()> {
        let used = Command::new("du").args(["-s", "-k"]).arg(self.0).output()?;
        let used = String::from_utf8_lossy(&used.stdout)
            .split_whitespace()
            .next()
            .map(str::parse::<u64>);
        let size = format!(
            "remount,size={}k",
            used.context("du prints nothing")?? + 64 + bytes / 1024
        );
        let status = Command::new("mount").args(["-o", &size]).arg(self.0).status()?;
        ensure!(status.success(), "the small disk cannot be changed");
        Ok(())
    }
}

impl Drop for SmallDisk<'_> {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(self.0).status();
    }
}
