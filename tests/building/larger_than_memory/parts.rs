//! The promise: a file in parts has the triangles of one file, and is read as such.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use delaunay_tiles::geometry::Point;
use delaunay_tiles::store::{OpenOptions, TileReader};
use delaunay_tiles::{BuildOptions, Builder, EditError, EditOptions, Editor};
use distributions::Kind;
use futures::TryStreamExt;

use crate::larger_than_memory::inputs::{Input, city, islands, long_lines, valley};
use crate::larger_than_memory::tasks::{conquer_and_finish, digest};
use crate::support::errors::whole;
use crate::support::{Scratch, batches, build_batches, points_of, runtime};

fn in_parts() -> Scratch {
    let mut scratch = Scratch::new();
    scratch.path = scratch.folder.path().join("test.tiles.parts");
    scratch
}

/// Returns the files of the parts, by name.
fn parts_of(scratch: &Scratch) -> Vec<PathBuf> {
    let folders = fs::read_dir(scratch.folder.path().join("test.tiles.parts.d")).unwrap();
    let folders: Vec<PathBuf> = folders.map(|folder| folder.unwrap().path()).collect();
    let [folder] = &folders[..] else {
        panic!("parts of other files are left: {folders:?}")
    };
    let mut files: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|file| file.unwrap().path()).collect();
    files.sort_unstable();
    files
}

fn is_cores(file: &Path) -> bool {
    file.file_name()
        .is_some_and(|name| name.to_string_lossy().starts_with("cores-"))
}

async fn built(input: &Input, path: &Path, options: BuildOptions) -> u64 {
    let mut builder = Builder::new(path, options).unwrap();
    input.push(&mut builder).await.unwrap();
    builder.finish().await.unwrap().file_bytes
}

#[test]
fn blocks_that_stay_where_they_are_give_the_triangles_of_one_file() {
    let curve = Input::new("points", &points_of(Kind::Kuzmin, 100_000, 5), &[], 1_500_000);
    runtime().block_on(async {
        for (input, seed) in [curve, city(), valley(), islands(), long_lines()].into_iter().zip(1..) {
            let [whole, one] = [Scratch::new(), Scratch::new()];
            built(&input, &whole.path, input.options.clone()).await;
            let scratch = in_parts();
            let summary = conquer_and_finish(&input, &scratch, seed).await;
            assert_eq!(digest(&scratch).await, digest(&whole).await, "{}", input.name);
            assert_eq!(fs::read_dir(scratch.folder.path()).unwrap().count(), 2, "work is left");
            let reader = scratch.open().await;
            assert_eq!(reader.file_length(), summary.file_bytes);
            // The file is needed in one piece to insert lines, and to look for sites in holes.
            let is_whole = summary.deferred_segments > 0 || input.name == "city";
            let parts = parts_of(&scratch).into_iter().filter(|file| is_cores(file)).count() as u64;
            assert_eq!(parts, if is_whole { 0 } else { summary.blocks }, "{}", input.name);
            let mode = |file: &Path| file.metadata().unwrap().permissions().mode();
            for file in parts_of(&scratch).iter().chain([&scratch.path]) {
                assert_eq!(mode(file), mode(&whole.path), "{}", file.display());
            }
            reader.compact(&one.path).await.unwrap();
            assert_eq!(digest(&one).await, digest(&whole).await, "{}", input.name);
        }
    });
}

#[test]
fn a_file_that_is_replaced_leaves_no_parts() {
    let points = Input::new("points", &points_of(Kind::Uniform, 100_000, 5), &[], 1_500_000);
    runtime().block_on(async {
        let scratch = in_parts();
        conquer_and_finish(&points, &scratch, 7).await;
        let before = parts_of(&scratch);
        assert!(before.len() > 3, "{before:?}");
        // A build in one process makes one part, and so does one in memory.
        for memory in [1_500_000, 64 << 20] {
            let length = built(
                &points,
                &scratch.path,
                points.options.clone().memory(memory).force(true),
            )
            .await;
            let now = parts_of(&scratch);
            assert!(now.len() == 1 && !before.contains(&now[0]), "{now:?}");
            assert_eq!(now[0].metadata().unwrap().len(), length);
            assert_eq!(scratch.open().await.verify(true).await.unwrap().vertices, 100_000);
        }
    });
}

#[test]
fn what_is_missing_or_damaged_is_an_error_that_names_the_part() {
    let points = Input::new("points", &points_of(Kind::Uniform, 100_000, 5), &[], 1_500_000);
    runtime().block_on(async {
        let scratch = in_parts();
        conquer_and_finish(&points, &scratch, 8).await;
        // Those of the first block are read when the file is opened.
        let cores = parts_of(&scratch).into_iter().rfind(|file| is_cores(file)).unwrap();
        let error = |reader: TileReader| async move {
            let error = reader
                .triangles_in(reader.metadata().bounds)
                .try_collect::<Vec<_>>()
                .await;
            whole(&error.map(|_| ()).unwrap_err())
        };
        let bytes = fs::read(&cores).unwrap();
        let mut changed = bytes.clone();
        // Between two cores there may be a gap.
        let middle = bytes.len() / 2;
        changed[middle - 3000..middle + 3000]
            .iter_mut()
            .for_each(|byte| *byte ^= 1);
        fs::write(&cores, changed).unwrap();
        let text = error(scratch.open().await).await;
        assert!(text.contains("checksum"), "{text}");
        fs::write(&cores, &bytes[..bytes.len() / 2]).unwrap();
        let text = error(scratch.open().await).await;
        let name = cores.file_name().unwrap().to_str().unwrap();
        assert!(text.contains(name), "{text}");
        fs::remove_file(&cores).unwrap();
        let text = error(scratch.open().await).await;
        assert!(text.contains(name) && text.contains("No such file"), "{text}");
        let manifest = fs::read(&scratch.path).unwrap();
        fs::write(&scratch.path, &manifest[..manifest.len() - 5]).unwrap();
        let opened = TileReader::open(&scratch.path, OpenOptions::default()).await;
        let text = whole(&opened.err().unwrap());
        assert!(
            text.contains("the manifest of parts: it is cut off or damaged"),
            "{text}"
        );
    });
}

#[test]
fn a_file_in_parts_is_not_edited() {
    runtime().block_on(async {
        let scratch = in_parts();
        let points: Vec<Point> = points_of(Kind::Uniform, 100, 1);
        build_batches(&scratch.path, &batches(&points, &[]), BuildOptions::default())
            .await
            .unwrap();
        let edited = Editor::open(&scratch.path, EditOptions::default()).await.err();
        assert!(matches!(edited, Some(EditError::InParts(_))), "{edited:?}");
    });
}
