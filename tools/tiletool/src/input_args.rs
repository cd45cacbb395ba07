//! The options for reading points, shared by `build` and `verify --against`.

use clap::Args;
use delaunay_tiles::input::{Columns, Format, InputOptions, MissingZ, Returns};

/// Options for reading the input.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Input options")]
pub struct InputArgs {
    /// Format of all inputs: text, f64, node, poly, geojson, las, ply, obj or parquet [default: by file name]
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<Format>,
    /// For text: columns of the coordinates, by name or by number from 1
    #[arg(long, value_name = "X,Y[,Z]")]
    pub columns: Option<Columns>,
    /// For raw f64: numbers per point
    #[arg(long, value_name = "2|3", default_value_t = 2, value_parser = clap::value_parser!(u8).range(2..=3))]
    pub dims: u8,
    /// For LAS: keep only points of these classes; 2 is ground
    #[arg(long = "class", value_name = "CLASS", value_delimiter = ',')]
    pub classes: Vec<u8>,
    /// For LAS: keep only these returns: first, last or all
    #[arg(long, value_name = "first|last|all", default_value_t = Returns::All)]
    pub returns: Returns,
    /// Skip and count invalid records; without this option, the first one is an error
    #[arg(long)]
    pub skip_invalid: bool,
}

impl InputArgs {
    /// Returns the options for the library.
    pub fn options(&self) -> InputOptions {
        InputOptions::default()
            .format(self.format)
            .columns(self.columns.clone())
            .dims(self.dims)
            .classes(self.classes.clone())
            .returns(self.returns)
            .skip_invalid(self.skip_invalid)
            // A build overrides this. A comparison of a file with its input does not require z.
            .missing_z(MissingZ::Zero)
    }
}
