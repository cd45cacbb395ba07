//! Contours that leave polygons, as the features of their parts.
//!
//! A segment may be cut by all edges of the polygons, so features are made piece by piece.

use std::ops::Range;
use std::sync::Arc;
use std::vec::IntoIter;

use super::features::{Contour, Encoding, Features};
use crate::export::error::ExportError;
use crate::geometry::Point;
use crate::terrain::{Clip, Cut, Piece};

/// The bytes of features that are made at once, but for one part of a feature.
const AT_ONCE: usize = 1 << 20;

/// A complete contour before it is cut.
pub(super) struct Whole {
    pub(super) z: f64,
    pub(super) points: Vec<Point>,
    pub(super) is_closed: bool,
}

/// Contours that are being cut.
pub(super) struct Clipped {
    clip: Arc<Clip>,
    encoding: Encoding,
    wholes: IntoIter<Whole>,
    /// The contour that is being cut, and its height.
    cut: Option<(Cut, f64)>,
    /// A part of it, and in which parts it is still to be formatted.
    piece: Option<(Piece, IntoIter<Range<usize>>)>,
}

impl Clipped {
    pub(super) fn new(clip: Arc<Clip>, encoding: Encoding, wholes: Vec<Whole>) -> Self {
        Self {
            clip,
            encoding,
            wholes: wholes.into_iter(),
            cut: None,
            piece: None,
        }
    }

    /// Returns the next features; `None` after the last ones.
    pub(super) fn next(&mut self) -> Result<Option<Features>, ExportError> {
        let mut features = Features::new(self.encoding);
        while features.bytes.len() < AT_ONCE {
            if let (Some((piece, parts)), Some((_, z))) = (&mut self.piece, &self.cut)
                && let Some(part) = parts.next()
            {
                let contour = Contour {
                    z: *z,
                    points: &piece.points,
                    is_closed: piece.is_closed,
                };
                features.add_part(contour, part)?;
            } else if let Some(piece) = self.cut.as_mut().and_then(|(cut, _)| cut.next()) {
                let parts = self.encoding.parts(piece.points.len());
                self.piece = Some((piece, parts.into_iter()));
            } else if let Some(Whole { z, points, is_closed }) = self.wholes.next() {
                self.piece = None;
                self.cut = Some((Cut::new(Arc::clone(&self.clip), points, is_closed), z));
            } else {
                break;
            }
        }
        Ok((features.points > 0).then_some(features))
    }
}
