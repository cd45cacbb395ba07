//! Heights as colours, in the encoding that Mapzen called Terrarium.
//!
//! A height of `h` metres is `256 R + G + B / 256 - 32768`, so it is rounded to the nearest 1/256
//! m, and cut off at -32768 m and 32767.996 m. Where there is no surface, a pixel has the lowest
//! height of the file, and is transparent if that is wanted. Browsers forget the colours of transparent
//! pixels.

use bytes::Bytes;

use crate::map_tiles::image::png;

/// Returns a picture of heights, NaN where there is none. `unit` is theirs in metres, and `lowest`
/// one of them. `opacity` is that of pixels without a height.
pub(super) fn terrarium(heights: &[f64], unit: f64, lowest: f64, opacity: u8) -> Bytes {
    let pixels: Vec<[u8; 4]> = heights
        .iter()
        .map(|&z| match z.is_nan() {
            true => encode(lowest * unit, opacity),
            false => encode(z * unit, 255),
        })
        .collect();
    png(&pixels)
}

/// Returns the colour of a height in metres.
fn encode(metres: f64, opacity: u8) -> [u8; 4] {
    // Conversions saturate.
    let steps = (((metres + 32768.0) * 256.0).round() as u32).min(0xff_ffff);
    [(steps >> 16) as u8, (steps >> 8) as u8, steps as u8, opacity]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_are_rounded_and_cut_off() {
        let decode = |[r, g, b, _]: [u8; 4]| f64::from(r) * 256.0 + f64::from(g) + f64::from(b) / 256.0 - 32768.0;
        for z in [0.0, 8848.86, -10_984.5, 1.0 / 256.0, 0.001] {
            assert!((decode(encode(z, 255)) - z).abs() <= 1.0 / 512.0);
        }
        assert_eq!(decode(encode(-1e9, 255)), -32768.0);
        assert_eq!(decode(encode(1e300, 255)), 32768.0 - 1.0 / 256.0);
    }
}
