//! The commands that change an existing tile file: points with `points`, lines with `constrain` and
//! `unconstrain`.
//!
//! In: a file and files of changes. Out: the file in its next state, or as it was; and a summary.

pub mod checkpoint;
pub mod constrain;
pub mod points;
mod report;
pub mod unconstrain;

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use delaunay_tiles::{EditError, EditOptions, EditSummary, Editor, OpenOptions, Transaction};

use crate::allocator;
use crate::common::{self, MemoryArgs};

/// What all commands that change a file have in common.
#[derive(Args, Clone, Debug)]
pub struct EditArgs {
    /// Tile file to change
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Do all the work, and report it, but leave the file as it is
    #[arg(long)]
    dry_run: bool,
    /// Print the summary as one JSON object
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    memory: MemoryArgs,
}

impl EditArgs {
    /// Opens the file to change it.
    async fn open(&self) -> anyhow::Result<Transaction> {
        // Lists of tiles grow in small steps and would leave free gaps of their sizes in the heap. So
        // as many allocations as possible are mappings of their own.
        allocator::keep_to(0);
        let mut transaction = Editor::open(&self.file, EditOptions::default().memory(self.memory.bytes()))
            .await?
            .begin()
            .await?;
        transaction.dry_run(self.dry_run);
        Ok(transaction)
    }

    /// Makes all changes. `name_in` adds names of the input to an error.
    async fn finish(
        &self,
        transaction: Transaction,
        name_in: impl FnOnce(EditError) -> anyhow::Error,
    ) -> anyhow::Result<EditSummary> {
        let unchanged = || format!("{} was not changed", common::shown(&self.file));
        let edited = tokio::select! {
            edited = transaction.commit() => edited,
            () = common::interrupted() => Err(EditError::Cancelled),
        };
        match edited {
            Err(EditError::Cancelled) => anyhow::bail!("interrupted; {}", unchanged()),
            edited => edited.map_err(name_in).with_context(unchanged),
        }
    }

    /// Prints the summary, and the notes on the input.
    fn report(&self, summary: &EditSummary, mut notes: Vec<String>) -> anyhow::Result<()> {
        // The changes are in the file, whether this can be found out or not.
        if !self.dry_run && common::block_on(has_stale_overviews(&self.file)).unwrap_or(false) {
            let file = common::shown(&self.file);
            notes.push(format!(
                "the overviews of the file are stale now; renew them with `tiletool overviews {file}`"
            ));
        }
        notes.iter().for_each(common::note);
        if self.json {
            return common::print_json("the summary", &report::EditReport::of(summary, self.dry_run, notes));
        }
        common::print_summary("the summary", &report::text(&self.file, summary, self.dry_run))
    }
}

async fn has_stale_overviews(file: &Path) -> anyhow::Result<bool> {
    let reader = common::open(file, OpenOptions::default()).await?;
    Ok(!reader.stale_overviews().is_empty())
}

/// Adds the names of lines to an error.
fn line_error(error: EditError, name: impl Fn(u64) -> String) -> anyhow::Error {
    let named = match &error {
        EditError::OpenRing { line } | EditError::NoZ { line, .. } => Some(name(*line)),
        EditError::Inverted(inverted) => Some(name(inverted.first.obstacle)),
        EditError::Overlapping(overlapping) => Some(name(overlapping.obstacle)),
        EditError::Crossed { line, other, .. } => {
            let other = other.map(|other| format!(" and {}", name(other.number())));
            Some(name(line.number()) + &other.unwrap_or_default())
        }
        _ => None,
    };
    let error = anyhow::Error::new(error);
    match named {
        None => error,
        Some(named) => error.context(named),
    }
}
