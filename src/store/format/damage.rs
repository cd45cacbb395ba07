//! The error for bytes that should be a part of a tile file.

/// A sentence that says how the part that was read contradicts the format or itself. Readers add
/// the file and the tile.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub(crate) struct Damage(Box<str>);

impl Damage {
    pub(crate) fn new(reason: impl Into<Box<str>>) -> Self {
        Self(reason.into())
    }

    /// Adds the name of the damaged `part` in front.
    pub(crate) fn of(self, part: &str) -> Self {
        Self::new(format!("{part}: {self}"))
    }
}

impl From<Damage> for String {
    fn from(damage: Damage) -> Self {
        damage.0.into()
    }
}
