//! The layout of a point's record, and the selection of points.

use crate::input::formats::las::problem::Problem;
use crate::input::options::{InputOptions, Returns};
use ::las::raw::header::Header;

/// The length limit of a point record. Format 10 has 67 bytes; the rest are extra bytes, and LAZ
/// keeps about 10 KiB of models for each of them.
const LONGEST_RECORD: usize = 4096;

/// The layout of a record.
#[derive(Clone, Copy)]
pub struct Layout {
    /// The length of a record in bytes.
    pub length: usize,
    /// Whether the format is 6 or higher.
    pub extended: bool,
    pub scale: [f64; 3],
    pub offset: [f64; 3],
}

/// The selection of points to keep.
#[derive(Clone, Copy)]
pub struct Keep {
    classes: [bool; 256],
    returns: Returns,
    withheld: bool,
}

impl Layout {
    /// Returns the layout, and whether the points are compressed.
    pub fn new(header: &Header) -> Result<(Self, bool), Problem> {
        check_version(header)?;
        // LAZ sets the highest bit. As in the crate `las`, the next bit is ignored.
        let compressed = header.point_data_record_format & 0x80 != 0;
        let number = header.point_data_record_format & 0x3f;
        let format = match ::las::point::Format::new(number) {
            Ok(format) if number <= 10 => format,
            _ => {
                return Err(Problem::damaged(format!("point format {number}; 10 is the highest")));
            }
        };
        let length = usize::from(header.point_data_record_length);
        if length < usize::from(format.len()) || length > LONGEST_RECORD {
            return Err(Problem::damaged(format!(
                "point records of {length} bytes; format {number} needs at least {}, and {LONGEST_RECORD} is the limit",
                format.len()
            )));
        }
        let layout = Self {
            length,
            extended: number >= 6,
            scale: [header.x_scale_factor, header.y_scale_factor, header.z_scale_factor],
            offset: [header.x_offset, header.y_offset, header.z_offset],
        };
        layout.check_scale()?;
        Ok((layout, compressed))
    }

    fn check_scale(&self) -> Result<(), Problem> {
        if self.scale.iter().chain(&self.offset).any(|v| !v.is_finite()) {
            return Err(Problem::damaged(
                "the scale or the offset of the coordinates is not finite",
            ));
        }
        match self.scale.iter().zip(["x", "y", "z"]).find(|(scale, _)| **scale == 0.0) {
            Some((_, name)) => Err(Problem::damaged(format!(
                "the scale of {name} is 0, so that all points have the same {name}"
            ))),
            None => Ok(()),
        }
    }

    #[inline]
    pub fn coordinate(&self, record: &[u8], axis: usize) -> f64 {
        let bytes = [0, 1, 2, 3].map(|n| record[4 * axis + n]);
        self.scale[axis] * f64::from(i32::from_le_bytes(bytes)) + self.offset[axis]
    }

    /// Returns the class, the number of the return, and the number of returns of its pulse.
    #[inline]
    pub fn class_and_return(&self, record: &[u8]) -> (u8, u8, u8) {
        if self.extended {
            (record[16], record[14] & 15, record[14] >> 4)
        } else {
            (record[15] & 0x1f, record[14] & 7, (record[14] >> 3) & 7)
        }
    }

    /// Returns the distance between neighbouring coordinates.
    pub fn step(&self, axis: usize) -> f64 {
        self.scale[axis].abs()
    }

    #[inline]
    pub fn is_withheld(&self, record: &[u8]) -> bool {
        record[15] & (if self.extended { 0x04 } else { 0x80 }) != 0
    }
}

impl Keep {
    pub fn new(options: &InputOptions) -> Self {
        let is_chosen = |class| options.classes.iter().any(|&chosen| usize::from(chosen) == class);
        Self {
            classes: std::array::from_fn(|class| options.classes.is_empty() || is_chosen(class)),
            returns: options.returns,
            withheld: options.keep_withheld,
        }
    }

    /// Returns whether a record is left out because it is marked as withheld.
    #[inline]
    pub fn drops_withheld(&self, record: &[u8], layout: &Layout) -> bool {
        !self.withheld && layout.is_withheld(record)
    }

    #[inline]
    pub fn keeps(&self, record: &[u8], layout: &Layout) -> bool {
        let (class, number, of) = layout.class_and_return(record);
        let returns = match self.returns {
            Returns::First => number == 1,
            Returns::Last => number == of,
            Returns::All => true,
        };
        returns && self.classes[usize::from(class)]
    }
}

/// Checks that the version of the header is supported and that the header is long enough for it.
fn check_version(header: &Header) -> Result<(), Problem> {
    let version = header.version;
    if version.major != 1 || version.minor > 4 {
        return Err(Problem {
            hint: "versions 1.0 to 1.4 are read",
            ..Problem::damaged(format!("this is LAS version {version}"))
        });
    }
    let least = match version.minor {
        0..=2 => 227,
        3 => 235,
        _ => 375,
    };
    if header.header_size < least {
        let size = header.header_size;
        return Err(Problem::damaged(format!(
            "a header of {size} bytes; it needs at least {least}"
        )));
    }
    Ok(())
}
