//! Object-centric event logs: OCEL 2.0 in JSON (Berti et al., "OCEL 2.0 Specification", 2023).
//!
//! Parts and stations are objects. A place gives its name to the events at it: a part enters the
//! line there, arrives there, or is done there; `join` events have all components and the new part.
//! The life of each object of a part type is therefore its route. Values of attributes are texts,
//! as the published schema wants it.
//!
//! Events are written at once. Objects, which follow them in the file, are kept in a temporary file
//! as their parts leave the line.

use crate::epoch::Dates;
use crate::{Context, EventWriter, kind_word};
use linewright_language::contract::line::{Line, NodeKind};
use linewright_line::log::{EventKind, LogEntry, Moment, Other};
use linewright_line::trace::{End, Violation};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter, Seek, Write};

/// Writes OCEL 2.0.
pub(crate) struct OcelWriter<'a, W> {
    file: W,
    line: &'a Line,
    dates: Dates,
    /// Name of the object type of stations.
    station_type: String,
    /// The objects of the parts that have left the line.
    objects: BufWriter<File>,
    /// The parts in the line, by number.
    parts: BTreeMap<u64, Life>,
    /// Parts that are joined into the next one that enters.
    components: Vec<u64>,
    /// By node: when its service began.
    started: Vec<f64>,
    events: u64,
}

/// What has happened to a part.
#[derive(Debug, Default)]
struct Life {
    kind: usize,
    /// Date, property and value.
    changes: Vec<(String, usize, f64)>,
}

impl<'a, W: Write> OcelWriter<'a, W> {
    pub(crate) fn new(mut file: W, context: Context<'a>) -> io::Result<Self> {
        let line = context.line;
        let mut station_type = "station".to_owned();
        while line.parts.iter().any(|part| part.name == station_type) {
            station_type.push('_');
        }
        write!(
            file,
            "{{\"objectTypes\":{},\n\"eventTypes\":{},\n\"events\":[",
            object_types(line, &station_type),
            event_types(line)
        )?;
        Ok(Self {
            file,
            line,
            dates: Dates::new(context.epoch),
            station_type,
            objects: BufWriter::new(tempfile::tempfile()?),
            parts: BTreeMap::new(),
            components: Vec::new(),
            started: vec![0.0; line.nodes.len()],
            events: 0,
        })
    }

    /// Writes an event. `attributes` are names with their texts.
    fn event(
        &mut self,
        name: &str,
        time: f64,
        attributes: &[(&str, String)],
        related: &[(String, &str)],
    ) -> io::Result<()> {
        self.events += 1;
        let attributes = attributes.iter();
        let attributes = attributes.map(|(name, value)| json!({ "name": name, "value": value }));
        let related = related.iter();
        let related = related
            .map(|(object, qualifier)| json!({ "objectId": object, "qualifier": qualifier }));
        let event = json!({
            "id": format!("e{}", self.events),
            "type": name,
            "time": self.dates.format(time),
            "attributes": attributes.collect::<Vec<_>>(),
            "relationships": related.collect::<Vec<_>>(),
        });
        self.file
            .write_all(if self.events == 1 { b"\n" } else { b",\n" })?;
        serde_json::to_writer(&mut self.file, &event)?;
        Ok(())
    }

    /// The objects of an event: its part, and its place if that is a station.
    fn related(&self, node: usize, part: Option<(u64, usize)>) -> Vec<(String, &'static str)> {
        let declared = &self.line.nodes[node];
        let part = part.map(|(number, _)| (number.to_string(), "part"));
        let is_station = is_resource(&declared.kind);
        let station = is_station.then(|| (declared.name.clone(), "resource"));
        part.into_iter().chain(station).collect()
    }

    fn enter(&mut self, entry: &LogEntry) -> io::Result<()> {
        let Some((number, kind)) = entry.part else {
            return Ok(());
        };
        let life = Life {
            kind,
            ..Life::default()
        };
        self.parts.insert(number, life);
        let mut related = self.related(entry.node, entry.part);
        let name = &self.line.nodes[entry.node].name;
        if !is_resource(&self.line.nodes[entry.node].kind) {
            return self.event(name, entry.time, &[], &related);
        }
        let components = std::mem::take(&mut self.components).into_iter();
        related.extend(components.map(|part| (part.to_string(), "component")));
        self.event(&format!("join {name}"), entry.time, &[], &related)
    }

    /// Keeps the object of a part that leaves the line, alone or in another part.
    fn leave(&mut self, number: u64, joined_to: Option<u64>) -> io::Result<()> {
        if let Some(life) = self.parts.remove(&number) {
            self.objects.write_all(b",\n")?;
            let object = object(self.line, number, &life, joined_to);
            serde_json::to_writer(&mut self.objects, &object)?;
        }
        Ok(())
    }
}

/// The object of a part.
fn object(line: &Line, number: u64, life: &Life, joined_to: Option<u64>) -> Value {
    let kind = &line.parts[life.kind];
    let changes = life.changes.iter().map(|(time, property, value)| {
        let name = &kind.properties[*property].name;
        json!({ "name": name, "time": time, "value": value.to_string() })
    });
    let relation = |part: u64| json!({ "objectId": part.to_string(), "qualifier": "component of" });
    json!({
        "id": number.to_string(),
        "type": kind.name,
        "attributes": changes.collect::<Vec<_>>(),
        "relationships": joined_to.map(relation).into_iter().collect::<Vec<_>>(),
    })
}

