//! WKT of coordinate reference systems as a tree of nodes: `KEYWORD["name", 1.5, CHILD[…]]`, with
//! brackets or parentheses. Source: OGC 12-063r5 (WKT 2), OGC 01-009 (WKT 1).

/// The maximum depth and the maximum length in bytes of a text. Real ones have a depth of ten and a
/// few KiB.
const MAX_DEPTH: usize = 32;
const MAX_LENGTH: usize = 1 << 18;

/// A node of the tree.
#[derive(Debug, Default, PartialEq)]
pub struct Node {
    /// The keyword, in capitals.
    pub keyword: String,
    /// The quoted texts, without quotes.
    pub texts: Vec<String>,
    /// The numbers, in order.
    pub numbers: Vec<f64>,
    /// The words without quotes that are no numbers, such as directions of axes.
    pub words: Vec<String>,
    pub children: Vec<Node>,
}

impl Node {
    /// Parses a text that is one node. Returns `None` for any other text.
    pub fn parse(text: &str) -> Option<Self> {
        if text.len() > MAX_LENGTH || !text.starts_with(|c: char| c.is_ascii_alphabetic()) {
            return None;
        }
        // The nodes that are open, from the outermost one inwards.
        let mut open: Vec<Self> = Vec::new();
        let mut word = String::new();
        let mut characters = text.chars().peekable();
        while let Some(c) = characters.next() {
            match c {
                '"' => loop {
                    match characters.next()? {
                        // A quote within a text is doubled.
                        '"' if characters.next_if_eq(&'"').is_some() => word.push('"'),
                        '"' => {
                            open.last_mut()?.texts.push(std::mem::take(&mut word));
                            break;
                        }
                        c => word.push(c),
                    }
                },
                '[' | '(' => {
                    if open.len() == MAX_DEPTH || word.is_empty() {
                        return None;
                    }
                    open.push(Self {
                        keyword: std::mem::take(&mut word).to_ascii_uppercase(),
                        ..Self::default()
                    });
                }
                ',' | ']' | ')' => {
                    let word = std::mem::take(&mut word);
                    match word.parse::<f64>().ok().filter(|number| number.is_finite()) {
                        Some(number) => open.last_mut()?.numbers.push(number),
                        None if word.is_empty() => {}
                        None => open.last_mut()?.words.push(word),
                    }
                    if c == ',' {
                        continue;
                    }
                    let node = open.pop()?;
                    let Some(parent) = open.last_mut() else {
                        // Only blanks may follow the root.
                        return characters.all(char::is_whitespace).then_some(node);
                    };
                    parent.children.push(node);
                }
                c if c.is_whitespace() => {}
                c => word.push(c),
            }
        }
        None
    }

    /// Returns the first child with one of these keywords.
    pub fn child(&self, keywords: &[&str]) -> Option<&Self> {
        self.children.iter().find(|child| keywords.contains(&&*child.keyword))
    }
}
