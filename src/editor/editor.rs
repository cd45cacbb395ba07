//! The editor of a file.

use std::path::Path;
use std::sync::Arc;

use tokio::sync::Mutex;

use crate::edit::{EditError, EditSummary};
use crate::editor::locked::LockedFile;
use crate::editor::options::EditOptions;
use crate::editor::transaction::Transaction;

/// An editor of a file on disk: points, lines and sites come and go, in transactions.
///
/// After each transaction, the file has exactly the triangles that a build of the changed points,
/// lines and sites would have. The file is locked against other editors. Readers may have it open, and
/// see it as it was when they opened it. On Linux, the threads that decode and encode tiles yield to
/// others of the process: their nice value is 10 more.
///
/// # Example
///
/// ```
/// use delaunay_tiles::input::PointBatch;
/// use delaunay_tiles::{BuildOptions, Builder, EditOptions, Editor, Point};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("field.tiles");
/// # tokio::runtime::Runtime::new()?.block_on(async {
/// let points: Vec<Point> = (0..100).map(|i| Point::new(f64::from(i % 10), f64::from(i / 10))).collect();
/// let grid = PointBatch { records: (0..100).collect(), points, z: vec![] };
/// let mut builder = Builder::new(&path, BuildOptions::default())?;
/// builder.push(&grid).await?;
/// builder.finish().await?;
///
/// let editor = Editor::open(&path, EditOptions::default()).await?;
/// let mut transaction = editor.begin().await?;
/// transaction.delete(&[Point::new(0.0, 0.0), Point::new(4.0, 4.0)])?;
/// transaction.move_points(&[[Point::new(9.0, 9.0), Point::new(20.0, 20.0)]])?;
/// let summary = transaction.commit().await?;
/// assert_eq!((summary.points.deleted, summary.points.moved, summary.vertices), (2, 1, 98));
/// # Ok(())
/// # })
/// # }
/// ```
pub struct Editor {
    file: Arc<Mutex<LockedFile>>,
}

impl Editor {
    /// Opens a file to edit it. If there are transactions in its log, it makes their changes first.
    ///
    /// # Errors
    /// Returns an error if the file cannot be opened, if another editor has it locked, if its log cannot
    /// be read, or if the changes in it cannot be made.
    pub async fn open(path: impl AsRef<Path>, options: EditOptions) -> Result<Self, EditError> {
        let file = LockedFile::open(path.as_ref(), options).await?;
        Ok(Self {
            file: Arc::new(Mutex::new(file)),
        })
    }

    /// Begins a transaction, as soon as the one before is committed or dropped. It keeps the file
    /// locked, even if the editor is dropped.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read.
    pub async fn begin(&self) -> Result<Transaction, EditError> {
        let file = Arc::clone(&self.file).lock_owned().await;
        Transaction::begin(file).await
    }

    /// Makes the changes in the file that are in its log ([`Durability::Log`](crate::Durability::Log)).
    /// Returns `None` if there are none.
    ///
    /// # Errors
    /// Returns an error if the system fails. The changes stay in the log.
    pub async fn checkpoint(&self) -> Result<Option<EditSummary>, EditError> {
        self.file.lock().await.checkpoint().await
    }
}
