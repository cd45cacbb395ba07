//! Prints answers for people and programs.

use std::io::{BufWriter, Write};

use delaunay_tiles::crs::Crs;
use delaunay_tiles_answers::answer::Answer;
use delaunay_tiles_answers::asked::Asked;
use delaunay_tiles_answers::objects::{features, object};
use delaunay_tiles_answers::values::{COLLECTION_END, collection, write_feature};
use serde_json::Value;

use super::args::Format;
use super::rows::{header, rows};
use super::stage::Stage;
use super::text::text;
use crate::output::StandardOutput;

/// Prints answers, one after the other.
pub struct Printer {
    format: Format,
    asked: Asked,
    out: BufWriter<StandardOutput>,
    features: u64,
}

impl Printer {
    /// Creates a printer and prints what precedes all answers. `in_stages` says whether answers
    /// come in stages.
    pub fn new(format: Format, asked: Asked, crs: Option<&Crs>, in_stages: bool) -> anyhow::Result<Self> {
        let mut out = BufWriter::new(StandardOutput::of("the answers"));
        match format {
            Format::Csv if in_stages => writeln!(out, "{},{}", header(asked.ask), Stage::HEADER)?,
            Format::Csv => writeln!(out, "{}", header(asked.ask))?,
            Format::GeoJson => write!(out, "{}", collection(crs))?,
            Format::Text | Format::Json => {}
        }
        Ok(Self {
            format,
            asked,
            out,
            features: 0,
        })
    }

    /// Prints an answer.
    pub fn print(&mut self, answer: &Answer) -> anyhow::Result<()> {
        match self.format {
            Format::Text => write!(self.out, "{}", text(self.asked, answer))?,
            Format::Json => writeln!(self.out, "{}", object(self.asked, answer))?,
            Format::Csv => {
                for row in rows(self.asked.ask, answer) {
                    writeln!(self.out, "{row}")?;
                }
            }
            Format::GeoJson => self.print_features(features(self.asked, answer))?,
        }
        Ok(())
    }

    /// Prints one of the two answers to a question, without delay. `stage` is `None` for an error
    /// before the first answer.
    pub fn print_stage(&mut self, answer: &Answer, stage: Option<Stage>) -> anyhow::Result<()> {
        match self.format {
            Format::Text => write!(
                self.out,
                "{}{}",
                stage.map(Stage::prefix).unwrap_or_default(),
                text(self.asked, answer)
            )?,
            Format::Json => {
                let mut object = object(self.asked, answer);
                stage.into_iter().for_each(|stage| stage.add_to(&mut object));
                writeln!(self.out, "{object}")?;
            }
            Format::Csv => {
                let cells = stage.map_or_else(|| ",,".to_owned(), Stage::cells);
                for row in rows(self.asked.ask, answer) {
                    writeln!(self.out, "{row},{cells}")?;
                }
            }
            Format::GeoJson => {
                let mut features = features(self.asked, answer);
                for feature in &mut features {
                    stage
                        .into_iter()
                        .for_each(|stage| stage.add_to(&mut feature["properties"]));
                }
                self.print_features(features)?;
            }
        }
        Ok(self.out.flush()?)
    }

    fn print_features(&mut self, features: Vec<Value>) -> anyhow::Result<()> {
        for feature in features {
            write_feature(&mut self.out, self.features, &feature)?;
            self.features += 1;
        }
        Ok(())
    }

    /// Prints what follows all answers.
    pub fn finish(mut self) -> anyhow::Result<()> {
        if self.format == Format::GeoJson {
            writeln!(self.out, "{COLLECTION_END}")?;
        }
        Ok(self.out.flush()?)
    }
}
