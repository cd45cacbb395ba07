//! GeoJSON (RFC 7946): positions of all geometries, and where lines, geometries and features end.
//!
//! In: a document (FeatureCollection, Feature or any geometry), or many of them one after the other, as in
//! newline-delimited files. Out: every position in document order. Points are points; lines and polygons give their
//! vertices, a ring's closing one too, and a note says so. Null geometries have none.
//!
//! Nothing is kept but what is open, so that a polygon may be larger than memory; `type` may stand behind
//! `coordinates`. RFC 7946 (7.1) makes this safe: no object has the defining members of another type, which is checked
//! when it ends. Why not the crate `geojson`: its `FeatureReader` takes the file's first `[` for that of `features`
//! (a `bbox` before it is enough to fail) and holds a feature at a time.

use crate::input::bytes::ByteInput;
use crate::input::error::{InputError, Place};
use crate::input::formats::geojson::event::{Event, Kind, Position};
use crate::input::formats::geojson::ids::{FoundId, read_id, read_property};
use crate::input::formats::geojson::json::{Json, ValueType};
use crate::shown;
use crate::shown::excerpt;

const HINT: &str = "GeoJSON (RFC 7946) is due";

/// The deepest array of coordinates: a MultiPolygon's.
const LEVELS: usize = 4;

pub struct GeoJson {
    json: Json,
    open: Vec<Frame>,
    /// The arrays open in `coordinates`; 0 outside.
    level: usize,
    /// The position being read.
    position: Position,
    crs: Option<String>,
    polygons: Tally,
    lines: Tally,
    name: String,
    /// The member of a feature that is wanted as its id.
    id_field: Option<Box<str>>,
    /// The id of the feature that is at its end.
    id: Option<FoundId>,
    /// The place of a record that is at its end, and still to be told of.
    record: Option<Place>,
}

/// What is open, from the outside in, but for `coordinates`.
enum Frame {
    Object(Object),
    /// `features`.
    Features,
    /// `geometries`.
    Geometries,
}

/// What an object may be by its place.
#[derive(Clone, Copy, PartialEq)]
enum Role {
    Root,
    Feature,
    Geometry,
}

struct Object {
    role: Role,
    kind: Option<Kind>,
    /// Where it begins.
    place: Place,
    /// The defining members seen.
    features: bool,
    geometry: bool,
    coordinates: bool,
    geometries: bool,
    /// The level of its positions, if it has any.
    level: Option<usize>,
    /// Its arrays that ended, by level: `arrays[2]` are the rings of a polygon.
    arrays: [u64; LEVELS + 1],
    /// The same, but of the array around them alone.
    siblings: [u64; LEVELS + 1],
    /// The wanted property, and the member `id`.
    property: Option<FoundId>,
    id: Option<FoundId>,
}

/// Geometries of a kind, and their vertices.
#[derive(Default)]
struct Tally {
    geometries: u64,
    vertices: u64,
}

impl GeoJson {
    pub fn new(input: ByteInput) -> Result<Self, InputError> {
        let name = shown::path(&input.path);
        let mut this = Self {
            json: Json::new(input),
            open: Vec::new(),
            level: 0,
            position: Position::default(),
            crs: None,
            polygons: Tally::default(),
            lines: Tally::default(),
            name,
            id_field: None,
            id: None,
            record: None,
        };
        if this.json.is_blank() {
            return Err(this.json.malformed("the file is empty".to_owned(), HINT));
        }
        this.enter(Role::Root)?;
        Ok(this)
    }

    /// The type of the geometry whose coordinates come, if it is known by now.
    pub fn kind(&self) -> Option<Kind> {
        match self.open.last() {
            Some(Frame::Object(object)) => object.kind,
            _ => None,
        }
    }

    /// Keeps from now on the id of every feature: its property of this name, or its member `id` if that is the name and it
    /// has no such property.
    pub fn keep_ids(&mut self, field: &str) {
        self.id_field = Some(field.into());
    }

    /// The id of the feature that has just come to its end.
    pub fn take_id(&mut self) -> Option<FoundId> {
        self.id.take()
    }

    /// The coordinate reference system, if the document has told it by now.
    pub fn crs(&self) -> Option<&str> {
        self.crs.as_deref()
    }

    /// Which geometries have given vertices and are no points.
    pub fn notes(&self) -> Vec<String> {
        [("polygons give", &self.polygons), ("lines give", &self.lines)]
            .into_iter()
            .filter(|(_, tally)| tally.geometries > 0)
            .map(|(what, tally)| {
                format!(
                    "{}: {} {what} their {} vertices",
                    self.name, tally.geometries, tally.vertices
                )
            })
            .collect()
    }

