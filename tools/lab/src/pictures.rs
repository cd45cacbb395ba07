//! The format of pictures, and how a page shows them.

use clap::{Args, ValueEnum};

use crate::folder::Folder;

/// The options for pictures.
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
    /// Keeps a picture in a file whose name begins with `stem`. Returns the Markdown that shows it.
    pub fn keep(self, stem: &str, title: &str, svg: String, folder: &mut Folder) -> anyhow::Result<String> {
        let suffix = match self.pictures {
            Format::Svg => "svg",
            Format::Png => "png",
        };
        let name = format!("{stem}.{suffix}");
        folder.keep_picture(&name, svg)?;
        Ok(format!("\n![{title}]({name})\n"))
    }
}
