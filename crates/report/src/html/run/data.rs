//! What the script of a page needs, as JSON: names, and columns of numbers.
//!
//! The script reads the columns in the same way, so both change together.

use super::super::for_script;
use super::moments::Moments;
use super::picture::Picture;
use super::recorder::{Move, Target};
use super::{Page, packed, state_class};
use linewright_language::contract::date::{format_date, weekday};
use linewright_language::contract::line::{Line, Node, NodeKind};
use linewright_line::log::Activity;
use packed::{Bytes, tick};
use serde_json::{Value, json};

/// All states, in their order.
const ACTIVITIES: [Activity; 7] = [
    Activity::Busy,
    Activity::Starved,
    Activity::Blocked,
    Activity::Failed,
    Activity::Idle,
    Activity::Setup,
    Activity::FailedOffShift,
];

/// Number of states that are shown apart, in the order of their numbers in the columns: the first
/// of all. The last one is shown as failed.
const SHOWN: usize = ACTIVITIES.len() - 1;

/// Classes of the states that are shown apart.
fn shown_states() -> [&'static str; SHOWN] {
    std::array::from_fn(|state| state_class(ACTIVITIES[state]))
}

/// Number of a movement's end that is no place: finished, rejected, joined.
const ENDS: u64 = 3;

pub(super) fn json(page: &Page<'_>, picture: &Picture) -> String {
    let recorder = page.recorder;
    let tick = tick(recorder.end);
    let ticks = |seconds: f64| (seconds / tick).round().max(0.0) as u64;
    let states: Vec<Value> = recorder
        .states
        .iter()
        .enumerate()
        .map(|(node, changes)| {
            if changes.is_empty() {
                return Value::Null;
            }
            let waiting = recorder.waiting(node);
            json!({ "count": changes.len(), "bytes": state_column(changes, waiting, ticks) })
        })
        .collect();
    let refusals: Vec<Value> = recorder
        .refusals
        .iter()
        .map(|times| {
            if times.is_empty() {
                return Value::Null;
            }
            json!({ "count": times.len(), "bytes": times_column(times, ticks) })
        })
        .collect();
    let days = match Moments::of(page.line) {
        Moments::Elapsed => Value::Null,
        Moments::Weekdays(first) => json!({ "weekday": first, "date": null }),
        Moments::Dates(first) => json!({ "weekday": weekday(first), "date": format_date(first) }),
    };
    let violations: Vec<Value> = page.traces[0]
        .violations
        .iter()
        .map(|violation| json!([violation.time, violation.node]))
        .collect();
    let document = json!({
        "end": recorder.end,
        "tick": tick,
        "margins": page.axis().margins(),
        "days": days,
        "nodes": page.line.nodes.iter().enumerate().map(|(index, of)| {
            let mut value = node(of);
            if recorder.waiting(index) == Activity::Idle {
                value["isUnused"] = json!(true);
            }
            value
        }).collect::<Vec<_>>(),
        "parts": page.line.parts.iter().map(|part| &part.name).collect::<Vec<_>>(),
        "links": picture.links,
        "stateNames": shown_states(),
        "states": states,
        "statesEnd": recorder.states_end,
        "laterStates": later_states(page),
        "moves": {
            "count": recorder.moves.len(),
            "bytes": move_column(page.line, &recorder.moves, ticks),
        },
        "movesEnd": recorder.moves_end,
        "violations": violations,
        "refusals": refusals,
    });
    for_script(&document.to_string())
}

/// A place: name, kind, and what its parts need.
fn node(node: &Node) -> Value {
    let mut value = json!({ "name": node.name, "kind": node.kind.word() });
    match &node.kind {
        NodeKind::Conveyor {
            places,
            pitch,
            speed,
            belt,
            ..
        } => {
            value["places"] = json!(places);
            value["pitchSeconds"] = json!(pitch / speed);
            value["isStepped"] = json!(belt.is_some());
        }
        NodeKind::Buffer { capacity, .. } => value["capacity"] = json!(capacity),
        _ => {}
    }
    value
}

/// For each change: eight times the ticks since the last one, plus the number of the state. Waiting
/// for parts is shown as `waiting`.
fn state_column(
    changes: &[(f64, Activity)],
    waiting: Activity,
    ticks: impl Fn(f64) -> u64,
) -> String {
    let mut bytes = Bytes::default();
    let mut last = 0;
    for (time, state) in changes {
        let now = ticks(*time);
        let class = state_class(shown(*state, waiting));
        let number = shown_states().iter().position(|shown| *shown == class);
        bytes.push((now - last) << 3 | number.unwrap_or(0) as u64);
        last = now;
    }
    bytes.packed()
}

