//! What is wrong with lines and sites, told by the files that they come from.

use anyhow::Error;
use delaunay_tiles::store::VerifyError;
use delaunay_tiles::{
    BuildError, Crossing, Inverted, InvertedPolygons, MemoryShortage, MemoryUse, VertexWithoutZ, WithoutZ,
};

use super::read::Lines;
use crate::common::thousands;

/// Crossings that a build tells of.
const TOLD: usize = 10;

impl Lines {
    /// Says of parts of polygons that are inside out where the first one is.
    pub fn inverted_note(&self, parts: u64, first: Inverted) -> String {
        let parts = match parts {
            1 => "1 part of a polygon is".to_owned(),
            parts => format!("{} parts of polygons are", thousands(parts)),
        };
        format!(
            "{parts} inside out, since rings are nested wrongly or cross, and covered all the same; the first is of {} at \
             ({}, {})",
            self.name(first.obstacle),
            first.point.x,
            first.point.y
        )
    }

    /// Says of an error that speaks of lines by their numbers which they are.
    pub fn name_in(&self, error: Error) -> Error {
        if let Some(VerifyError::Line { line, .. }) = error.downcast_ref() {
            let name = self.name(line.number());
            return error.context(name);
        }
        match error.downcast_ref() {
            Some(&BuildError::OpenRing { obstacle })
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
            "{} is inside out at ({}, {}): a hole of it lies outside of it or in another of its holes, or a ring of it \
             runs round there the other way{others}\nput it right, or give --crossings split, which covers such parts too",
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
        let all = match count {
            1 => "one vertex".to_owned(),
            count => format!("{} vertices", thousands(count)),
        };
        format!(
            "{what} has no z at ({x}, {y}), where no point with z lies; {all} would get z = 0, and others have z\n\
             give z to all, or give --missing-z zero"
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
        // Segments that are there twice cross twice, and are told of once.
        if first.len() == TOLD && count > TOLD as u64 {
            text += "\n  and others";
        }
        text + "\nlet them meet in a point, leave one of each pair out, or give --crossings split"
    }
}
