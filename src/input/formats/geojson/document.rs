//! GeoJSON (RFC 7946) as a stream of events: the positions of all geometries, and the ends of
//! lines, geometries and features.
//!
//! In: a document (FeatureCollection, Feature or any geometry), or a sequence of documents, as in
//! newline-delimited files. Out: every position in document order. Points give points; lines and
//! polygons give their vertices, including the closing one of a ring, and a note reports this. Null
//! geometries have no positions.
//!
//! Only the state of open objects and arrays is stored, so a polygon may be larger than memory.
//! `type` may come after `coordinates`. RFC 7946 (7.1) makes this safe: no object has the defining
//! members of another type, which is checked when the object ends. The crate `geojson` is not used:
//! its `FeatureReader` takes the file's first `[` for that of `features` (a preceding `bbox` makes
//! it fail) and stores a whole feature at a time.

use crate::input::about::Field;
use crate::input::bytes::ByteInput;
use crate::input::error::{InputError, Location};
use crate::input::formats::geojson::fields::Fields;
use crate::input::formats::geojson::ids::{read_id, read_property};
use crate::input::formats::geojson::json::{Json, ValueType};
use crate::input::formats::geojson::kinds::{kind_of, level_of};
use crate::input::formats::shapes::{Event, FoundId, Kind, Position, Shapes};
use crate::shown::excerpt;

const HINT: &str = "expected GeoJSON (RFC 7946)";

/// The depth of the deepest array of coordinates, in a MultiPolygon.
const LEVELS: usize = 4;

pub struct GeoJson {
    json: Json,
    open: Vec<Frame>,
    /// The number of open arrays in `coordinates`; 0 outside.
    level: usize,
    /// The position being read.
    position: Position,
    crs: Option<String>,
    /// The member of a feature that is its id.
    id_field: Option<Box<str>>,
    /// The properties of all features, if they are to be listed.
    fields: Option<Fields>,
    /// The id of the feature that has just ended.
    id: Option<FoundId>,
    /// The location of a record that has ended and is still to be reported.
    record: Option<Location>,
}

/// An open object or array, from the outside in, except arrays within `coordinates`.
enum Frame {
    Object(Object),
    /// `features`.
    Features,
    /// `geometries`.
    Geometries,
}

/// What an object may be, according to the position where it appears.
#[derive(Clone, Copy, PartialEq)]
enum Role {
    Root,
    Feature,
    Geometry,
}

struct Object {
    role: Role,
    kind: Option<Kind>,
    /// Where the object begins.
    location: Location,
    /// Whether the defining members were seen.
    features: bool,
    geometry: bool,
    coordinates: bool,
    geometries: bool,
    /// The level of the positions, if there are any.
    level: Option<usize>,
    /// The number of arrays that ended within the enclosing array, by level: `siblings[2]` counts
    /// the rings of a polygon.
    siblings: [u64; LEVELS + 1],
    /// The wanted property, and the member `id`.
    property: Option<FoundId>,
    id: Option<FoundId>,
}

