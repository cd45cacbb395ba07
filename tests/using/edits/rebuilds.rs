//! The promise: an edit that builds all tiles anew looks like any other edit from outside.

use std::fs;
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};

use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::{PointBatch, SiteId};
use delaunay_tiles::store::LineKind;
use delaunay_tiles::{BuildOptions, EditError, EditOptions, Editor};
use distributions::Kind;

use crate::edits::scene::{Line, Scene, checked, key};
use crate::edits::{ENOUGH, batch, edited};
use crate::support::{Scratch, built, points_of, runtime};

fn inode(scratch: &Scratch) -> u64 {
    fs::metadata(&scratch.path).unwrap().ino()
}

#[test]
fn many_changes_build_the_file_anew_and_few_do_not() {
    runtime().block_on(async {
        let points = points_of(Kind::Uniform, 220_000, 1);
        let (first, second) = points.split_at(150_000);
        let scratch = built(first, BuildOptions::default().tile_vertices(2000)).await.0;
        let (before, tiles) = (inode(&scratch), scratch.open().await.metadata().tiles);
        let corner: Vec<Point> = second.iter().copied().filter(|p| p.x < 0.05 && p.y < 0.05).collect();
        let summary = edited(&scratch, ENOUGH, |editor| editor.insert(&batch(&corner)).unwrap());
        assert!(summary.await.unwrap().tiles_written < u64::from(tiles) / 8);
        assert_eq!(inode(&scratch), before);
        let summary = edited(&scratch, ENOUGH, |editor| editor.insert(&batch(second)).unwrap());
        let summary = summary.await.unwrap();
        assert_ne!(inode(&scratch), before);
        let counts = [summary.points.inserted, summary.points.duplicates, summary.vertices];
        assert_eq!(
            counts,
            [second.len() - corner.len(), corner.len(), points.len()].map(|count| count as u64)
        );
        assert!(summary.tile_reads <= u64::from(tiles) + 10);
        let whole = built(&points, BuildOptions::default()).await.0;
        assert_eq!(checked(&scratch).await, checked(&whole).await);
    });
}

#[test]
fn a_file_that_is_built_anew_keeps_its_readers_its_name_and_its_permissions() {
    runtime().block_on(async {
        let points = points_of(Kind::Kuzmin, 900, 2);
        let scratch = built(&points, BuildOptions::default().tile_vertices(60)).await.0;
        let real = scratch.path.with_file_name("real.tiles");
        fs::rename(&scratch.path, &real).unwrap();
        symlink(&real, &scratch.path).unwrap();
        fs::set_permissions(&real, fs::Permissions::from_mode(0o640)).unwrap();
        let before = checked(&scratch).await;
        let old = scratch.open().await;
        let mut following = scratch.open().await;
        let dry = edited(&scratch, ENOUGH, |editor| {
            editor.prefer_build(true);
            editor.dry_run(true);
            editor.delete(&points[..100]).unwrap();
        });
        let dry = dry.await.unwrap();
        assert_eq!((dry.points.deleted, dry.vertices), (100, 800));
        assert_eq!(checked(&scratch).await, before);

        let mut editor = Editor::open(&scratch.path, EditOptions::default().memory(ENOUGH))
            .await
            .unwrap()
            .begin()
            .await
            .unwrap();
        assert!(matches!(
            Editor::open(&scratch.path, EditOptions::default().memory(ENOUGH)).await,
            Err(EditError::Busy(_))
        ));
        editor.prefer_build(true);
        editor.delete(&points[..100]).unwrap();
        assert_eq!(editor.commit().await.unwrap().vertices, dry.vertices);
        assert!(fs::symlink_metadata(&scratch.path).unwrap().is_symlink());
        assert_eq!(fs::metadata(&real).unwrap().permissions().mode() & 0o777, 0o640);
        let folder = fs::read_dir(real.parent().unwrap()).unwrap();
        assert_eq!(folder.count(), 2, "something is left");
        assert_eq!(old.recompute_digest().await.unwrap(), before);
        assert!(following.refresh().await.unwrap());
        assert_eq!(following.metadata().vertices, 800);
        assert!(following.generation() > old.generation());
        assert_eq!(following.metadata().next_record, old.metadata().next_record);
        // The next edit is one in place, with the same generations.
        edited(&scratch, ENOUGH, |editor| editor.insert(&batch(&points[..1])).unwrap())
            .await
            .unwrap();
        assert!(following.refresh().await.unwrap());
        assert_eq!(following.metadata().vertices, 801);
    });
}

