//! Errors of the library as Python exceptions, with the library's words.

use std::error::Error;
use std::io;
use std::sync::Arc;

use delaunay_tiles::export::ExportError;
use delaunay_tiles::input::InputError;
use delaunay_tiles::query::QueryError;
use delaunay_tiles::terrain::TerrainError;
use delaunay_tiles::{BuildError, EditError, ReadError, VerifyError, shown};
use pyo3::PyErr;
use pyo3::exceptions::{
    PyFileExistsError, PyFileNotFoundError, PyIndexError, PyKeyboardInterrupt, PyOSError, PyPermissionError,
    PyTypeError, PyValueError,
};

/// The exceptions of the Python part.
mod python {
    pyo3::import_exception!(delaunay_tiles._errors, Error);
    pyo3::import_exception!(delaunay_tiles._errors, BuildError);
    pyo3::import_exception!(delaunay_tiles._errors, EditError);
    pyo3::import_exception!(delaunay_tiles._errors, FileError);
    pyo3::import_exception!(delaunay_tiles._errors, InputError);
    pyo3::import_exception!(delaunay_tiles._errors, MemoryLimitError);
    pyo3::import_exception!(delaunay_tiles._errors, QueryError);
    pyo3::import_exception!(delaunay_tiles._errors, VerifyError);
}

/// A Python exception that is to be raised. It can be made without the interpreter.
#[derive(Debug)]
pub struct Failure(PyErr);

/// The result of a question.
pub type Outcome<T> = Result<T, Failure>;

impl Failure {
    /// Returns a `ValueError`.
    pub fn value(text: impl Into<String>) -> Self {
        Self(PyValueError::new_err(text.into()))
    }

    /// Returns a `TypeError`.
    pub fn of_type(text: impl Into<String>) -> Self {
        Self(PyTypeError::new_err(text.into()))
    }

    /// Returns an error of the input of a build.
    pub fn input(text: impl Into<String>) -> Self {
        Self(python::InputError::new_err(in_python(text.into())))
    }

    /// Returns an error of what is to be built.
    pub fn build(text: impl Into<String>) -> Self {
        Self(python::BuildError::new_err(text.into()))
    }

    /// Returns an error of an edit.
    pub fn edit(text: impl Into<String>) -> Self {
        Self(python::EditError::new_err(text.into()))
    }

    /// Returns a `ValueError` for an argument, in the words of the command line.
    pub fn argument(text: String) -> Self {
        Self::value(with_keywords(&text))
    }

    /// Returns an exception for an error of the tool.
    pub fn of_tool(error: tiletool::Error) -> Self {
        let words = in_python(format!("{error:#}"));
        match error
            .chain()
            .find_map(|cause| of_system(cause.downcast_ref::<io::Error>()?, &words))
        {
            Some(exception) => Self(exception),
            None => match error.downcast::<ReadError>() {
                Ok(error) => error.into(),
                Err(error) if error.chain().any(is_of_question) => Self(python::QueryError::new_err(words)),
                Err(_) => Self(python::Error::new_err(words)),
            },
        }
    }

    /// Returns an exception for an error of a build, which the tool has put into words.
    pub fn of_build(error: tiletool::Error) -> Self {
        let words = in_python(format!("{error:#}"));
        match error.downcast::<BuildError>() {
            // The tool's words begin with the name of a line.
            Ok(error @ BuildError::Memory(_)) => Self::of(&error, |_| python::MemoryLimitError::new_err(words)),
            Ok(error) if !words.starts_with(&error.to_string()) => Self(python::BuildError::new_err(words)),
            Ok(error) => error.into(),
            Err(error) => match error.downcast::<InputError>() {
                Ok(error) => error.into(),
                Err(_) => Self(python::BuildError::new_err(words)),
            },
        }
    }

    /// Returns an error of the package that has no class of its own.
    pub fn other(text: impl Into<String>) -> Self {
        Self(python::Error::new_err(text.into()))
    }

    /// Returns an exception for an error: one of the operating system if that is its cause, otherwise
    /// what `class` makes of its words.
    fn of(error: &(dyn Error + 'static), class: impl FnOnce(String) -> PyErr) -> Self {
        let words = words(error);
        let mut cause = Some(error);
        while let Some(this) = cause {
            let shared = this.downcast_ref::<Arc<io::Error>>().map(|shared| &**shared);
            if let Some(system) = this.downcast_ref::<io::Error>().or(shared)
                && let Some(exception) = of_system(system, &words)
            {
                return Self(exception);
            }
            cause = this.source();
        }
        Self(class(in_python(words)))
    }
}

/// Returns the words of the library and the tool with the names of arguments instead of options.
fn in_python(words: String) -> String {
    const OPTIONS: [(&str, &str); 10] = [
        ("--skip-missing", "skip_missing=True"),
        ("leave z out (--dims 2)", "leave z out"),
        ("--crossings split", "crossings='split'"),
        ("(--line)", "(remove_lines)"),
        ("--missing-z drape", "missing_z='drape'"),
        ("--missing-z error", "missing_z='error'"),
        ("--missing-z zero", "missing_z='zero'"),
        ("(option `crs`)", "(argument crs)"),
        ("--max-edge", "max_edge"),
        ("give crossings=", "pass crossings="),
    ];
    let replaced = OPTIONS.iter().filter(|(option, _)| words.contains(option));
    replaced.fold(words.clone(), |words, (option, argument)| {
        words.replace(option, argument)
    })
}

/// Returns words with keyword arguments instead of options: `max_edge` instead of `--max-edge`.
fn with_keywords(words: &str) -> String {
    let mut parts = words.split("--");
    let mut replaced = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let is_of_name = |c: char| c.is_ascii_alphanumeric() || c == '-';
        let (name, rest) = part.split_at(part.find(|c| !is_of_name(c)).unwrap_or(part.len()));
        replaced.extend([name.replace('-', "_").as_str(), rest]);
    }
    replaced
}