/// Whether a place is an object.
fn is_resource(kind: &NodeKind) -> bool {
    matches!(
        kind,
        NodeKind::Station(_) | NodeKind::Conveyor { belt: Some(_), .. }
    )
}

fn object_types(line: &Line, station_type: &str) -> Value {
    let parts = line.parts.iter().map(|part| {
        let properties = part.properties.iter();
        let properties =
            properties.map(|property| json!({ "name": property.name, "type": "float" }));
        json!({ "name": part.name, "attributes": properties.collect::<Vec<_>>() })
    });
    let station = json!({ "name": station_type, "attributes": [] });
    parts.chain([station]).collect()
}

fn event_types(line: &Line) -> Value {
    let mut types = Vec::new();
    let mut add = |name: String, attributes: &[(&str, &str)]| {
        let attributes = attributes.iter();
        let attributes = attributes.map(|(name, kind)| json!({ "name": name, "type": kind }));
        types.push(json!({ "name": name, "attributes": attributes.collect::<Vec<_>>() }));
    };
    for node in &line.nodes {
        let name = &node.name;
        let is_station = matches!(node.kind, NodeKind::Station(_));
        let times: &[(&str, &str)] = if is_station {
            &[("started", "time"), ("seconds", "float")]
        } else {
            &[]
        };
        add(name.clone(), times);
        if is_station {
            add(format!("join {name}"), &[]);
            add(format!("failure {name}"), &[]);
            add(format!("repair {name}"), &[]);
        }
        if is_resource(&node.kind) {
            add(format!("violation {name}"), &[("rule", "string")]);
        }
        if is_station || kind_word(&node.kind) == "buffer" {
            add(format!("reject {name}"), &[]);
        }
    }
    types.into()
}

impl<W: Write> EventWriter for OcelWriter<'_, W> {
    fn entry(&mut self, entry: &LogEntry) -> io::Result<()> {
        let node = &self.line.nodes[entry.node];
        let is_station = matches!(node.kind, NodeKind::Station(_));
        let number = entry.part.map_or(0, |part| part.0);
        let related = |writer: &Self| writer.related(entry.node, entry.part);
        match entry.what {
            EventKind::Entered => self.enter(entry),
            EventKind::Arrived if !is_station => {
                let related = related(self);
                self.event(&node.name, entry.time, &[], &related)
            }
            EventKind::Started => {
                self.started[entry.node] = entry.time;
                Ok(())
            }
            EventKind::Ended => {
                let related = related(self);
                let attributes = [
                    ("started", self.dates.format(self.started[entry.node])),
                    ("seconds", entry.seconds.unwrap_or(0.0).to_string()),
                ];
                self.event(&node.name, entry.time, &attributes, &related)
            }
            EventKind::Failed | EventKind::Repaired => {
                let word = if entry.what == EventKind::Failed {
                    "failure"
                } else {
                    "repair"
                };
                let related = related(self);
                self.event(&format!("{word} {}", node.name), entry.time, &[], &related)
            }
            EventKind::Changed | EventKind::Defect => {
                let date = self.dates.format(entry.time);
                if let (Some(life), Some(Other::Property(property, value))) =
                    (self.parts.get_mut(&number), entry.other)
                {
                    life.changes.push((date, property, value));
                }
                Ok(())
            }
            EventKind::Consumed => {
                self.components.push(number);
                let joined_to = match entry.other {
                    Some(Other::Part(number)) => Some(number),
                    _ => None,
                };
                self.leave(number, joined_to)
            }
            EventKind::Finished => self.leave(number, None),
            EventKind::Rejected => {
                if !matches!(node.kind, NodeKind::Sink { .. }) {
                    let related = related(self);
                    self.event(&format!("reject {}", node.name), entry.time, &[], &related)?;
                }
                self.leave(number, None)
            }
            _ => Ok(()),
        }
    }

    fn violation(&mut self, violation: &Violation) -> io::Result<()> {
        let name = format!("violation {}", self.line.nodes[violation.node].name);
        let rule = violation.rule.as_ref().unwrap_or(&violation.message);
        let related = self.related(violation.node, violation.part);
        self.event(&name, violation.time, &[("rule", rule.clone())], &related)
    }

    fn counting(&mut self, _: Moment) -> io::Result<()> {
        Ok(())
    }

    fn end(&mut self, _: Moment, _: End) -> io::Result<()> {
        self.file.write_all(b"\n],\n\"objects\":[")?;
        let (line, station_type) = (self.line, &self.station_type);
        let nodes = line.nodes.iter();
        let stations = nodes.filter(|node| is_resource(&node.kind)).map(|node| {
            json!({
                "id": node.name,
                "type": station_type,
                "attributes": [],
                "relationships": [],
            })
        });
        let left = std::mem::take(&mut self.parts);
        let left = left.iter();
        let left = left.map(|(number, life)| object(line, *number, life, None));
        let mut is_first = true;
        for object in stations.chain(left) {
            self.file.write_all(if is_first { b"\n" } else { b",\n" })?;
            is_first = false;
            serde_json::to_writer(&mut self.file, &object)?;
        }
        self.objects.flush()?;
        let objects = self.objects.get_mut();
        objects.rewind()?;
        if is_first {
            // Each of the kept objects follows a comma.
            objects.seek(io::SeekFrom::Start(1))?;
        }
        io::copy(objects, &mut self.file)?;
        self.file.write_all(b"\n]}\n")?;
        self.file.flush()
    }
}
