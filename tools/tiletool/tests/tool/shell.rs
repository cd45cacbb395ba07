//! Scripts for shells, and manual pages.

use std::fs;

use crate::support::{fails, names, run};

#[test]
fn scripts_complete_all_commands_and_their_options() {
    let scratch = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = run(scratch.path(), &format!("completions {shell}"));
        for name in ["unconstrain", "checkpoint", "tile-vertices", "matrix"] {
            assert!(script.contains(name), "{shell}: {name}");
        }
    }
    let error = fails(scratch.path(), 2, "completions tcsh");
    assert!(error.contains("bash") && error.contains("zsh"), "{error}");
}

#[test]
fn each_command_has_a_manual_page() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    assert_eq!(run(folder, "man -o ."), "");
    let help = run(folder, "--help");
    let listed = help.lines().skip_while(|line| !line.starts_with("Usage:"));
    let commands: Vec<&str> = listed
        .take_while(|line| *line != "Options:")
        .filter_map(|line| line.strip_prefix("  ")?.split(' ').next())
        .collect();
    assert!(commands.len() >= 20, "{commands:?}");
    for command in commands {
        let page = fs::read_to_string(folder.join(format!("tiletool-{command}.1"))).unwrap();
        assert!(page.contains(".SH SYNOPSIS"), "{command}");
    }
    assert!(names(folder).contains(&"tiletool-query-path.1".to_owned()));
    let error = fails(folder, 1, "man -o nowhere");
    assert!(error.contains("nowhere"), "{error}");
}
