//! The log of a tile file: transactions that are on the medium, and not yet in the file.
//!
//! It lies beside the file, as `NAME.log`. What a transaction contains is not known here.
//! `schema/LOG.md` specifies its bytes.
//!
//! ```text
//!   head │ number, length, checksum │ transaction │ number, length, checksum │ transaction │ …
//! ```
//!
//! Each transaction is appended and synced. What a crash leaves of the last one is not a
//! transaction: its checksum is wrong. The file says which transaction is the last one that it
//! contains, so that those before are never carried out twice.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind};
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bytes::{Buf, BufMut, Bytes, BytesMut};

use crate::io::{OutputFile, ReadAt, ThreadsFile, WriteAt, blocking, folder_of, open_regular, output_target};
use crate::shown;
use crate::store::format::superblock::FileId;
use crate::store::reader::TileReader;

const MAGIC: [u8; 8] = *b"DELTILOG";
const VERSION: u32 = 1;
/// Bytes of the head: magic, version, zero, id of the file, number of the transaction before the first
/// one, zero, checksum.
const HEAD: u64 = 48;
/// Bytes before a transaction: its number, its length, and a checksum of these and of itself.
const FRAME: u64 = 16;
/// The most bytes of a transaction.
const MAX_LOGGED: u64 = 16 << 20;

/// The reason why a log cannot be used.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LogError {
    /// An operation on the log failed.
    #[error("{log}: cannot {what} the log", log = shown::path(log))]
    Io {
        /// The log.
        log: PathBuf,
        /// The operation that failed.
        what: &'static str,
        /// The system's error.
        source: Arc<io::Error>,
    },
    /// The log belongs to another file.
    #[error(
        "{log}: the log belongs to another file than the one beside it, with the id {other}; move it to that file, or delete \
         it, which loses the transactions in it", log = shown::path(log)
    )]
    OfAnother {
        /// The log.
        log: PathBuf,
        /// The id of the file to which it belongs.
        other: FileId,
    },
    /// The log is damaged.
    #[error(
        "{log}: {reason}; delete the log, which loses the transactions in it, or restore it", log = shown::path(log)
    )]
    Damaged {
        /// The log.
        log: PathBuf,
        /// What is wrong.
        reason: String,
    },
}

/// Returns the name of the log of a tile file.
fn log_of(file: &Path) -> io::Result<PathBuf> {
    let mut name = OsString::from(output_target(file)?);
    name.push(".log");
    Ok(name.into())
}

/// The log of a file that is locked against other editors.
pub(crate) struct Log {
    path: PathBuf,
    file: ThreadsFile,
    /// Where the next transaction goes.
    length: u64,
    /// Whether an append failed, so that nobody knows what is on the medium.
    is_broken: bool,
}

/// The transactions in a log that its file does not contain, in order.
pub(crate) struct Logged {
    pub(crate) log: Log,
    pub(crate) transactions: Vec<Bytes>,
}

impl Log {
    /// Opens the log of a file with this id, whose last transaction is `last`. Returns `None` if there
    /// is none.
    pub(crate) async fn open(file: &Path, id: FileId, last: u64) -> Result<Option<Logged>, LogError> {
        Self::open_as(file, id, last, File::options().read(true).write(true)).await
    }

    /// Opens a log with these options.
    async fn open_as(file: &Path, id: FileId, last: u64, how: &OpenOptions) -> Result<Option<Logged>, LogError> {
        let path = log_of(file).map_err(|error| io_error(file, "find", error))?;
        let (log, _) = match open_regular(&path, how) {
            Ok(opened) => opened,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(io_error(&path, "open", error)),
        };
        let mut log = Self {
            path,
            file: ThreadsFile::from(Arc::new(log)),
            length: HEAD,
            is_broken: false,
        };
        let (of, before) = log.head().await?;
        let mut transactions = Vec::new();
        let mut number = before;
        while let Some(transaction) = log.next(number + 1).await? {
            number += 1;
            if number > last {
                transactions.push(transaction);
            }
        }
        // The log of a file that was built anew since is still there after a crash, with nothing left
        // in it.
        if transactions.is_empty() {
            return Ok(Some(Logged { log, transactions }));
        }
        if of != id {
            return Err(LogError::OfAnother {
                log: log.path,
                other: of,
            });
        }
        if before > last {
            return Err(log.damaged(format!(
                "its first transaction is number {}, but the file ends with number {last}",
                before + 1
            )));
        }
        Ok(Some(Logged { log, transactions }))
    }

    /// Creates the log of a file with this id, whose last transaction is `last`.
    pub(crate) async fn create(file: &Path, id: FileId, last: u64) -> Result<Self, LogError> {
        let path = log_of(file).map_err(|error| io_error(file, "find", error))?;
        let mut head = BytesMut::with_capacity(HEAD as usize);
        head.put_slice(&MAGIC);
        head.put_u32_le(VERSION);
        head.put_u32_le(0);
        head.put_u128_le(id.0);
        head.put_u64_le(last);
        head.put_u32_le(0);
        head.put_u32_le(crc32c::crc32c(&head));
        let name = path.clone();
        let created = blocking(move || {
            // A file without a whole head never has the name.
            let output = OutputFile::create(&name)?;
            output.file().write_all_at(&head, 0)?;
            let file = output.file().try_clone()?;
            output.publish()?;
            Ok(file)
        });
        let created = created.await.and_then(|created| created);
        let file = created.map_err(|error| io_error(&path, "create", error))?;
        Ok(Self {
            path,
            file: ThreadsFile::from(Arc::new(file)),
            length: HEAD,
            is_broken: false,
        })
    }

