//! What is wrong with bytes that should be a part of a tile file.

/// A sentence about the part that was read, which says how it contradicts the format or itself. Readers add which file and
/// which tile.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub(crate) struct Damage(Box<str>);

impl Damage {
    pub(crate) fn new(reason: impl Into<Box<str>>) -> Self {
        Self(reason.into())
    }

    /// It is `part` that is damaged.
    pub(crate) fn of(self, part: &str) -> Self {
        Self::new(format!("{part}: {self}"))
    }
}

impl From<Damage> for String {
    fn from(damage: Damage) -> Self {
        damage.0.into()
    }
}
