//! The command line of delaunay-tiles.
use clap::Parser;

mod generate;

#[derive(Parser)]
enum Cli {
    Generate(generate::GenerateArgs),
}

fn main() -> anyhow::Result<()> {
    match Cli::parse() {
        Cli::Generate(args) => generate::run(args),
    }
}
