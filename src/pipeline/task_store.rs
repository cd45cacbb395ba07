//! The objects of a build whose tasks share nothing but an object store.
//!
//! ```text
//! NAME.parts                    the manifest, once the file is complete
//! NAME.parts.d/ID/main-OFFSET   what the build itself wrote
//! NAME.parts.d/ID/cores-N       the cores of block N
//! NAME.parts.d/work/…           what tasks need, as in the work folder, until then
//! NAME.parts.d/work/ID/block-N  what a task of this build leaves besides the cores
//! ```

use std::borrow::Cow;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
#[cfg(feature = "object-store")]
use std::sync::Arc;

#[cfg(feature = "object-store")]
use crate::io::open_in;
use crate::io::{Manifest, Objects, PARTS_FOLDER, id_name, is_id_name, is_manifest};
#[cfg(feature = "object-store")]
use crate::store::{OpenOptions, ReadError, TileReader};

/// Where the tasks of a build and its file in parts are: an object store.
///
/// Given to a build as [`BuildOptions::store`](crate::BuildOptions::store), with an output of the
/// same name on disk, in whose folder the build works. [`plan_tasks`](crate::Builder::plan_tasks)
/// puts there what tasks need, [`conquer`](Self::conquer) does a task, on any machine, and a
/// resumed build puts the file there, as parts and a manifest.
/// [`TileReader::open_url`](crate::TileReader::open_url) reads it.
#[derive(Clone, Debug)]
pub struct TaskStore {
    objects: Objects,
    /// The path of the manifest in the store.
    manifest: String,
}

