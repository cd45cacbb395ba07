//! Gives a finished file in parts its name: the name of a manifest, beside a folder of its parts.
//!
//! ```text
//! NAME.parts               the manifest
//! NAME.parts.d/ID/main     the tile file, with gaps in the place of the cores that lie in other parts
//! NAME.parts.d/ID/cores-N  the cores of block N
//! ```

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::io::{Manifest, PARTS_FOLDER, Part, folder_of, id_name, is_id_name};
use crate::pipeline::records::LeftCores;
use crate::pipeline::work_folder::WorkFolder;

/// Returns the folder of the parts of all files that have had the name of `manifest`.
fn folder_for(manifest: &Path) -> PathBuf {
    let mut name = OsString::from(manifest);
    name.push(PARTS_FOLDER);
    PathBuf::from(name)
}

/// Returns the parts of a file of `length` bytes that has gaps in the place of the cores, in the folder
/// `name`, which is relative to the manifest.
pub(crate) fn manifest(name: &str, left: &[LeftCores], length: u64) -> Manifest {
    let (mut parts, mut end) = (Vec::new(), 0);
    let main = |range: std::ops::Range<u64>| Part {
        from: range.start,
        range,
        name: format!("{name}/main"),
    };
    for (LeftCores { block, range }, index) in left.iter().zip(0..) {
        // Between two blocks there is nothing.
        parts.extend((index == 0).then(|| main(end..range.start)));
        parts.push(Part {
            range: range.clone(),
            from: 0,
            name: format!("{name}/{}", WorkFolder::cores_name(*block)),
        });
        end = range.end;
    }
    parts.push(main(end..length));
    Manifest { parts }
}

/// Puts the parts of the file that are here into the folder of its parts, where `id` distinguishes
/// them. Returns the manifest, which names them all.
pub(crate) fn link_parts(folder: &WorkFolder, left: &[LeftCores], length: u64, id: u64) -> io::Result<Manifest> {
    let all = folder_for(folder.output());
    let own = all.join(id_name(id));
    let name = all
        .file_name()
        .and_then(|name| name.to_str())
        .map(|name| format!("{name}/{}", id_name(id)));
    let name = name.ok_or_else(|| io::Error::new(io::ErrorKind::InvalidFilename, "the name is no Unicode"))?;
    fs::create_dir_all(&own)?;
    link(&folder.file(), &own.join("main"))?;
    for LeftCores { block, .. } in left {
        match link(&folder.cores_of(*block), &own.join(WorkFolder::cores_name(*block))) {
            Err(error) if error.kind() == io::ErrorKind::NotFound && folder.has_cores_elsewhere() => {}
            linked => linked?,
        }
    }
    for folder in [&own, &all] {
        File::open(folder)?.sync_all()?;
    }
    Ok(manifest(&name, left, length))
}

/// Gives the file its name, and removes the parts of a file that had it before.
pub(crate) fn give_name(folder: &WorkFolder, manifest: &Manifest, id: u64) -> io::Result<()> {
    let output = folder.output();
    let mut text = WorkFolder::replace(output)?;
    text.write_all(manifest.text().as_bytes())?;
    text.as_file().sync_all()?;
    text.persist(output)?;
    File::open(folder_of(output))?.sync_all()?;
    remove_others(&folder_for(output), &id_name(id));
    Ok(())
}

/// Removes the parts of the file `id`, which are elsewhere now.
pub(crate) fn remove_parts(output: &Path, id: u64) -> io::Result<()> {
    let all = folder_for(output);
    fs::remove_dir_all(all.join(id_name(id)))?;
    // If it is empty.
    let _ = fs::remove_dir(all);
    Ok(())
}

/// Gives a file another name too, or copies it where that is not possible.
fn link(from: &Path, to: &Path) -> io::Result<()> {
    match fs::remove_file(to) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    match fs::hard_link(from, to) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => {
            fs::copy(from, to)?;
            File::open(to)?.sync_all()
        }
        linked => linked,
    }
}

/// Removes the parts of files that had the name before, and nothing else that lies there.
fn remove_others(all: &Path, own: &str) {
    let Ok(entries) = fs::read_dir(all) else { return };
    let is_other = |name: &str| is_id_name(name) && name != own;
    for entry in entries
        .flatten()
        .filter(|entry| entry.file_name().to_str().is_some_and(is_other))
    {
        if let Err(error) = fs::remove_dir_all(entry.path()) {
            tracing::warn!(folder = %entry.path().display(), %error, "the parts of an earlier file could not be removed");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_folders_of_parts_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let names = [
            "00000000000000ab",
            "00000000000000AB",
            "ab",
            "photos",
            "00000000000000cd",
        ];
        for name in names {
            fs::create_dir(folder.path().join(name)).unwrap();
        }
        remove_others(folder.path(), &id_name(0xcd));
        let left = names.map(|name| folder.path().join(name).exists());
        assert_eq!(left, [false, true, true, true, true]);
    }

    #[test]
    fn the_main_part_is_what_the_cores_leave() {
        let left = [(0, 4096..5000), (2, 8192..8193)].map(|(block, range)| LeftCores { block, range });
        let parts = manifest("a", &left, 9000).parts;
        let parts: Vec<_> = parts
            .iter()
            .map(|part| (part.range.clone(), part.from, &*part.name))
            .collect();
        let expected = [
            (0..4096, 0, "a/main"),
            (4096..5000, 0, "a/cores-0"),
            (8192..8193, 0, "a/cores-2"),
            (8193..9000, 8193, "a/main"),
        ];
        assert_eq!(parts, expected);
        assert_eq!(manifest("a", &[], 9000).length(), 9000);
    }
}
