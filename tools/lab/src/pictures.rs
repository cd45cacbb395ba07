//! In which format pictures are written.

use clap::{Args, ValueEnum};

/// How pictures are written.
#[derive(Args, Clone, Copy, Debug)]
pub struct Pictures {
    /// The format of the pictures
    #[arg(long, value_name = "svg|png", default_value = "svg")]
    pictures: Format,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Format {
    Svg,
    Png,
}

impl Pictures {
    /// The name of a picture's file.
    pub fn name(self, stem: &str) -> String {
        let suffix = match self.pictures {
            Format::Svg => "svg",
            Format::Png => "png",
        };
        format!("{stem}.{suffix}")
    }
}
