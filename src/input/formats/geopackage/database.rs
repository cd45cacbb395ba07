//! Opening of the database, and its errors.

use crate::input::error::{InputError, Location};
use crate::input::formats::shapes::LONGEST;
use crate::input::layer;
use rusqlite::config::DbConfig;
use rusqlite::limits::Limit;
use rusqlite::{Connection, OpenFlags};
use std::error::Error;
use std::ffi::OsString;
use std::fmt::Write;
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};

/// Opens the database at `path`, which may name a layer, read-only. The file begins with `head`, and
/// has `size` bytes.
pub fn open(path: &Path, head: &[u8], size: u64) -> Result<Connection, InputError> {
    let file = layer::file(path);
    check_length(path, head, size)?;
    check_journals(path, file)?;
    let connect = || {
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_URI | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let connection = Connection::open_with_flags(address(file)?, flags)?;
        for (setting, value) in [
            (DbConfig::SQLITE_DBCONFIG_DEFENSIVE, true),
            (DbConfig::SQLITE_DBCONFIG_TRUSTED_SCHEMA, false),
            (DbConfig::SQLITE_DBCONFIG_ENABLE_TRIGGER, false),
            (DbConfig::SQLITE_DBCONFIG_ENABLE_VIEW, false),
            // A column that does not exist is an error, and not a text.
            (DbConfig::SQLITE_DBCONFIG_DQS_DML, false),
        ] {
            connection.set_db_config(setting, value)?;
        }
        connection.set_limit(Limit::SQLITE_LIMIT_LENGTH, i32::try_from(LONGEST).unwrap_or(i32::MAX))?;
        Ok(connection)
    };
    connect().map_err(|error: rusqlite::Error| damaged(path, "SQLite cannot open it", error))
}

/// Fails if the file is shorter than its header says: SQLite would report only the pages that it
/// needs. Headers of old versions may not say it.
fn check_length(path: &Path, head: &[u8], size: u64) -> Result<(), InputError> {
    let number = |at: usize| {
        let bytes = head.get(at..).and_then(|bytes| bytes.first_chunk::<4>());
        bytes.map_or(0, |bytes| u64::from(u32::from_be_bytes(*bytes)))
    };
    let page = match number(16) >> 16 {
        1 => 1 << 16,
        page => page,
    };
    let (length, is_valid) = (page * number(28), number(24) == number(92));
    if is_valid && length > size {
        let problem = format!("the header says that the file has {length} bytes, and it has {size}");
        let hint = "the file is cut short, or damaged";
        return Err(InputError::malformed(path, Location::File, problem, hint));
    }
    Ok(())
}

/// Fails if there are changes that are not in the file yet: it is read as it is, since SQLite
/// would write to apply them.
fn check_journals(path: &Path, file: &Path) -> Result<(), InputError> {
    for suffix in ["-wal", "-journal"] {
        let mut journal = OsString::from(file);
        journal.push(suffix);
        if fs::metadata(&journal).is_ok_and(|metadata| metadata.len() > 0) {
            let problem = format!("another program has changes of it in the file `…{suffix}` beside it");
            let hint = "close that program, or open and close the file with it";
            return Err(InputError::malformed(path, Location::File, problem, hint));
        }
    }
    Ok(())
}

/// Returns the address under which SQLite takes a file as one that nothing changes, so that it
/// neither locks it nor creates others.
fn address(file: &Path) -> rusqlite::Result<String> {
    let absolute = std::path::absolute(file).map_err(|_| rusqlite::Error::InvalidPath(PathBuf::from(file)))?;
    let mut address = "file:".to_owned();
    for &byte in absolute.as_os_str().as_bytes() {
        match byte {
            b'/' | b'.' | b'-' | b'_' => address.push(char::from(byte)),
            byte if byte.is_ascii_alphanumeric() => address.push(char::from(byte)),
            // Writing to a string does not fail.
            byte => write!(address, "%{byte:02X}").unwrap_or_default(),
        }
    }
    address.push_str("?immutable=1");
    Ok(address)
}

/// Returns the error of a file that SQLite cannot read.
pub fn damaged(path: &Path, problem: impl Into<String>, error: impl Error + Send + Sync + 'static) -> InputError {
    InputError::Malformed {
        path: path.to_owned(),
        location: Location::File,
        problem: problem.into(),
        hint: "this is not a GeoPackage, or it is damaged or cut short",
        source: Some(Box::new(error)),
    }
}

/// Returns a name as SQL has it.
pub fn quoted(name: &str) -> String {
    format!("\"{}\"", name.replace('"', "\"\""))
}
