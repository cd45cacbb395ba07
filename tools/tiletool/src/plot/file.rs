//! The file of a picture: its name, its format and its title.

use std::path::PathBuf;

use anyhow::{Context, bail};

use super::png;
use crate::output::{self, StreamOutput};

/// The file of a picture, whose suffix names the format.
#[derive(Clone, Debug)]
pub struct PlotFile {
    pub(super) path: PathBuf,
    pub(super) format: PictureFormat,
    /// The text above the map; `None` if it is the name of the tile file.
    pub(super) title: Option<String>,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum PictureFormat {
    Svg,
    Png,
}

impl PictureFormat {
    pub(super) fn encode(self, svg: String) -> anyhow::Result<Vec<u8>> {
        match self {
            Self::Svg => Ok(svg.into_bytes()),
            Self::Png => png::render(&svg, None),
        }
    }
}

impl PlotFile {
    /// Creates the file of a picture. The suffix of its path determines the format.
    ///
    /// # Errors
    /// Fails if the suffix is neither .svg nor .png.
    pub fn new(path: PathBuf) -> anyhow::Result<Self> {
        let suffix = path.extension().map(|s| s.to_string_lossy().to_ascii_lowercase());
        let format = match suffix.as_deref() {
            Some("svg") => PictureFormat::Svg,
            Some("png") => PictureFormat::Png,
            _ => bail!("maps are drawn as SVG or PNG: the name must end in .svg or .png"),
        };
        Ok(Self {
            path,
            format,
            title: None,
        })
    }

    /// Returns the same file with another title.
    pub fn titled(mut self, title: Option<String>) -> Self {
        self.title = title;
        self
    }

    /// Checks that the file can be created, so that a command fails before it computes for long.
    ///
    /// # Errors
    /// Fails as writing the file would: if its folder does not exist or is read-only, for example.
    pub fn check(&self) -> anyhow::Result<()> {
        // Dropping the output removes its partial file.
        drop(StreamOutput::create(&self.path).with_context(|| self.cannot_write())?);
        Ok(())
    }

    /// Writes a picture. Returns its number of bytes.
    pub(super) fn save(&self, picture: &[u8]) -> anyhow::Result<u64> {
        output::write(&self.path, picture).with_context(|| self.cannot_write())?;
        Ok(picture.len() as u64)
    }

    fn cannot_write(&self) -> String {
        format!("{}: cannot write the map", crate::common::shown(&self.path))
    }
}
