//! GeoJSON (RFC 7946): positions of all geometries.
//!
//! In: a document (FeatureCollection, Feature or any geometry), or many of them one after the other, as in
//! newline-delimited files. Out: every position in document order. Points are points; lines and polygons give their
//! vertices, a ring's closing one too, and a note says so. Null geometries have none.
//!
//! Nothing is kept but what is open, so that a polygon may be larger than memory; `type` may stand behind
//! `coordinates`. RFC 7946 (7.1) makes this safe: no object has the defining members of another type, which is checked
//! when it ends. Why not the crate `geojson`: its `FeatureReader` takes the file's first `[` for that of `features`
//! (a `bbox` before it is enough to fail) and holds a feature at a time.

use super::bytes::{Buffered, ByteInput};
use super::json::{Event, Json};
use super::sink::Sink;
use super::source::Reader;
use super::{InputError, Place};

const HINT: &str = "GeoJSON (RFC 7946) is due";

/// The deepest array of coordinates: a MultiPolygon's.
const LEVELS: usize = 4;

pub(super) struct GeoJson {
    json: Json,
    open: Vec<Frame>,
    /// The arrays open in `coordinates`; 0 outside.
    level: usize,
    /// The position being read.
    position: Position,
    /// The first position, read at open to learn whether it has z.
    first: Option<Position>,
    has_z: bool,
    crs: Option<String>,
    polygons: Tally,
    lines: Tally,
    name: String,
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
    /// The defining members seen.
    features: bool,
    geometry: bool,
    coordinates: bool,
    geometries: bool,
    /// The level of its positions, if it has any.
    level: Option<usize>,
    /// Its arrays that ended, by level: `arrays[2]` are the rings of a polygon.
    arrays: [u64; LEVELS + 1],
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    FeatureCollection,
    Feature,
    GeometryCollection,
    Point,
    MultiPoint,
    LineString,
    MultiLineString,
    Polygon,
    MultiPolygon,
}

impl Kind {
    fn from_name(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"FeatureCollection" => Self::FeatureCollection,
            b"Feature" => Self::Feature,
            b"GeometryCollection" => Self::GeometryCollection,
            b"Point" => Self::Point,
            b"MultiPoint" => Self::MultiPoint,
            b"LineString" => Self::LineString,
            b"MultiLineString" => Self::MultiLineString,
            b"Polygon" => Self::Polygon,
            b"MultiPolygon" => Self::MultiPolygon,
            _ => return None,
        })
    }

    /// The level of its positions.
    fn level(self) -> usize {
        match self {
            Self::FeatureCollection | Self::Feature | Self::GeometryCollection => 0,
            Self::Point => 1,
            Self::MultiPoint | Self::LineString => 2,
            Self::MultiLineString | Self::Polygon => 3,
            Self::MultiPolygon => 4,
        }
    }
}

/// A position, good or not.
#[derive(Clone, Copy, Default)]
struct Position {
    values: [f64; 3],
    /// Its elements, more than three too.
    length: usize,
    /// Whether all elements are numbers.
    strange: bool,
    offset: u64,
}

impl Position {
    fn put(self, sink: &mut Sink<'_>) -> Result<(), InputError> {
        let place = || Place::Byte(self.offset);
        let [x, y, z] = self.values;
        if self.strange {
            sink.invalid(place, || "an element of the position is not a number".to_owned())
        } else if self.length < 2 {
            sink.invalid(place, || {
                format!("the position has {} of at least 2 elements", self.length)
            })
        } else {
            sink.point(x, y, (self.length > 2).then_some(z), place)
        }
    }
}

/// Geometries of a kind, and their vertices.
#[derive(Default)]
struct Tally {
    geometries: u64,
    vertices: u64,
}

impl GeoJson {
    pub fn new(input: ByteInput) -> Result<Self, InputError> {
        let name = input.path.display().to_string();
        let mut this = Self {
            json: Json::new(Buffered::new(input))?,
            open: Vec::new(),
            level: 0,
            position: Position::default(),
            first: None,
            has_z: false,
            crs: None,
            polygons: Tally::default(),
            lines: Tally::default(),
            name,
        };
        match this.json.next()? {
            Event::ObjectStart => this.enter(Role::Root),
            Event::End => return Err(this.json.malformed("the file is empty".to_owned(), HINT)),
            _ => return Err(this.json.malformed("this is not an object".to_owned(), HINT)),
        }
        this.first = this.next_position()?;
        this.has_z = this.first.is_some_and(|position| position.length > 2);
        Ok(this)
    }

    fn enter(&mut self, role: Role) {
        self.open.push(Frame::Object(Object {
            role,
            kind: None,
            features: false,
            geometry: false,
            coordinates: false,
            geometries: false,
            level: None,
            arrays: [0; LEVELS + 1],
        }));
    }

    /// The next position; `None` at the end of the file.
    fn next_position(&mut self) -> Result<Option<Position>, InputError> {
        loop {
            let event = self.json.next()?;
            if self.level > 0 {
                if let Some(position) = self.coordinate(event)? {
                    return Ok(Some(position));
                }
                continue;
            }
            match (self.open.last_mut(), event) {
                (Some(Frame::Object(_)), Event::Key) => self.member()?,
                (Some(Frame::Object(_)), Event::ObjectEnd) => {
                    if let Some(Frame::Object(object)) = self.open.pop() {
                        self.leave(&object)?;
                    }
                }
                (Some(Frame::Features), Event::ObjectStart) => self.enter(Role::Feature),
                (Some(Frame::Geometries), Event::ObjectStart) => self.enter(Role::Geometry),
                (Some(Frame::Features | Frame::Geometries), Event::ArrayEnd) => {
                    self.open.pop();
                }
                (None, Event::ObjectStart) => self.enter(Role::Root),
                (None, Event::End) => return Ok(None),
                _ => return Err(self.json.malformed("this is not an object".to_owned(), HINT)),
            }
        }
    }

