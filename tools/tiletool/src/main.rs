//! The command line tool of delaunay-tiles.

use std::process::ExitCode;

use tiletool::Ending;

/// The global allocator. A failed allocation ends the tool with an error.
#[global_allocator]
static ALLOCATOR: Ending = Ending;

fn main() -> ExitCode {
    tiletool::tiletool(std::env::args_os()).into()
}
