//! Event logs: every figure of a run that follows from its events is computed again from the log,
//! and each format keeps to its own rules.

mod figures;
mod formats;
mod python;

use crate::runner::conservation;
use crate::simpy::lines as simpy_lines;
use linewright::contract::line::Line;
use linewright::contract::load;
use linewright::event_log::{Context, Epoch, EventLog, Format};
use linewright::line::{Options, Plant, Trace};
use std::collections::BTreeMap;
use std::io::{Seek, Write};
use std::sync::Arc;

/// A row of a log, as a reader of its columns sees it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Row {
    pub time: f64,
    pub node: String,
    pub part_type: String,
    pub part: Option<u64>,
    pub what: String,
    pub other: String,
    pub value: Option<f64>,
    pub seconds: Option<f64>,
    pub joules: Option<f64>,
    pub control_seconds: Option<f64>,
}

/// Runs a line, and returns its log in one format.
fn logged(plant: &mut Plant, format: Format) -> (Trace, Vec<u8>) {
    let line = plant.line().clone();
    let seed = plant.seed();
    let context = Context {
        line: &line,
        seed,
        epoch: Epoch::of(&line),
    };
    let mut file = tempfile::tempfile().unwrap();
    let mut log = EventLog::new(format, context, &mut file).unwrap();
    let trace = plant.run_observed(seed, Some(&mut log));
    log.finish().unwrap();
    file.flush().unwrap();
    file.rewind().unwrap();
    let mut bytes = Vec::new();
    std::io::Read::read_to_end(&mut file, &mut bytes).unwrap();
    (trace, bytes)
}

/// The rows of a CSV file.
fn rows(bytes: &[u8]) -> Vec<Row> {
    let mut reader = csv::Reader::from_reader(bytes);
    let records = reader.records().map(|record| {
        let record = record.unwrap();
        let number = |column: usize| {
            let text = &record[column];
            (!text.is_empty()).then(|| text.parse::<f64>().unwrap())
        };
        Row {
            time: number(0).unwrap(),
            node: record[1].to_owned(),
            part_type: record[2].to_owned(),
            part: record[3].parse().ok(),
            what: record[4].to_owned(),
            other: record[5].to_owned(),
            value: number(6),
            seconds: number(7),
            joules: number(8),
            control_seconds: number(9),
        }
    });
    records.collect()
}

/// A line of the comparison with `SimPy`.
fn uncontrolled(seed: u64, warm_up: f64) -> Plant {
    let line = simpy_lines::line(seed);
    let text = format!("line L {{\n{}}}\n", line.text);
    let (mut library, _) = load(&[("line.lw".to_owned(), text)], &|path, _| {
        let table = line.tables.iter().find(|(name, _)| name == path);
        table.cloned().ok_or("there is no such table".to_owned())
    });
    let options = Options {
        seed: line.seed,
        parts: line.parts,
        until: Some(line.until),
        warm_up: warm_up * line.until,
        ..Options::default()
    };
    Plant::new(Arc::new(library.lines.remove(0)), BTreeMap::new(), options).unwrap()
}

/// A line with controllers that refuse parts, belts, joins, stores and defects.
fn controlled(seed: u64, warm_up: f64) -> Plant {
    conservation::line(seed, false).plant(Options {
        seed,
        parts: Some(20),
        until: Some(2000.0),
        warm_up,
        ..Options::default()
    })
}

/// Index of a node by its name.
fn node(line: &Line, name: &str) -> usize {
    let mut nodes = line.nodes.iter();
    nodes.position(|node| node.name == name).expect(name)
}
