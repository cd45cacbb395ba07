//! Numbers for people, with the units of distances and areas.

use delaunay_tiles::crs::Crs;
pub use delaunay_tiles::crs::Unit;

/// Returns the unit of the coordinates in a system.
pub fn unit(crs: Option<&Crs>) -> Unit {
    crs.map_or(Unit::Unknown, Crs::unit)
}

/// Distances and areas in a unit.
pub trait Measure {
    /// Formats a distance with its unit.
    fn distance(self, distance: f64) -> String;
    /// Formats an area with its unit.
    fn area(self, area: f64) -> String;
    /// Returns what the reader of a distance in this unit must know.
    fn warning(self) -> Option<&'static str>;
}

impl Measure for Unit {
    fn distance(self, distance: f64) -> String {
        let number = number(distance);
        let name = match (self, &*number) {
            (Self::Degree, "1") => "degree",
            (Self::Unknown, "1") => "coordinate unit",
            _ => self.name(),
        };
        format!("{number} {name}")
    }

    fn area(self, area: f64) -> String {
        match self {
            Self::Degree | Self::Unknown => format!("{} square {}", number(area), self.name()),
            _ => format!("{} {}²", number(area), self.name()),
        }
    }

    fn warning(self) -> Option<&'static str> {
        match self {
            Self::Degree => {
                Some("the coordinates are degrees, so distances are in degrees, not metres; project the data first")
            }
            _ => None,
        }
    }
}

/// Formats a number for people: six significant digits, all digits before the point, and no
/// trailing zeros. Very small and very large numbers have an exponent.
pub fn number(v: f64) -> String {
    let magnitude = v.abs();
    if magnitude == 0.0 {
        return "0".to_owned();
    } else if !v.is_finite() {
        return v.to_string();
    }
    if !(1e-5..1e15).contains(&magnitude) {
        let text = format!("{v:.5e}");
        let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{}e{exponent}", without_zeros(digits));
    }
    let decimals = (5 - magnitude.log10().floor() as i32).clamp(0, 10) as usize;
    without_zeros(&format!("{v:.decimals$}")).to_owned()
}

/// Returns a decimal number without zeros at its end.
fn without_zeros(text: &str) -> &str {
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_six_significant_digits() {
        for (v, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (8.0, "8"),
            (-1.5, "-1.5"),
            (2f64.sqrt(), "1.41421"),
            (0.1 + 0.2, "0.3"),
            (9.999_999_9, "10"),
            (1_234.567_89, "1234.57"),
            (1_234_567.89, "1234568"),
            (0.000_012_345_678, "0.0000123457"),
            (1e-7, "1e-7"),
            (1.234_567_8e-7, "1.23457e-7"),
            (1e20, "1e20"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(number(v), text);
        }
    }

    #[test]
    fn distances_and_areas_name_their_units() {
        assert_eq!(Unit::Metre.distance(12.5), "12.5 m");
        assert_eq!(Unit::Metre.area(12.5), "12.5 m²");
        assert_eq!(Unit::Degree.distance(1.0), "1 degree");
        assert_eq!(Unit::Unknown.distance(0.5), "0.5 coordinate units");
        assert_eq!(Unit::Unknown.area(2.0), "2 square coordinate units");
        assert!(Unit::Degree.warning().is_some() && Unit::Metre.warning().is_none());
    }
}
