//! What a study leaves behind: files, and text for the terminal.

use super::chart::Chart;
use super::machine::{Machine, date};
use super::{StudyError, Table};
use crate::output::{encode_png, write_whole};
use serde_json::{Map, Value, json};
use std::fmt::Write;
use std::io;
use std::path::{Path, PathBuf};

/// A study that is done.
#[derive(Debug)]
pub struct Report {
    /// What its files are called: `threads`.
    pub name: String,
    /// What it was asked to do.
    pub settings: Map<String, Value>,
    /// Every single measurement.
    pub samples: Table,
    /// What follows from them, for programs.
    pub summary: Value,
    /// The same for people.
    pub tables: Vec<Table>,
    /// Sentences below the tables.
    pub notes: Vec<String>,
    /// Endings of file names, and charts.
    pub charts: Vec<(String, Chart)>,
    /// Taken when the study began.
    pub machine: Machine,
}

impl Report {
    /// An empty report of a study that begins now.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            settings: Map::new(),
            samples: Table::default(),
            summary: Value::Null,
            tables: Vec::new(),
            notes: Vec::new(),
            charts: Vec::new(),
            machine: Machine::here(),
        }
    }

    /// Notes what the study was asked to do.
    pub fn set(&mut self, name: &str, value: impl Into<Value>) {
        self.settings.insert(name.to_owned(), value.into());
    }

    /// Adds a chart; its files are called `<name>-<ending>`, or `<name>` if the ending is empty.
    pub fn chart(&mut self, ending: impl Into<String>, chart: Chart) {
        self.charts.push((ending.into(), chart));
    }

    /// Writes `<name>.csv` (raw measurements), `<name>.json` (header and summary), and each chart as PNG and SVG into a
    /// directory. Each file appears whole or not at all, and all are made before the first is written.
    /// Their paths.
    pub fn write(&self, directory: &Path) -> Result<Vec<PathBuf>, StudyError> {
        let date = date();
        let mut files = vec![
            (format!("{}.csv", self.name), self.csv(&date)?),
            (format!("{}.json", self.name), serde_json::to_vec_pretty(&self.json(&date)).map_err(io::Error::from)?),
        ];
        for (ending, chart) in &self.charts {
            let dash = if ending.is_empty() { "" } else { "-" };
            let stem = format!("{}{dash}{ending}", self.name);
            let (width, height, pixels) = chart.to_rgb8().map_err(StudyError::Chart)?;
            files.push((format!("{stem}.png"), encode_png(width, height, &pixels)?));
            files.push((format!("{stem}.svg"), chart.to_svg().map_err(StudyError::Chart)?.into_bytes()));
        }
        files
            .into_iter()
            .map(|(name, bytes)| {
                let path = directory.join(name);
                write_whole(&path, &bytes)?;
                Ok(path)
            })
            .collect()
    }

    /// Tables and notes, for a person.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for table in &self.tables {
            let _ = writeln!(text, "{table}");
        }
        for note in &self.notes {
            let _ = writeln!(text, "{note}");
        }
        text
    }

    /// Lines that begin with `#` tell where the numbers come from.
    fn csv(&self, date: &str) -> io::Result<Vec<u8>> {
        let machine = &self.machine;
        let mut text = format!("# glimt {} study {}, {date}\n", env!("CARGO_PKG_VERSION"), self.name);
        text += &format!(
            "# {}, {} threads, {}, {}, load {}\n",
            machine.cpu,
            machine.threads,
            machine.system,
            machine.isa,
            machine.load.map_or("unknown".to_owned(), |load| load.to_string())
        );
        for (name, value) in &self.settings {
            text += &format!("# {name}: {value}\n");
        }
        let mut writer = csv::Writer::from_writer(text.into_bytes());
        writer.write_record(&self.samples.columns)?;
        for row in &self.samples.rows {
            writer.write_record(row.iter().map(ToString::to_string))?;
        }
        writer.into_inner().map_err(|error| io::Error::other(error.to_string()))
    }

    fn json(&self, date: &str) -> Value {
        json!({
            "study": self.name,
            "glimt": env!("CARGO_PKG_VERSION"),
            "date": date,
            "machine": self.machine,
            "settings": self.settings,
            "summary": self.summary,
            "samples": { "columns": self.samples.columns, "rows": self.samples.rows },
        })
    }
}
