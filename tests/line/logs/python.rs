//! Other tools read the logs: pyarrow and pandas compute figures from them, and pm4py discovers the
//! routes of the line.

use super::logged;
use crate::models::plant_of;
use crate::support::{python_with, root};
use linewright::event_log::Format;
use linewright::line::{Options, Plant};
use serde_json::Value;
use std::collections::BTreeSet;
use std::process::Command;

/// A line with a join, rework, rejects, failures, setup and shifts.
const LINE: &str = "line L {
    part Body { property bad: bool = false }
    part Cap
    part Box from 1 Body, 1 Cap
    product Box
    source bodies: Body every exponential(20 s)
    source caps: Cap every 15 s
    buffer queue capacity 5
    buffer tray capacity 4
    station mill {
        takes gamma(2, 5 s)
        power 300 W
        defect on Body probability 20 %: bad becomes true
    }
    station wash { takes 6 s failures mtbf 10 min mttr 30 s }
    station press { takes 12 s }
    sink out
    sink scrap rejects
    shift 0 h to 3 h break 1 h to 1.25 h
    route Body: bodies -> queue -> mill
    route Body: mill -> scrap when bad
    route Body: mill -> wash otherwise
    route Body: wash -> press
    route Cap: caps -> tray -> press
    route Box: press -> out
}";

fn plant() -> Plant {
    plant_of(
        LINE,
        Options {
            until: Some(4.0 * 3600.0),
            warm_up: 600.0,
            ..Options::default()
        },
    )
}

#[test]
fn other_tools_read_the_logs() {
    let needs = ["pandas", "pyarrow", "pm4py"];
    let found = needs.map(|need| python_with(need, need));
    let [Some(python), Some(_), Some(_)] = found else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let mut trace = None;
    for (name, format) in [
        ("run.csv", Format::Csv),
        ("run.parquet", Format::Parquet),
        ("run.ocel.json", Format::Ocel),
        ("run.xes", Format::Xes),
    ] {
        let (run, bytes) = logged(&mut plant(), format);
        std::fs::write(folder.path().join(name), bytes).expect("a file");
        trace = Some(run);
    }
    let trace = trace.expect("a trace");
    let output = Command::new(&python)
        .arg("-B")
        .arg(root().join("tests/line/logs/read.py"))
        .arg(folder.path())
        .output()
        .expect("Python starts");
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{words}");
    let answer = String::from_utf8_lossy(&output.stdout);
    let answer: Value = serde_json::from_str(answer.lines().last().expect("a line")).expect("JSON");
    let near = |ours: f64, theirs: &Value, what: &str| {
        let theirs = theirs.as_f64().unwrap_or(0.0);
        assert!(
            (ours - theirs).abs() < 1e-9 * ours.max(1.0),
            "{what}: {ours}, {theirs}"
        );
    };
    for station in &trace.stations {
        let s = station.shares;
        for (state, share) in [
            ("busy", s.busy),
            ("blocked", s.blocked),
            ("starved", s.starved),
            ("failed", s.failed),
            ("setup", s.setup),
        ] {
            let what = format!("{} {state}", station.name);
            near(share, &answer["shares"][&what], &what);
        }
    }
    near(trace.wip.mean, &answer["wip"], "WIP");
    near(trace.joules, &answer["joules"], "energy");
    assert_eq!(answer["finished"], trace.products);
    assert!(trace.products > 100 && !trace.rejects.is_empty());
    let edges = |format: &str, kind: &str| -> BTreeSet<(String, String)> {
        let edges = answer[format][kind].as_array().expect(kind).iter();
        let name = |edge: &Value, end: usize| edge[end].as_str().expect("a name").to_owned();
        edges.map(|edge| (name(edge, 0), name(edge, 1))).collect()
    };
    let pairs = |edges: &[(&str, &str)]| -> BTreeSet<(String, String)> {
        let edges = edges.iter();
        edges
            .map(|(a, b)| ((*a).to_owned(), (*b).to_owned()))
            .collect()
    };
    let body = [
        ("bodies", "queue"),
        ("queue", "mill"),
        ("mill", "scrap"),
        ("mill", "wash"),
    ];
    let cap = [("caps", "tray")];
    let product = [("press", "out")];
    assert_eq!(edges("xes", "Body"), pairs(&body));
    assert_eq!(edges("xes", "Cap"), pairs(&cap));
    assert_eq!(edges("xes", "Box"), pairs(&product));
    let with = |edges: &[(&str, &str)], more| pairs(&[edges, &[more]].concat());
    assert_eq!(edges("ocel", "Body"), with(&body, ("wash", "join press")));
    assert_eq!(edges("ocel", "Cap"), with(&cap, ("tray", "join press")));
    assert_eq!(
        edges("ocel", "Box"),
        with(&product, ("join press", "press"))
    );
}
