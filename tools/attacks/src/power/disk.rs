//! The content of a disk after a power cut: synced data is there, and any part of the rest may be
//! there.
//!
//! The input is the log of `tools/faults`, record by record. The output is a folder as a cut may
//! leave it. Each write to a file since its last sync may be lost, may be applied, or may be
//! applied in some sectors. Each change to names since the last sync of their folder may be lost or
//! applied, also before the data that the names refer to.

use std::collections::{BTreeMap, HashMap};
use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use rand_chacha::ChaCha8Rng;

use crate::campaign::below;

/// The number of bytes that a disk writes as a whole or not at all.
const SECTOR: u64 = 512;

/// A folder after a cut: the content of its files, and `None` for its folders.
pub type Tree = BTreeMap<PathBuf, Option<Vec<u8>>>;

/// A folder on a disk.
#[derive(Default)]
pub struct Disk {
    files: Vec<Content>,
    by_inode: HashMap<u64, usize>,
    /// The names as programs see them.
    names: Names,
    synced: Names,
    /// Changes since the last sync of the folder that they are in.
    unsynced: Vec<NameChange>,
}

type Names = BTreeMap<PathBuf, Node>;

#[derive(Clone, Copy, PartialEq)]
enum Node {
    Folder,
    File(usize),
}

#[derive(Clone)]
enum NameChange {
    Put(PathBuf, Node),
    Remove(PathBuf),
    Move(PathBuf, PathBuf, Node),
}

#[derive(Default)]
struct Content {
    synced: Vec<u8>,
    unsynced: Vec<Change>,
}

enum Change {
    Write(u64, Vec<u8>),
    Length(u64),
}

/// A record of the log.
pub struct Record {
    kind: u8,
    numbers: [u64; 2],
    bytes: [Vec<u8>; 2],
}

/// Reads the records of a log.
pub fn records(log: &[u8]) -> anyhow::Result<Vec<Record>> {
    let mut rest = log;
    let mut take = |count: usize| {
        let (taken, behind) = rest.split_at_checked(count).context("the log ends within a record")?;
        rest = behind;
        anyhow::Ok((taken.to_vec(), rest.is_empty()))
    };
    let number = |bytes: &[u8]| {
        bytes
            .iter()
            .rev()
            .fold(0, |number, byte| number << 8 | u64::from(*byte))
    };
    let mut records = Vec::new();
    let mut is_over = log.is_empty();
    while !is_over {
        let (head, _) = take(17)?;
        let mut bytes = [Vec::new(), Vec::new()];
        for bytes in &mut bytes {
            let length = number(&take(4)?.0) as usize;
            (*bytes, is_over) = take(length)?;
        }
        records.push(Record {
            kind: head[0],
            numbers: [number(&head[1..9]), number(&head[9..])],
            bytes,
        });
    }
    Ok(records)
}

impl Disk {
    /// Creates a disk with the content of a folder, all of it synced.
    pub fn of(root: &Path) -> anyhow::Result<Self> {
        let mut disk = Self::default();
        for entry in fs::read_dir(root)? {
            let path = entry?.path();
            let file = disk.add(fs::metadata(&path)?.ino());
            disk.files[file].synced = fs::read(&path)?;
            disk.names.insert(path.strip_prefix(root)?.to_owned(), Node::File(file));
        }
        disk.synced = disk.names.clone();
        Ok(disk)
    }

    fn add(&mut self, inode: u64) -> usize {
        self.files.push(Content::default());
        self.by_inode.insert(inode, self.files.len() - 1);
        self.files.len() - 1
    }

    /// Applies a record.
    pub fn take(&mut self, record: &Record) {
        let [inode, number] = record.numbers;
        let [first, second] = record.bytes.each_ref().map(|bytes| Path::new(OsStr::from_bytes(bytes)));
        let file = self.by_inode.get(&inode).copied();
        match (record.kind, file) {
            (1, _) => {
                let file = match file.filter(|&file| self.names.get(first) == Some(&Node::File(file))) {
                    Some(file) => file,
                    // A new file, perhaps with the inode of a removed one.
                    None => {
                        let node = Node::File(self.add(inode));
                        self.change(NameChange::Put(first.to_owned(), node));
                        self.files.len() - 1
                    }
                };
                if number == 1 {
                    self.files[file].unsynced.push(Change::Length(0));
                }
            }
            (2, Some(file)) => self.files[file]
                .unsynced
                .push(Change::Write(number, record.bytes[0].clone())),
            (3, Some(file)) => self.files[file].unsynced.push(Change::Length(number)),
            (4, Some(file)) => self.files[file].sync(),
            (5, _) => self.sync_folder(first),
            (6, _) => {
                if let Some(&node) = self.names.get(first) {
                    self.change(NameChange::Move(first.to_owned(), second.to_owned(), node));
                }
            }
            (7, _) => self.change(NameChange::Remove(first.to_owned())),
            (8, _) => self.change(NameChange::Put(first.to_owned(), Node::Folder)),
            _ => {}
        }
    }

