//! The files of an export, under temporary names until all are complete; or standard output.

#[cfg(feature = "pmtiles")]
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

#[cfg(feature = "pmtiles")]
use anyhow::bail;
use anyhow::{Context, ensure};

use crate::common;
use crate::output::{StandardOutput, StreamOutput};

/// The outputs of an export.
pub struct Targets {
    names: Vec<PathBuf>,
    /// Empty for standard output.
    files: Vec<StreamOutput>,
    is_stdout: bool,
    /// What is written, for errors of standard output.
    what: &'static str,
}

impl Targets {
    /// Opens outputs for `what` with these names; a single `-` is standard output.
    ///
    /// # Errors
    /// Fails if an output is the tile file `input`, or cannot be created.
    pub fn create(what: &'static str, names: Vec<PathBuf>, input: &Path) -> anyhow::Result<Self> {
        let is_stdout = matches!(&names[..], [name] if name == Path::new("-"));
        let files = match is_stdout {
            true => Vec::new(),
            false => names
                .iter()
                .map(|name| create(name, input))
                .collect::<anyhow::Result<_>>()?,
        };
        Ok(Self {
            names,
            files,
            is_stdout,
            what,
        })
    }

    /// Returns what to write to, in the order of the names.
    pub fn writers(&mut self) -> anyhow::Result<Vec<Box<dyn Write + Send>>> {
        if self.is_stdout {
            return Ok(vec![Box::new(StandardOutput::of(self.what))]);
        }
        let writer = |(file, name): (&mut StreamOutput, &PathBuf)| {
            let copy = file.file().try_clone();
            let copy = copy.with_context(|| common::shown(name))?;
            Ok::<Box<dyn Write + Send>, anyhow::Error>(Box::new(copy))
        };
        self.files.iter_mut().zip(&self.names).map(writer).collect()
    }

    /// Returns the only file, to be written in any order.
    #[cfg(feature = "pmtiles")]
    pub fn file(&mut self) -> anyhow::Result<File> {
        let [file] = &mut self.files[..] else {
            bail!("the output must be one file");
        };
        file.file().try_clone().with_context(|| joined(&self.names))
    }

    /// Returns the result of writing, with the names of the files if it failed. Errors of standard
    /// output say so themselves.
    pub fn explained<T, E>(&self, result: Result<T, E>) -> anyhow::Result<T>
    where
        Result<T, E>: Context<T, E>,
        E: Into<anyhow::Error>,
    {
        match self.is_stdout {
            true => result.map_err(Into::into),
            false => result.with_context(|| self.joined()),
        }
    }

    /// Gives the complete files their names. Returns the names as texts.
    ///
    /// # Errors
    /// Fails if a file cannot be written to the disk or renamed.
    pub async fn publish(self) -> anyhow::Result<Vec<String>> {
        let Self { names, files, .. } = self;
        let shown: Vec<String> = names.iter().map(|name| name.display().to_string()).collect();
        // All files are on the disk before the first one gets its name. This runs on another thread,
        // because an interrupt must not wait for it.
        let finish = move || {
            files.iter().try_for_each(StreamOutput::sync)?;
            Ok(files.into_iter().try_for_each(StreamOutput::publish)?)
        };
        let finished = common::on_thread("finishing", finish).await;
        finished.with_context(|| format!("cannot write {}", joined(&names)))?;
        Ok(shown)
    }

    fn joined(&self) -> String {
        joined(&self.names)
    }
}

fn joined(names: &[PathBuf]) -> String {
    let shown: Vec<_> = names.iter().map(|name| common::shown(name)).collect();
    shown.join(", ")
}

/// Opens an output.
fn create(name: &Path, input: &Path) -> anyhow::Result<StreamOutput> {
    let shown = common::shown(name);
    let is_input = name
        .canonicalize()
        .is_ok_and(|name| input.canonicalize().is_ok_and(|input| input == name));
    ensure!(!is_input, "{shown} is the tile file itself; choose another output");
    StreamOutput::create(name).with_context(|| format!("cannot create {shown}"))
}