    /// Begins an object that is due.
    fn enter(&mut self, role: Role) -> Result<(), InputError> {
        self.need(ValueType::Object, "this is not an object")?;
        self.json.begin_object()?;
        self.open.push(Frame::Object(Object {
            role,
            kind: None,
            place: Place::Byte(self.json.offset()),
            features: false,
            geometry: false,
            coordinates: false,
            geometries: false,
            level: None,
            arrays: [0; LEVELS + 1],
            siblings: [0; LEVELS + 1],
            property: None,
            id: None,
        }));
        Ok(())
    }

    /// Fails if the next value is not of this type.
    fn need(&mut self, wanted: ValueType, problem: &str) -> Result<(), InputError> {
        if self.json.peek()? == wanted {
            return Ok(());
        }
        Err(self.json.malformed(problem, HINT))
    }

    /// What comes next; `None` at the end of the file.
    pub fn next_event(&mut self) -> Result<Option<Event>, InputError> {
        loop {
            if self.level > 0 {
                if let Some(event) = self.coordinate()? {
                    return Ok(Some(event));
                }
                continue;
            }
            if let Some(place) = self.record.take() {
                return Ok(Some(Event::Record(place)));
            }
            let has_next = self.json.has_next()?;
            match self.open.last() {
                Some(Frame::Object(_)) if has_next => self.member()?,
                Some(Frame::Features) if has_next => self.enter(Role::Feature)?,
                Some(Frame::Geometries) if has_next => self.enter(Role::Geometry)?,
                None if has_next => self.enter(Role::Root)?,
                Some(Frame::Object(_)) => {
                    let mut geometry = None;
                    if let Some(Frame::Object(object)) = self.open.pop() {
                        self.leave(&object)?;
                        let kind = object.kind.filter(|_| object.coordinates);
                        geometry = kind.map(|kind| Event::Geometry(kind, object.place));
                        self.end_record(object);
                    }
                    self.json.end_object()?;
                    if geometry.is_some() {
                        return Ok(geometry);
                    }
                }
                Some(Frame::Features | Frame::Geometries) => {
                    self.open.pop();
                    self.json.end_array()?;
                }
                None => return Ok(None),
            }
        }
    }

    /// Notes it if an object that ended is a record.
    fn end_record(&mut self, object: Object) {
        let is_feature = object.kind == Some(Kind::Feature);
        if is_feature || (object.role == Role::Root && object.kind != Some(Kind::FeatureCollection)) {
            self.record = Some(object.place);
            self.id = object.property.or(object.id).filter(|_| is_feature);
        }
    }

    /// The next member of the object that is open.
    fn member(&mut self) -> Result<(), InputError> {
        let Some(Frame::Object(object)) = self.open.last_mut() else {
            return Ok(());
        };
        let role = object.role;
        let twice = |seen: &mut bool| std::mem::replace(seen, true);
        match self.json.name()? {
            "type" => {
                self.need(ValueType::String, "`type` is not a string")?;
                let name = self.json.string()?;
                let kind = Kind::from_name(name);
                if kind.is_none() {
                    let problem = format!("the type `{}` is not one of GeoJSON", excerpt(name.as_bytes()));
                    return Err(self.json.malformed(problem, HINT));
                }
                if let Some(Frame::Object(object)) = self.open.last_mut() {
                    object.kind = kind;
                }
            }
            "features" if role == Role::Root && !twice(&mut object.features) => {
                self.need(ValueType::Array, "`features` is not an array")?;
                self.json.begin_array()?;
                self.open.push(Frame::Features);
            }
            "geometries" if role != Role::Feature && !twice(&mut object.geometries) => {
                self.need(ValueType::Array, "`geometries` is not an array")?;
                self.json.begin_array()?;
                self.open.push(Frame::Geometries);
            }
            "geometry" if role != Role::Geometry && !twice(&mut object.geometry) => match self.json.peek()? {
                ValueType::Object => self.enter(Role::Geometry)?,
                ValueType::Null => self.json.skip()?,
                _ => return Err(self.json.malformed("`geometry` is not an object", HINT)),
            },
            "coordinates" if role != Role::Feature && !twice(&mut object.coordinates) => {
                self.need(ValueType::Array, "`coordinates` is not an array")?;
                self.begin_array()?;
            }
            "crs" if role == Role::Root && self.crs.is_none() => self.read_crs(&["properties", "name"])?,
            "properties" if role != Role::Geometry && self.id_field.is_some() => {
                let id = read_property(&mut self.json, self.id_field.as_deref())?;
                if let Some(id) = id
                    && let Some(Frame::Object(object)) = self.open.last_mut()
                {
                    object.property = id;
                }
            }
            "id" if role != Role::Geometry && self.id_field.as_deref() == Some("id") => {
                let id = read_id(&mut self.json)?;
                if let Some(Frame::Object(object)) = self.open.last_mut() {
                    object.id = id;
                }
            }
            _ => self.json.skip()?,
        }
        Ok(())
    }

