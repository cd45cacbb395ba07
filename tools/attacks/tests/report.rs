//! The output of the program for rounds that fail.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::process::Command;

/// The tool always fails: the totals count each round, each message says how to repeat it, and the
/// exit code is 1.
#[test]
fn a_failed_round_prints_the_command_that_repeats_it() {
    let folder = tempfile::tempdir().unwrap();
    let tool = folder.path().join("tool");
    fs::write(&tool, "#!/bin/sh\necho 'error: it is broken' >&2\nexit 1\n").unwrap();
    fs::set_permissions(&tool, fs::Permissions::from_mode(0o755)).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_attacks"));
    let output = command
        .args(["pslg", "--seed", "7", "--rounds", "2", "--tool"])
        .arg(&tool)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(String::from_utf8(output.stdout).unwrap(), "pslg: 2 rounds, 2 failed\n");
    let errors = String::from_utf8(output.stderr).unwrap();
    for part in [
        "error: it is broken",
        "attacks pslg --seed 7 --rounds 1",
        "attacks pslg --seed 8 --rounds 1",
    ] {
        assert!(errors.contains(part), "{errors}");
    }
}