#[test]
fn where_no_build_can_begin_a_file_with_triangles_is_edited_in_place() {
    runtime().block_on(async {
        let points = points_of(Kind::Uniform, 500, 3);
        for (points, has_triangles) in [(&points[..], true), (&points[..2], false)] {
            let scratch = built(points, BuildOptions::default().tile_vertices(60)).await.0;
            let before = checked(&scratch).await;
            let mut blocked = scratch.path.clone().into_os_string();
            blocked.push(".partial");
            fs::create_dir(&blocked).unwrap();
            fs::write(std::path::Path::new(&blocked).join("diary.txt"), "mine").unwrap();
            let done = edited(&scratch, ENOUGH, |editor| {
                editor.prefer_build(true);
                editor.insert(&batch(&[Point::new(3.0, 3.0)])).unwrap();
            });
            match done.await {
                Ok(summary) => assert_eq!((summary.vertices, has_triangles), (501, true)),
                Err(error) => {
                    assert!(!has_triangles && error.to_string().contains(".partial"), "{error}");
                    assert_eq!(checked(&scratch).await, before);
                }
            }
            assert!(std::path::Path::new(&blocked).join("diary.txt").exists());
        }
    });
}

#[test]
fn the_first_points_of_an_empty_file_decide_whether_it_has_z() {
    runtime().block_on(async {
        let points = points_of(Kind::Uniform, 50, 4);
        for z in [vec![], (0..50).map(f64::from).collect::<Vec<f64>>()] {
            let scratch = built(&[], BuildOptions::default()).await.0;
            let has_z = !z.is_empty();
            let summary = edited(&scratch, ENOUGH, |editor| {
                editor.insert(&PointBatch { z, ..batch(&points) }).unwrap()
            });
            assert_eq!(summary.await.unwrap().points.inserted, 50);
            assert_eq!(scratch.open().await.metadata().has_z, has_z);
            checked(&scratch).await;
        }
    });
}

#[test]
fn tiles_do_not_grow_from_edit_to_edit() {
    runtime().block_on(async {
        let points = points_of(Kind::Uniform, 4000, 5);
        let scratch = built(&points[..400], BuildOptions::default().tile_vertices(50)).await.0;
        for chunk in points[400..].chunks(100) {
            edited(&scratch, ENOUGH, |editor| editor.insert(&batch(chunk)).unwrap())
                .await
                .unwrap();
        }
        let reader = scratch.open().await;
        assert_eq!(reader.metadata().tile_vertices, 50);
        let tiles = reader.directory().await.unwrap();
        let largest = tiles.tiles.iter().map(|tile| tile.vertices).max();
        assert!(largest <= Some(75), "{largest:?}");
    });
}

#[test]
fn transactions_of_an_editor_follow_each_other_and_keep_the_lock() {
    runtime().block_on(async {
        let points = points_of(Kind::Uniform, 700, 6);
        let scratch = built(&points[..500], BuildOptions::default().tile_vertices(60)).await.0;
        let editor = Editor::open(&scratch.path, EditOptions::default().memory(ENOUGH))
            .await
            .unwrap();
        let is_busy = async || {
            matches!(
                Editor::open(&scratch.path, EditOptions::default().memory(ENOUGH)).await,
                Err(EditError::Busy(_))
            )
        };
        let mut reader = scratch.open().await;
        let mut vertices = 500;
        for (number, chunk) in points[500..].chunks(20).enumerate() {
            // Every other one builds the file anew, so that it is another file.
            let mut transaction = editor.begin().await.unwrap();
            transaction.prefer_build(number % 2 == 0);
            transaction.insert(&batch(chunk)).unwrap();
            assert!(is_busy().await);
            if number % 3 == 2 {
                drop(transaction);
            } else {
                transaction.commit().await.unwrap();
                vertices += chunk.len() as u64;
            }
            assert!(is_busy().await);
            reader.refresh().await.unwrap();
            assert_eq!(reader.metadata().vertices, vertices);
            assert_eq!(checked(&scratch).await.vertices.count, vertices);
        }
        // A transaction that fails leaves the editor as it was.
        let mut wrong = editor.begin().await.unwrap();
        wrong.delete(&[Point::new(7.0, 7.0)]).unwrap();
        assert!(matches!(wrong.commit().await, Err(EditError::NoPoint { .. })));
        // The next one waits for the end of the one before, which outlives its editor.
        let first = editor.begin().await.unwrap();
        let waiting = tokio::spawn(async move { editor.begin().await.map(|_| ()) });
        tokio::task::yield_now().await;
        assert!(!waiting.is_finished());
        drop(first);
        waiting.await.unwrap().unwrap();
        assert!(!is_busy().await);
    });
}

