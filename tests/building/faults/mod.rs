//! The promise: when any one read, write or sync fails, the result is an error that says where, or
//! the same answer; never a panic, never another answer. The next attempt succeeds.

mod round_trips;
use std::error::Error;
use std::time::Duration;

use crate::support::faults::{Fault, Faulty};
use crate::support::{batches, file_bytes, points_of, runtime};
use bytes::Bytes;
use delaunay_tiles::BuildOptions;
use delaunay_tiles::geometry::Rect;
use delaunay_tiles::io::{MemoryFile, ReadAt, WriteAt};
use delaunay_tiles::store::{Cache, OpenOptions, ReadError, TileId, TileReader, VerifyError};
use distributions::Kind;
use futures::TryStreamExt;

const LONGEST: Duration = Duration::from_secs(20);

/// Builds a file of about twenty tiles.
fn town() -> Vec<u8> {
    let options = BuildOptions::default().tile_vertices(32).threads(2);
    runtime().block_on(file_bytes(&batches(&points_of(Kind::Uniform, 400, 3), &[]), options))
}

/// An operation on a reader.
#[derive(Clone, Copy, Debug)]
enum Task {
    Open,
    Tile,
    Tiles,
    Digest,
    Locate,
    TrianglesIn,
    Verify,
    VerifyDeep,
}

impl Task {
    const ALL: [Self; 8] = [
        Self::Open,
        Self::Tile,
        Self::Tiles,
        Self::Digest,
        Self::Locate,
        Self::TrianglesIn,
        Self::Verify,
        Self::VerifyDeep,
    ];

    /// Runs the operation. The answer is text, so that answers of all tasks can be compared.
    async fn run(self, reader: &TileReader) -> Result<String, ReadError> {
        Ok(match self {
            Self::Open => format!("{} {:?}", reader.file_id(), reader.metadata()),
            Self::Tile => {
                let tile = reader.tile(TileId(3)).await?;
                format!(
                    "{:?}",
                    tile.triangle_ids().map(|t| tile.vertices(t)).collect::<Vec<_>>()
                )
            }
            Self::Tiles => {
                let tiles = reader
                    .tiles()
                    .map_ok(|tile| (tile.id(), tile.points().collect::<Vec<_>>()));
                format!("{:?}", tiles.try_collect::<Vec<_>>().await?)
            }
            Self::Digest => reader.recompute_digest().await?.to_string(),
            Self::Locate => {
                let mut answers = Vec::new();
                for x in [0.1, 0.3, 0.5, 0.7, 0.9] {
                    answers.push(reader.locate(x, 1.0 - x).await?);
                }
                format!("{answers:?}")
            }
            Self::TrianglesIn => {
                let triangles = reader.triangles_in(Rect::new(0.2, 0.3, 0.8, 0.6));
                format!("{:?}", triangles.try_collect::<Vec<_>>().await?)
            }
            Self::Verify => verified(reader.verify(false).await)?,
            Self::VerifyDeep => verified(reader.verify(true).await)?,
        })
    }
}

/// Returns a report as text, or the read error. Panics if a sound file is reported to be wrong.
fn verified<T: std::fmt::Debug>(report: Result<T, VerifyError>) -> Result<String, ReadError> {
    match report {
        Ok(report) => Ok(format!("{report:?}")),
        Err(VerifyError::Read(error)) => Err(error),
        Err(other) => panic!("a sound file is said to be wrong: {other}"),
    }
}

fn options() -> OpenOptions {
    // No tile stays in memory, so no later read is skipped.
    OpenOptions::default().cache(&Cache::new(0))
}

/// Opens the file and runs `task`. If only the task fails, runs it again with the same reader and
/// returns that answer too.
async fn attempt(file: impl ReadAt + 'static, task: Task) -> (Result<String, ReadError>, Option<String>) {
    let reader = match TileReader::open_source(file, "town.tiles", options()).await {
        Ok(reader) => reader,
        Err(error) => return (Err(error), None),
    };
    match task.run(&reader).await {
        Ok(answer) => (Ok(answer), None),
        Err(error) => (
            Err(error),
            Some(task.run(&reader).await.expect("the fault was there once")),
        ),
    }
}