    /// Appends a transaction, and brings it onto the medium. After an error, nobody knows what is there:
    /// the log takes no more.
    pub(crate) async fn append(&mut self, number: u64, transaction: &[u8]) -> Result<(), LogError> {
        let mut framed = BytesMut::with_capacity(FRAME as usize + transaction.len());
        framed.put_u64_le(number);
        framed.put_u32_le(transaction.len() as u32);
        framed.put_u32_le(checksum(&framed, transaction));
        framed.put_slice(transaction);
        let length = framed.len() as u64;
        // Also if the future is dropped.
        self.is_broken = true;
        let written = self.file.write_at(self.length, framed.freeze()).await;
        let synced = match written {
            Ok(()) => self.file.sync().await,
            Err(error) => Err(error),
        };
        if let Err(error) = synced {
            // What was written may still be cut off. The error that counts is the one before.
            let _ = self.file.truncate(self.length);
            return Err(io_error(&self.path, "append to", error));
        }
        self.is_broken = false;
        self.length += length;
        Ok(())
    }

    /// Returns whether it takes no more transactions.
    pub(crate) fn is_broken(&self) -> bool {
        self.is_broken
    }

    /// Removes the log, whose transactions the file contains.
    pub(crate) async fn remove(self) -> Result<(), LogError> {
        let path = self.path.clone();
        let removed = blocking(move || {
            fs::remove_file(&path)?;
            File::open(folder_of(&path))?.sync_all()
        });
        let removed = removed.await.and_then(|removed| removed);
        removed.map_err(|error| io_error(&self.path, "remove", error))
    }

    /// Reads the head: the id of the file, and the number of the transaction before the first one.
    async fn head(&self) -> Result<(FileId, u64), LogError> {
        let mut head = self.read(0, HEAD).await?.unwrap_or_default();
        if head.len() < HEAD as usize || head[..8] != MAGIC {
            return Err(self.damaged("it is no log of a tile file".to_owned()));
        }
        let expected = crc32c::crc32c(&head[..HEAD as usize - 4]);
        head.advance(8);
        let version = head.get_u32_le();
        head.advance(4);
        let (id, before) = (FileId(head.get_u128_le()), head.get_u64_le());
        if version != VERSION {
            return Err(self.damaged(format!(
                "it has format version {version}, this program reads version {VERSION}"
            )));
        }
        head.advance(4);
        if head.get_u32_le() != expected || before == u64::MAX {
            return Err(self.damaged("its head is damaged".to_owned()));
        }
        Ok((id, before))
    }

    /// Reads the next transaction, which must have this number. Returns `None` at the end, where a
    /// transaction may be incomplete that was not acknowledged.
    async fn next(&mut self, number: u64) -> Result<Option<Bytes>, LogError> {
        let Some((found, end)) = self.transaction_at(self.length, number).await? else {
            return Ok(None);
        };
        let Some(transaction) = found else {
            // A transaction is only written when the one before it is on the medium.
            return match self.transaction_at(end, number + 1).await? {
                Some((Some(_), _)) => Err(self.damaged(format!("transaction {number} in it is damaged"))),
                _ => Ok(None),
            };
        };
        self.length = end;
        Ok(Some(transaction))
    }

    /// Reads a transaction that must have this number, `None` inside if it is damaged, and where it
    /// ends. Returns `None` if the log is shorter.
    async fn transaction_at(&self, offset: u64, number: u64) -> Result<Option<(Option<Bytes>, u64)>, LogError> {
        let Some(mut frame) = self.read(offset, FRAME).await? else {
            return Ok(None);
        };
        let summed = frame.slice(..12);
        let (found, length, sum) = (frame.get_u64_le(), frame.get_u32_le(), frame.get_u32_le());
        let end = offset + FRAME + u64::from(length);
        if u64::from(length) > MAX_LOGGED {
            return Ok(None);
        }
        let Some(transaction) = self.read(offset + FRAME, length.into()).await? else {
            return Ok(None);
        };
        let is_whole = found == number && sum == checksum(&summed, &transaction);
        Ok(Some((is_whole.then_some(transaction), end)))
    }

    /// Reads bytes. Returns `None` if the log is shorter.
    async fn read(&self, offset: u64, length: u64) -> Result<Option<Bytes>, LogError> {
        let end = offset + length;
        if end > self.file.length() {
            return Ok(None);
        }
        let read = self.file.read_at(offset..end).await;
        read.map(Some).map_err(|error| io_error(&self.path, "read", error))
    }

    pub(crate) fn damaged(&self, reason: String) -> LogError {
        LogError::Damaged {
            log: self.path.clone(),
            reason,
        }
    }
}

/// Returns the checksum of a transaction and of what precedes it.
fn checksum(frame: &[u8], transaction: &[u8]) -> u32 {
    crc32c::crc32c_append(crc32c::crc32c(frame), transaction)
}

fn io_error(path: &Path, what: &'static str, error: io::Error) -> LogError {
    LogError::Io {
        log: path.to_owned(),
        what,
        source: Arc::new(error),
    }
}

/// Returns the number of transactions that are in the log of a file on disk, and not yet in the file.
/// The next [`Editor`](crate::Editor) of the file makes them.
///
/// # Errors
/// Returns an error if there is a log that cannot be read, is damaged, or belongs to another file.
pub async fn pending_transactions(file: impl AsRef<Path>, reader: &TileReader) -> Result<u64, LogError> {
    let last = reader.metadata().last_transaction;
    let logged = Log::open_as(file.as_ref(), reader.file_id(), last, File::options().read(true)).await?;
    Ok(logged.map_or(0, |logged| logged.transactions.len() as u64))
}

/// Removes the log of a file that was replaced, if there is one.
pub(crate) fn remove_log(file: &Path) -> io::Result<()> {
    match fs::remove_file(log_of(file)?) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}
