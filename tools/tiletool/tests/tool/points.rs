//! `tiletool insert`, `delete`, `move` and `set-z` from the command line: their results beside those
//! of builds, mistakes, and kills at any moment.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::time::Instant;

use crate::support::{data, fails, json, kill_after, run, tiletool};

/// Writes rows of x, y and z: each of `numbers` is a place on a grid of 60 columns.
fn write(path: &Path, numbers: impl Iterator<Item = u32>, z: impl Fn(u32) -> f64) {
    let mut text = String::from("x,y,z\n");
    for n in numbers {
        writeln!(text, "{},{},{}", n % 60, n / 60, z(n)).unwrap();
    }
    fs::write(path, text).unwrap();
}

fn height(n: u32) -> f64 {
    f64::from(n * 7 % 31)
}

/// Returns a folder with a file of half of a grid, and files of points.
fn grid() -> tempfile::TempDir {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    write(&folder.join("half.csv"), (0..3600).filter(|n| n % 2 == 0), height);
    write(&folder.join("other.csv"), (0..3600).filter(|n| n % 2 == 1), height);
    write(&folder.join("all.csv"), 0..3600, height);
    run(folder, "build half.csv -o half.tiles --tile-vertices 200");
    run(folder, "build all.csv -o all.tiles");
    scratch
}

fn digest(folder: &Path, file: &str) -> String {
    run(folder, &format!("digest --recompute {file}"))
}

#[test]
fn points_come_and_go_as_if_the_file_had_been_built_so() {
    let scratch = grid();
    let folder = scratch.path();
    let half = digest(folder, "half.tiles");
    let inserted = json(folder, "insert half.tiles other.csv --json");
    assert_eq!(
        (&inserted["inserted_points"], &inserted["vertices"]),
        (&1800.into(), &3600.into())
    );
    assert_eq!(digest(folder, "half.tiles"), digest(folder, "all.tiles"));
    run(folder, "verify --deep half.tiles --against half.csv other.csv");

    let deleted = run(folder, "delete half.tiles other.csv");
    assert!(deleted.contains("deleted 1 800 points"), "{deleted}");
    assert_eq!(digest(folder, "half.tiles"), half);
    let sources = json(folder, "inspect half.tiles --json")["sources"].clone();
    assert_eq!(sources.as_array().map(Vec::len), Some(2), "{sources}");

    // To the east and back, and up by one.
    let far: String = (0..3600)
        .step_by(2)
        .map(|n| format!("{},{},{},{}\n", n % 60, n / 60, n % 60 + 90, n / 60))
        .collect();
    let back = far.lines().map(|row| {
        let numbers: Vec<&str> = row.split(',').collect();
        format!("{},{},{},{}\n", numbers[2], numbers[3], numbers[0], numbers[1])
    });
    fs::write(folder.join("back.csv"), back.collect::<String>()).unwrap();
    fs::write(folder.join("far.csv"), far).unwrap();
    run(folder, "move half.tiles far.csv");
    assert_eq!(json(folder, "inspect half.tiles --json")["bounds"]["min_x"], 90.0);
    run(folder, "move half.tiles back.csv");
    assert_eq!(digest(folder, "half.tiles"), half);
    write(&folder.join("up.csv"), (0..3600).filter(|n| n % 2 == 0), |n| {
        height(n) + 1.0
    });
    run(folder, "set-z half.tiles up.csv");
    run(folder, "build up.csv -o up.tiles");
    assert_eq!(digest(folder, "half.tiles"), digest(folder, "up.tiles"));
    run(folder, "verify --deep half.tiles --against up.csv");

    run(folder, "compact half.tiles");
    run(folder, "verify --deep half.tiles --against up.csv");
    assert_eq!(digest(folder, "half.tiles"), digest(folder, "up.tiles"));
}

#[test]
fn files_without_some_of_their_first_tiles_are_read_by_all_commands() {
    let scratch = grid();
    let folder = scratch.path();
    write(
        &folder.join("west.csv"),
        (0..3600).filter(|n| n % 2 == 0 && n % 60 < 40),
        height,
    );
    write(
        &folder.join("east.csv"),
        (0..3600).filter(|n| n % 2 == 0 && n % 60 >= 40),
        height,
    );
    let tiles = json(folder, "inspect half.tiles --json")["tiles"].as_u64();
    run(folder, "delete half.tiles west.csv");
    assert!(json(folder, "inspect half.tiles --json")["tiles"].as_u64() < tiles);
    run(folder, "build east.csv -o east.tiles");
    run(folder, "overviews half.tiles");
    run(folder, "inspect half.tiles --tiles --plot map.png");
    for command in [
        "export FILE.tiles -o FILE.obj",
        "verify --deep FILE.tiles --against east.csv",
        "bench read FILE.tiles",
    ] {
        run(folder, &command.replace("FILE", "half"));
    }
    let z = run(folder, "query z half.tiles --at 50.5,20.25");
    assert_eq!(z, run(folder, "query z east.tiles --at 50.5,20.25"));
    run(folder, "compact half.tiles");
    assert_eq!(digest(folder, "half.tiles"), digest(folder, "east.tiles"));
}