    /// A member of the object that is open: its name was read.
    fn member(&mut self) -> Result<(), InputError> {
        let Some(Frame::Object(object)) = self.open.last_mut() else {
            return Ok(());
        };
        let role = object.role;
        let twice = |seen: &mut bool| std::mem::replace(seen, true);
        match self.json.text() {
            b"type" => match self.json.next()? {
                Event::String => match Kind::from_name(self.json.text()) {
                    Some(kind) => object.kind = Some(kind),
                    None => {
                        let name = super::error::excerpt(self.json.text());
                        return Err(self
                            .json
                            .malformed(format!("the type `{name}` is not one of GeoJSON"), HINT));
                    }
                },
                _ => return Err(self.json.malformed("`type` is not a string".to_owned(), HINT)),
            },
            b"features" if role == Role::Root && !twice(&mut object.features) => match self.json.next()? {
                Event::ArrayStart => self.open.push(Frame::Features),
                _ => return Err(self.json.malformed("`features` is not an array".to_owned(), HINT)),
            },
            b"geometries" if role != Role::Feature && !twice(&mut object.geometries) => match self.json.next()? {
                Event::ArrayStart => self.open.push(Frame::Geometries),
                _ => return Err(self.json.malformed("`geometries` is not an array".to_owned(), HINT)),
            },
            b"geometry" if role != Role::Geometry && !twice(&mut object.geometry) => match self.json.next()? {
                Event::ObjectStart => self.enter(Role::Geometry),
                Event::Literal => {}
                _ => return Err(self.json.malformed("`geometry` is not an object".to_owned(), HINT)),
            },
            b"coordinates" if role != Role::Feature && !twice(&mut object.coordinates) => match self.json.next()? {
                Event::ArrayStart => self.array_start(),
                _ => return Err(self.json.malformed("`coordinates` is not an array".to_owned(), HINT)),
            },
            b"crs" if role == Role::Root && self.crs.is_none() => self.skip_value(true)?,
            _ => self.skip_value(false)?,
        }
        Ok(())
    }

    /// Passes over a value; of a `crs` it keeps the name.
    fn skip_value(&mut self, is_crs: bool) -> Result<(), InputError> {
        let depth = self.json.depth();
        let mut is_name = false;
        loop {
            match self.json.next()? {
                Event::Key => is_name = is_crs && self.json.text() == b"name",
                Event::String if is_name && self.crs.is_none() => {
                    self.crs = Some(String::from_utf8_lossy(self.json.text()).into_owned());
                }
                _ => is_name = false,
            }
            if self.json.depth() == depth {
                return Ok(());
            }
        }
    }

    fn array_start(&mut self) {
        self.level += 1;
        self.position = Position {
            offset: self.json.offset(),
            ..Position::default()
        };
    }

    /// A piece within `coordinates`; gives the position that it ends.
    fn coordinate(&mut self, event: Event) -> Result<Option<Position>, InputError> {
        let Some(Frame::Object(object)) = self.open.last_mut() else {
            return Ok(None);
        };
        let in_position = object.level == Some(self.level);
        match event {
            Event::ArrayStart if in_position || self.level == LEVELS => Err(self
                .json
                .malformed("an array too deep within `coordinates`".to_owned(), HINT)),
            Event::ArrayStart => {
                self.array_start();
                Ok(None)
            }
            Event::ArrayEnd => {
                object.arrays[self.level] += 1;
                self.level -= 1;
                Ok(in_position.then_some(self.position))
            }
            Event::Number(_) | Event::Literal | Event::String if in_position || object.level.is_none() => {
                object.level = Some(self.level);
                match (event, self.position.values.get_mut(self.position.length)) {
                    (Event::Number(number), Some(value)) => *value = number,
                    (Event::Number(_), None) => {}
                    _ => self.position.strange = true,
                }
                self.position.length += 1;
                Ok(None)
            }
            _ => Err(self
                .json
                .malformed("positions and arrays mixed within `coordinates`".to_owned(), HINT)),
        }
    }

    /// An object ended: is it what its type says?
    fn leave(&mut self, object: &Object) -> Result<(), InputError> {
        let Some(kind) = object.kind else {
            return Err(self.json.malformed("an object without a `type`".to_owned(), HINT));
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

impl Reader for GeoJson {
    fn has_z(&self) -> bool {
        self.has_z
    }

    fn crs(&self) -> Option<&str> {
        self.crs.as_deref()
    }

    fn fill(&mut self, sink: &mut Sink<'_>) -> Result<bool, InputError> {
        while !sink.is_full() {
            let position = match self.first.take() {
                Some(first) => Some(first),
                None => self.next_position()?,
            };
            match position {
                Some(position) => position.put(sink)?,
                None => return Ok(false),
            }
        }
        Ok(true)
    }

    fn notes(&self) -> Vec<String> {
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
}
