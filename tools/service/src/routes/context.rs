//! What every request for a file begins with: its snapshot, its tag, and whether the client has the answer.

use std::sync::Arc;

use axum::http::HeaderMap;
use axum::response::Response;
use delaunay_tiles::map_tiles::MapSource;

use super::input::Input;
use crate::catalog::Snapshot;
use crate::etag::Tag;
use crate::parameters::Parameters;
use crate::problem::Problem;
use crate::reply::{Keep, Reply, add_tag, not_modified};
use crate::state::Service;

/// A request for a file.
pub struct Context<'a> {
    /// The service.
    pub service: Service,
    /// The state of the file.
    pub snapshot: Arc<Snapshot>,
    /// The version of the state.
    pub version: Arc<str>,
    headers: &'a HeaderMap,
    keep: Keep,
}

impl<'a> Context<'a> {
    /// Finds the file. Takes `v` from the parameters.
    ///
    /// # Errors
    /// Fails if there is no such file, if it cannot be read, or if the service ends.
    pub async fn new(service: Service, input: &'a Input, parameters: &mut Parameters) -> Result<Self, Problem> {
        if service.is_draining() {
            return Err(Problem::busy("the service ends"));
        }
        let snapshot = service.catalog().get(input.part("id"))?.snapshot().await?;
        let version = Arc::clone(snapshot.version());
        // Another version may be one that is to come; so only this one is kept.
        let keep = match parameters.version()? {
            Some(known) if *known == *version => Keep::Forever,
            _ => Keep::Ask,
        };
        Ok(Self {
            service,
            snapshot,
            version,
            headers: &input.headers,
            keep,
        })
    }

    /// Returns the id of the file.
    pub fn id(&self) -> &str {
        self.snapshot.reader.name()
    }

    /// Returns what map tiles of the file are drawn from.
    ///
    /// # Errors
    /// Fails if the file cannot be read.
    pub async fn maps(&self) -> Result<&MapSource, Problem> {
        let maps = self.snapshot.maps().await;
        maps.map_err(|error| Problem::of_read(self.id(), &error))
    }

    /// Returns the tag of a resource of this file.
    pub fn tag(&self, resource: &str) -> Tag {
        Tag::new(&self.version, resource)
    }

    /// Returns the response to a client that has the resource already.
    pub fn known(&self, tag: &Tag) -> Option<Response> {
        tag.is_known(self.headers).then(|| not_modified(tag, self.keep))
    }

    /// Returns how long the client may keep an answer.
    pub fn keep(&self) -> Keep {
        self.keep
    }

    /// Adds a tag to headers, and how long the client may keep the answer.
    pub fn add_to(&self, headers: &mut HeaderMap, tag: &Tag) {
        add_tag(headers, Some(tag), self.keep);
    }

    /// Sends an answer. `tag` is `None` if the same request may have another answer.
    ///
    /// # Errors
    /// Fails if too many bytes wait for clients.
    pub async fn send(&self, reply: Reply, tag: Option<Tag>) -> Result<Response, Problem> {
        let reply = match tag {
            Some(tag) => reply.tagged(tag, self.keep),
            None => reply,
        };
        reply.send(self.headers, self.service.outgoing()).await
    }
}
