//! The rows of a text file, for callers whose rows are not points, for example files of queries.

use crate::input::bytes::ByteInput;
use crate::input::error::InputError;
use crate::input::formats::text_lines::Lines;
use crate::input::watch::{Reading, Watch, Watched};
use std::fmt;
use std::path::Path;
use std::sync::Arc;

/// The rows of one text file, which may be compressed with gzip: the lines that are neither blank
/// nor begin with `#`.
///
/// No row is longer than 1 MiB. As with all sources, a file that changes while it is read is an
/// error.
///
/// ```
/// use delaunay_tiles::input::RowFile;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let dir = tempfile::tempdir()?;
/// let path = dir.path().join("queries.txt");
/// std::fs::write(&path, "# from, to\n1 2\n\n3 4\n")?;
///
/// let mut rows = RowFile::open(&path)?;
/// assert_eq!(rows.next_row()?, Some((&b"1 2"[..], 2)));
/// assert_eq!(rows.next_row()?, Some((&b"3 4"[..], 4)));
/// assert_eq!(rows.next_row()?, None);
/// # Ok(())
/// # }
/// ```
pub struct RowFile {
    lines: Lines,
    watch: Arc<Watch>,
}

impl RowFile {
    /// Opens a file.
    ///
    /// # Errors
    /// Fails if the file cannot be opened or read, or if it is not text.
    pub fn open(path: &Path) -> Result<Self, InputError> {
        let file = Watched::open(path, &Reading::default(), None)?;
        let watch = Arc::clone(&file.watch);
        let lines = ByteInput::new(file, true).and_then(Lines::new);
        Ok(Self {
            lines: lines.map_err(|error| watch.explain(error))?,
            watch,
        })
    }

    /// Returns the next row, without surrounding blanks, and its line number, counted from 1;
    /// `None` after the last row.
    ///
    /// # Errors
    /// Fails if a row is too long, or if the file cannot be read or has changed since it was
    /// opened.
    pub fn next_row(&mut self) -> Result<Option<(&[u8], u64)>, InputError> {
        if !self.lines.next_row().map_err(|error| self.watch.explain(error))? {
            self.watch.check()?;
            return Ok(None);
        }
        Ok(Some((self.lines.text().trim_ascii(), self.lines.row())))
    }

    /// Returns the error `problem`, with the advice `hint`, at the row that was returned last.
    #[must_use]
    pub fn wrong_row(&self, problem: String, hint: &'static str) -> InputError {
        self.lines.malformed(problem, hint)
    }
}

impl fmt::Debug for RowFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RowFile")
            .field("path", &self.watch.path)
            .finish_non_exhaustive()
    }
}