impl TaskStore {
    /// Opens the store of the manifest at `s3://bucket/…/NAME.parts`. Credentials, and the endpoint if it
    /// differs from the default, come from environment variables such as `AWS_ACCESS_KEY_ID`.
    ///
    /// # Errors
    /// Fails if the name does not end with `.parts`, if the address is none of a store, or if the
    /// library was built without the feature `object-store`.
    pub fn at(url: &str) -> io::Result<Self> {
        if !is_manifest(url) {
            let message = format!("{url}: in a store, a file is in parts, and its name ends with .parts");
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
        let (objects, manifest) = Objects::at(url)?;
        Ok(Self { objects, manifest })
    }

    /// Returns the place of the manifest `path` in any store.
    #[cfg(feature = "object-store")]
    pub fn of(store: Arc<dyn object_store::ObjectStore>, path: &str) -> Self {
        Self {
            objects: Objects::of(store, "the store"),
            manifest: path.to_owned(),
        }
    }

    /// Returns the file name of the manifest.
    #[must_use]
    pub fn file_name(&self) -> &str {
        self.manifest.rsplit('/').next().unwrap_or_default()
    }

    /// Returns the path of the manifest in the store.
    pub(crate) fn manifest(&self) -> &str {
        &self.manifest
    }

    /// Returns whether there is a file of this name.
    pub(crate) async fn has_file(&self) -> io::Result<bool> {
        Ok(self.objects.length(&self.manifest).await?.is_some())
    }

    /// Opens the file for reading, once it is complete.
    ///
    /// # Errors
    /// Returns the errors of [`TileReader::open`].
    #[cfg(feature = "object-store")]
    pub async fn open(&self, options: OpenOptions) -> Result<TileReader, ReadError> {
        let opened = open_in(self.objects.clone(), &self.manifest).await;
        let file = opened.map_err(|error| ReadError::Io {
            file: self.manifest.as_str().into(),
            what: "the file".to_owned(),
            source: Arc::new(error),
        })?;
        TileReader::open_source(file, &self.manifest, options).await
    }

    fn folder(&self) -> String {
        format!("{}{PARTS_FOLDER}", self.manifest)
    }

    fn work(&self, file: &Path) -> String {
        format!("{}/work/{}", self.folder(), name_of(file))
    }

    fn blocks(&self, id: u64) -> String {
        format!("{}/work/{}", self.folder(), id_name(id))
    }

    /// Returns the path of a part, which the manifest names.
    fn part(&self, name: &str) -> String {
        match self.manifest.rsplit_once('/') {
            Some((folder, _)) => format!("{folder}/{name}"),
            None => name.to_owned(),
        }
    }

    /// Removes what an earlier build left for its tasks.
    pub(crate) async fn clear_work(&self) -> io::Result<()> {
        self.objects
            .remove_below(&self.folder(), |name| name == "work", &[])
            .await
    }

    /// Puts a file of a work folder there. Others find it by its name.
    pub(crate) async fn put_work(&self, file: &Path) -> io::Result<()> {
        put(&self.objects, &self.work(file), file).await
    }

    /// Fetches a file of a work folder. Returns `false` if there is none of this name.
    pub(crate) async fn fetch_work(&self, file: PathBuf) -> io::Result<bool> {
        self.objects.fetch(&self.work(&file), file).await
    }

    /// Puts the output of a task of the build `id` there: the cores of a block, as a part of the
    /// file, and then the rest.
    pub(crate) async fn put_block(&self, id: u64, cores: &Path, block: &Path) -> io::Result<()> {
        put(&self.objects, &self.cores(id, cores), cores).await?;
        put(&self.objects, &format!("{}/{}", self.blocks(id), name_of(block)), block).await
    }

    /// Fetches the output of a task without the cores. Returns `false` if it is not there.
    pub(crate) async fn fetch_block(&self, id: u64, block: PathBuf) -> io::Result<bool> {
        self.objects
            .fetch(&format!("{}/{}", self.blocks(id), name_of(&block)), block)
            .await
    }

    /// Returns the names of the outputs of tasks that are there.
    pub(crate) async fn block_names(&self, id: u64) -> io::Result<Vec<String>> {
        self.objects.names_in(&self.blocks(id)).await
    }

    /// Fetches the cores of a block. Returns `false` if they are not there.
    pub(crate) async fn fetch_cores(&self, id: u64, cores: PathBuf) -> io::Result<bool> {
        self.objects.fetch(&self.cores(id, &cores), cores).await
    }

    fn cores(&self, id: u64, cores: &Path) -> String {
        format!("{}/{}/{}", self.folder(), id_name(id), name_of(cores))
    }

    /// Puts a file in parts there, of which those that are on disk are below `folder`. The others
    /// must be there. At last, the manifest gets its name, and what other builds left under it is
    /// removed.
    pub(crate) async fn put_file(&self, manifest: Manifest, folder: &Path) -> io::Result<()> {
        let mut parts = manifest.parts;
        for part in &mut parts {
            let on_disk = folder.join(&part.name);
            let end = part.from + part.range.end - part.range.start;
            if part.name.ends_with("/main") {
                // It has gaps, and is large with them.
                let name = format!("{}-{}", part.name, part.from);
                let file = File::open(&on_disk)?;
                self.objects.put_file(&self.part(&name), file, part.from..end).await?;
                (part.name, part.from) = (name, 0);
            } else if on_disk.exists() {
                put(&self.objects, &self.part(&part.name), &on_disk).await?;
            } else if self.objects.length(&self.part(&part.name)).await? != Some(end) {
                let message = format!("{} is not in the store, or not complete", part.name);
                return Err(io::Error::new(io::ErrorKind::NotFound, message));
            }
        }
        let named: Vec<String> = parts.iter().map(|part| self.part(&part.name)).collect();
        let text = Manifest { parts }.text();
        self.objects.put(&self.manifest, text.into()).await?;
        let of_builds = |name: &str| name == "work" || is_id_name(name);
        self.objects.remove_below(&self.folder(), of_builds, &named).await
    }
}

fn name_of(file: &Path) -> Cow<'_, str> {
    file.file_name().unwrap_or_default().to_string_lossy()
}

async fn put(objects: &Objects, path: &str, file: &Path) -> io::Result<()> {
    let file = File::open(file)?;
    let length = file.metadata()?.len();
    objects.put_file(path, file, 0..length).await
}
