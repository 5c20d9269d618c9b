//! Each format keeps to its own rules, on lines with failures, shifts, joins, rejects, setup,
//! defects, belts and violations.

use super::{Row, controlled, logged, rows, uncontrolled};
use linewright::contract::line::{Line, NodeKind};
use linewright::event_log::{COLUMNS, Format};
use linewright::line::{Plant, Trace};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use quick_xml::events::{BytesStart, Event};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;

fn plants() -> impl Iterator<Item = Box<dyn Fn() -> Plant>> {
    let uncontrolled = (1..=12).map(|seed| {
        let make: Box<dyn Fn() -> Plant> = Box::new(move || uncontrolled(seed, 0.1));
        make
    });
    uncontrolled.chain((1..=12).map(|seed| {
        let make: Box<dyn Fn() -> Plant> = Box::new(move || controlled(seed, 0.0));
        make
    }))
}

fn each(format: Format, check: impl Fn(&Line, &Trace, &[u8])) {
    for make in plants() {
        let mut plant = make();
        let line = plant.line().clone();
        let (trace, bytes) = logged(&mut plant, format);
        check(&line, &trace, &bytes);
    }
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).expect("UTF-8")
}

/// The rules of RFC 4180: a header, CRLF, and as many fields in each record.
#[test]
fn csv_is_what_spreadsheets_read() {
    each(Format::Csv, |_, trace, bytes| {
        let text = text(bytes);
        assert!(text.starts_with(&(COLUMNS.join(",") + "\r\n")));
        assert!(text.ends_with("\r\n"));
        assert_eq!(text.matches('\n').count(), text.matches("\r\n").count());
        let mut reader = csv::ReaderBuilder::new().flexible(false).from_reader(bytes);
        assert!(reader.records().all(|record| record.is_ok()));
        let rows = rows(bytes);
        assert!(rows.windows(2).all(|pair| pair[0].time <= pair[1].time));
        assert_eq!(rows.last().map(|row| row.time), Some(trace.seconds));
    });
}

#[test]
fn json_lines_have_the_rows_of_csv() {
    for make in plants() {
        let (_, csv) = logged(&mut make(), Format::Csv);
        let (_, jsonl) = logged(&mut make(), Format::Jsonl);
        let mut lines = text(&jsonl).lines();
        let header: Value = serde_json::from_str(lines.next().unwrap()).unwrap();
        assert_eq!(header["schema"], "linewright/log/1");
        let word = |value: &Value| value.as_str().unwrap_or_default().to_owned();
        let ours = lines.map(|line| {
            let fields: Value = serde_json::from_str(line).unwrap();
            Row {
                time: fields["time"].as_f64().unwrap(),
                node: word(&fields["node"]),
                part_type: word(&fields["part_type"]),
                part: fields["part"].as_u64(),
                what: word(&fields["what"]),
                other: word(&fields["other"]),
                value: fields["value"].as_f64(),
                seconds: fields["seconds"].as_f64(),
                joules: fields["joules"].as_f64(),
                control_seconds: fields["control_seconds"].as_f64(),
            }
        });
        assert_eq!(ours.collect::<Vec<_>>(), rows(&csv));
    }
}

#[test]
fn parquet_has_the_rows_of_csv() {
    for make in plants() {
        let (_, csv) = logged(&mut make(), Format::Csv);
        let (_, bytes) = logged(&mut make(), Format::Parquet);
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(&bytes).unwrap();
        let reader = SerializedFileReader::new(file).unwrap();
        let metadata = reader.metadata().file_metadata();
        let columns = metadata.schema_descr().columns().iter();
        let names: Vec<_> = columns.map(|column| column.name().to_owned()).collect();
        assert_eq!(names, COLUMNS);
        let about = metadata.key_value_metadata().unwrap().iter();
        let about = about.clone().find(|pair| pair.key == "linewright").unwrap();
        let about: Value = serde_json::from_str(about.value.as_ref().unwrap()).unwrap();
        assert_eq!(about["schema"], "linewright/log/1");
        let ours = reader.get_row_iter(None).unwrap().map(|row| {
            let row = row.unwrap();
            let mut read = Row::default();
            for (name, field) in row.get_column_iter() {
                match (name.as_str(), field) {
                    (_, Field::Null) => {}
                    ("time", Field::Double(value)) => read.time = *value,
                    ("node", Field::Str(name)) => read.node.clone_from(name),
                    ("part_type", Field::Str(name)) => read.part_type.clone_from(name),
                    ("part", Field::Long(part)) => read.part = Some(*part as u64),
                    ("what", Field::Str(name)) => read.what.clone_from(name),
                    ("other", Field::Str(name)) => read.other.clone_from(name),
                    ("value", Field::Double(value)) => read.value = Some(*value),
                    ("seconds", Field::Double(value)) => read.seconds = Some(*value),
                    ("joules", Field::Double(value)) => read.joules = Some(*value),
                    ("control_seconds", Field::Double(value)) => {
                        read.control_seconds = Some(*value);
                    }
                    (name, field) => panic!("{name}: {field:?}"),
                }
            }
            read
        });
        assert_eq!(ours.collect::<Vec<_>>(), rows(&csv));
    }
}

