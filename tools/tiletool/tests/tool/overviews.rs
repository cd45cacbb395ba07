//! `tiletool overviews` from the command line, and what the other commands say of overviews.

use std::fs;
use std::path::Path;
use std::time::Instant;

use crate::support::{errors, fails, json, kill_after, names, run, tiletool};

/// Returns a folder with a file of 1,600 points with z, without overviews.
fn hill() -> tempfile::TempDir {
    let scratch = tempfile::tempdir().unwrap();
    let point = |i: i32| {
        let (x, y) = (f64::from(i % 40), f64::from(i / 40) + f64::from(i % 7) / 16.0);
        format!("{x},{y},{}\n", (x / 5.0).sin() + (y / 7.0).cos())
    };
    fs::write(
        scratch.path().join("hill.csv"),
        (0..1600).map(point).collect::<String>(),
    )
    .unwrap();
    fs::write(scratch.path().join("wall.csv"), "3,3,30,21\n").unwrap();
    run(
        scratch.path(),
        "build hill.csv --columns 1,2,3 -o hill.tiles --tile-vertices 100 --quiet",
    );
    scratch
}

fn count(folder: &Path, file: &str) -> [usize; 2] {
    let found = json(folder, &format!("inspect {file} --json"));
    let list = found["overview_list"].as_array().unwrap();
    let stale = list.iter().filter(|row| row["is_stale"] == true).count();
    [list.len() - stale, stale]
}

#[test]
fn overviews_are_made_shown_proven_and_removed() {
    let scratch = hill();
    let folder = scratch.path();
    assert_eq!(count(folder, "hill.tiles"), [0, 0]);
    let text = run(folder, "overviews hill.tiles");
    assert!(
        text.starts_with("hill.tiles: 2 overviews\n") && text.contains("rms"),
        "{text}"
    );
    assert_eq!(names(folder), ["hill.csv", "hill.tiles", "wall.csv"]);
    let found = json(folder, "inspect hill.tiles --json");
    let rows = found["overview_list"].as_array().unwrap();
    assert_eq!((rows.len(), rows[1]["tiles"].as_u64()), (2, Some(1)));
    assert!(rows[0]["rms_error"].as_f64() < rows[1]["rms_error"].as_f64());
    let bytes: u64 = rows.iter().map(|row| row["bytes"].as_u64().unwrap()).sum();
    assert_eq!(found["overview_bytes"].as_u64(), Some(bytes));
    assert!(run(folder, "inspect hill.tiles").contains("overviews"));
    for verify in ["verify", "verify --deep"] {
        let verified = json(folder, &format!("{verify} hill.tiles --json"));
        assert_eq!(verified["overviews"], 2);
    }
    assert!(run(folder, "verify hill.tiles").contains("2 overviews"));
    let again = json(folder, "overviews hill.tiles --json");
    assert_eq!((&again["is_new"], &again["bytes_appended"]), (&false.into(), &0.into()));
    let forced = json(folder, "overviews hill.tiles --force --json");
    assert_eq!(forced["is_new"], true);
    assert!(forced["bytes_appended"].as_u64() >= Some(bytes));
    assert!(run(folder, "overviews hill.tiles --remove").contains("2 overviews removed"));
    assert_eq!(count(folder, "hill.tiles"), [0, 0]);
    let compacted = json(folder, "compact hill.tiles --json");
    assert!(compacted["bytes_after"].as_u64() < compacted["bytes_before"].as_u64());
}

#[test]
fn a_build_with_overviews_has_them_and_the_same_triangles() {
    let scratch = hill();
    let folder = scratch.path();
    let build = "build hill.csv --columns 1,2,3 -o other.tiles --tile-vertices 100 --overviews";
    let text = run(folder, build);
    assert!(text.contains("other.tiles: 2 overviews"), "{text}");
    let built = json(folder, &format!("{build} --force --json"));
    assert_eq!(built["overview_list"].as_array().unwrap().len(), 2);
    assert_eq!(count(folder, "other.tiles"), [2, 0]);
    assert_eq!(run(folder, "digest other.tiles"), run(folder, "digest hill.tiles"));
}

#[test]
fn constrain_makes_overviews_stale_and_the_tool_says_how_to_renew_them() {
    let scratch = hill();
    let folder = scratch.path();
    run(folder, "overviews hill.tiles --quiet");
    let done = tiletool(folder, "constrain hill.tiles --walls wall.csv")
        .output()
        .unwrap();
    let noted = errors(&done);
    assert!(
        done.status.success() && noted.contains("`tiletool overviews hill.tiles`"),
        "{noted}"
    );
    assert_eq!(count(folder, "hill.tiles"), [0, 2]);
    let text = run(folder, "inspect hill.tiles");
    assert!(
        text.contains("stale, renew with `tiletool overviews hill.tiles`"),
        "{text}"
    );
    let verified = json(folder, "verify --deep hill.tiles --json");
    assert_eq!(verified["overviews"], 0);
    run(folder, "overviews hill.tiles --quiet");
    assert_eq!(count(folder, "hill.tiles"), [2, 0]);
    run(folder, "compact hill.tiles");
    assert_eq!(count(folder, "hill.tiles"), [2, 0]);
    run(folder, "verify --deep hill.tiles");
}

#[test]
fn mistakes_are_errors() {
    let scratch = hill();
    let folder = scratch.path();
    for (args, says) in [
        ("overviews nothing.tiles", "nothing.tiles"),
        ("overviews hill.csv", "it is no tile file"),
        ("overviews hill.tiles --memory 10KB", "memory"),
    ] {
        let error = fails(folder, 1, args);
        assert!(error.contains(says), "{args}: {error}");
    }
    fails(folder, 2, "overviews hill.tiles --remove --force");
    assert_eq!(names(folder), ["hill.csv", "hill.tiles", "wall.csv"]);
}

#[test]
fn a_kill_at_any_moment_leaves_a_file_with_all_overviews_or_none() {
    let scratch = hill();
    let folder = scratch.path();
    let before = fs::read(folder.join("hill.tiles")).unwrap();
    let began = Instant::now();
    run(folder, "overviews hill.tiles --quiet");
    let took = began.elapsed();
    let mut seen = [0; 2];
    for kill in 0..12 {
        fs::write(folder.join("hill.tiles"), &before).unwrap();
        for moment in [f64::from(kill) / 10.0, 0.5] {
            kill_after(tiletool(folder, "overviews hill.tiles --quiet"), took.mul_f64(moment));
            let verified = json(folder, "verify --deep hill.tiles --json");
            let found = verified["overviews"].as_u64().unwrap();
            assert!(found == 0 || found == 2, "killed after {moment} of the time: {found}");
            seen[usize::from(found == 2)] += 1;
        }
        // What killed processes left is no obstacle.
        run(folder, "overviews hill.tiles --quiet");
        assert_eq!(names(folder), ["hill.csv", "hill.tiles", "wall.csv"]);
    }
    assert!(seen[0] > 0, "{seen:?}");
}