/// Returns whether an error says that the file cannot answer a question.
fn is_of_question(error: &(dyn Error + 'static)) -> bool {
    match error.downcast_ref::<ExportError>() {
        Some(error) => matches!(error, ExportError::Terrain(_)),
        None => error.is::<TerrainError>() || error.is::<QueryError>(),
    }
}

/// Returns the exception of an error of the operating system, or `None` if it is another one.
fn of_system(error: &io::Error, words: &str) -> Option<PyErr> {
    let words = words.to_owned();
    match error.kind() {
        io::ErrorKind::NotFound => Some(PyFileNotFoundError::new_err(words)),
        io::ErrorKind::PermissionDenied => Some(PyPermissionError::new_err(words)),
        io::ErrorKind::AlreadyExists => Some(PyFileExistsError::new_err(words)),
        _ => error.raw_os_error().map(|_| PyOSError::new_err(words)),
    }
}

/// Returns the words of an error and of its causes.
fn words(error: &dyn Error) -> String {
    let mut words = error.to_string();
    let mut cause = error.source();
    while let Some(this) = cause {
        let more = this.to_string();
        if !words.ends_with(&more) {
            words = format!("{words}: {more}");
        }
        cause = this.source();
    }
    words
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        failure.0
    }
}

impl From<PyErr> for Failure {
    fn from(error: PyErr) -> Self {
        Self(error)
    }
}

impl From<ReadError> for Failure {
    fn from(error: ReadError) -> Self {
        Self::of(&error, |words| match &error {
            ReadError::Memory { .. } => python::MemoryLimitError::new_err(words),
            ReadError::NoSuchTile { .. } => PyIndexError::new_err(words),
            _ => python::FileError::new_err(words),
        })
    }
}

impl From<QueryError> for Failure {
    fn from(error: QueryError) -> Self {
        match error {
            QueryError::Read(error) => error.into(),
            error => Self::of(&error, python::QueryError::new_err),
        }
    }
}

impl From<TerrainError> for Failure {
    fn from(error: TerrainError) -> Self {
        match error {
            TerrainError::Read(error) => error.into(),
            error => Self::of(&error, python::QueryError::new_err),
        }
    }
}

impl From<ExportError> for Failure {
    fn from(error: ExportError) -> Self {
        match error {
            ExportError::Read(error) => error.into(),
            ExportError::Terrain(error) => error.into(),
            error => Self::of(&error, python::Error::new_err),
        }
    }
}

impl From<VerifyError> for Failure {
    fn from(error: VerifyError) -> Self {
        match error {
            VerifyError::Read(error) => error.into(),
            error => Self::of(&error, python::VerifyError::new_err),
        }
    }
}

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        Self::of(&error, python::InputError::new_err)
    }
}

impl From<EditError> for Failure {
    fn from(error: EditError) -> Self {
        match error {
            EditError::Read(error) => error.into(),
            EditError::Cancelled => Self(PyKeyboardInterrupt::new_err("cancelled")),
            EditError::Memory(_) => Self::of(&error, python::MemoryLimitError::new_err),
            EditError::InvalidPoint(_) | EditError::InvalidZ { .. } => Self::of(&error, PyValueError::new_err),
            error => Self::of(&error, python::EditError::new_err),
        }
    }
}

impl From<BuildError> for Failure {
    fn from(error: BuildError) -> Self {
        Self::of(&error, |words| match &error {
            BuildError::OutputExists(path) => PyFileExistsError::new_err(format!(
                "{} exists already; choose another name, or pass overwrite=True",
                shown::path(path)
            )),
            BuildError::WorkKept { .. } => {
                PyFileExistsError::new_err(format!("{words} (resume=True or overwrite=True)"))
            }
            BuildError::Memory(_) => python::MemoryLimitError::new_err(words),
            BuildError::Cancelled => PyKeyboardInterrupt::new_err(words),
            BuildError::InvalidPoint { .. } | BuildError::InvalidZ { .. } | BuildError::Option { .. } => {
                PyValueError::new_err(words)
            }
            _ => python::BuildError::new_err(words),
        })
    }
}
