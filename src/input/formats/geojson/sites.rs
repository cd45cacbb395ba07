//! The points of GeoJSON as sites.

use crate::input::bytes::ByteInput;
use crate::input::error::{InputError, Place, RecordKind};
use crate::input::flaw::Flaw;
use crate::input::formats::geojson::event::{Event, Kind};
use crate::input::formats::geojson::features::Features;
use crate::input::reader::{Reader, Sink};
use crate::input::sites::{SiteBatch, SiteId};
use crate::input::spot::Spot;
use crate::shown;

pub struct Sites {
    features: Features,
    /// The member that is the id, if one was chosen.
    id_field: Option<Box<str>>,
    /// The points of the feature at hand, which are kept since its id may come last. The geometries at their end are all
    /// points; of the one at hand only its end tells.
    spots: Vec<Spot>,
    /// How many are of geometries at their end.
    sure: usize,
    /// How the feature is handed out, if it is at its end.
    due: Option<Due>,
    name: String,
    /// Geometries that are no points.
    others: u64,
}

/// A feature that is handed out.
struct Due {
    id: Option<SiteId>,
    /// The sites so far.
    given: usize,
}

fn is_point(kind: Kind) -> bool {
    matches!(kind, Kind::Point | Kind::MultiPoint)
}

impl Sites {
    pub fn new(input: ByteInput, id_field: Option<&str>) -> Result<Self, InputError> {
        let name = shown::path(&input.path);
        Ok(Self {
            features: Features::new(input, id_field, is_point)?,
            id_field: id_field.map(Into::into),
            spots: Vec::new(),
            sure: 0,
            due: None,
            name,
            others: 0,
        })
    }

    /// A feature is at its end.
    fn end_feature(&mut self, place: Place, sink: &Sink<'_, SiteBatch>) -> Result<(), InputError> {
        let found = self.features.take_id();
        if self.spots.is_empty() {
            return Ok(());
        }
        let id = match (found, &self.id_field) {
            (Some(found), _) => found.map(Some),
            (None, None) => Ok(None),
            (None, Some(field)) => Err(Flaw::NoIdProperty {
                field: field.to_string(),
            }),
        };
        let id = id.map_err(|flaw| sink.wrong(RecordKind::Site, sink.next(), place, &flaw))?;
        self.due = Some(Due { id, given: 0 });
        Ok(())
    }

    /// Hands out a site of a feature at its end.
    fn give(&mut self, mut due: Due, sink: &mut Sink<'_, SiteBatch>) {
        if let Some(&spot) = self.spots.get(due.given) {
            sink.site(spot, due.id.clone());
            due.given += 1;
            self.due = Some(due);
        } else {
            self.spots.clear();
            self.sure = 0;
        }
    }
}

impl Reader<SiteBatch> for Sites {
    fn has_z(&self) -> bool {
        self.features.has_z()
    }

    fn fill(&mut self, sink: &mut Sink<'_, SiteBatch>) -> Result<bool, InputError> {
        while !sink.is_full() {
            if let Some(due) = self.due.take() {
                self.give(due, sink);
                continue;
            }
            match self.features.next_event()? {
                None => return Ok(false),
                Some(Event::Position(position)) => {
                    if self.features.json().kind().is_some_and(|kind| !is_point(kind)) {
                        continue;
                    }
                    let number = sink.next() + self.spots.len() as u64;
                    let spot = position.spot();
                    let spot = spot.map_err(|flaw| sink.wrong(RecordKind::Site, number, position.place(), &flaw))?;
                    self.spots.push(spot);
                }
                Some(Event::Geometry(kind, _)) if is_point(kind) => self.sure = self.spots.len(),
                Some(Event::Geometry(..)) => {
                    self.spots.truncate(self.sure);
                    self.others += 1;
                }
                Some(Event::LineEnd(_)) => {}
                Some(Event::Record(place)) => self.end_feature(place, sink)?,
            }
        }
        Ok(true)
    }

    fn notes(&self) -> Vec<String> {
        match self.others {
            0 => Vec::new(),
            n => vec![format!(
                "{}: {n} geometries are no points, and give no sites",
                self.name
            )],
        }
    }
}
