//! The two parts of a tile, which are encoded and stored apart.

/// The two parts of a tile.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Part {
    Core,
    Border,
}
