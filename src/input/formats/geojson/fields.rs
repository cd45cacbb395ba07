//! The names of properties, and the types of their values.

use crate::input::about::{Field, MOST_FIELDS};
use crate::input::error::InputError;
use crate::input::formats::geojson::json::{Json, ValueType};

/// The limit on the characters of a name that is kept.
const LONGEST_NAME: usize = 256;

/// The types of values, in the order in which they are listed.
const TYPES: [&str; 6] = ["number", "string", "boolean", "object", "array", "null"];

/// The properties of all features so far, in the order in which they first appeared.
#[derive(Default)]
pub struct Fields {
    /// The name of each, and the types of its values as bits.
    found: Vec<(String, u8)>,
}

impl Fields {
    /// Reads `properties`.
    pub fn read(&mut self, json: &mut Json) -> Result<(), InputError> {
        if json.peek()? != ValueType::Object {
            return json.skip();
        }
        json.begin_object()?;
        // Features usually have the same properties in the same order.
        let mut next = 0;
        while json.has_next()? {
            let name = json.name()?;
            let end = name.char_indices().nth(LONGEST_NAME).map_or(name.len(), |(end, _)| end);
            let at = self.place(&name[..end], next);
            let kind = json.peek()?;
            json.skip()?;
            if let Some(at) = at {
                self.found[at].1 |= 1 << kind_number(kind);
                next = at + 1;
            }
        }
        json.end_object()
    }

    /// Returns the place of a name, which is probably `guess`; `None` if there are too many names.
    fn place(&mut self, name: &str, guess: usize) -> Option<usize> {
        if self.found.get(guess).is_some_and(|(of, _)| of == name) {
            return Some(guess);
        }
        if let Some(at) = self.found.iter().position(|(of, _)| of == name) {
            return Some(at);
        }
        (self.found.len() < MOST_FIELDS).then(|| {
            self.found.push((name.to_owned(), 0));
            self.found.len() - 1
        })
    }

    pub fn list(&self) -> Vec<Field> {
        let field = |(name, kinds): &(String, u8)| {
            let kinds = (0..).zip(TYPES).filter(|(bit, _)| kinds >> bit & 1 != 0);
            let kinds: Vec<&str> = kinds.map(|(_, name)| name).collect();
            Field::new(name.clone(), kinds.join(" or "))
        };
        self.found.iter().map(field).collect()
    }
}

/// Returns the place of a type in [`TYPES`].
fn kind_number(kind: ValueType) -> u8 {
    match kind {
        ValueType::Number => 0,
        ValueType::String => 1,
        ValueType::Boolean => 2,
        ValueType::Object => 3,
        ValueType::Array => 4,
        ValueType::Null => 5,
    }
}
