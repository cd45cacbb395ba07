//! Colours of heights, and the light on slopes: the shaded relief of map tiles and of the tool's plots.
//!
//! ```
//! use delaunay_tiles::terrain::shading::{brightness, lit, tint};
//!
//! // A third of the way up, on a slope that falls to the north-west.
//! let colour = lit(tint(0.3), brightness([0.5, -0.5], 0.55));
//! assert!(colour[0] > tint(0.3)[0]);
//! ```

/// The colours from the lowest to the highest z, as red, green and blue. Each is lighter than the one
/// before, and they go from blue to yellow, so that they remain apart for people who do not see red and
/// green.
pub const RAMP: [[u8; 3]; 8] = [
    [88, 124, 142],
    [104, 144, 154],
    [126, 162, 160],
    [153, 178, 160],
    [187, 198, 163],
    [217, 214, 172],
    [238, 229, 191],
    [251, 244, 220],
];

/// Returns the colour of a share between 0 and 1 of the range of heights, between the colours of [`RAMP`].
/// Components are from 0 to 255.
#[must_use]
pub fn tint(share: f64) -> [f64; 3] {
    let steps = (RAMP.len() - 1) as f64;
    let position = share.clamp(0.0, 1.0) * steps;
    let before = position.floor().min(steps - 1.0);
    let (a, b) = (RAMP[before as usize], RAMP[before as usize + 1]);
    let weight = position - before;
    [0, 1, 2].map(|i| f64::from(a[i]) * (1.0 - weight) + f64::from(b[i]) * weight)
}

/// Returns how bright a slope is in light from the north-west, halfway up; 1 is as bright as flat
/// ground. `east` and `north` are the change of height for each unit of length. `strength` says how much of
/// the light is seen: with 1, slopes away from it are black.
#[must_use]
pub fn brightness([east, north]: [f64; 2], strength: f64) -> f64 {
    let up = 0.5f64.sqrt();
    let seen = (0.5 * east - 0.5 * north + up) / (1.0 + east * east + north * north).sqrt();
    let seen = if seen.is_nan() { up } else { seen };
    1.0 + strength * (seen.max(0.0) / up - 1.0)
}

/// Returns a colour in light: darker, or closer to white.
#[must_use]
pub fn lit(colour: [f64; 3], brightness: f64) -> [f64; 3] {
    colour.map(|c| match brightness > 1.0 {
        true => c + (255.0 - c) * (brightness - 1.0),
        false => c * brightness,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn higher_is_lighter_and_slopes_towards_the_light_are_brighter() {
        let luminance = |[r, g, b]: [f64; 3]| 0.2126 * r + 0.7152 * g + 0.0722 * b;
        let shares: Vec<_> = (0..=100).map(|i| luminance(tint(f64::from(i) / 100.0))).collect();
        assert!(shares.windows(2).all(|pair| pair[0] < pair[1]));
        let brightness = |slope| brightness(slope, 0.5);
        assert!((brightness([0.0, 0.0]) - 1.0).abs() < 1e-12);
        assert!(brightness([0.5, -0.5]) > 1.1 && brightness([-0.5, 0.5]) < 0.8);
        assert!((brightness([0.5, 0.5]) - brightness([-0.5, -0.5])).abs() < 1e-12);
    }
}
