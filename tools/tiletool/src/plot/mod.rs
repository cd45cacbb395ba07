//! Maps: the cells of the tiles over the triangulation, as SVG or PNG.
//!
//! The input is an open tile file. The output is a picture that appears under its name only when it
//! is complete. All of the file is drawn: a small one line by line, and a large one, which may exceed
//! memory, tile by tile into the pixels of an image. If there is z, an image of it is the ground.

pub mod axis;
mod image;
mod ink;
mod layers;
pub mod legend;
pub mod map;
pub mod page;
pub mod png;
mod query;
mod relief;
mod scales;
pub mod scene;
pub mod style;
pub mod svg;

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use delaunay_tiles::peak_memory;
use delaunay_tiles::store::TileReader;
use resvg::tiny_skia::Pixmap;
use serde::Serialize;

use crate::common::{bytes, counted, file_name};
use crate::output::{self, StreamOutput};
use layers::Layers;
use legend::Legend;
use map::{Ground, Map};
use page::Page;
pub use query::Overlay;
use relief::Relief;
use scene::Scene;
use style::{PAPER, rgb};

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

    /// Writes a picture. Returns its number of bytes.
    fn save(&self, picture: &[u8]) -> anyhow::Result<u64> {
        output::write(&self.path, picture).with_context(|| self.cannot_write())?;
        Ok(picture.len() as u64)
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
    vertices: u64,
    triangles: u64,
    peak_memory_bytes: Option<u64>,
}

impl Plotted {
    /// Returns the report for people, as one line.
    pub fn report(&self) -> String {
        let vertices = counted(self.vertices, "vertex", "vertices");
        let (width, height) = (self.width, self.height);
        format!(
            "{}: {width} x {height} pixels, {}, {vertices}\n",
            self.file,
            bytes(self.bytes)
        )
    }
}

/// Returns how much of the memory that a command may use is for the reader of a file that is drawn; the
/// rest is for pixels. Too little memory for both is all for the reader, so that its errors name it.
pub fn memory_of_reader(memory: u64) -> u64 {
    const MEBIBYTE: u64 = 1 << 20;
    match memory > 16 * MEBIBYTE {
        true => memory - (memory / 3).min(24 * MEBIBYTE),
        false => memory,
    }
}

/// Draws a map of a tile file.
///
/// # Errors
/// Fails if the file cannot be read or is damaged, if the memory does not suffice, or if the map
/// cannot be written.
pub async fn draw(reader: &TileReader, file: &PlotFile) -> anyhow::Result<Plotted> {
    let directory = reader.directory().await?;
    let page = Page::new(directory.metadata.bounds)?;
    let name = file_name(Path::new(reader.name()));
    let relief = Relief::gather(reader, &page).await?;
    let heights = relief.as_ref().and_then(Relief::heights);
    let mut ground = match (relief, heights) {
        (Some(relief), Some(heights)) => Some(relief.image(heights, rgb(PAPER))?),
        _ => None,
    };
    let mut legend = Legend::default();
    let scene = Scene::gather(reader).await?;
    let (vertices, triangles) = match &scene {
        Some(scene) => (scene.points.len() as u64, scene.triangles),
        None => {
            let layers = Layers::gather(reader, &page).await?;
            let mut image = ground.map_or_else(|| image::blank(page.pixels(), rgb(PAPER)), Ok)?;
            layers.paint(&mut image, heights.is_some(), &mut legend);
            ground = Some(image);
            layers.counts()
        }
    };
    let map = Map {
        name: &name,
        directory: &directory,
        page: &page,
        unit: scales::unit_of(reader).await?,
        scene: scene.as_ref(),
        heights,
    };
    let bytes = file.save(&picture(&map, ground, file.format, legend)?)?;
    Ok(Plotted {
        file: file.path.display().to_string(),
        bytes,
        width: page.width,
        height: page.height,
        vertices,
        triangles,
        peak_memory_bytes: peak_memory(),
    })
}

/// Draws a map, over an image of its frame if there is one.
fn picture(map: &Map, image: Option<Pixmap>, format: PictureFormat, legend: Legend) -> anyhow::Result<Vec<u8>> {
    let Some(image) = image else {
        return format.encode(map.draw(Ground::Colour(PAPER), legend));
    };
    match format {
        PictureFormat::Svg => {
            let reference = image::data_url(&image)?;
            drop(image);
            Ok(map.draw(Ground::Image(&reference), legend).into_bytes())
        }
        PictureFormat::Png => {
            let corner = (map.page.frame.min_x as i32, map.page.frame.min_y as i32);
            png::render(&map.draw(Ground::Beneath, legend), Some((image, corner)))
        }
    }
}

/// Returns the bytes of a picture whose name ends in `.svg` or `.png`.
pub fn encode(name: &Path, svg: String) -> anyhow::Result<Vec<u8>> {
    PlotFile::new(name.to_owned())?.format.encode(svg)
}

/// Draws the answer to a query.
pub async fn draw_query(reader: &TileReader, file: &PlotFile, overlay: &Overlay) -> anyhow::Result<()> {
    let page = Page::new(overlay.window(reader.metadata().bounds))?;
    let name = file_name(Path::new(reader.name()));
    let svg = query::draw(reader, &name, overlay, &page).await?;
    file.save(&file.format.encode(svg)?)?;
    Ok(())
}
