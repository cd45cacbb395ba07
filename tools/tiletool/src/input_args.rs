//! The options that say how to read points: the same for `build` and for `verify --against`.

use clap::Args;
use delaunay_tiles::input::{Columns, Format, InputOptions, MissingZ, Returns};

/// How to read the input.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Input options")]
pub struct InputArgs {
    /// The format of all inputs, where their names do not tell: text, f64, node, poly, geojson, las
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<Format>,
    /// Text: the columns of the coordinates, by name or by number from 1
    #[arg(long, value_name = "X,Y[,Z]")]
    pub columns: Option<Columns>,
    /// Raw f64: numbers per point
    #[arg(long, value_name = "2|3", default_value_t = 2, value_parser = clap::value_parser!(u8).range(2..=3))]
    pub dims: u8,
    /// LAS: keep these classes only (2 is ground)
    #[arg(long = "class", value_name = "CLASS", value_delimiter = ',')]
    pub classes: Vec<u8>,
    /// LAS: keep these returns only: first, last, all
    #[arg(long, value_name = "RETURNS", default_value_t = Returns::All)]
    pub returns: Returns,
    /// Count records that are broken, and go on, where otherwise the first one is an error
    #[arg(long)]
    pub skip_invalid: bool,
}

impl InputArgs {
    /// The library's options.
    pub fn options(&self) -> InputOptions {
        InputOptions::default()
            .format(self.format)
            .columns(self.columns.clone())
            .dims(self.dims)
            .classes(self.classes.clone())
            .returns(self.returns)
            .skip_invalid(self.skip_invalid)
            // A build may say otherwise; who compares a file with its input asks no more of it.
            .missing_z(MissingZ::Zero)
    }
}
