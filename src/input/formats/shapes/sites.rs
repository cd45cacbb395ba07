//! Points as sites.

use crate::input::error::{InputError, Location, RecordKind};
use crate::input::flaw::Flaw;
use crate::input::formats::shapes::Shapes;
use crate::input::formats::shapes::event::{Event, Kind};
use crate::input::formats::shapes::features::Features;
use crate::input::point_z::PointZ;
use crate::input::reader::{Reader, Sink};
use crate::input::sites::{SiteBatch, SiteId};
use crate::shown;
use std::path::Path;

pub struct Sites {
    features: Features,
    /// The member that is the id, if one is selected.
    id_field: Option<Box<str>>,
    /// The points of the current feature, kept since its id may come last. Geometries that have
    /// ended are all points; the type of the current one is certain only at its end.
    points: Vec<PointZ>,
    /// The number of `points` that belong to geometries that have ended.
    certain_count: usize,
    /// The progress of handing out the feature, if it has ended.
    pending: Option<PendingFeature>,
    name: String,
    /// The number of geometries that are not points.
    others: u64,
}

/// The progress of handing out a feature.
struct PendingFeature {
    id: Option<SiteId>,
    /// The number of sites handed out so far.
    emitted: usize,
}

fn is_point(kind: Kind) -> bool {
    matches!(kind, Kind::Point | Kind::MultiPoint)
}

impl Sites {
    pub fn new(shapes: Box<dyn Shapes>, path: &Path, id_field: Option<&str>) -> Result<Self, InputError> {
        let name = shown::path(path);
        Ok(Self {
            features: Features::new(shapes, id_field, is_point)?,
            id_field: id_field.map(Into::into),
            points: Vec::new(),
            certain_count: 0,
            pending: None,
            name,
            others: 0,
        })
    }

    /// Ends the current feature.
    fn end_feature(&mut self, location: Location, sink: &Sink<'_, SiteBatch>) -> Result<(), InputError> {
        let found = self.features.take_id();
        if self.points.is_empty() {
            return Ok(());
        }
        let id = match (found, &self.id_field) {
            (Some(found), _) => found.map(Some),
            (None, None) => Ok(None),
            (None, Some(field)) => Err(Flaw::NoIdProperty {
                field: field.to_string(),
            }),
        };
        let id = id.map_err(|flaw| sink.wrong(RecordKind::Site, sink.next(), location, &flaw))?;
        self.pending = Some(PendingFeature { id, emitted: 0 });
        Ok(())
    }

    /// Hands out a site of a feature that has ended.
    fn emit(&mut self, mut pending: PendingFeature, sink: &mut Sink<'_, SiteBatch>) {
        if let Some(&point) = self.points.get(pending.emitted) {
            sink.site(point, pending.id.clone());
            pending.emitted += 1;
            self.pending = Some(pending);
        } else {
            self.points.clear();
            self.certain_count = 0;
        }
    }
}

impl Reader<SiteBatch> for Sites {
    fn has_z(&self) -> bool {
        self.features.has_z()
    }

    fn crs(&self) -> Option<&str> {
        self.features.crs()
    }

    fn fill(&mut self, sink: &mut Sink<'_, SiteBatch>) -> Result<bool, InputError> {
        while !sink.is_full() {
            if let Some(pending) = self.pending.take() {
                self.emit(pending, sink);
                continue;
            }
            match self.features.next_event()? {
                None => return Ok(false),
                Some(Event::Position(position)) => {
                    if self.features.kind().is_some_and(|kind| !is_point(kind)) {
                        continue;
                    }
                    let number = sink.next() + self.points.len() as u64;
                    let point_z = position.point_z();
                    let point_z =
                        point_z.map_err(|flaw| sink.wrong(RecordKind::Site, number, position.location, &flaw))?;
                    self.points.push(point_z);
                }
                Some(Event::Geometry(kind, _)) if is_point(kind) => self.certain_count = self.points.len(),
                Some(Event::Geometry(..)) => {
                    self.points.truncate(self.certain_count);
                    self.others += 1;
                }
                Some(Event::LineEnd(_)) => {}
                Some(Event::Record(location)) => self.end_feature(location, sink)?,
            }
        }
        Ok(true)
    }

    fn notes(&self) -> Vec<String> {
        let others = || {
            format!(
                "{}: {} geometries are no points, and give no sites",
                self.name, self.others
            )
        };
        let others = (self.others > 0).then(others);
        self.features.notes().into_iter().chain(others).collect()
    }
}
