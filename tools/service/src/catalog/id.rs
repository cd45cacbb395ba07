//! Names of files in URLs.

use std::path::Path;

/// First parts of paths that are no files.
const RESERVED: &[&str] = &["catalog", "health", "metrics", "openapi.json", "page", "assets", "_"];

/// Returns the id of a file: its name without the last ending.
///
/// # Errors
/// Returns why the name cannot be in a URL.
pub fn of(path: &Path) -> Result<String, String> {
    let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
    let is_safe = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.' | '~');
    if stem.is_empty() || stem.starts_with('.') || !stem.chars().all(is_safe) {
        return Err(
            "its name cannot be in a URL; rename it with letters of ASCII, digits and the characters - _ . ~ only"
                .to_owned(),
        );
    }
    if RESERVED.contains(&stem) {
        return Err(format!("`{stem}` is a path of the service; rename the file"));
    }
    Ok(stem.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_stems_that_need_no_escapes() {
        assert_eq!(of(Path::new("maps/town.v2.tiles")), Ok("town.v2".to_owned()));
        for name in [
            "a b.tiles",
            "a%2f.tiles",
            "größe.tiles",
            ".tiles",
            "..",
            "catalog.tiles",
            "health",
        ] {
            assert!(of(Path::new(name)).is_err(), "{name}");
        }
    }
}
