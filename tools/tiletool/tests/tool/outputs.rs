//! Outputs of commands: only regular files are replaced, links are followed, and files that killed
//! runs left are removed.
//!
//! `-o /dev/null --force` once replaced the device if root ran it, and likewise pipes and links.
//! `constrain` followed links, which `build` replaced. Killed runs left `.compact-…partial` and
//! `….ply.…partial` for ever, 1.1 GB in 15 rounds.

use std::fs::{self, File};
use std::os::unix::fs::{FileTypeExt, symlink};
use std::os::unix::net::UnixListener;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use crate::support::{complaint, fails, kill_after, names, run, tiletool, within_a_minute};

fn prepare(folder: &Path) {
    let points = (0..400).map(|i| format!("{},{}\n", i % 20, f64::from(i / 20) + f64::from(i % 7) / 16.0));
    fs::write(folder.join("p.csv"), points.collect::<String>()).unwrap();
    fs::write(folder.join("w.csv"), "3.5,3.5,4.5,3.6\n").unwrap();
    run(folder, "build p.csv -o t.tiles --quiet --tile-vertices 100");
}

/// Commands that write a file whose name has this suffix.
const WRITERS: &[(&str, &str)] = &[
    ("build p.csv --force --quiet -o", "tiles"),
    ("compact t.tiles --force -o", "tiles"),
    ("export t.tiles --format ply -o", "ply"),
    #[cfg(feature = "pmtiles")]
    ("export t.tiles --format pmtiles --grid native --zooms 0 -o", "pmtiles"),
    ("inspect t.tiles --plot", "svg"),
    ("query knn t.tiles --at 3,3 --plot", "svg"),
    ("query path t.tiles --from 3,3 --to 9,9 --plot", "svg"),
    ("generate uniform -n 10 -o", "f64"),
];

#[test]
fn folders_sockets_pipes_and_devices_are_never_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    prepare(path);
    let made = |program: &str, args: &[&str]| {
        let status = Command::new(program)
            .current_dir(path)
            .args(args)
            .stderr(std::process::Stdio::null())
            .status();
        status.is_ok_and(|status| status.success())
    };
    fs::create_dir(path.join("folder")).unwrap();
    let _socket = UnixListener::bind(path.join("socket")).unwrap();
    assert!(made("mkfifo", &["pipe"]));
    // Only root can create a device.
    let has_device = made("mknod", &["device", "c", "1", "3"]);
    let others = ["folder", "socket", "pipe"]
        .into_iter()
        .chain(has_device.then_some("device"));
    for other in others {
        let before = fs::symlink_metadata(path.join(other)).unwrap().file_type();
        for (args, suffix) in WRITERS {
            // An export and raw points are written directly to pipes and devices.
            let is_stream = args.starts_with("export") || args.starts_with("generate");
            if is_stream && (before.is_fifo() || before.is_char_device()) {
                continue;
            }
            let link = path.join(format!("link.{suffix}"));
            symlink(other, &link).unwrap();
            let direct = if *suffix == "svg" { None } else { Some(other.to_owned()) };
            for name in direct.into_iter().chain([format!("link.{suffix}")]) {
                let output = within_a_minute(tiletool(path, &format!("{args} {name}")));
                let errors = crate::support::errors(&output);
                assert_eq!(output.status.code(), Some(1), "{args} {name}: {errors}");
                assert!(
                    errors.starts_with("error: ") && errors.contains(&name),
                    "{args} {name}: {errors}"
                );
                assert!(errors.contains(" it is a "), "{args} {name}: {errors}");
            }
            fs::remove_file(link).unwrap();
            assert_eq!(
                fs::symlink_metadata(path.join(other)).unwrap().file_type(),
                before,
                "{args} {other}"
            );
        }
        for args in [format!("constrain {other} --walls w.csv"), format!("compact {other}")] {
            let errors = complaint(tiletool(path, &args), 1);
            assert!(errors.contains(" it is a "), "{args}: {errors}");
        }
    }
}

#[test]
fn all_commands_write_through_links_and_keep_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    prepare(path);
    fs::create_dir(path.join("far")).unwrap();
    for (args, suffix) in WRITERS {
        let [link, target] = [format!("link.{suffix}"), format!("far/target.{suffix}")].map(|name| path.join(name));
        symlink(path.join(format!("middle.{suffix}")), &link).unwrap();
        symlink(format!("far/target.{suffix}"), path.join(format!("middle.{suffix}"))).unwrap();
        // At first the target of the links does not exist, then it is a file.
        for before in ["nothing", "a file"] {
            if before == "a file" {
                fs::write(&target, "what was there before").unwrap();
            }
            run(path, &format!("{args} link.{suffix}"));
            assert!(fs::symlink_metadata(&link).unwrap().is_symlink(), "{args}: {before}");
            assert!(fs::symlink_metadata(&target).unwrap().is_file(), "{args}: {before}");
            assert_ne!(fs::read(&target).unwrap(), b"what was there before", "{args}");
        }
        assert_eq!(names(&path.join("far")), [format!("target.{suffix}")], "{args}");
        fs::remove_file(link).unwrap();
        fs::remove_file(target).unwrap();
        fs::remove_file(path.join(format!("middle.{suffix}"))).unwrap();
    }
    symlink("t.tiles", path.join("same.tiles")).unwrap();
    run(path, "constrain same.tiles --walls w.csv --quiet");
    run(path, "compact same.tiles");
    assert!(fs::symlink_metadata(path.join("same.tiles")).unwrap().is_symlink());
    run(path, "verify --deep t.tiles");
    symlink("round.tiles", path.join("ring.tiles")).unwrap();
    symlink("ring.tiles", path.join("round.tiles")).unwrap();
    let errors = fails(path, 1, "build p.csv -o ring.tiles --force");
    assert!(
        errors.contains("ring.tiles") && errors.contains("symbolic links"),
        "{errors}"
    );
}

