//! Charts, and figures of whatever lies in the plane, in the style of the tool's maps.

pub mod chart;
pub mod figure;
