//! Whether several files have one coordinate reference system.

use std::path::{Path, PathBuf};

use super::Crs;
use crate::shown;

/// The coordinate reference system of several files, which must have the same one.
///
/// ```
/// use delaunay_tiles::crs::{Agreement, Crs};
///
/// let mut files = Agreement::default();
/// files.add("survey.laz".as_ref(), Crs::new("EPSG:2949"))?;
/// let error = files.add("lakes.shp".as_ref(), Crs::new("EPSG:26917")).unwrap_err();
/// assert!(error.to_string().contains("survey.laz") && error.to_string().contains("lakes.shp"));
/// # Ok::<(), delaunay_tiles::crs::CrsConflict>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Agreement {
    given: Option<Crs>,
    files: Vec<(PathBuf, Crs)>,
}

/// The error of two files with different coordinate reference systems.
#[derive(Debug, thiserror::Error)]
#[error(
    "{} has another coordinate reference system than {}: {why} ({}; {}); convert one of them, or, if a file names the \
     wrong one, give the right one for all (option `crs`)",
    shown::path(&.files[1]),
    shown::path(&.files[0]),
    .systems[1],
    .systems[0]
)]
pub struct CrsConflict {
    /// The two files.
    pub files: [PathBuf; 2],
    /// Their systems, in a few words.
    pub systems: [String; 2],
    why: String,
}

impl Agreement {
    /// Creates an agreement on a system that overrides those of the files.
    #[must_use]
    pub fn on(given: Crs) -> Self {
        Self {
            given: Some(given),
            ..Self::default()
        }
    }

    /// Adds a file.
    ///
    /// # Errors
    /// Fails if its system [differs](Crs::conflict) from that of another file, unless one is given
    /// that overrides them.
    pub fn add(&mut self, file: &Path, crs: Crs) -> Result<(), CrsConflict> {
        if self.given.is_some() {
            return Ok(());
        }
        for (other, of_other) in &self.files {
            if let Some(why) = crs.conflict(of_other) {
                return Err(CrsConflict {
                    files: [other.clone(), file.to_owned()],
                    systems: [of_other.summary(), crs.summary()],
                    why,
                });
            }
        }
        // One file for each text is enough.
        if !self.files.iter().any(|(_, other)| *other == crs) {
            self.files.push((file.to_owned(), crs));
        }
        Ok(())
    }

    /// Returns the system: the given one, or that of the first file that has a code, or of the first
    /// file.
    #[must_use]
    pub fn crs(&self) -> Option<&Crs> {
        let mut files = self.files.iter().map(|(_, crs)| crs);
        let coded = files.clone().find(|crs| crs.epsg().is_some());
        self.given.as_ref().or(coded).or_else(|| files.next())
    }
}