impl Shapes for GeoJson {
    fn next_event(&mut self) -> Result<Option<Event>, InputError> {
        loop {
            if self.level > 0 {
                if let Some(event) = self.coordinate()? {
                    return Ok(Some(event));
                }
                continue;
            }
            if let Some(location) = self.record.take() {
                return Ok(Some(Event::Record(location)));
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
                        geometry = kind.map(|kind| Event::Geometry(kind, object.location));
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

    fn kind(&self) -> Option<Kind> {
        match self.open.last() {
            Some(Frame::Object(object)) => object.kind,
            _ => None,
        }
    }

    /// The id is the property `field`, or the member `id` if `field` is `id` and the feature has no
    /// such property.
    fn keep_ids(&mut self, field: &str) {
        self.id_field = Some(field.into());
    }

    fn take_id(&mut self) -> Option<FoundId> {
        self.id.take()
    }

    fn keep_fields(&mut self) {
        self.fields = Some(Fields::default());
    }

    fn fields(&self) -> Vec<Field> {
        self.fields.as_ref().map_or_else(Vec::new, Fields::list)
    }

    fn crs(&self) -> Option<&str> {
        self.crs.as_deref()
    }
}

impl GeoJson {
    pub fn new(input: ByteInput) -> Result<Self, InputError> {
        let mut this = Self {
            json: Json::new(input),
            open: Vec::new(),
            level: 0,
            position: no_position(0),
            crs: None,
            id_field: None,
            fields: None,
            id: None,
            record: None,
        };
        if this.json.is_blank() {
            return Err(this.json.malformed("the file is empty".to_owned(), HINT));
        }
        this.enter(Role::Root)?;
        Ok(this)
    }

    /// Begins an object, which must come next.
    fn enter(&mut self, role: Role) -> Result<(), InputError> {
        self.need(ValueType::Object, "this is not an object")?;
        self.json.begin_object()?;
        self.open.push(Frame::Object(Object {
            role,
            kind: None,
            location: Location::Byte(self.json.offset()),
            features: false,
            geometry: false,
            coordinates: false,
            geometries: false,
            level: None,
            siblings: [0; LEVELS + 1],
            property: None,
            id: None,
        }));
        Ok(())
    }

    /// Fails if the next value is not of the type `wanted`.
    fn need(&mut self, wanted: ValueType, problem: &str) -> Result<(), InputError> {
        if self.json.peek()? == wanted {
            return Ok(());
        }
        Err(self.json.malformed(problem, HINT))
    }

    /// Records that a record has ended, if `object` is one.
    fn end_record(&mut self, object: Object) {
        let is_feature = object.kind == Some(Kind::Feature);
        if is_feature || (object.role == Role::Root && object.kind != Some(Kind::FeatureCollection)) {
            self.record = Some(object.location);
            self.id = object.property.or(object.id).filter(|_| is_feature);
        }
    }

    /// Reads the next member of the open object.
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
                let kind = kind_of(name);
                if kind.is_none() {
                    let problem = format!("the type `{}` is not a GeoJSON type", excerpt(name.as_bytes()));
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
            "properties" if role != Role::Geometry && self.fields.is_some() => {
                if let Some(fields) = &mut self.fields {
                    fields.read(&mut self.json)?;
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

    /// Skips a `crs`, except the string at the path `names`.
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

    /// Begins the array `coordinates` or an array within it.
    fn begin_array(&mut self) -> Result<(), InputError> {
        self.level += 1;
        if let Some(Frame::Object(object)) = self.open.last_mut()
            && let Some(inside) = object.siblings.get_mut(self.level + 1)
        {
            *inside = 0;
        }
        self.position = no_position(self.json.offset());
        self.json.begin_array()
    }

    /// Reads one token within `coordinates`. Returns the position or the line that it ends.
    fn coordinate(&mut self) -> Result<Option<Event>, InputError> {
        let Some(Frame::Object(object)) = self.open.last_mut() else {
            return Ok(None);
        };
        let in_position = object.level == Some(self.level);
        if !self.json.has_next()? {
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
                    self.position.has_non_number = true;
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

    /// Checks that an object that has ended matches its type.
    fn leave(&mut self, object: &Object) -> Result<(), InputError> {
        let Some(kind) = object.kind else {
            return Err(self.json.malformed("an object without a `type`", HINT));
        };
        let role_ok = match object.role {
            Role::Root => true,
            Role::Feature => kind == Kind::Feature,
            Role::Geometry => !matches!(kind, Kind::Feature | Kind::FeatureCollection),
        };
        let seen = (object.features, object.geometry, object.geometries, object.coordinates);
        let members_ok = match kind {
            Kind::FeatureCollection => seen == (true, false, false, false),
            // Some writers omit a null geometry.
            Kind::Feature => matches!(seen, (false, _, false, false)),
            Kind::GeometryCollection => seen == (false, false, true, false),
            _ => seen == (false, false, false, true) && object.level.is_none_or(|level| level == level_of(kind)),
        };
        if !role_ok || !members_ok {
            let problem = format!("an object of type {kind:?} has wrong members, or is in the wrong position");
            return Err(self.json.malformed(problem, HINT));
        }
        Ok(())
    }
}

/// Returns a position without elements at this offset.
fn no_position(offset: u64) -> Position {
    Position {
        values: [0.0; 3],
        length: 0,
        has_non_number: false,
        location: Location::Byte(offset),
    }
}
