//! Options for the treatment of lines, and of vertices without z.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{ArgAction, Args};
use delaunay_tiles::{Crossings, MissingZ, Steiner};

/// The treatment of vertices without z.
#[derive(Args, Clone, Copy, Debug)]
pub struct MissingZArgs {
    /// How to treat vertices without z where other vertices have z: drape, error or zero
    ///
    /// This concerns ends of lines, crossing points and sites without z, unless a vertex with z is at
    /// the same position. 'drape' lays them on the surface: in a build on the triangulation of the
    /// points, in an edit on that of the file. Outside the hull they get the z of its nearest point.
    /// 'error' names the first one. 'zero' gives them z = 0. Points without z are an error unless
    /// 'zero' is given.
    #[arg(
        long,
        value_name = "drape|error|zero",
        default_value = "drape",
        hide_possible_values = true,
        value_parser = choice([
            ("drape", MissingZ::Drape),
            ("error", MissingZ::Error),
            ("zero", MissingZ::Zero),
        ]),
        help_heading = "Lines and sites"
    )]
    missing_z: MissingZ,
}

impl From<MissingZ> for MissingZArgs {
    fn from(missing_z: MissingZ) -> Self {
        Self { missing_z }
    }
}

impl MissingZArgs {
    /// Returns the argument that gives this option.
    pub fn arguments(self) -> Option<String> {
        let name = match self.missing_z {
            MissingZ::Drape => "drape",
            MissingZ::Error => "error",
            MissingZ::Zero => "zero",
            _ => return None,
        };
        Some(format!("--missing-z={name}"))
    }

    /// Returns the option for the library.
    pub fn option(self) -> MissingZ {
        self.missing_z
    }
}

/// The treatment of lines by a build.
#[derive(Args, Clone, Debug)]
pub struct LineRules {
    /// How to treat lines that cross: error or split
    ///
    /// 'error' names the first ten pairs. 'split' makes a vertex of each crossing point.
    #[arg(
        long,
        value_name = "error|split",
        help_heading = "Lines and sites",
        default_value = "error",
        hide_possible_values = true,
        value_parser = choice([("error", Crossings::Error), ("split", Crossings::Split)])
    )]
    pub crossings: Crossings,
    /// Whether to add vertices on lines: never or borders
    ///
    /// 'borders' adds a vertex where a line crosses a border of the cells that points are spilled
    /// to. Only this option makes the triangles depend on --memory.
    #[arg(
        long,
        value_name = "never|borders",
        help_heading = "Lines and sites",
        default_value = "never",
        hide_possible_values = true,
        value_parser = choice([("never", Steiner::Never), ("borders", Steiner::Borders)])
    )]
    pub steiner: Steiner,
    /// Whether to keep the area outside all lines, up to the convex hull, or to make it a hole
    #[arg(
        long = "exterior",
        value_name = "keep|hole",
        help_heading = "Lines and sites",
        default_value = "keep",
        hide_possible_values = true,
        action = ArgAction::Set,
        value_parser = choice([("keep", false), ("hole", true)])
    )]
    pub exterior_is_hole: bool,
}

/// Returns a parser of one of some words, which gives the value of the word.
fn choice<T: Copy + Send + Sync + 'static, const N: usize>(
    words: [(&'static str, T); N],
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(words.map(|(word, _)| word)).try_map(move |given| {
        let found = words.iter().find(|(word, _)| *word == given);
        found.map(|(_, value)| *value).ok_or("unknown word")
    })
}
