//! The page that shows the files, and its scripts and styles, which are in the program.

use std::collections::BTreeMap;
use std::io::Write;
use std::sync::{LazyLock, OnceLock};

use axum::http::{HeaderName, HeaderValue, header};
use axum::response::Response;
use bytes::Bytes;
use flate2::Compression;
use flate2::write::GzEncoder;
use rust_embed::RustEmbed;
use xxhash_rust::xxh3::Xxh3;

use super::input::Input;
use crate::etag::Tag;
use crate::problem::Problem;
use crate::reply::{Keep, Reply, not_modified};
use crate::state::Service;

const INDEX: &str = "index.html";
/// What the page may load: what this service serves. MapLibre makes pictures from `data:` and `blob:`.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; \
    connect-src 'self'; worker-src 'self'; base-uri 'self'; form-action 'none'; frame-ancestors 'self'";
const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";

#[derive(RustEmbed)]
#[folder = "page/"]
struct Folder;

/// The files of the page.
static ASSETS: LazyLock<Assets> = LazyLock::new(Assets::load);

struct Assets {
    /// Names the content of all files. It is in their URLs, so browsers keep them.
    version: String,
    files: BTreeMap<String, Asset>,
}

struct Asset {
    media: &'static str,
    bytes: Bytes,
    gzipped: OnceLock<Bytes>,
}

impl Assets {
    fn load() -> Self {
        let (mut files, mut hash) = (BTreeMap::new(), Xxh3::new());
        let mut names: Vec<_> = Folder::iter().collect();
        names.sort_unstable();
        for name in names {
            let Some(file) = Folder::get(&name) else { continue };
            hash.update(name.as_bytes());
            hash.update(&file.data);
            let asset = Asset {
                media: media(&name),
                bytes: Bytes::from(file.data.into_owned()),
                gzipped: OnceLock::new(),
            };
            files.insert(name.into_owned(), asset);
        }
        let version = format!("{:016x}", hash.digest());
        Self { version, files }
    }

    /// Returns the links that ask for all modules at once. Otherwise a browser would learn their names
    /// from one another. Workers load their own.
    fn modules(&self) -> String {
        let is_module = |name: &str| media(name) == SCRIPT && !name.ends_with("-worker.mjs");
        let names = self.files.keys().filter(|name| is_module(name));
        let links = names.map(|name| format!(r#"<link rel="modulepreload" href="{{{{assets}}}}/{name}">"#));
        links.collect::<Vec<_>>().join("\n")
    }
}

impl Asset {
    /// Returns the bytes compressed. They are compressed once, on a thread for blocking work.
    async fn gzipped(&'static self) -> Option<Bytes> {
        match self.gzipped.get() {
            Some(gzipped) => Some(gzipped.clone()),
            None => tokio::task::spawn_blocking(|| self.compress()).await.ok()?,
        }
    }

    fn compress(&self) -> Option<Bytes> {
        let mut encoder = GzEncoder::new(Vec::with_capacity(self.bytes.len() / 3), Compression::best());
        encoder.write_all(&self.bytes).ok()?;
        let gzipped = Bytes::from(encoder.finish().ok()?);
        Some(self.gzipped.get_or_init(|| gzipped).clone())
    }
}

/// Returns the media type of a file of the page.
fn media(name: &str) -> &'static str {
    match name.rsplit('.').next() {
        Some("html") => HTML,
        Some("css") => "text/css; charset=utf-8",
        Some("js" | "mjs") => SCRIPT,
        Some("svg") => "image/svg+xml",
        _ => "text/plain; charset=utf-8",
    }
}

/// Answers with the page.
///
/// # Errors
/// Fails if too many bytes wait for clients.
pub async fn index(service: Service, input: Input) -> Result<Response, Problem> {
    let template = ASSETS.files.get(INDEX).ok_or_else(Problem::defect)?;
    let ids: Vec<&str> = service.catalog().ids().collect();
    // Ids need no escapes.
    let page = String::from_utf8_lossy(&template.bytes)
        .replace("{{base}}", &base(input.original.path()))
        .replace("{{modules}}", &ASSETS.modules())
        .replace("{{assets}}", &format!("page/{}", ASSETS.version))
        .replace("{{files}}", &serde_json::json!(ids).to_string())
        .replace("{{version}}", env!("CARGO_PKG_VERSION"));
    let tag = Tag::new(&ASSETS.version, &page);
    if tag.is_known(&input.headers) {
        return Ok(not_modified(&tag, Keep::Ask));
    }
    let reply = Reply::new(HTML, page).tagged(tag, Keep::Ask);
    let mut response = reply.send(&input.headers, service.outgoing()).await?;
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_SECURITY_POLICY, HeaderValue::from_static(POLICY));
    headers.insert(header::REFERRER_POLICY, HeaderValue::from_static("no-referrer"));
    Ok(response)
}

/// Returns the folder of the service, relative to the page at this path. A router within another one
/// may be at a path without a slash at its end.
fn base(path: &str) -> String {
    let last = path.rsplit('/').next().unwrap_or_default();
    let is_safe = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_' | '~');
    match last.is_empty() || !last.chars().all(is_safe) {
        true => "./".to_owned(),
        false => format!("./{last}/"),
    }
}

/// Answers with a file of the page.
///
/// # Errors
/// Fails if there is no such file, or if too many bytes wait for clients.
pub async fn asset(service: Service, input: Input) -> Result<Response, Problem> {
    let name = input.part("file");
    let asset = ASSETS.files.get(name).filter(|_| name != INDEX);
    let asset = asset.ok_or_else(Problem::no_route)?;
    let keep = match input.part("version") == ASSETS.version {
        true => Keep::Forever,
        false => Keep::Ask,
    };
    let tag = Tag::new(&ASSETS.version, name);
    if tag.is_known(&input.headers) {
        return Ok(not_modified(&tag, keep));
    }
    let mut reply = Reply::new(asset.media, asset.bytes.clone()).tagged(tag, keep);
    reply.gzipped = asset.gzipped().await;
    let mut response = reply.send(&input.headers, service.outgoing()).await?;
    let nosniff = HeaderName::from_static("x-content-type-options");
    response
        .headers_mut()
        .insert(nosniff, HeaderValue::from_static("nosniff"));
    Ok(response)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_folder_of_the_service_is_found_with_and_without_a_slash() {
        assert_eq!(base("/"), "./");
        assert_eq!(base("/maps/"), "./");
        assert_eq!(base("/maps"), "./maps/");
        assert_eq!(base("/\"x"), "./");
    }
}
