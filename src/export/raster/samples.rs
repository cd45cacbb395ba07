//! The formats of rasters, and the numbers in them.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use crate::terrain::Measure;

/// A format of rasters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RasterFormat {
    /// GeoTIFF: tiled, compressed, with its header before its data. Needs the feature `geotiff`.
    GeoTiff,
    /// Esri's ASCII grid.
    Asc,
}

/// The error of a name that no format of rasters has.
#[derive(Clone, Debug, thiserror::Error)]
#[error("formats of rasters are tif and asc, and not '{0}'")]
pub struct UnknownRasterFormat(String);

impl RasterFormat {
    /// Returns the format that a file's suffix indicates, if it is one of a raster.
    #[must_use]
    pub fn from_path(path: &Path) -> Option<Self> {
        let suffix = path.extension()?.to_str()?;
        suffix.to_ascii_lowercase().parse().ok()
    }

    /// Returns the suffix of the format.
    #[must_use]
    pub fn suffix(self) -> &'static str {
        match self {
            Self::GeoTiff => "tif",
            Self::Asc => "asc",
        }
    }
}

impl FromStr for RasterFormat {
    type Err = UnknownRasterFormat;

    fn from_str(name: &str) -> Result<Self, UnknownRasterFormat> {
        match name {
            "tif" | "tiff" | "geotiff" => Ok(Self::GeoTiff),
            "asc" => Ok(Self::Asc),
            _ => Err(UnknownRasterFormat(name.to_owned())),
        }
    }
}

impl fmt::Display for RasterFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.suffix())
    }
}

/// The numbers in which a raster is stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Samples {
    /// As computed: 64 bits.
    #[default]
    Float64,
    /// Rounded to 32 bits.
    Float32,
    /// Rounded to whole numbers from 0 to 255: the numbers of hillshades.
    Byte,
}

impl Samples {
    /// Returns the numbers in which a measure is stored: bytes for shades, otherwise `floats`.
    pub(super) fn of(measure: Measure, floats: Self) -> Self {
        match measure {
            Measure::Hillshade(_) => Self::Byte,
            _ => floats,
        }
    }

    /// Returns the number that means that there is no value.
    pub(super) fn no_data(self) -> f64 {
        match self {
            Self::Float64 | Self::Float32 => -9999.0,
            Self::Byte => 0.0,
        }
    }

    /// Returns the number that is stored for a value, which is NaN if there is none. A value that
    /// would mean that there is none becomes the next larger number.
    #[inline]
    pub(super) fn stored(self, value: f64) -> f64 {
        let no_data = self.no_data();
        if value.is_nan() {
            return no_data;
        }
        match self {
            Self::Float64 if value == no_data => no_data.next_up(),
            Self::Float64 => value,
            Self::Float32 => match value as f32 {
                rounded if f64::from(rounded) == no_data => f64::from(rounded.next_up()),
                rounded => f64::from(rounded),
            },
            // Halves go up, as in GDAL.
            Self::Byte => (value + 0.5).floor().clamp(1.0, 255.0),
        }
    }

    /// Returns the number of bytes of a sample.
    #[cfg(feature = "geotiff")]
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::Float64 => 8,
            Self::Float32 => 4,
            Self::Byte => 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_missing_values_are_stored_as_missing() {
        for samples in [Samples::Float64, Samples::Float32, Samples::Byte] {
            assert_eq!(samples.stored(f64::NAN), samples.no_data());
            for value in [-9999.0, (-9999.0f64).next_up(), 0.0, 0.4, 1.0, 254.6, 255.0, -1e300] {
                assert_ne!(samples.stored(value), samples.no_data(), "{samples:?} {value}");
            }
        }
        assert_eq!(Samples::Float64.stored(0.1), 0.1);
        assert_eq!(Samples::Float32.stored(0.1), f64::from(0.1f32));
        assert_eq!(Samples::Byte.stored(181.5), 182.0);
    }
}
