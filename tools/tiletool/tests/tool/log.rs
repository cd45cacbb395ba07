//! The log of a file, as the tool shows it and carries it out. Services write it, through the library.

use std::path::Path;

use delaunay_tiles::input::PointBatch;
use delaunay_tiles::{Durability, EditOptions, Editor, Point};

use crate::support::{errors, json, run, tiletool};

/// Inserts points into the log of a file, each in a transaction of its own.
pub fn log_points(file: &Path, points: &[Point]) {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .unwrap();
    runtime.block_on(async {
        let options = EditOptions::default().durability(Durability::Log);
        let editor = Editor::open(file, options).await.unwrap();
        for &point in points {
            let mut transaction = editor.begin().await.unwrap();
            let one = PointBatch {
                records: vec![0],
                points: vec![point],
                z: vec![],
            };
            transaction.insert(&one).unwrap();
            transaction.commit().await.unwrap();
        }
    });
}

#[test]
fn transactions_in_the_log_are_told_until_a_checkpoint_makes_them() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let points = [(0, 0), (9, 0), (0, 9), (9, 8)].map(|(x, y)| format!("{x},{y}\n"));
    std::fs::write(folder.join("points.csv"), points.concat()).unwrap();
    run(folder, "build points.csv -o a.tiles");
    assert_eq!(json(folder, "inspect a.tiles --json")["pending_transactions"], 0);
    let none = run(folder, "checkpoint a.tiles");
    assert!(none.contains("its log has no transactions"), "{none}");

    log_points(&folder.join("a.tiles"), &[Point::new(4.0, 3.0), Point::new(5.0, 5.0)]);
    let before = json(folder, "inspect a.tiles --json");
    assert_eq!(
        (&before["pending_transactions"], &before["vertices"]),
        (&2.into(), &4.into())
    );
    let told = errors(&tiletool(folder, "inspect a.tiles").output().unwrap());
    assert!(
        told.contains("2 transactions of the log of a.tiles are not in it yet: tiletool checkpoint a.tiles"),
        "{told}"
    );

    let made = run(folder, "checkpoint a.tiles");
    assert!(made.contains("made 2 transactions; the file has 6 vertices"), "{made}");
    let after = json(folder, "inspect a.tiles --json");
    assert_eq!(
        (&after["pending_transactions"], &after["vertices"]),
        (&0.into(), &6.into())
    );
    assert!(!folder.join("a.tiles.log").exists());
    run(folder, "verify --deep a.tiles");
}
