//! What a build does with lines, and with what has no z.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{ArgAction, Args};
use delaunay_tiles::{Crossings, MissingZ, Steiner};

/// What to do with what has no z.
#[derive(Args, Clone, Copy, Debug)]
pub struct MissingZArgs {
    /// What to do with points, ends of lines, crossing points and sites that have no z where other
    /// vertices have, and do not lie where one of those lies: error names the first; zero gives
    /// them z = 0
    #[arg(
        long,
        value_name = "error|zero",
        default_value = "error",
        hide_possible_values = true,
        value_parser = choice([("error", MissingZ::Error), ("zero", MissingZ::Zero)]),
        help_heading = "Lines and sites"
    )]
    missing_z: MissingZ,
}

impl MissingZArgs {
    /// The library's option.
    pub fn option(self) -> MissingZ {
        self.missing_z
    }
}

/// What a build does with lines.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Lines and sites")]
pub struct LineRules {
    /// What to do with lines that cross: error names the first ten pairs; split makes vertices of their crossing points
    #[arg(
        long,
        value_name = "error|split",
        default_value = "error",
        hide_possible_values = true,
        value_parser = choice([("error", Crossings::Error), ("split", Crossings::Split)])
    )]
    pub crossings: Crossings,
    /// Whether vertices are added where lines cross the borders of the cells that points are spilled to: only this makes the
    /// triangles depend on --memory
    #[arg(
        long,
        value_name = "never|borders",
        default_value = "never",
        hide_possible_values = true,
        value_parser = choice([("never", Steiner::Never), ("borders", Steiner::Borders)])
    )]
    pub steiner: Steiner,
    /// What is outside of all lines, up to the convex hull: kept, or a hole
    #[arg(
        long = "exterior",
        value_name = "keep|hole",
        default_value = "keep",
        hide_possible_values = true,
        action = ArgAction::Set,
        value_parser = choice([("keep", false), ("hole", true)])
    )]
    pub exterior_is_hole: bool,
}

/// Reads one of two words, and gives what it stands for.
fn choice<T: Copy + Send + Sync + 'static>(words: [(&'static str, T); 2]) -> impl TypedValueParser<Value = T> {
    let [(one, its), (other, others)] = words;
    PossibleValuesParser::new([one, other]).map(move |word| if word == one { its } else { others })
}
