//! The program refuses what it cannot use.

use std::process::Command;

#[test]
fn a_program_that_cannot_be_run_is_an_error_and_names_it() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_service-load"));
    let done = command
        .args(["--tiletool", "no/such/program", "--seconds", "1"])
        .output()
        .unwrap();
    assert_eq!(done.status.code(), Some(1));
    let printed = String::from_utf8(done.stderr).unwrap();
    assert!(printed.contains("no/such/program"), "{printed}");
}
