//! The available in-core engines, and their names.

use std::fmt;
use std::str::FromStr;

use super::divide_conquer::DivideConquer;
use super::engine::Engine;
#[cfg(feature = "spade")]
use super::spade_engine::SpadeEngine;

/// An in-core engine. All engines give the same triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum EngineKind {
    /// The library's own divide and conquer.
    #[default]
    Native,
    /// Crate `spade`, followed by flips that make its result canonical.
    #[cfg(feature = "spade")]
    Spade,
}

impl EngineKind {
    /// All engines that this build of the library has.
    pub const ALL: &'static [Self] = &[
        Self::Native,
        #[cfg(feature = "spade")]
        Self::Spade,
    ];

    /// Creates an engine of this kind.
    #[must_use]
    pub fn create(self) -> Box<dyn Engine> {
        match self {
            Self::Native => Box::<DivideConquer>::default(),
            #[cfg(feature = "spade")]
            Self::Spade => Box::<SpadeEngine>::default(),
        }
    }

    /// Returns the engine's name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Native => "native",
            #[cfg(feature = "spade")]
            Self::Spade => "spade",
        }
    }
}

impl fmt::Display for EngineKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The error of a name that no engine has.
#[derive(Clone, Debug, thiserror::Error)]
#[error("no engine is called '{0}'; there are: {names}", names = EngineKind::ALL.iter().map(|e| e.name()).collect::<Vec<_>>().join(", "))]
pub struct UnknownEngine(String);

impl FromStr for EngineKind {
    type Err = UnknownEngine;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        Self::ALL
            .iter()
            .copied()
            .find(|e| e.name() == name)
            .ok_or_else(|| UnknownEngine(name.to_owned()))
    }
}