/// The rules of "Trace Event Format": the phases in use with their fields. Events of a thread do
/// not overlap, and their durations are the shares of the station.
#[test]
fn chrome_traces_keep_to_their_format() {
    each(Format::Perfetto, |line, trace, bytes| {
        let document: Value = serde_json::from_slice(bytes).unwrap();
        let events = document["traceEvents"].as_array().unwrap();
        let mut busy: BTreeMap<u64, f64> = BTreeMap::new();
        let mut ends: BTreeMap<u64, f64> = BTreeMap::new();
        let mut names: BTreeMap<u64, &str> = BTreeMap::new();
        let mut wip = 0;
        for event in events {
            assert!(
                event["pid"].is_u64() && event["name"].is_string(),
                "{event}"
            );
            let thread = event["tid"].as_u64();
            match event["ph"].as_str().unwrap() {
                "M" => match event["name"].as_str().unwrap() {
                    "process_name" => assert_eq!(event["args"]["name"], line.name.as_str()),
                    "thread_name" => {
                        names.insert(thread.unwrap(), event["args"]["name"].as_str().unwrap());
                    }
                    "thread_sort_index" => assert!(event["args"]["sort_index"].is_u64()),
                    name => panic!("{name} is not a name of metadata"),
                },
                "X" => {
                    let (start, lasts) = (time(event, "ts"), time(event, "dur"));
                    assert!(lasts >= 0.0 && names.contains_key(&thread.unwrap()));
                    let end = ends.entry(thread.unwrap()).or_default();
                    assert!(start >= *end - 2e-3, "{event} begins before {end}");
                    *end = start + lasts;
                    if event["name"] == "busy" {
                        *busy.entry(thread.unwrap()).or_default() += lasts / 1e6;
                    }
                }
                "C" => {
                    time(event, "ts");
                    let parts = event["args"]["parts"].as_i64().unwrap();
                    assert!(parts >= 0);
                    if event["name"] == "WIP" {
                        wip = parts;
                    }
                }
                "i" => {
                    time(event, "ts");
                    assert!(["t", "g"].contains(&event["s"].as_str().unwrap()));
                }
                phase => panic!("{phase} is not in use"),
            }
        }
        assert_eq!(wip as u64, trace.parts.in_progress);
        if trace.warm_up > 0.0 {
            return;
        }
        for station in &trace.stations {
            let ours = busy.get(&(station.node as u64 + 1)).copied().unwrap_or(0.0);
            let name = &station.name;
            assert!((ours - station.busy_seconds).abs() < 1e-3, "{name}: {ours}");
        }
    });
}

fn time(event: &Value, name: &str) -> f64 {
    event[name].as_f64().unwrap_or_else(|| panic!("{event}"))
}

/// What the published schema (`ocel20-schema-json.json`, draft 7) wants: four lists, the fields of
/// their items with their types, and values of attributes as texts. Beyond it, what the
/// specification says in words: identities are unique, and every type, attribute and object that is
/// named is declared.
#[test]
fn ocel_keeps_to_its_schema() {
    each(Format::Ocel, |line, trace, bytes| {
        let document: Value = serde_json::from_slice(bytes).unwrap();
        let list = |name: &str| document[name].as_array().unwrap().clone();
        let types = |name: &str| {
            let types = list(name).into_iter().map(|kind| {
                let attributes = kind["attributes"].as_array().unwrap().iter();
                let attributes = attributes.map(|attribute| {
                    let kind = attribute["type"].as_str().unwrap();
                    assert!(["string", "time", "integer", "float", "boolean"].contains(&kind));
                    attribute["name"].as_str().unwrap().to_owned()
                });
                let name = kind["name"].as_str().unwrap().to_owned();
                (name, attributes.collect::<BTreeSet<_>>())
            });
            let count = list(name).len();
            let types: BTreeMap<_, _> = types.collect();
            assert_eq!(types.len(), count, "names are unique");
            types
        };
        let (object_types, event_types) = (types("objectTypes"), types("eventTypes"));
        let attributes = |item: &Value, known: &BTreeSet<String>, has_time: bool| {
            for attribute in item["attributes"].as_array().unwrap() {
                assert!(
                    known.contains(attribute["name"].as_str().unwrap()),
                    "{item}"
                );
                assert!(attribute["value"].is_string());
                assert_eq!(attribute["time"].as_str().is_some_and(is_date), has_time);
            }
        };
        let objects = list("objects");
        let mut identities = BTreeSet::new();
        for object in &objects {
            let known = &object_types[object["type"].as_str().unwrap()];
            attributes(object, known, true);
            assert!(
                identities.insert(object["id"].as_str().unwrap()),
                "{object}"
            );
        }
        let related = |item: &Value| {
            for relation in item["relationships"].as_array().unwrap() {
                assert!(relation["qualifier"].is_string());
                let object = relation["objectId"].as_str().unwrap();
                assert!(identities.contains(object), "{item}");
            }
        };
        objects.iter().for_each(related);
        let mut seen = BTreeSet::new();
        let mut last = String::new();
        for event in &list("events") {
            attributes(event, &event_types[event["type"].as_str().unwrap()], false);
            related(event);
            assert!(seen.insert(event["id"].as_str().unwrap().to_owned()));
            let time = event["time"].as_str().unwrap();
            assert!(is_date(time) && *time >= *last, "{event}");
            time.clone_into(&mut last);
        }
        let is_part = |object: &&Value| line.parts.iter().any(|part| object["type"] == *part.name);
        let parts = objects.iter().filter(is_part).count() as u64;
        if trace.warm_up <= 0.0 {
            assert_eq!(parts, trace.parts.entered);
        }
    });
}

