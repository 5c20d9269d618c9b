//! JSON lines: the first line describes the line, each other one is an event. Fields without a
//! value are left out.

use crate::row::{Row, RowWriter};
use crate::{Context, kind_word};
use linewright_language::contract::line::{Line, NodeKind};
use serde_json::{Map, Value, json};
use std::io::{self, Write};

/// JSON Schema of the first line.
pub(crate) const SCHEMA: &str = include_str!("log.schema.json");

/// Writes rows as JSON lines.
pub(crate) struct JsonLines<W> {
    file: W,
}

impl<W: Write> JsonLines<W> {
    pub(crate) fn new(mut file: W, context: Context<'_>) -> io::Result<Self> {
        writeln!(file, "{}", header(context))?;
        Ok(Self { file })
    }
}

/// What is known before the run.
pub(crate) fn header(context: Context<'_>) -> Value {
    let line = context.line;
    let nodes: Vec<Value> = line.nodes.iter().map(|node| place(line, node)).collect();
    let parts = line.parts.iter().enumerate().map(|(index, part)| {
        let bill = part.bill.iter();
        let bill = bill.map(
            |(component, count)| json!({ "part": line.parts[*component].name, "count": count }),
        );
        json!({
            "name": part.name,
            "product": line.is_product(index),
            "bill": bill.collect::<Vec<_>>(),
        })
    });
    json!({
        "schema": "linewright/log/1",
        "line": line.name,
        "seed": context.seed,
        "nodes": nodes,
        "parts": parts.collect::<Vec<_>>(),
    })
}

fn place(line: &Line, node: &linewright_language::contract::line::Node) -> Value {
    let mut place = json!({ "name": node.name, "kind": kind_word(&node.kind) });
    match &node.kind {
        NodeKind::Source { part, .. } => place["part"] = json!(line.parts[*part].name),
        NodeKind::Buffer { capacity, .. } => place["capacity"] = json!(capacity),
        NodeKind::Conveyor { places, .. } => place["capacity"] = json!(places),
        _ => {}
    }
    if let Some(machine) = node.machine() {
        place["machine"] = json!(machine.name);
    }
    place
}

impl<W: Write> RowWriter for JsonLines<W> {
    fn row(&mut self, row: &Row<'_>) -> io::Result<()> {
        let mut fields = Map::new();
        fields.insert("time".to_owned(), row.time.into());
        let mut put = |name: &str, value: Option<Value>| {
            if let Some(value) = value {
                fields.insert(name.to_owned(), value);
            }
        };
        put("node", row.node.map(Value::from));
        put("part_type", row.part_type.map(Value::from));
        put("part", row.part.map(Value::from));
        put("what", Some(row.what.into()));
        put("other", row.other.map(Value::from));
        put("value", row.value.map(Value::from));
        put("seconds", row.seconds.map(Value::from));
        put("joules", row.joules.map(Value::from));
        put("control_seconds", row.control_seconds.map(Value::from));
        serde_json::to_writer(&mut self.file, &fields)?;
        self.file.write_all(b"\n")
    }

    fn finish(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}