/// Checks that an error names the file and what was read of it, and has the system's reason as its
/// source.
fn check(error: &ReadError, case: &str) {
    assert!(!matches!(error, ReadError::Cancelled), "{case}: a task panicked");
    let text = error.to_string();
    assert!(text.starts_with("town.tiles: cannot read "), "{case}: {text}");
    assert!(error.source().is_some(), "{case}: {text}");
}

#[test]
fn a_failing_read_gives_an_error_or_the_same_answer() {
    let bytes = town();
    let file = MemoryFile::new(bytes);
    let (mut cases, mut errors) = (0, 0);
    runtime().block_on(async {
        for task in Task::ALL {
            let sound = Faulty::sound(file.clone());
            let expected = attempt(sound.clone(), task).await.0.unwrap();
            assert!(expected.len() > 100, "{task:?}: an answer to compare with: {expected}");
            for number in 0..sound.operations() {
                for fault in Fault::OF_READS {
                    let case = format!("{task:?}, read {number}, {fault:?}");
                    let faulty = Faulty::new(file.clone(), fault, number);
                    let done = tokio::time::timeout(LONGEST, attempt(faulty, task)).await;
                    let (answer, again) = done.unwrap_or_else(|_| panic!("{case}: no answer"));
                    cases += 1;
                    match answer {
                        Ok(answer) => assert!(answer == expected, "{case}: another answer"),
                        Err(error) => {
                            assert_ne!(fault, Fault::Delay, "{case}");
                            check(&error, &case);
                            errors += 1;
                        }
                    }
                    assert!(
                        again.is_none_or(|again| again == expected),
                        "{case}: another answer afterwards"
                    );
                }
            }
        }
    });
    println!("{cases} cases, {errors} of them errors");
    // Every fault but a delay gives an error, since readers read only what they need.
    assert!(cases > 500, "{cases}");
    assert_eq!(errors, cases / 5 * 4);
}

/// Writes a file in the order of builds: the content after the superblocks, a sync, the
/// superblocks, a sync.
async fn copy(bytes: &Bytes, to: &impl WriteAt) -> std::io::Result<()> {
    const CHUNK: usize = 5000;
    for at in (8192..bytes.len()).step_by(CHUNK) {
        to.write_at(at as u64, bytes.slice(at..bytes.len().min(at + CHUNK)))
            .await?;
    }
    to.sync().await?;
    to.write_at(0, bytes.slice(..8192)).await?;
    to.sync().await
}

#[test]
fn a_failing_write_leaves_the_whole_file_or_no_valid_file() {
    let bytes = Bytes::from(town());
    let mut cases = 0;
    runtime().block_on(async {
        let expected = attempt(MemoryFile::new(bytes.to_vec()), Task::Digest).await.0.unwrap();
        let sound = Faulty::sound(MemoryFile::default());
        copy(&bytes, &sound).await.unwrap();
        for number in 0..sound.operations() {
            for fault in Fault::OF_WRITES {
                let case = format!("write {number}, {fault:?}");
                let file = MemoryFile::default();
                let copied = copy(&bytes, &Faulty::new(file.clone(), fault, number)).await;
                assert_eq!(copied.is_ok(), fault == Fault::Delay, "{case}");
                cases += 1;
                // What was written is the whole file, or no valid file.
                match attempt(file, Task::Digest).await.0 {
                    Ok(answer) => assert!(answer == expected, "{case}: another answer"),
                    Err(error) => {
                        assert!(
                            fault != Fault::Delay && !matches!(error, ReadError::Cancelled),
                            "{case}: {error}"
                        );
                    }
                }
            }
        }
    });
    println!("{cases} cases");
    assert!(cases > 40, "{cases}");
}
