//! An HTTP client that reads only the part of a server's error that a message needs.
//!
//! The crate `object_store` gathers the body of every error in memory, however long it is. The
//! answer to a request for a range is bounded where it is [gathered](crate::io::object::Object).

use std::fmt;

use futures::StreamExt;
use object_store::ClientOptions;
use object_store::client::{
    HttpClient, HttpConnector, HttpError, HttpRequest, HttpResponse, HttpService, ReqwestConnector,
};

/// The number of bytes of an error that are read.
const LONGEST_ERROR: usize = 4 << 10;

/// A connector of guarded clients.
#[derive(Debug)]
pub(super) struct Guard;

struct Guarded(HttpClient);

impl fmt::Debug for Guarded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Guarded").finish_non_exhaustive()
    }
}

impl HttpConnector for Guard {
    fn connect(&self, options: &ClientOptions) -> object_store::Result<HttpClient> {
        // The first cryptography provider installed in a process stays. If the program has chosen
        // one, that one is used.
        let _ = rustls::crypto::ring::default_provider().install_default();
        let client = ReqwestConnector::default().connect(options)?;
        Ok(HttpClient::new(Guarded(client)))
    }
}

#[async_trait::async_trait]
impl HttpService for Guarded {
    async fn call(&self, request: HttpRequest) -> Result<HttpResponse, HttpError> {
        let answer = self.0.execute(request).await?;
        if answer.status().is_success() {
            return Ok(answer);
        }
        let (parts, body) = answer.into_parts();
        let (mut text, mut body) = (Vec::new(), body.bytes_stream());
        // An error while the body of an error is read is ignored.
        while let Some(Ok(part)) = body.next().await
            && text.len() < LONGEST_ERROR
        {
            text.extend_from_slice(&part[..part.len().min(LONGEST_ERROR - text.len())]);
        }
        let text = String::from_utf8_lossy(&text).into_owned();
        Ok(HttpResponse::from_parts(parts, text.into()))
    }
}
