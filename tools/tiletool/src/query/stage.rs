//! Which of two answers one is.

use delaunay_tiles::query::Cost;
use serde_json::{Value, json};

/// Which of the two answers one is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stage {
    /// The fast one, with what the exact one is expected to cost.
    Fast(Cost),
    Exact,
}

impl Stage {
    /// What stands behind the other columns of a table.
    pub const HEADER: &str = "stage,exact_tiles,exact_seconds";

    pub fn cells(self) -> String {
        match self {
            Self::Fast(cost) => format!("fast,{},{}", cost.tiles, cost.time.as_secs_f64()),
            Self::Exact => "exact,,".to_owned(),
        }
    }

    /// Puts it into an object.
    pub fn tell(self, object: &mut Value) {
        object["stage"] = match self {
            Self::Fast(cost) => {
                object["exact_cost"] = json!({"tiles": cost.tiles, "seconds": cost.time.as_secs_f64()});
                "fast".into()
            }
            Self::Exact => "exact".into(),
        };
    }

    pub fn text(self) -> String {
        match self {
            Self::Fast(Cost { tiles, time }) => {
                let seconds = time.as_secs_f64();
                format!("fast, while the exact answer may take {tiles} tiles and {seconds:.3} s: ")
            }
            Self::Exact => "exact: ".to_owned(),
        }
    }
}