    /// Passes over a `crs`, but for the string that is behind these names.
    fn read_crs(&mut self, names: &[&str]) -> Result<(), InputError> {
        match (names, self.json.peek()?) {
            ([], ValueType::String) => self.crs = Some(self.json.string()?.to_owned()),
            ([first, rest @ ..], ValueType::Object) => {
                self.json.begin_object()?;
                while self.json.has_next()? {
                    match self.json.name()? == *first {
                        true => self.read_crs(rest)?,
                        false => self.json.skip()?,
                    }
                }
                self.json.end_object()?;
            }
            _ => self.json.skip()?,
        }
        Ok(())
    }

    /// Begins an array within `coordinates`, or theirs.
    fn begin_array(&mut self) -> Result<(), InputError> {
        self.level += 1;
        if let Some(Frame::Object(object)) = self.open.last_mut()
            && let Some(inside) = object.siblings.get_mut(self.level + 1)
        {
            *inside = 0;
        }
        self.position = Position {
            offset: self.json.offset(),
            ..Position::default()
        };
        self.json.begin_array()
    }

    /// A piece within `coordinates`; gives the position, or the line, that it ends.
    fn coordinate(&mut self) -> Result<Option<Event>, InputError> {
        let Some(Frame::Object(object)) = self.open.last_mut() else {
            return Ok(None);
        };
        let in_position = object.level == Some(self.level);
        if !self.json.has_next()? {
            object.arrays[self.level] += 1;
            let line = object.siblings[self.level];
            object.siblings[self.level] += 1;
            let ends_line = object.level == Some(self.level + 1);
            self.level -= 1;
            self.json.end_array()?;
            return Ok(match (in_position, ends_line) {
                (true, _) => Some(Event::Position(self.position)),
                (_, true) => Some(Event::LineEnd(line)),
                _ => None,
            });
        }
        match self.json.peek()? {
            ValueType::Array if in_position || self.level == LEVELS => {
                let problem = "an array too deep within `coordinates`";
                return Err(self.json.malformed(problem, HINT));
            }
            ValueType::Array => self.begin_array()?,
            found if found != ValueType::Object && (in_position || object.level.is_none()) => {
                object.level = Some(self.level);
                if found == ValueType::Number {
                    let number = self.json.number()?;
                    if let Some(value) = self.position.values.get_mut(self.position.length) {
                        *value = number;
                    }
                } else {
                    self.json.skip()?;
                    self.position.strange = true;
                }
                self.position.length += 1;
            }
            _ => {
                let problem = "positions and arrays mixed within `coordinates`";
                return Err(self.json.malformed(problem, HINT));
            }
        }
        Ok(None)
    }

    /// An object ended: is it what its type says?
    fn leave(&mut self, object: &Object) -> Result<(), InputError> {
        let Some(kind) = object.kind else {
            return Err(self.json.malformed("an object without a `type`", HINT));
        };
        let place_ok = match object.role {
            Role::Root => true,
            Role::Feature => kind == Kind::Feature,
            Role::Geometry => !matches!(kind, Kind::Feature | Kind::FeatureCollection),
        };
        let seen = (object.features, object.geometry, object.geometries, object.coordinates);
        let members_ok = match kind {
            Kind::FeatureCollection => seen == (true, false, false, false),
            // Some writers leave a null geometry out.
            Kind::Feature => matches!(seen, (false, _, false, false)),
            Kind::GeometryCollection => seen == (false, false, true, false),
            _ => seen == (false, false, false, true) && object.level.is_none_or(|level| level == kind.level()),
        };
        if !place_ok || !members_ok {
            let problem = format!("an object of type {kind:?} has not the members, or not the place, of one");
            return Err(self.json.malformed(problem, HINT));
        }
        let (tally, geometries) = match kind {
            Kind::LineString => (&mut self.lines, 1),
            Kind::MultiLineString => (&mut self.lines, object.arrays[2]),
            Kind::Polygon => (&mut self.polygons, 1),
            Kind::MultiPolygon => (&mut self.polygons, object.arrays[2]),
            _ => return Ok(()),
        };
        tally.geometries += geometries;
        tally.vertices += object.arrays[kind.level()];
        Ok(())
    }
}