#[test]
fn a_missing_folder_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    prepare(path);
    symlink("gone/away", path.join("link")).unwrap();
    let before = names(path);
    for (args, suffix) in WRITERS {
        for (output, missing) in [
            (format!("missing/out.{suffix}"), "missing"),
            (format!("missing/deep/out.{suffix}"), "missing/deep"),
        ] {
            let errors = fails(path, 1, &format!("{args} {output}"));
            assert!(
                errors.contains(&format!("the folder {missing} does not exist; create it first")),
                "{args}: {errors}"
            );
            assert!(
                errors.contains(&output) && !errors.contains(".partial"),
                "{args}: {errors}"
            );
        }
        assert_eq!(names(path), before, "{args}");
    }
    // A build finds out before it computes, not when the map is drawn.
    let errors = fails(path, 1, "build p.csv -o new.tiles --plot missing/map.svg");
    assert!(
        errors.contains("the folder missing does not exist; create it first"),
        "{errors}"
    );
    assert_eq!(names(path), before);
    let errors = fails(path, 1, "export t.tiles --format ply -o link");
    assert!(errors.contains("gone does not exist; create it first"), "{errors}");
}

#[test]
fn the_next_run_removes_the_files_of_a_killed_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    prepare(path);
    for (args, suffix) in WRITERS {
        let name = format!("out.{suffix}");
        let partial = match args.starts_with("build") {
            true => path.join(format!("{name}.partial")),
            false => path.join(format!(".{name}.partial")),
        };
        match args.starts_with("build") {
            true => {
                fs::create_dir(&partial).unwrap();
                // A build with deferred lines is compacted in its work folder.
                for left in ["lock", "tiles", ".tiles.partial", "run-3"] {
                    fs::write(partial.join(left), "left").unwrap();
                }
            }
            false => fs::write(&partial, "left, and longer than what comes".repeat(10_000)).unwrap(),
        }
        run(path, &format!("{args} {name}"));
        assert!(!partial.exists(), "{args}");
        assert!(
            fs::metadata(path.join(&name)).unwrap().len() < 300_000,
            "{args}: the file ends with old bytes"
        );
        fs::remove_file(path.join(&name)).unwrap();
    }
    // A run that is really killed.
    kill_after(
        tiletool(path, "generate uniform -n 1G -o out.f64"),
        Duration::from_millis(300),
    );
    assert!(path.join(".out.f64.partial").exists() && !path.join("out.f64").exists());
    run(path, "generate uniform -n 10 -o out.f64");
    assert_eq!(names(path), ["out.f64", "p.csv", "t.tiles", "w.csv"]);
}

#[test]
fn two_runs_do_not_write_the_same_output_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    prepare(path);
    let other = File::create(path.join(".out.ply.partial")).unwrap();
    other.lock().unwrap();
    let errors = fails(path, 1, "export t.tiles -o out.ply");
    assert!(
        errors.contains("another process is writing it") && errors.contains(".out.ply.partial"),
        "{errors}"
    );
    assert!(!path.join("out.ply").exists());
    drop(other);
    run(path, "export t.tiles -o out.ply");
    assert!(!path.join(".out.ply.partial").exists());
}

#[test]
fn a_build_removes_the_spilled_files_of_a_killed_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    run(path, "generate uniform -n 400k -o p.f64");
    fs::create_dir(path.join("tmp")).unwrap();
    let spills = "build p.f64 -o out.tiles --memory 2MiB --tile-vertices 1000 --tmp tmp";
    let partial = path.join("out.tiles.partial/spill");
    let mut milliseconds = 20;
    while !partial.exists() {
        let _ = fs::remove_file(path.join("out.tiles"));
        kill_after(tiletool(path, spills), Duration::from_millis(milliseconds));
        milliseconds = (milliseconds + 20) % 500;
    }
    assert_eq!(names(&path.join("tmp")).len(), 1);
    let _ = fs::remove_file(path.join("out.tiles"));
    // If all points had arrived, the killed build could be resumed, and its work is not removed by
    // accident.
    run(path, "build p.f64 -o out.tiles --quiet --force");
    assert!(names(&path.join("tmp")).is_empty());
    assert_eq!(names(path), ["out.tiles", "p.f64", "tmp"]);
}
