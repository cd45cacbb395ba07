//! Round coordinates along a side of the frame.

/// The coordinates along one axis, and their offsets.
#[derive(Default)]
pub struct Axis {
    /// Each tick: the pixels from the middle of the frame, in the direction of the axis, and the
    /// coordinate.
    pub ticks: Vec<(f64, String)>,
}

/// Font size of the coordinates beside the frame.
pub const TICK_TEXT: f64 = 15.0;
/// Minimum number of pixels between two coordinates.
const MIN_SPACING: f64 = 130.0;
/// Maximum number of coordinates along an axis.
const MAX_TICKS: u32 = 40;

impl Axis {
    /// Creates an axis of `pixels` pixels around the coordinate `middle`. `room` returns the pixels
    /// that a label needs along the axis.
    pub fn new(middle: f64, scale: f64, pixels: f64, room: fn(&str) -> f64) -> Self {
        let mut spacing = MIN_SPACING;
        loop {
            let axis = Self::every(middle, scale, pixels, spacing);
            let widest = axis.ticks.iter().map(|(_, label)| room(label)).fold(0.0, f64::max);
            if widest <= spacing || spacing > pixels {
                return axis;
            }
            spacing *= 1.5;
        }
    }

    fn every(middle: f64, scale: f64, pixels: f64, spacing: f64) -> Self {
        let step = round_above(spacing / scale);
        let half = pixels / 2.0 / scale;
        let first = ((middle - half) / step).ceil();
        let mut ticks: Vec<(f64, String)> = Vec::new();
        for k in 0..MAX_TICKS {
            let multiple = first + f64::from(k);
            let value = multiple * step;
            let offset = (value - middle) * scale;
            if offset > pixels / 2.0 {
                break;
            }
            // More than 2⁵³ steps away from zero, several coordinates are equal.
            let moved = ticks.last().is_none_or(|(before, _)| offset - before > spacing / 2.0);
            if moved && offset.is_finite() && offset >= -pixels / 2.0 {
                ticks.push((offset, label(value, step, middle.abs() + half)));
            }
        }
        Self { ticks }
    }

    /// Returns the pixels of the widest label.
    pub fn widest(&self) -> f64 {
        let widths = self.ticks.iter().map(|(_, label)| text_width(label, TICK_TEXT));
        widths.fold(0.0, f64::max)
    }
}

/// Returns the smallest number that is 1, 2 or 5 times a power of ten and at least `least`.
pub fn round_above(least: f64) -> f64 {
    let power = 10f64.powi(least.log10().floor() as i32);
    let steps = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * power);
    steps.into_iter().find(|&step| step >= least).unwrap_or(10.0 * power)
}

/// Formats a coordinate with the digits that `step` needs. `largest` decides whether the labels of
/// an axis have exponents.
pub fn label(value: f64, step: f64, largest: f64) -> String {
    let (digit, top) = (step.log10().floor() as i32, largest.log10().floor() as i32);
    let text = if value == 0.0 {
        "0".to_owned()
    } else if (-4..9).contains(&top) || (9..16).contains(&top) && digit > -4 && digit < 6 {
        grouped(&format!("{value:.*}", (-digit).clamp(0, 16) as usize))
    } else {
        let decimals = (value.abs().log10().floor() as i32 - digit).clamp(0, 16) as usize;
        format!("{value:.decimals$e}")
    };
    text.replace('-', "\u{2212}")
}

/// Groups the digits before the decimal point in threes, if there are five or more.
fn grouped(number: &str) -> String {
    let (whole, rest) = number.split_at(number.find('.').unwrap_or(number.len()));
    let digits = whole.trim_start_matches('-').len();
    let mut text = String::new();
    for (index, c) in whole.chars().rev().enumerate() {
        if digits > 4 && index > 0 && index % 3 == 0 && c != '-' {
            text.push('\u{a0}');
        }
        text.push(c);
    }
    text.chars().rev().chain(rest.chars()).collect()
}

/// Returns the approximate width in pixels of a text in DejaVu Sans.
pub fn text_width(text: &str, size: f64) -> f64 {
    let ems = text.chars().map(|c| match c {
        ' ' | '\u{a0}' | '.' | ',' | ':' | 'i' | 'l' | 'j' | 'I' => 0.31,
        't' | 'r' | 'f' | '-' | '(' | ')' => 0.39,
        'm' | 'w' | 'M' | 'W' | '…' => 0.95,
        '\u{2212}' => 0.84,
        'A'..='Z' => 0.69,
        _ => 0.63,
    });
    size * ems.sum::<f64>()
}

/// Returns `size`, or a smaller font size if the text would be wider than `pixels`.
pub fn fitted_text(text: &str, size: f64, pixels: f64) -> f64 {
    let width = text_width(text, size);
    if width > pixels { size * pixels / width } else { size }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(min: f64, max: f64) -> Vec<String> {
        let axis = Axis::new((min + max) / 2.0, 1000.0 / (max - min), 1000.0, |_| 40.0);
        axis.ticks.into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn an_axis_has_few_and_round_coordinates() {
        assert_eq!(labels(0.0, 1.0), ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(
            labels(-6.0, 6.0),
            ["\u{2212}6", "\u{2212}4", "\u{2212}2", "0", "2", "4", "6"]
        );
        assert_eq!(labels(636_010.0, 636_890.0)[0], "636\u{a0}200");
        assert_eq!(labels(-1e30, 1e30)[..2], ["\u{2212}1.0e30", "\u{2212}5e29"]);
        assert_eq!(labels(0.0, 1e-30)[..2], ["0", "2e\u{2212}31"]);
        assert_eq!(labels(1e15, 1e15 + 1.0).len(), 6);
        assert!(labels(1e300, 1e300 * (1.0 + 1e-15)).len() <= 7);
    }
}
