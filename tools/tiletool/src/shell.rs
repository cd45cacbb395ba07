//! What a shell knows of the tool: `tiletool completions` and `tiletool man`.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, Command, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man;

use crate::{Cli, common, output};

/// Print a script by which a shell completes commands and options
///
/// The script belongs where the shell looks for such scripts, or is read when the shell starts.
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Examples:
  tiletool completions bash > ~/.local/share/bash-completion/completions/tiletool
  tiletool completions zsh > ~/.zfunc/_tiletool
  tiletool completions fish > ~/.config/fish/completions/tiletool.fish")]
pub struct CompletionsArgs {
    /// Shell to write for
    shell: Shell,
}

/// Write manual pages: one of the tool, and one of each command
///
/// The page of `tiletool build` is tiletool-build.1. Pages that exist are replaced.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example:
  tiletool man -o ~/.local/share/man/man1 && man tiletool-build")]
pub struct ManArgs {
    /// Folder to write to, which must exist
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
}

/// Prints a script for a shell.
pub fn complete(args: &CompletionsArgs) -> anyhow::Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "tiletool", &mut script);
    common::print_bytes("the script", &script)
}

/// Writes the manual pages.
pub fn describe(args: &ManArgs) -> anyhow::Result<()> {
    let mut tool = Cli::command().disable_help_subcommand(true);
    tool.build();
    write_pages(&tool, &args.output)
}

/// Writes the page of a command, and those of its own commands.
fn write_pages(command: &Command, folder: &Path) -> anyhow::Result<()> {
    let man = Man::new(command.clone());
    let mut page = Vec::new();
    man.render(&mut page)?;
    let file = folder.join(man.get_filename());
    output::write(&file, &page).with_context(|| common::shown(&file))?;
    command
        .get_subcommands()
        .try_for_each(|command| write_pages(command, folder))
}
