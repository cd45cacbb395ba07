//! The ids of the sites of an answer.

use std::collections::BTreeMap;

use crate::columns::Column;

/// The id of each site that was found. A site that is found often has one entry.
#[derive(Default)]
pub struct Names(BTreeMap<u64, Option<String>>);

impl Names {
    /// Adds a site.
    pub fn push(&mut self, number: u64, id: Option<String>) {
        self.0.entry(number).or_insert(id);
    }

    /// Returns the numbers, ascending, and the ids.
    pub fn into_columns(self) -> [Column; 2] {
        let (numbers, ids) = self.0.into_iter().map(|(number, id)| (number as i64, id)).unzip();
        [Column::I64(numbers), Column::Texts(ids)]
    }
}
