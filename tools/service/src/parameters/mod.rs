//! Parameters of requests: their texts, and what is wrong with them.

pub mod number;

use std::fmt::Display;

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{Mode, Search};

use crate::problem::Problem;
use number::number;

/// The largest limit that a request may name. Limits above those of the service have no effect.
pub const MAX_COUNT: u64 = 1_000_000_000;

/// The parameters of a URL. Each is taken once; [`end`](Self::end) refuses the rest.
pub struct Parameters {
    all: Vec<(String, String)>,
}

impl Parameters {
    /// Reads the query of a URL.
    pub fn new(query: Option<&str>) -> Self {
        let all = form_urlencoded::parse(query.unwrap_or_default().as_bytes());
        Self {
            all: all.into_owned().collect(),
        }
    }

    /// Takes the text of a parameter.
    ///
    /// # Errors
    /// Fails if it is given twice.
    pub fn text(&mut self, name: &str) -> Result<Option<String>, Problem> {
        let mut found = self
            .all
            .extract_if(.., |(other, _)| other == name)
            .map(|(_, text)| text);
        let text = found.next();
        if found.next().is_some() {
            return Err(Problem::invalid(name, "it is given more than once", "give it once"));
        }
        Ok(text)
    }

    /// Takes a parameter that `parse` understands. `form` says which texts those are.
    fn parsed<T>(
        &mut self,
        name: &str,
        form: impl Display,
        parse: impl FnOnce(&str) -> Option<T>,
    ) -> Result<Option<T>, Problem> {
        let Some(text) = self.text(name)? else { return Ok(None) };
        let parsed = parse(&text);
        let wrong = || Problem::invalid(name, format!("it is not {form}"), format!("give {form}"));
        parsed.map(Some).ok_or_else(wrong)
    }

    /// Takes a point, `X,Y`.
    ///
    /// # Errors
    /// Fails if it is missing or something else.
    pub fn point(&mut self, name: &str) -> Result<Point, Problem> {
        let form = "two numbers separated by a comma, such as 3.5,-4";
        let point = self.parsed(name, form, |text| {
            let (x, y) = text.split_once(',')?;
            Some(Point::new(number(x)?, number(y)?))
        })?;
        point.ok_or_else(|| missing(name, form))
    }

    /// Takes a distance: a number of at least 0.
    ///
    /// # Errors
    /// Fails if it is missing or something else.
    pub fn distance(&mut self, name: &str) -> Result<f64, Problem> {
        let form = "a number from 0 up to 1e50";
        let distance = self.parsed(name, form, |text| {
            text.parse()
                .ok()
                .filter(|distance: &f64| (0.0..=1e50).contains(distance))
        })?;
        distance.ok_or_else(|| missing(name, form))
    }

    /// Takes the length of an edge: a number above 0.
    ///
    /// # Errors
    /// Fails if it is something else.
    pub fn length(&mut self, name: &str) -> Result<Option<f64>, Problem> {
        self.parsed(name, "a number above 0 and up to 1e50", |text| {
            text.parse()
                .ok()
                .filter(|length: &f64| *length > 0.0 && *length <= 1e50)
        })
    }

    /// Takes a number from `least` up to `most`.
    ///
    /// # Errors
    /// Fails if it is something else.
    pub fn count(&mut self, name: &str, least: u64, most: u64) -> Result<Option<u64>, Problem> {
        let form = format_args!("a whole number from {least} up to {most}");
        self.parsed(name, form, |text| {
            let is_number = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
            let number = text.parse().ok().filter(|_| is_number);
            number.filter(|number| (least..=most).contains(number))
        })
    }

    /// Takes `true` or `false`; `false` if it is missing.
    ///
    /// # Errors
    /// Fails if it is something else.
    pub fn flag(&mut self, name: &str) -> Result<bool, Problem> {
        Ok(self
            .parsed(name, "true or false", |text| text.parse().ok())?
            .unwrap_or(false))
    }

    /// Takes the accuracy of distances.
    ///
    /// # Errors
    /// Fails if it is something else.
    pub fn mode(&mut self) -> Result<Mode, Problem> {
        let mode = self.parsed(
            "mode",
            "exact, fast or within:TOLERANCE, such as within:0.05",
            |text| match text.strip_prefix("within:") {
                Some(tolerance) => number(tolerance)
                    .filter(|tolerance| *tolerance >= 0.0)
                    .map(Mode::Within),
                None => text.parse().ok(),
            },
        )?;
        Ok(mode.unwrap_or_default())
    }

    /// Takes how sites are searched for.
    ///
    /// # Errors
    /// Fails if it is something else.
    pub fn search(&mut self) -> Result<Search, Problem> {
        let search = self.parsed("search", "auto, wavefront or aimed", |text| text.parse().ok())?;
        Ok(search.unwrap_or_default())
    }

    /// Takes the version of the file that the client knows.
    ///
    /// # Errors
    /// Fails if it is given twice.
    pub fn version(&mut self) -> Result<Option<String>, Problem> {
        self.text("v")
    }

    /// Refuses parameters that were not taken.
    ///
    /// # Errors
    /// Fails if there are any.
    pub fn end(self) -> Result<(), Problem> {
        match self.all.first() {
            None => Ok(()),
            Some(_) => Err(Problem::invalid(
                "query",
                "there are parameters that this path does not have",
                "leave them out; see /openapi.json for those that it has",
            )),
        }
    }
}

fn missing(name: &str, form: &str) -> Problem {
    Problem::invalid(name, "it is missing", format!("give {form}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_are_taken_once_and_no_others_are_there() {
        let mut parameters = Parameters::new(Some("at=1%2C-2.5&k=3&area=true&mode=within:0.05&v=x"));
        assert_eq!(parameters.point("at"), Ok(Point::new(1.0, -2.5)));
        assert_eq!(parameters.count("k", 1, 9), Ok(Some(3)));
        assert_eq!(parameters.flag("area"), Ok(true));
        assert_eq!(parameters.flag("certify"), Ok(false));
        assert_eq!(parameters.mode(), Ok(Mode::Within(0.05)));
        assert_eq!(parameters.version(), Ok(Some("x".to_owned())));
        assert_eq!(parameters.end(), Ok(()));
    }

    #[test]
    fn what_is_wrong_is_refused_by_name() {
        let wrong = |query: &str, take: fn(&mut Parameters) -> Result<(), Problem>| {
            let mut parameters = Parameters::new(Some(query));
            take(&mut parameters).and_then(|()| parameters.end()).unwrap_err().place
        };
        for query in [
            "",
            "at=",
            "at=1",
            "at=1,2,3",
            "at=1,NaN",
            "at=a,b",
            "at=1,2&at=1,2",
            "at=1e999,0",
        ] {
            assert_eq!(wrong(query, |p| p.point("at").map(drop)), "at", "{query}");
        }
        for query in ["k=0", "k=-1", "k=1.5", "k=10", "k=+1", "k=99999999999999999999"] {
            assert_eq!(wrong(query, |p| p.count("k", 1, 9).map(drop)), "k", "{query}");
        }
        for query in ["radius=-1", "radius=NaN", "radius=inf", "radius=1e51"] {
            assert_eq!(wrong(query, |p| p.distance("radius").map(drop)), "radius", "{query}");
        }
        for query in ["mode=", "mode=within", "mode=within:-1", "mode=within:inf"] {
            assert_eq!(wrong(query, |p| p.mode().map(drop)), "mode", "{query}");
        }
        assert_eq!(wrong("area=1", |p| p.flag("area").map(drop)), "area");
        assert_eq!(wrong("x=1", |_| Ok(())), "query");
    }
}
