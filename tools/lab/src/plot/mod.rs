//! Charts, and figures of shapes in the plane, in the style of the tool's maps.

pub mod chart;
pub mod figure;
