//! The colours of pictures. They are those of the tool's plots, but for the ground: a map has no frame,
//! so free ground must differ from the page, and holes from free ground.

/// Red, green and blue.
pub(super) type Colour = [u8; 3];

/// The colours from the lowest to the highest z. Each is lighter than the one before, and they go
/// from blue to yellow, so that they remain apart for people who do not see red and green.
const RAMP: [Colour; 8] = [
    [88, 124, 142],
    [104, 144, 154],
    [126, 162, 160],
    [153, 178, 160],
    [187, 198, 163],
    [217, 214, 172],
    [238, 229, 191],
    [251, 244, 220],
];

/// Free ground without heights.
pub(super) const FREE: Colour = [242, 240, 234];
/// Holes.
pub(super) const HOLE: Colour = [193, 201, 207];
/// Break lines.
pub(super) const BREAK: Colour = [47, 125, 79];
/// Walls.
pub(super) const WALL: Colour = [74, 44, 29];
/// Outlines of holes.
pub(super) const OUTLINE: Colour = [122, 133, 141];
/// Sites.
pub(super) const SITE: Colour = [168, 50, 122];
/// Vertices, where there is nothing else.
pub(super) const VERTEX: Colour = [35, 49, 61];

/// How much of the light is seen; 1 draws slopes away from it in black.
const STRENGTH: f64 = 0.55;

/// Returns the colour of a share between 0 and 1 of the range of heights.
pub(super) fn tint(share: f64) -> [f64; 3] {
    let steps = (RAMP.len() - 1) as f64;
    let position = share.clamp(0.0, 1.0) * steps;
    let before = position.floor().min(steps - 1.0);
    let (a, b) = (RAMP[before as usize], RAMP[before as usize + 1]);
    let weight = position - before;
    [0, 1, 2].map(|i| f64::from(a[i]) * (1.0 - weight) + f64::from(b[i]) * weight)
}

/// Returns how bright a slope is in light from the north-west, halfway up; 1 is as bright as flat
/// ground. `east` and `north` are the change of height for each unit of length.
pub(super) fn brightness([east, north]: [f64; 2]) -> f64 {
    let up = 0.5f64.sqrt();
    let seen = (0.5 * east - 0.5 * north + up) / (1.0 + east * east + north * north).sqrt();
    let seen = if seen.is_nan() { up } else { seen };
    1.0 + STRENGTH * (seen.max(0.0) / up - 1.0)
}

/// Returns a colour in light: darker, or closer to white.
pub(super) fn lit(colour: [f64; 3], brightness: f64) -> [f64; 3] {
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
        assert!((brightness([0.0, 0.0]) - 1.0).abs() < 1e-12);
        assert!(brightness([0.5, -0.5]) > 1.1 && brightness([-0.5, 0.5]) < 0.8);
    }
}