    fn change(&mut self, change: NameChange) {
        change.apply(&mut self.names);
        self.unsynced.push(change);
    }

    fn sync_folder(&mut self, folder: &Path) {
        let (synced, unsynced) = std::mem::take(&mut self.unsynced)
            .into_iter()
            .partition(|change| change.is_in(folder));
        self.unsynced = unsynced;
        let synced: Vec<NameChange> = synced;
        synced.iter().for_each(|change| change.apply(&mut self.synced));
    }

    /// Returns the folder as a cut may leave it, restricted to paths for which `is_wanted` is true.
    pub fn cut(&self, random: &mut ChaCha8Rng, is_wanted: impl Fn(&Path) -> bool) -> Tree {
        let mut names = self.synced.clone();
        for (_, change) in chosen(&self.unsynced, random) {
            change.apply(&mut names);
        }
        let is_there = |path: &Path| {
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
            folder.is_none_or(|folder| names.get(folder) == Some(&Node::Folder))
        };
        let there = names.iter().filter(|(path, _)| is_wanted(path) && is_there(path));
        let mut tree = Tree::new();
        for (path, node) in there {
            let content = match node {
                Node::Folder => None,
                Node::File(file) => Some(self.files[*file].cut(random)),
            };
            tree.insert(path.clone(), content);
        }
        tree
    }
}

impl NameChange {
    fn apply(&self, names: &mut Names) {
        match self {
            Self::Put(path, node) => drop(names.insert(path.clone(), *node)),
            Self::Remove(path) => drop(names.remove(path)),
            Self::Move(from, to, node) => {
                names.remove(from);
                names.insert(to.clone(), *node);
            }
        }
    }

    fn is_in(&self, folder: &Path) -> bool {
        let within = |path: &Path| path.parent() == Some(folder);
        match self {
            Self::Put(path, _) | Self::Remove(path) => within(path),
            Self::Move(from, to, _) => within(from) || within(to),
        }
    }
}

/// Chooses the changes that are applied: none, all, those before one of them, or any; and whether
/// only in part.
fn chosen<'a, T>(changes: &'a [T], random: &mut ChaCha8Rng) -> Vec<(bool, &'a T)> {
    let count = changes.len() as u64;
    let whole = |change: &'a T| (false, change);
    match below(random, 4) {
        0 => Vec::new(),
        1 => changes.iter().map(whole).collect(),
        2 => changes
            .iter()
            .take(below(random, count + 1) as usize)
            .map(whole)
            .collect(),
        _ => {
            let mut some = Vec::new();
            for change in changes {
                match below(random, 3) {
                    0 => {}
                    1 => some.push((false, change)),
                    _ => some.push((true, change)),
                }
            }
            some
        }
    }
}

impl Content {
    fn sync(&mut self) {
        for change in std::mem::take(&mut self.unsynced) {
            change.apply(&mut self.synced);
        }
    }

    fn cut(&self, random: &mut ChaCha8Rng) -> Vec<u8> {
        let mut bytes = self.synced.clone();
        for (is_partial, change) in chosen(&self.unsynced, random) {
            match change {
                Change::Write(at, data) if is_partial => tear(&mut bytes, *at, data, random),
                _ => change.apply(&mut bytes),
            }
        }
        // The length may be applied before the data.
        if below(random, 4) == 0 {
            let length = |length: usize, change: &Change| match change {
                Change::Write(at, data) => length.max(*at as usize + data.len()),
                Change::Length(length) => *length as usize,
            };
            bytes.resize(self.unsynced.iter().fold(self.synced.len(), length), 0);
        }
        bytes
    }
}

/// Writes some sectors of a write.
fn tear(bytes: &mut Vec<u8>, at: u64, data: &[u8], random: &mut ChaCha8Rng) {
    let (mut begin, end) = (at, at + data.len() as u64);
    while begin < end {
        let next = (begin / SECTOR + 1) * SECTOR;
        let sector = &data[(begin - at) as usize..(next.min(end) - at) as usize];
        if below(random, 2) == 0 {
            put(bytes, begin, sector);
        }
        begin = next;
    }
}

fn put(bytes: &mut Vec<u8>, at: u64, data: &[u8]) {
    let at = at as usize;
    if bytes.len() < at + data.len() {
        bytes.resize(at + data.len(), 0);
    }
    bytes[at..at + data.len()].copy_from_slice(data);
}

impl Change {
    fn apply(&self, bytes: &mut Vec<u8>) {
        match self {
            Self::Write(at, data) => put(bytes, *at, data),
            Self::Length(length) => bytes.resize(*length as usize, 0),
        }
    }
}
