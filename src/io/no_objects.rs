//! Stands for the objects of a store in a library without the feature `object-store`.

use std::fs::File;
use std::io;
use std::ops::Range;
use std::path::PathBuf;

use bytes::Bytes;
use futures::future::BoxFuture;

/// Objects of a store, of which there are none.
#[derive(Clone, Debug)]
pub(crate) enum Objects {}

impl Objects {
    /// Fails.
    pub(crate) fn at(url: &str) -> io::Result<(Self, String)> {
        let message = format!("{url}: the library was built without the feature `object-store`");
        Err(io::Error::new(io::ErrorKind::Unsupported, message))
    }

    pub(crate) fn put(&self, _: &str, _: Bytes) -> BoxFuture<'static, io::Result<()>> {
        match *self {}
    }

    pub(crate) fn put_file(&self, _: &str, _: File, _: Range<u64>) -> BoxFuture<'static, io::Result<()>> {
        match *self {}
    }

    pub(crate) fn length(&self, _: &str) -> BoxFuture<'static, io::Result<Option<u64>>> {
        match *self {}
    }

    pub(crate) fn fetch(&self, _: &str, _: PathBuf) -> BoxFuture<'static, io::Result<bool>> {
        match *self {}
    }

    pub(crate) fn names_in(&self, _: &str) -> BoxFuture<'static, io::Result<Vec<String>>> {
        match *self {}
    }

    pub(crate) fn remove_below(
        &self,
        _: &str,
        _: fn(&str) -> bool,
        _: &[String],
    ) -> BoxFuture<'static, io::Result<()>> {
        match *self {}
    }
}