/// Points on a lattice, an obstacle, a break line whose ends no point holds, and a site.
fn scene_with_lines() -> Scene {
    let rows: [&[u8]; 10] = [
        &[1, 2, 4, 5, 6],
        &[0, 3, 7],
        &[0, 3, 4, 7, 8],
        &[4, 6, 8],
        &[0, 1, 2, 5, 7, 9],
        &[3, 8, 9],
        &[5],
        &[1, 2, 4, 7, 8, 9],
        &[0, 1, 2, 7, 8],
        &[0, 7, 8, 9],
    ];
    let at = |x: usize, y: u8| Point::new(x as f64, f64::from(y));
    let mut scene = Scene::default();
    for (row, x) in rows.into_iter().zip(0..) {
        scene
            .points
            .extend(row.iter().map(|&y| (key(at(x, y)), (at(x, y), 0.0))));
    }
    let line = |kind, corners: &[(usize, u8)], number| Line {
        kind,
        corners: corners.iter().map(|&(x, y)| at(x, y)).collect(),
        number,
    };
    let obstacle = [(2, 5), (6, 5), (6, 9), (2, 9), (2, 5)];
    scene.lines.push(line(LineKind::Obstacle, &obstacle, 0));
    let break_line = [(9, 4), (0, 2), (9, 6)];
    scene.lines.push(line(LineKind::BreakLine, &break_line, 1));
    scene.sites.push((at(6, 4), SiteId::Number(16)));
    scene
}

#[test]
fn lines_and_sites_are_built_anew_with_the_points() {
    runtime().block_on(async {
        for (memory, tile_vertices) in [256 << 10, ENOUGH]
            .into_iter()
            .flat_map(|m| (4..47).map(move |t| (m, t)))
        {
            let mut scene = scene_with_lines();
            let scratch = scene.build(tile_vertices).await.unwrap();
            let before = inode(&scratch);
            let editor = Editor::open(&scratch.path, EditOptions::default().memory(memory))
                .await
                .unwrap();
            let mut transaction = editor.begin().await.unwrap();
            transaction.prefer_build(true);
            // On a line, at an end, at the site, at a corner, and where nothing is.
            let new = [(4.5, 4.0), (9.0, 6.0), (6.0, 4.0), (2.0, 5.0), (5.5, 6.5)].map(|(x, y)| Point::new(x, y));
            transaction.insert(&batch(&new)).unwrap();
            let gone = [(5.0, 8.0), (6.0, 5.0)].map(|(x, y)| Point::new(x, y));
            transaction.delete(&gone).unwrap();
            scene.points.extend(new.map(|point| (key(point), (point, 0.0))));
            scene.points.retain(|_, (point, _)| !gone.contains(point));
            let summary = transaction.commit().await.unwrap();
            assert_eq!((summary.points.inserted, summary.points.deleted), (5, 2));
            assert_ne!(inode(&scratch), before);
            let whole = scene.build(30).await.unwrap();
            assert_eq!(
                checked(&scratch).await,
                checked(&whole).await,
                "{memory} {tile_vertices}"
            );
            let [edited, built] = [scratch.open().await, whole.open().await];
            assert_eq!(edited.metadata().ends, built.metadata().ends);
            assert_eq!(edited.metadata().last_transaction, 1);
        }
    });
}
