//! A read or a write, split into as many operations of the ring as the system needs.

use std::io;

use bytes::Bytes;
use tokio_uring::buf::BoundedBuf;
use tokio_uring::fs::File;

use crate::io::uring::pages::{ALIGNMENT, PagePool};

/// The limit on the bytes of one operation: a multiple of the alignment that fits into its 32 bits
/// and the system's limit.
const LARGEST: usize = 1 << 30;

/// Reads all of `length` bytes from `offset` on, or fails. With `is_direct`, reads begin and end at
/// multiples of [`ALIGNMENT`], in the file and in memory.
pub(super) async fn read(
    file: &File,
    offset: u64,
    length: usize,
    is_direct: bool,
    pool: &PagePool,
) -> io::Result<Bytes> {
    let alignment = if is_direct { ALIGNMENT } else { 1 };
    let ahead = (offset % alignment as u64) as usize;
    let (needed, first) = (ahead + length, offset - ahead as u64);
    let whole = needed.next_multiple_of(alignment);
    let mut pages = pool.take(whole)?;
    let start = pages.start();
    let mut done = 0;
    while done < needed {
        let part = start + done..start + whole.min(done + LARGEST);
        let (read, slice) = file.read_at(pages.slice(part), first + done as u64).await;
        pages = slice.into_inner();
        let before = done;
        match read {
            Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
            Ok(read) => done += read,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(error) => return Err(error),
        }
        if done < needed {
            // Continue at an aligned offset. At the end of the file, that is the same offset as
            // before.
            done -= done % alignment;
            if done <= before {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
        }
    }
    Ok(pool.freeze(pages, ahead..needed))
}

/// Writes all the bytes from `offset` on, or fails.
pub(super) async fn write(file: &File, offset: u64, mut data: Bytes) -> io::Result<()> {
    let mut offset = offset;
    while !data.is_empty() {
        let part = Bytes::slice(&data, ..data.len().min(LARGEST));
        match file.write_at(part, offset).submit().await.0 {
            Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
            Ok(written) => {
                data = data.split_off(written);
                offset += written as u64;
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => (),
            Err(error) => return Err(error),
        }
    }
    Ok(())
}
