//! The options of commands that draw maps, besides `--plot` itself.

use clap::Args;
use clap::builder::NonEmptyStringValueParser;

use super::file::PlotFile;

#[derive(Args, Clone, Debug)]
pub struct TitleArgs {
    /// Text above the map, in place of the file's name, which then precedes the line below it
    #[arg(long, value_name = "TEXT", requires = "plot", value_parser = NonEmptyStringValueParser::new())]
    title: Option<String>,
}

impl TitleArgs {
    /// Returns a file of a picture with this title.
    pub fn of(&self, file: &PlotFile) -> PlotFile {
        file.clone().titled(self.title.clone())
    }
}
