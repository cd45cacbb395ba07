//! The options for reading points, shared by `build`, `verify --against` and, in part, `info`.

use std::num::NonZeroU64;

use anyhow::ensure;
use clap::Args;
use delaunay_tiles::geometry::{Point, Rect};
use delaunay_tiles::input::{Columns, Format, InputOptions, MissingZ, Returns};

/// Options that tell how to read a file.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Input options")]
pub struct FormatArgs {
    /// Format of all inputs: text, f64, node, poly, geojson, las, flatgeobuf, shapefile, geopackage,
    /// ply, obj or parquet [default: by file name, otherwise by content]
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<Format>,
    /// For text: columns of the coordinates, by name or by number from 1
    #[arg(long, value_name = "X,Y[,Z]")]
    pub columns: Option<Columns>,
    /// For raw f64: numbers per point
    #[arg(long, value_name = "2|3", default_value_t = 2, value_parser = clap::value_parser!(u8).range(2..=3))]
    pub dims: u8,
}

/// Options for reading the input.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Input options")]
pub struct InputArgs {
    #[command(flatten)]
    pub format: FormatArgs,
    /// For LAS: keep only points of these classes; 2 is ground
    #[arg(long = "class", value_name = "CLASS", value_delimiter = ',')]
    pub classes: Vec<u8>,
    /// For LAS: keep only these returns: first, last or all
    #[arg(long, value_name = "first|last|all", default_value_t = Returns::All)]
    pub returns: Returns,
    /// For LAS: keep points that are marked as withheld
    #[arg(long)]
    pub keep_withheld: bool,
    /// For LAS: drop points that are marked as withheld, which is the default
    #[arg(long, conflicts_with = "keep_withheld")]
    pub drop_withheld: bool,
    /// Keep only points within this rectangle; of COPC, only what meets it is read
    #[arg(long, value_name = "XMIN,YMIN,XMAX,YMAX", allow_hyphen_values = true, value_parser = rect)]
    pub bounds: Option<Rect>,
    /// Keep only each N-th record, counted over all inputs from the first one
    #[arg(long, value_name = "N", default_value_t = NonZeroU64::MIN)]
    pub every: NonZeroU64,
    /// For COPC: keep only points in nodes of the octree up to this level; 0 is the root
    #[arg(long, value_name = "N")]
    pub level: Option<u8>,
    /// For COPC: keep only levels of the octree up to the first at which points are at most this far
    /// apart, in the unit of the coordinates
    #[arg(long, value_name = "DISTANCE", value_parser = distance)]
    pub resolution: Option<f64>,
    /// Skip and count invalid records; without this option, the first one is an error
    #[arg(long)]
    pub skip_invalid: bool,
}

impl FormatArgs {
    /// Returns the options for the library.
    pub fn options(&self) -> InputOptions {
        InputOptions::default()
            .format(self.format)
            .columns(self.columns.clone())
            .dims(self.dims)
    }
}

impl FormatArgs {
    /// Returns the arguments that give these options.
    fn arguments(&self) -> Vec<String> {
        let format = self.format.map(|format| format!("--format={format}"));
        let columns = self.columns.as_ref().map(|columns| format!("--columns={columns}"));
        let dims = format!("--dims={}", self.dims);
        format.into_iter().chain(columns).chain([dims]).collect()
    }
}

impl InputArgs {
    /// Returns the arguments that give these options.
    pub fn arguments(&self) -> Vec<String> {
        let mut arguments = self.format.arguments();
        arguments.extend(self.classes.iter().map(|class| format!("--class={class}")));
        arguments.push(format!("--returns={}", self.returns));
        arguments.push(format!("--every={}", self.every));
        if let Some(rect) = self.bounds {
            let Rect {
                min_x,
                min_y,
                max_x,
                max_y,
            } = rect;
            arguments.push(format!("--bounds={min_x},{min_y},{max_x},{max_y}"));
        }
        arguments.extend(self.level.map(|level| format!("--level={level}")));
        arguments.extend(self.resolution.map(|resolution| format!("--resolution={resolution}")));
        let flags = [
            ("--keep-withheld", self.keep_withheld),
            ("--skip-invalid", self.skip_invalid),
        ];
        arguments.extend(
            flags
                .iter()
                .filter(|(_, is_set)| *is_set)
                .map(|(flag, _)| (*flag).to_owned()),
        );
        arguments
    }

    /// Returns the options for the library.
    pub fn options(&self) -> InputOptions {
        self.format
            .options()
            .classes(self.classes.clone())
            .returns(self.returns)
            .keep_withheld(self.keep_withheld)
            .bounds(self.bounds)
            .every(self.every)
            .copc_level(self.level)
            .copc_resolution(self.resolution)
            .skip_invalid(self.skip_invalid)
            // A build overrides this. A comparison of a file with its input does not require z.
            .missing_z(MissingZ::Zero)
    }
}

/// Parses a rectangle.
pub fn rect(text: &str) -> anyhow::Result<Rect> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    let rect = match numbers.as_deref() {
        Ok(&[min_x, min_y, max_x, max_y]) => Rect::new(min_x, min_y, max_x, max_y),
        _ => Rect::EMPTY,
    };
    let corners = [Point::new(rect.min_x, rect.min_y), Point::new(rect.max_x, rect.max_y)];
    ensure!(
        corners.iter().all(|corner| corner.is_valid()) && !rect.is_empty(),
        "a rectangle is four numbers XMIN,YMIN,XMAX,YMAX, such as 0,0,500.5,400, with the lower ones first"
    );
    Ok(rect)
}

/// Parses a distance above 0.
fn distance(text: &str) -> anyhow::Result<f64> {
    let distance = text.trim().parse().unwrap_or(f64::NAN);
    ensure!(
        distance.is_finite() && distance > 0.0,
        "a distance is a finite number above 0, such as 0.5"
    );
    Ok(distance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    #[command(no_binary_name = true)]
    struct Parsed {
        #[command(flatten)]
        input: InputArgs,
    }

    #[test]
    fn arguments_give_the_options_that_they_come_from() {
        for line in [
            "",
            "--format f64 --dims 3 --every 7 --skip-invalid",
            "--columns lon,lat,5 --bounds=-1.5,2,3e20,0.1e22",
            "--class 2,9 --returns last --keep-withheld --level 3 --resolution 0.1",
        ] {
            let parsed = Parsed::parse_from(line.split_whitespace());
            let again = Parsed::parse_from(parsed.input.arguments());
            assert_eq!(format!("{:?}", again.input), format!("{:?}", parsed.input), "{line}");
        }
    }

    #[test]
    fn rectangles_have_finite_corners_in_order() {
        assert_eq!(rect("-1, 0,2,3.5").unwrap(), Rect::new(-1.0, 0.0, 2.0, 3.5));
        assert_eq!(rect("1,1,1,1").unwrap(), Rect::new(1.0, 1.0, 1.0, 1.0));
        for wrong in ["", "1,2,3", "1,2,3,4,5", "a,b,c,d", "0,0,inf,1", "0,NaN,1,1", "1,0,0,1"] {
            assert!(rect(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn distances_are_finite_and_above_0() {
        assert_eq!(distance(" 0.5").unwrap(), 0.5);
        for wrong in ["", "0", "-1", "inf", "NaN", "1e999", "1m"] {
            assert!(distance(wrong).is_err(), "{wrong}");
        }
    }
}
