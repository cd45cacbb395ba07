//! Cores that stay in the files of their tasks, because the tile file will be in parts.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

use crate::pipeline::records::{FinishedBlocks, LeftCores};
use crate::pipeline::tasks::gather::ALIGNMENT;
use crate::pipeline::work_folder::WorkFolder;

/// Returns the cores of all blocks that were gathered, where the first ones come behind `front_end`.
pub(crate) fn left_cores(finished: &FinishedBlocks, front_end: u64) -> Vec<LeftCores> {
    let mut end = front_end;
    let of_block = |(block, &end_of_block): (u32, &u64)| {
        let start = end.next_multiple_of(ALIGNMENT);
        end = end_of_block.max(start);
        LeftCores {
            block,
            range: start..end,
        }
    };
    let left = (0..).zip(&finished.ends).map(of_block);
    left.filter(|left| !left.range.is_empty()).collect()
}

/// Copies the cores into the tile file, where their gaps are. Fails with [`io::ErrorKind::NotFound`] if
/// they are elsewhere.
pub(crate) fn fill(folder: &WorkFolder, left: &[LeftCores]) -> io::Result<()> {
    let mut tiles = File::options().write(true).open(folder.file())?;
    for LeftCores { block, range } in left {
        let length = range.end - range.start;
        let cores = File::open(folder.cores_of(*block))?;
        tiles.seek(SeekFrom::Start(range.start))?;
        if io::copy(&mut cores.take(length), &mut tiles)? != length {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
    }
    Ok(())
}
