//! The page that lists all files. It has no scripts.

use std::fmt::Write;

use axum::response::Response;
use delaunay_tiles::crs::Crs;

use super::input::Input;
use crate::catalog::Snapshot;
use crate::problem::Problem;
use crate::reply::Reply;
use crate::state::Service;

const HEAD: &str = include_str!("index.html");

/// Answers with the page.
///
/// # Errors
/// Fails if too many bytes wait for clients.
pub async fn page(service: Service, input: Input) -> Result<Response, Problem> {
    let mut list = String::new();
    for file in service.catalog().files() {
        // Ids need no escapes; other texts do.
        match file.snapshot().await {
            Ok(snapshot) => push(&mut list, &file.id, &snapshot, service.options().raw),
            Err(problem) => {
                _ = write!(
                    list,
                    "<section><h2>{}</h2><p class=\"bad\">{}</p></section>",
                    file.id,
                    escaped(&problem.what)
                )
            }
        }
    }
    let page = HEAD
        .replace("{{files}}", &list)
        .replace("{{version}}", env!("CARGO_PKG_VERSION"));
    Reply::new("text/html; charset=utf-8", page)
        .send(&input.headers, service.outgoing())
        .await
}

/// Appends what is known of a file.
fn push(list: &mut String, id: &str, snapshot: &Snapshot, raw: bool) {
    let (reader, metadata) = (&snapshot.reader, snapshot.reader.metadata());
    let crs = snapshot
        .crs
        .as_ref()
        .map_or_else(|| "not named".to_owned(), Crs::summary);
    let bounds = metadata.bounds;
    let extent = match bounds.is_empty() {
        true => "empty".to_owned(),
        false => format!(
            "{} … {}, {} … {}",
            bounds.min_x, bounds.max_x, bounds.min_y, bounds.max_y
        ),
    };
    let rows = [
        ("triangles", grouped(metadata.triangles)),
        ("vertices", grouped(metadata.vertices)),
        ("sites", grouped(metadata.sites)),
        ("heights", if metadata.has_z { "yes" } else { "no" }.to_owned()),
        ("reference system", escaped(&crs)),
        ("extent", extent),
        ("generation", reader.generation().to_string()),
        ("size", format!("{} bytes", grouped(reader.file_length()))),
    ];
    _ = write!(list, "<section><h2><a href=\"{id}\">{id}</a></h2><dl>");
    for (name, value) in rows {
        _ = write!(list, "<div><dt>{name}</dt><dd>{value}</dd></div>");
    }
    let mut links = vec![
        (format!("{id}/native/shade.json"), "pictures"),
        (format!("{id}/native/mesh.json"), "vectors"),
    ];
    if metadata.has_z {
        links.push((format!("{id}/native/terrarium.json"), "heights"));
        links.push((format!("{id}/terrain/layer.json"), "terrain"));
    }
    if raw {
        links.push((format!("{id}/raw"), "file"));
    }
    _ = write!(list, "</dl><p class=\"links\">");
    for (url, name) in links {
        _ = write!(list, "<a href=\"{url}\">{name}</a>");
    }
    _ = write!(list, "</p></section>");
}

/// Formats a number with thin spaces between groups of three digits.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

fn escaped(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_files_cannot_be_markup() {
        assert_eq!(escaped("<b>\"&\n"), "&lt;b&gt;&quot;&amp; ");
        assert_eq!(grouped(1_234_567), "1\u{202f}234\u{202f}567");
    }
}