/// The states after those whose changes are in the columns: the width of a bin of time, the number
/// of the first bin, and by node the percentages of the states in each bin; null if there is none.
fn later_states(page: &Page<'_>) -> Value {
    let recorder = page.recorder;
    let Some(end) = recorder.states_end else {
        return Value::Null;
    };
    let mut layout = (0.0, 0);
    let nodes = 0..page.line.nodes.len();
    let columns = nodes.map(|node| {
        if recorder.states[node].is_empty() {
            return Value::Null;
        }
        let Some((bins, width)) = recorder.later_states(node) else {
            return Value::Null;
        };
        let first = (end / width) as usize;
        layout = (width, first);
        let mut bytes = Bytes::default();
        let waiting = recorder.waiting(node);
        let bins = bins.iter().skip(first);
        for bin in bins.clone() {
            let all: f64 = bin.iter().sum();
            for class in shown_states() {
                let states = bin.iter().zip(ACTIVITIES);
                let of_class =
                    states.filter(|(_, state)| state_class(shown(*state, waiting)) == class);
                let seconds: f64 = of_class.map(|(seconds, _)| seconds).sum();
                bytes.push((100.0 * seconds / all.max(f64::MIN_POSITIVE)).round() as u64);
            }
        }
        json!({ "count": bins.len(), "bytes": bytes.packed() })
    });
    let columns: Vec<Value> = columns.collect();
    json!({ "width": layout.0, "first": layout.1, "nodes": columns })
}

/// The state as which a state is shown, if waiting for parts is shown as `waiting`.
fn shown(state: Activity, waiting: Activity) -> Activity {
    if state == Activity::Starved {
        waiting
    } else {
        state
    }
}

/// For each time: the ticks since the last one.
fn times_column(times: &[f64], ticks: impl Fn(f64) -> u64) -> String {
    let mut bytes = Bytes::default();
    let mut last = 0;
    for time in times {
        let now = ticks(*time);
        bytes.push(now - last);
        last = now;
    }
    bytes.packed()
}

/// For each movement: the ticks since the last one; the number of the part; twice the number of the
/// target, plus 1 if the part enters the line; then the number of its type.
fn move_column(line: &Line, moves: &[Move], ticks: impl Fn(f64) -> u64) -> String {
    let mut bytes = Bytes::default();
    let mut last = 0;
    for movement in moves {
        let now = ticks(movement.time);
        bytes.push(now - last);
        last = now;
        bytes.push(movement.part);
        let target = match movement.to {
            Target::Finished => 0,
            Target::Rejected => 1,
            Target::Joined => 2,
            Target::Node(node) => ENDS + node as u64,
            Target::Place(place) => ENDS + line.nodes.len() as u64 + u64::from(place),
        };
        bytes.push(target << 1 | u64::from(movement.enters.is_some()));
        if let Some(kind) = movement.enters {
            bytes.push(kind as u64);
        }
    }
    bytes.packed()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use base64::Engine as _;
    use std::io::Read as _;

    /// The columns of a page, read as its script does.
    pub struct Columns {
        /// Time and part of each movement.
        pub moves: Vec<(f64, u64)>,
        /// By node: time and name of each state.
        pub states: Vec<Option<Vec<(f64, String)>>>,
    }

    /// The numbers of a column, from the first on.
    fn numbers(packed: &Value) -> impl FnMut() -> u64 {
        let engine = base64::engine::general_purpose::STANDARD;
        let compressed = engine.decode(packed["bytes"].as_str().unwrap()).unwrap();
        let mut bytes = Vec::new();
        let mut decoder = flate2::read::DeflateDecoder::new(&compressed[..]);
        decoder.read_to_end(&mut bytes).unwrap();
        let mut bytes = bytes.into_iter();
        move || {
            let mut number = 0;
            for shift in (0..).step_by(7) {
                let byte = bytes.next().unwrap();
                number |= u64::from(byte & 0x7f) << shift;
                if byte < 0x80 {
                    break;
                }
            }
            number
        }
    }

    impl Columns {
        pub fn read(document: &str) -> Self {
            let document: Value = serde_json::from_str(document).unwrap();
            let tick = document["tick"].as_f64().unwrap();
            let mut next = numbers(&document["moves"]);
            let mut ticks = 0;
            let moves = (0..document["moves"]["count"].as_u64().unwrap()).map(|_| {
                ticks += next();
                let part = next();
                if next() % 2 == 1 {
                    next();
                }
                (ticks as f64 * tick, part)
            });
            let moves = moves.collect();
            let states = document["states"].as_array().unwrap().iter().map(|column| {
                let count = column.get("count")?.as_u64()?;
                let mut next = numbers(column);
                let mut ticks = 0;
                let changes = (0..count).map(|_| {
                    let number = next();
                    ticks += number / 8;
                    let name = &document["stateNames"][(number % 8) as usize];
                    (ticks as f64 * tick, name.as_str().unwrap().to_owned())
                });
                Some(changes.collect())
            });
            Self {
                moves,
                states: states.collect(),
            }
        }
    }
}
