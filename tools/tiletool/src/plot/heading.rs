//! The two lines of text above a map.

/// Maximum number of characters of a file's name.
const MAX_NAME: usize = 70;
/// Maximum number of characters of a title, which would be too small otherwise.
const MAX_TITLE: usize = 160;

/// A title, and a line about the map below it.
pub struct Heading {
    pub title: String,
    pub subtitle: String,
}

impl Heading {
    /// Creates the heading of a map of a file. Without a title, the name of the file is the title.
    pub fn new(name: &str, title: Option<&str>, subtitle: &str) -> Self {
        let name = middle_cut(name, MAX_NAME);
        match title {
            Some(title) => Self {
                title: middle_cut(title, MAX_TITLE),
                subtitle: format!("{name}  ·  {subtitle}"),
            },
            None => Self {
                title: name,
                subtitle: subtitle.to_owned(),
            },
        }
    }

    /// Returns both lines.
    pub fn lines(&self) -> [&str; 2] {
        [&self.title, &self.subtitle]
    }
}

/// Shortens a text that is too long for a line, by cutting out its middle.
fn middle_cut(text: &str, most: usize) -> String {
    let characters: Vec<char> = text.chars().collect();
    if characters.len() <= most {
        return text.to_owned();
    }
    let (start, end) = (&characters[..most / 2], &characters[characters.len() - most / 2..]);
    start.iter().chain(&['…']).chain(end).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_title_moves_the_name_of_the_file_to_the_second_line() {
        let heading = Heading::new("a.tiles", None, "3 vertices");
        assert_eq!(heading.lines(), ["a.tiles", "3 vertices"]);
        let heading = Heading::new("a.tiles", Some("A town"), "3 vertices");
        assert_eq!(heading.lines(), ["A town", "a.tiles  ·  3 vertices"]);
        let long = Heading::new(&"ä".repeat(71), Some(&"é".repeat(1000)), "");
        assert_eq!(long.title.chars().count(), MAX_TITLE + 1);
        assert_eq!(long.subtitle, format!("{0}…{0}  ·  ", "ä".repeat(35)));
    }
}
