//! The stages of a progressive answer.

use delaunay_tiles::query::Cost;
use serde_json::{Value, json};

use crate::common::counted;

/// The stage of a progressive answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stage {
    /// The fast answer, with the expected cost of the exact one.
    Fast(Cost),
    /// The exact answer.
    Exact,
}

impl Stage {
    /// The CSV columns of the stage, after all others.
    pub const HEADER: &str = "stage,exact_tiles,exact_seconds";

    pub fn cells(self) -> String {
        match self {
            Self::Fast(cost) => format!("fast,{},{}", cost.tiles, cost.time.as_secs_f64()),
            Self::Exact => "exact,,".to_owned(),
        }
    }

    /// Adds the stage to an object.
    pub fn add_to(self, object: &mut Value) {
        object["stage"] = match self {
            Self::Fast(cost) => {
                object["exact_cost"] = json!({"tiles": cost.tiles, "seconds": cost.time.as_secs_f64()});
                "fast".into()
            }
            Self::Exact => "exact".into(),
        };
    }

    pub fn prefix(self) -> String {
        match self {
            Self::Fast(Cost { tiles, time }) => {
                let seconds = time.as_secs_f64();
                let tiles = counted(tiles, "tile", "tiles");
                format!("fast (the exact answer may take {tiles} and {seconds:.3} s): ")
            }
            Self::Exact => "exact: ".to_owned(),
        }
    }
}
