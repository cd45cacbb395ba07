//! What tests of the tool share.

use std::path::Path;
use std::process::{Command, Output};

/// The tool in a folder, with these arguments.
pub fn tiletool(folder: &Path, args: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tiletool"));
    command.current_dir(folder).args(args.split(' '));
    command
}

/// Runs a command that must succeed, and gives what it prints.
pub fn run(folder: &Path, args: &str) -> String {
    let output = tiletool(folder, args).output().unwrap();
    assert!(output.status.success(), "{args}: {}", errors(&output));
    String::from_utf8(output.stdout).unwrap()
}

/// What a command complains of.
pub fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}
