//! Maps: the cells of the tiles over the triangulation, as SVG or PNG.
//!
//! The input is an open tile file. The output is a picture that appears under its name only when it
//! is complete. A small file is drawn whole. A large file, which no picture could show and which
//! may exceed memory, is drawn as the triangulation of a sample of its vertices.

pub mod axis;
pub mod legend;
pub mod map;
pub mod page;
pub mod png;
mod query;
pub mod scene;
pub mod style;
pub mod svg;

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use delaunay_tiles::peak_memory;
use delaunay_tiles::store::TileReader;
use serde::Serialize;

use crate::common::{bytes, counted, file_name};
use crate::output::{self, StreamOutput};
use page::Page;
pub use query::Overlay;
use scene::Scene;

/// The file of a picture, whose suffix names the format.
#[derive(Clone, Debug)]
pub struct PlotFile {
    path: PathBuf,
    format: PictureFormat,
}

#[derive(Clone, Copy, Debug)]
enum PictureFormat {
    Svg,
    Png,
}

impl PictureFormat {
    fn encode(self, svg: String) -> anyhow::Result<Vec<u8>> {
        match self {
            Self::Svg => Ok(svg.into_bytes()),
            Self::Png => png::render(&svg),
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
        Ok(Self { path, format })
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

    fn cannot_write(&self) -> String {
        format!("{}: cannot write the map", crate::common::shown(&self.path))
    }
}

/// A report about a drawn map. Its field names are stable keys of `--json`.
#[derive(Serialize)]
pub struct Plotted {
    file: String,
    bytes: u64,
    width: u32,
    height: u32,
    sampled: bool,
    vertices: u64,
    triangles: u64,
    peak_memory_bytes: Option<u64>,
}

impl Plotted {
    /// Returns the report for people, as one line.
    pub fn report(&self) -> String {
        let vertices = counted(self.vertices, "vertex", "vertices");
        let drawn = match self.sampled {
            true => format!("a sample of {vertices}"),
            false => format!("whole, {vertices}"),
        };
        let (width, height) = (self.width, self.height);
        format!(
            "{}: {width} x {height} pixels, {}, {drawn}\n",
            self.file,
            bytes(self.bytes)
        )
    }
}

/// Draws a map of a tile file.
pub async fn draw(reader: &TileReader, file: &PlotFile) -> anyhow::Result<Plotted> {
    let directory = reader.directory().await?;
    let scene = Scene::gather(reader).await?;
    let page = Page::new(scene.bounds)?;
    let name = file_name(Path::new(reader.name()));
    let bytes = save(file, map::draw(&name, &directory, &scene, &page))?;
    Ok(Plotted {
        file: file.path.display().to_string(),
        bytes,
        width: page.width,
        height: page.height,
        sampled: scene.sampled,
        vertices: scene.points.len() as u64,
        triangles: scene.triangles,
        peak_memory_bytes: peak_memory(),
    })
}

/// Returns the bytes of a picture whose name ends in `.svg` or `.png`.
pub fn encode(name: &Path, svg: String) -> anyhow::Result<Vec<u8>> {
    PlotFile::new(name.to_owned())?.format.encode(svg)
}

/// Draws the answer to a query.
pub async fn draw_query(reader: &TileReader, file: &PlotFile, overlay: &Overlay) -> anyhow::Result<()> {
    let page = Page::new(overlay.window(reader.metadata().bounds))?;
    let name = file_name(Path::new(reader.name()));
    save(file, query::draw(reader, &name, overlay, &page).await?)?;
    Ok(())
}

/// Writes a picture. Returns its number of bytes.
fn save(file: &PlotFile, svg: String) -> anyhow::Result<u64> {
    let picture = file.format.encode(svg)?;
    output::write(&file.path, &picture).with_context(|| file.cannot_write())?;
    Ok(picture.len() as u64)
}
