//! Messages about faults of lines and sites, which name the files that they come from.

use anyhow::Error;
use delaunay_tiles::store::VerifyError;
use delaunay_tiles::{
    BuildError, Crossing, Inverted, InvertedPolygons, MemoryShortage, MemoryUse, Overlapping, VertexWithoutZ, WithoutZ,
};

use super::read::LineInput;
use crate::common::{counted, thousands};

/// Maximum number of crossings that a build's error lists.
const LISTED: usize = 10;

impl LineInput {
    /// Returns the note about `parts` parts of polygons that are inside out, of which `first` is
    /// the first.
    pub fn inverted_note(&self, parts: u64, first: Inverted) -> String {
        let parts = match parts {
            1 => "1 part of a polygon is".to_owned(),
            parts => format!("{} parts of polygons are", thousands(parts)),
        };
        format!(
            "{parts} inside out, because rings are nested wrongly or cross, and still covered; the first is in {} at \
             ({}, {})",
            self.name(first.obstacle),
            first.point.x,
            first.point.y
        )
    }

    /// Adds the file and record of lines to an error that names them by number.
    pub fn name_in(&self, error: Error) -> Error {
        if let Some(VerifyError::Line { line, .. }) = error.downcast_ref() {
            let name = self.name(line.number());
            return error.context(name);
        }
        match error.downcast_ref() {
            Some(&BuildError::OpenRing { obstacle })
            | Some(&BuildError::Overlapping(Overlapping { obstacle, .. }))
            | Some(&BuildError::Memory(MemoryShortage {
                of: MemoryUse::Polygon { obstacle },
                ..
            })) => error.context(self.name(obstacle)),
            Some(BuildError::Inverted(inverted)) => Error::msg(self.inverted(inverted)),
            Some(BuildError::NoZ { first, count }) => Error::msg(self.without_z(first, *count)),
            Some(BuildError::Crossings { first, count }) => Error::msg(self.crossings(first, *count)),
            _ => error,
        }
    }

    fn inverted(&self, InvertedPolygons { first, polygons }: &InvertedPolygons) -> String {
        let others = match polygons {
            1 => String::new(),
            polygons => format!("; {} polygons are inside out", thousands(*polygons)),
        };
        format!(
            "{} is inside out at ({}, {}): one of its holes is outside the polygon or inside another hole, or one of its \
             rings has the opposite direction there{others}\ncorrect the polygon, or give --crossings split, which covers \
             such parts too",
            self.name(first.obstacle),
            first.point.x,
            first.point.y
        )
    }

    fn without_z(&self, first: &VertexWithoutZ, count: u64) -> String {
        let (x, y) = (first.point.x, first.point.y);
        let what = match (first.what, first.line) {
            (WithoutZ::End | WithoutZ::Crossing, Some(line)) => self.name(line.number()),
            (WithoutZ::Site(site), _) => self.site_name(site),
            (WithoutZ::Point(record), _) => format!("the point of record {record}"),
            _ => "a point where lines end or cross".to_owned(),
        };
        let all = counted(count, "vertex", "vertices");
        let or = match first.what {
            WithoutZ::Point(_) => "or",
            _ => "leave out --missing-z error if the points have z, or",
        };
        format!(
            "{what} has no z at ({x}, {y}), and no point with z is there; {all} would get z = 0, although other \
             vertices have z\nadd the missing z, {or} give --missing-z zero"
        )
    }

    fn crossings(&self, first: &[Crossing], count: u64) -> String {
        let mut text = match count {
            1 => "two lines cross:".to_owned(),
            count => format!("{} pairs of segments cross:", thousands(count)),
        };
        for crossing in first {
            let [one, other] = crossing.lines.map(|line| self.name(line.number()));
            let (x, y) = (crossing.point.x, crossing.point.y);
            text += &if one == other {
                format!("\n  {one} crosses itself at ({x}, {y})")
            } else {
                format!("\n  {one} and {other} at ({x}, {y})")
            };
        }
        // Identical segments cross twice but are listed once.
        if first.len() == LISTED && count > LISTED as u64 {
            text += "\n  and others";
        }
        text + "\nmake the lines meet in a common point, remove one of each pair, or give --crossings split"
    }
}
