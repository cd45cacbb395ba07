//! The page `schema/FORMAT.md`, as tables for a reader.

use std::collections::HashMap;
use std::path::Path;

/// A row of a table with offsets: the offset and the length of a field, in bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldPosition {
    pub offset: usize,
    pub bytes: usize,
}

/// The tables of the page, by their headings.
#[derive(Default)]
pub struct Page {
    /// Fields of superblocks and structs.
    pub positions: HashMap<String, Vec<(String, FieldPosition)>>,
    /// Fields of FlatBuffers tables, by slot, each with name and type.
    pub slots: HashMap<String, Vec<(String, String)>>,
    /// Limits by name, without thousands separators.
    pub limits: HashMap<String, String>,
}

fn read(file: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../schema").join(file)).unwrap()
}

impl Page {
    pub fn read() -> Self {
        let text = read("FORMAT.md");
        let mut this = Self::default();
        let (mut heading, mut columns) = (String::new(), Vec::new());
        for line in text.lines() {
            if let Some(title) = line.strip_prefix("### ").or_else(|| line.strip_prefix("## ")) {
                (heading, columns) = (title.to_owned(), Vec::new());
            }
            let Some(row) = line.strip_prefix('|').and_then(|row| row.strip_suffix('|')) else {
                continue;
            };
            let cells: Vec<String> = row.split('|').map(|c| c.trim().trim_matches('`').to_owned()).collect();
            if columns.is_empty() {
                columns = cells;
                continue;
            }
            if cells[0].starts_with("---") {
                continue;
            }
            match (columns[0].as_str(), columns[1].as_str()) {
                ("offset", "bytes") => {
                    let position = FieldPosition {
                        offset: cells[0].parse().unwrap(),
                        bytes: cells[1].parse().unwrap(),
                    };
                    this.positions
                        .entry(heading.clone())
                        .or_default()
                        .push((cells[2].clone(), position));
                }
                ("slot", "field") => {
                    let slots = this.slots.entry(heading.clone()).or_default();
                    assert_eq!(cells[0], slots.len().to_string(), "slots of {heading} are in order");
                    slots.push((cells[1].clone(), cells[2].clone()));
                }
                ("what", "limit") => {
                    this.limits.insert(cells[0].clone(), cells[1].replace(',', ""));
                }
                other => panic!("a table with columns {other:?}"),
            }
        }
        this
    }

    pub fn position(&self, table: &str, field: &str) -> FieldPosition {
        let fields = self
            .positions
            .get(table)
            .unwrap_or_else(|| panic!("the page has no table {table}"));
        let found = fields.iter().find(|(name, _)| name == field);
        found.unwrap_or_else(|| panic!("the table {table} has no {field}")).1
    }

    /// Returns the length of a superblock or a struct in bytes.
    pub fn size(&self, table: &str) -> usize {
        let (_, last) = self.positions[table].last().unwrap();
        last.offset + last.bytes
    }

    pub fn slot(&self, table: &str, field: &str) -> usize {
        let fields = self
            .slots
            .get(table)
            .unwrap_or_else(|| panic!("the page has no table {table}"));
        let found = fields.iter().position(|(name, _)| name == field);
        found.unwrap_or_else(|| panic!("the table {table} has no {field}"))
    }
}

/// A table or struct of a schema.
pub struct Declared {
    pub is_struct: bool,
    pub name: String,
    /// Names and types of the fields, in order.
    pub fields: Vec<(String, String)>,
}

/// Returns what the schemas declare.
pub fn schemas() -> Vec<Declared> {
    let text = ["tile.fbs", "directory.fbs"].map(read).concat();
    let mut found: Vec<Declared> = Vec::new();
    for line in text.lines().map(|line| line.split("//").next().unwrap().trim()) {
        let words: Vec<&str> = line.split_whitespace().collect();
        if let [kind @ ("table" | "struct"), name, "{"] = words[..] {
            found.push(Declared {
                is_struct: kind == "struct",
                name: name.to_owned(),
                fields: Vec::new(),
            });
        } else if let Some((name, rest)) = line.split_once(':') {
            let kind = rest.trim_end_matches(';').replace("(required)", "");
            let fields = &mut found.last_mut().unwrap().fields;
            fields.push((name.trim().to_owned(), kind.trim().to_owned()));
        }
    }
    found
}
