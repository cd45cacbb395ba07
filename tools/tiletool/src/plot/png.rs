//! Converts SVG to PNG with a bundled font, so that a map looks the same on every machine.

use anyhow::{Context, anyhow};
use resvg::tiny_skia::{Color, Pixmap, PixmapPaint, Transform};
use resvg::usvg::{Options, Tree};

/// DejaVu Sans, reduced to Latin, Greek and Cyrillic. Its licence is in the same folder.
const FONT: &[u8] = include_bytes!("../../assets/DejaVuSans-subset.ttf");

/// Renders an SVG as PNG, over an image whose upper left corner is at a pixel.
pub fn render(svg: &str, beneath: Option<(Pixmap, (i32, i32))>) -> anyhow::Result<Vec<u8>> {
    let mut options = Options {
        font_family: "DejaVu Sans".to_owned(),
        ..Options::default()
    };
    options.fontdb_mut().load_font_data(FONT.to_vec());
    let tree = Tree::from_str(svg, &options).context("the map is not valid SVG")?;
    let size = tree.size().to_int_size();
    let mut pixels = Pixmap::new(size.width(), size.height()).ok_or_else(|| anyhow!("the map has no size"))?;
    pixels.fill(Color::WHITE);
    if let Some((image, (x, y))) = beneath {
        let (paint, unchanged) = (PixmapPaint::default(), Transform::identity());
        pixels.draw_pixmap(x, y, image.as_ref(), &paint, unchanged, None);
    }
    resvg::render(&tree, Transform::identity(), &mut pixels.as_mut());
    Ok(pixels.encode_png()?)
}
