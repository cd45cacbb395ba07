//! Helpers that the tests of the tool share: they run the tool in a folder and return its output.
#![allow(dead_code, reason = "each test uses some of the helpers")]

#[path = "../../../../tests/support/cases.rs"]
pub mod cases;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;

/// Returns a command that runs the tool in a folder with these arguments.
pub fn command(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(crate::PROGRAM);
    command.current_dir(folder).args(args).stdin(Stdio::null());
    command
}

/// Returns a command that runs the tool in a folder with arguments separated by spaces.
pub fn tiletool(folder: &Path, args: &str) -> Command {
    command(folder, &args.split(' ').collect::<Vec<_>>())
}

/// Runs a command that must succeed. Returns its standard output.
#[track_caller]
pub fn run(folder: &Path, args: &str) -> String {
    printed(tiletool(folder, args))
}

/// Runs a command that must succeed. Returns the JSON that it prints.
#[track_caller]
pub fn json(folder: &Path, args: &str) -> Value {
    serde_json::from_str(&run(folder, args)).unwrap()
}

/// Runs a command that must fail with this exit code. Returns its standard error.
#[track_caller]
pub fn fails(folder: &Path, code: i32, args: &str) -> String {
    complaint(tiletool(folder, args), code)
}

/// Runs a command that must succeed. Returns its standard output.
#[track_caller]
pub fn printed(mut command: Command) -> String {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{command:?}: {}", errors(&output));
    String::from_utf8(output.stdout).unwrap()
}

/// Runs a command that must fail with this exit code. Returns its standard error.
#[track_caller]
pub fn complaint(mut command: Command, code: i32) -> String {
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(code), "{command:?}: {}", errors(&output));
    String::from_utf8(output.stderr).unwrap()
}

/// Returns the standard error of a command.
pub fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Starts a command, and kills it after this time unless it has ended before.
pub fn kill_after(mut command: Command, time: Duration) {
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    thread::sleep(time);
    let _ = child.kill();
    child.wait().unwrap();
}

/// Waits until the journal of the build of `p.tiles` in a folder has a whole entry. Returns false if
/// the build ended before.
///
/// An entry begins with its length. While it is being written, the file may be shorter than that,
/// and a build that is killed then leaves an entry that does not count.
pub fn wait_for_a_block(folder: &Path, child: &mut Child) -> bool {
    let journal = folder.join("p.tiles.partial/journal");
    while child.try_wait().unwrap().is_none() {
        let bytes = fs::read(&journal).unwrap_or_default();
        if let Some((length, entry)) = bytes.split_first_chunk::<4>()
            && entry.len() >= 4 + u32::from_le_bytes(*length) as usize
        {
            return true;
        }
        thread::sleep(Duration::from_micros(200));
    }
    false
}

/// Returns a command in which the shell runs `before`, such as `ulimit -n 15`, and then the tool.
pub fn after(before: &str, tool: &Command) -> Command {
    let mut command = Command::new("sh");
    command.args(["-c", &format!("{before} && exec \"$@\""), "sh"]);
    command
        .arg(tool.get_program())
        .args(tool.get_args())
        .stdin(Stdio::null());
    if let Some(folder) = tool.get_current_dir() {
        command.current_dir(folder);
    }
    command
}

/// Returns the path of the library of `tools/faults`, to be preloaded. It is in the folder of the
/// test program.
pub fn faults() -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let found = test.with_file_name("libfaults.so");
    assert!(found.exists(), "{}: it is built with this test", found.display());
    found
}

/// Runs a command. Kills it and fails the test if it takes more than a minute.
#[track_caller]
pub fn within_a_minute(mut command: Command) -> Output {
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let began = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if began.elapsed() > Duration::from_secs(60) {
            child.kill().unwrap();
            panic!("{command:?} hangs");
        }
        thread::sleep(Duration::from_millis(2));
    }
    child.wait_with_output().unwrap()
}

/// Returns the sorted names of the entries of a folder.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort_unstable();
    names
}

/// Returns the path of a file of the repository's test data.
pub fn data(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data");
    folder.join(name).to_str().unwrap().to_owned()
}
