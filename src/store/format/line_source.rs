//! The files from which lines were read.

use crate::store::format::edge_source::{EdgeSource, LineKind};

/// A file from which lines were read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LineSource {
    /// The file name without its folder.
    pub name: String,
    /// The kind of its lines.
    pub kind: LineKind,
    /// The number of its first line.
    pub first: u64,
    /// The number of lines read from the file.
    pub lines: u64,
    /// 0 for lines of the build, else the number of the edit that added them, from 1 on.
    pub edit: u32,
}

impl LineSource {
    /// Returns whether `source` is one of `lines`, which are in order. Also returns true if `lines`
    /// is empty, because then the lines are not known.
    pub(crate) fn knows(lines: &[Self], source: EdgeSource) -> bool {
        let before = lines.partition_point(|of_file| of_file.first <= source.number());
        let of_file = before.checked_sub(1).map(|index| &lines[index]);
        let has_source = |l: &Self| l.kind == source.kind() && source.number() - l.first < l.lines;
        lines.is_empty() || of_file.is_some_and(has_source)
    }
}