#[test]
fn a_mistake_names_it_and_leaves_the_file_unchanged() {
    let scratch = grid();
    let folder = scratch.path();
    let before = fs::read(folder.join("half.tiles")).unwrap();
    fs::write(folder.join("flat.csv"), "x,y\n5.5,5.5\n").unwrap();
    fs::write(folder.join("three.csv"), "1,2,3\n").unwrap();
    fs::write(folder.join("empty.csv"), "").unwrap();
    for (args, says) in [
        ("insert half.tiles", "POINTS"),
        ("insert half.tiles none.csv", "none.csv"),
        ("insert half.tiles flat.csv", "z"),
        ("insert none.tiles other.csv", "none.tiles"),
        ("insert other.csv other.csv", "it is no tile file"),
        (
            "delete half.tiles other.csv",
            "there is no point at (1, 0); 1800 such positions",
        ),
        ("delete half.tiles other.csv", "half.tiles was not changed"),
        ("move half.tiles three.csv", "three.csv"),
        ("set-z half.tiles flat.csv", "z"),
        ("set-z half.tiles other.csv", "there is no point"),
    ] {
        let code = if says == "POINTS" { 2 } else { 1 };
        let error = fails(folder, code, args);
        assert!(error.contains(says), "{args}: {error}");
    }
    // Changes that do not fit into memory go to disk.
    let spilled = json(folder, "delete half.tiles half.csv --memory 100KB --dry-run --json");
    assert_eq!(spilled["deleted_points"], 1800);
    assert!(fs::read(folder.join("half.tiles")).unwrap() == before);
    let nothing = run(folder, "insert half.tiles empty.csv");
    assert!(nothing.contains("nothing to change"), "{nothing}");
    let skipped = json(folder, "delete half.tiles all.csv --skip-missing --dry-run --json");
    let expected = (&1800.into(), &1800.into(), &true.into());
    assert_eq!(
        (
            &skipped["deleted_points"],
            &skipped["skipped_points"],
            &skipped["dry_run"]
        ),
        expected
    );
    assert_eq!(json(folder, "inspect half.tiles --json")["vertices"], 1800);
}

#[test]
fn a_change_killed_at_any_moment_is_made_completely_or_not_at_all() {
    let scratch = grid();
    let folder = scratch.path();
    let (old, new) = (digest(folder, "half.tiles"), digest(folder, "all.tiles"));
    fs::copy(folder.join("half.tiles"), folder.join("start.tiles")).unwrap();
    let began = Instant::now();
    run(folder, "insert half.tiles other.csv");
    let duration = began.elapsed();
    let mut seen = [0; 2];
    for kill in 0..20 {
        fs::copy(folder.join("start.tiles"), folder.join("half.tiles")).unwrap();
        // A second kill follows. What the first one left must not disturb it.
        for moment in [f64::from(kill) / 17.0, 0.5] {
            kill_after(
                tiletool(folder, "insert half.tiles other.csv"),
                duration.mul_f64(moment),
            );
            let found = digest(folder, "half.tiles");
            assert!(found == old || found == new, "{found}");
            seen[usize::from(found == new)] += 1;
        }
        run(folder, "verify --deep half.tiles");
    }
    assert!(seen[0] > 0, "{seen:?}");
}

#[test]
fn a_survey_takes_the_points_that_were_left_out() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let survey = data("las/32-1-472-150-76.laz");
    run(
        folder,
        &format!("build {survey} -o half.tiles --every 2 --tile-vertices 2000"),
    );
    run(folder, &format!("build {survey} -o whole.tiles"));
    // Half of them are there already.
    let inserted = json(folder, &format!("insert half.tiles {survey} --json"));
    let [new, known] = ["inserted_points", "duplicate_points"].map(|key| inserted[key].as_u64().unwrap());
    assert!(new > 0 && known > 0, "{inserted}");
    // Where two points share a place, a build keeps the first of the file, and here the one that was
    // there.
    let triangles = |file: &str| digest(folder, file).lines().next().map(str::to_owned);
    assert_eq!(triangles("half.tiles"), triangles("whole.tiles"));
    run(folder, "verify --deep half.tiles");
}

#[test]
fn sites_come_and_go_and_queries_find_them() {
    let scratch = grid();
    let folder = scratch.path();
    let plain = digest(folder, "all.tiles");
    fs::write(
        folder.join("shops.csv"),
        "10.5,10.25,baker\n30,30,grocer\n10.5,10.25,butcher\n",
    )
    .unwrap();
    let inserted = json(folder, "insert all.tiles --sites shops.csv --json");
    assert_eq!(
        (&inserted["inserted_sites"], &inserted["added_vertices"]),
        (&3.into(), &1.into())
    );
    run(folder, "verify --deep all.tiles --against all.csv --sites shops.csv");
    let near = run(folder, "query knn all.tiles --at 10,10 -k 2 --csv");
    assert!(near.contains("baker") && near.contains("butcher"), "{near}");
    fs::write(folder.join("closed.csv"), "10.5,10.25\n").unwrap();
    let text = run(folder, "delete all.tiles --sites closed.csv");
    assert!(text.contains("deleted 2 sites"), "{text}");
    let error = fails(folder, 1, "delete all.tiles --sites closed.csv");
    assert!(error.contains("no site at (10.5, 10.25)"), "{error}");
    let text = run(folder, "delete all.tiles --sites shops.csv --skip-missing");
    assert!(text.contains("2 sites left out"), "{text}");
    assert_eq!(digest(folder, "all.tiles"), plain);
    assert!(fails(folder, 2, "insert all.tiles").contains("POINTS"));
}
