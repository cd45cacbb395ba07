//! Opaque images: their colours, and their place in an SVG.

use anyhow::anyhow;
use resvg::tiny_skia::{Color, Pixmap, PremultipliedColorU8};

use super::style::rgb;

/// Creates an image of one colour.
pub fn blank((columns, rows): (usize, usize), [r, g, b]: [u8; 3]) -> anyhow::Result<Pixmap> {
    let image = Pixmap::new(columns as u32, rows as u32);
    let mut image = image.ok_or_else(|| anyhow!("the map has no size"))?;
    image.fill(Color::from_rgba8(r, g, b, 255));
    Ok(image)
}

/// Paints a colour over an opaque image, as much as each pixel is covered.
pub fn paint(image: &mut Pixmap, colour: &str, covered: impl Iterator<Item = f64>) {
    let colour = rgb(colour).map(f64::from);
    for (pixel, share) in image.pixels_mut().iter_mut().zip(covered) {
        if share > 0.0 {
            let mix = |below: u8, c: f64| (f64::from(below) * (1.0 - share) + c * share).round() as u8;
            let [r, g, b] = [(pixel.red(), 0), (pixel.green(), 1), (pixel.blue(), 2)].map(|(c, i)| mix(c, colour[i]));
            *pixel = PremultipliedColorU8::from_rgba(r, g, b, 255).unwrap_or(*pixel);
        }
    }
}

/// Returns an image as the reference of an SVG image.
pub fn data_url(image: &Pixmap) -> anyhow::Result<String> {
    let mut url = "data:image/png;base64,".to_owned();
    push_base64(&mut url, &image.encode_png()?);
    Ok(url)
}

/// Appends bytes in Base64 (RFC 4648).
fn push_base64(text: &mut String, bytes: &[u8]) {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    text.reserve(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let bits = (0..3).fold(0, |bits, i| bits << 8 | usize::from(group.get(i).copied().unwrap_or(0)));
        for digit in 0..4 {
            text.push(match digit <= group.len() {
                true => char::from(DIGITS[bits >> (18 - 6 * digit) & 63]),
                false => '=',
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_standard() {
        // The test vectors of RFC 4648.
        for (bytes, expected) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            let mut text = String::new();
            push_base64(&mut text, bytes.as_bytes());
            assert_eq!(text, expected);
        }
    }
}
