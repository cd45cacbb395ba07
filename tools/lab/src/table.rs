//! A table that is written as CSV with all digits, and as Markdown for people.

use tiletool::common;

/// A value in a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Text.
    Text(String),
    /// A whole number.
    Count(u64),
    /// A number, and its number of decimals in Markdown.
    Number(f64, usize),
    /// An unknown value.
    Missing,
}

impl Cell {
    /// Creates a number that may be missing.
    pub fn number(value: Option<f64>, decimals: usize) -> Self {
        value.map_or(Self::Missing, |value| Self::Number(value, decimals))
    }

    /// Creates a whole number that may be missing.
    pub fn count(value: Option<u64>) -> Self {
        value.map_or(Self::Missing, Self::Count)
    }

    /// Returns the value with all digits, for CSV.
    fn exact(&self) -> String {
        match self {
            Self::Text(text) => common::cell(text),
            Self::Count(count) => count.to_string(),
            Self::Number(value, _) if value.is_finite() => value.to_string(),
            Self::Number(..) | Self::Missing => String::new(),
        }
    }

    /// Returns the value as people read it, for Markdown.
    fn short(&self) -> String {
        match self {
            Self::Text(text) => text.replace('|', "\\|").replace(['\n', '\r'], " "),
            Self::Count(count) => common::thousands(*count),
            Self::Number(value, decimals) if value.is_finite() => format!("{value:.decimals$}"),
            Self::Number(..) | Self::Missing => "–".to_owned(),
        }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<u64> for Cell {
    fn from(count: u64) -> Self {
        Self::Count(count)
    }
}

/// Rows under named columns.
pub struct Table {
    columns: Vec<&'static str>,
    rows: Vec<Vec<Cell>>,
}

/// The name of a column, and the function that computes an item's cell in it.
pub type Column<T> = (&'static str, fn(&T) -> Cell);

impl Table {
    /// Creates a table with a row for each item.
    pub fn of<'t, T: 't>(columns: &[Column<T>], items: impl IntoIterator<Item = &'t T>) -> Self {
        let row = |item| columns.iter().map(|(_, cell)| cell(item)).collect();
        Self {
            columns: columns.iter().map(|&(name, _)| name).collect(),
            rows: items.into_iter().map(row).collect(),
        }
    }

    /// Creates a table without rows.
    pub fn new<const N: usize>(columns: [&'static str; N]) -> Self {
        Self {
            columns: columns.to_vec(),
            rows: Vec::new(),
        }
    }

    /// Appends a row, which has a cell for each column.
    pub fn push<const N: usize>(&mut self, row: [Cell; N]) {
        debug_assert_eq!(self.columns.len(), N);
        self.rows.push(row.to_vec());
    }

    /// Returns the table as CSV: a header first, numbers with all digits; unknown values are empty.
    pub fn csv(&self) -> String {
        let mut text = self.columns.join(",");
        text.push('\n');
        for row in &self.rows {
            text += &row.iter().map(Cell::exact).collect::<Vec<_>>().join(",");
            text.push('\n');
        }
        text
    }

    /// Returns the table as Markdown; columns without text are right-aligned.
    pub fn markdown(&self) -> String {
        let mut text = format!("| {} |\n|", self.columns.join(" | "));
        for column in 0..self.columns.len() {
            let words = self.rows.iter().any(|row| matches!(row[column], Cell::Text(_)));
            text += if words { " --- |" } else { " --: |" };
        }
        text.push('\n');
        for row in &self.rows {
            let cells: Vec<_> = row.iter().map(Cell::short).collect();
            text += &format!("| {} |\n", cells.join(" | "));
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn csv_has_all_digits_and_markdown_few() {
        let mut table = Table::new(["name", "n", "x"]);
        table.push(["a,\"b\"".into(), Cell::Count(12345), Cell::Number(1.0 / 3.0, 2)]);
        table.push(["a|b".into(), Cell::Missing, Cell::Number(f64::NAN, 2)]);
        assert_eq!(
            table.csv(),
            "name,n,x\n\"a,\"\"b\"\"\",12345,0.3333333333333333\na|b,,\n"
        );
        assert_eq!(
            table.markdown(),
            "| name | n | x |\n| --- | --: | --: |\n| a,\"b\" | 12 345 | 0.33 |\n| a\\|b | – | – |\n"
        );
    }
}