/// Whether a text is a date as `format: date-time` has it.
fn is_date(text: &str) -> bool {
    let bytes = text.as_bytes();
    bytes.len() == 27
        && bytes.iter().zip("dddd-dd-ddTdd:dd:dd.ddddddZ".bytes()).all(
            |(byte, wanted)| match wanted {
                b'd' => byte.is_ascii_digit(),
                _ => *byte == wanted,
            },
        )
}

fn attribute(tag: &BytesStart<'_>, name: &str) -> String {
    let found = tag.try_get_attribute(name).unwrap();
    let found = found.unwrap_or_else(|| panic!("{tag:?} has no {name}"));
    quick_xml::escape::unescape(&found.value)
        .unwrap()
        .into_owned()
}

/// What IEEE 1849 wants: the order of extensions, globals, classifiers, attributes and traces;
/// unique keys; the global attributes in every trace and event; the values of the lifecycle.
#[test]
fn xes_keeps_to_its_standard() {
    each(Format::Xes, |line, trace, bytes| {
        let mut reader = quick_xml::Reader::from_str(text(bytes));
        let mut path: Vec<String> = Vec::new();
        let mut keys: Vec<BTreeSet<String>> = vec![BTreeSet::new()];
        let (mut rank, mut traces) = (0, 0_u64);
        let mut last = String::new();
        loop {
            match reader.read_event().unwrap() {
                Event::Eof => break,
                Event::Start(tag) => {
                    let name = tag.name().as_ref().to_owned();
                    enter(&path, &name, &mut rank);
                    if name == "trace" {
                        traces += 1;
                        last.clear();
                    }
                    if name == "log" {
                        assert_eq!(attribute(&tag, "xes.version"), "1849.2016");
                        attribute(&tag, "xes.features");
                    }
                    path.push(name);
                    keys.push(BTreeSet::new());
                }
                Event::Empty(tag) => {
                    let name = tag.name().as_ref().to_owned();
                    enter(&path, &name, &mut rank);
                    if ["string", "date", "int"].contains(&name.as_str()) {
                        let (key, value) = (attribute(&tag, "key"), attribute(&tag, "value"));
                        assert!(keys.last_mut().unwrap().insert(key.clone()), "{key} twice");
                        if key == "lifecycle:transition" {
                            assert!(["start", "complete"].contains(&value.as_str()));
                        }
                        if key == "time:timestamp" {
                            assert!(is_date(&value));
                            if path.last().is_some_and(|name| name == "event") {
                                assert!(value >= last);
                                last = value;
                            }
                        }
                    }
                }
                Event::End(_) => {
                    let (name, keys) = (path.pop().unwrap(), keys.pop().unwrap());
                    let wanted: &[&str] = match name.as_str() {
                        "trace" => &["concept:name"],
                        "event" => &[
                            "concept:name",
                            "lifecycle:transition",
                            "org:resource",
                            "time:timestamp",
                        ],
                        _ => &[],
                    };
                    assert!(wanted.iter().all(|key| keys.contains(*key)), "{keys:?}");
                }
                _ => {}
            }
        }
        assert!(path.is_empty());
        let is_plain = |kind: &NodeKind| !matches!(kind, NodeKind::Store { .. });
        if trace.warm_up <= 0.0 && line.nodes.iter().all(|node| is_plain(&node.kind)) {
            assert_eq!(traces, trace.parts.finished + trace.parts.rejected);
        }
    });
}

/// The place of an element in its parent, and the order of those of the log.
fn enter(path: &[String], name: &str, rank: &mut usize) {
    let attributes = ["string", "date", "int"];
    match path.last().map(String::as_str) {
        None => assert_eq!(name, "log"),
        Some("log") => {
            let order = ["extension", "global", "classifier", "string", "trace"];
            let next = order.iter().position(|known| *known == name).expect(name);
            assert!(next >= *rank, "{name} comes too late");
            *rank = next;
        }
        Some("global" | "event") => assert!(attributes.contains(&name), "{name}"),
        Some("trace") => assert!(name == "event" || attributes.contains(&name), "{name}"),
        Some(parent) => panic!("{name} stands in {parent}"),
    }
}
