//! Runs of recipes on the command line: `recipe run`, on `examples/pad` and on `examples/cell`,
//! whose machines work with their station libraries.

use super::recipes::{document, text};
use crate::support::mesa::Validator;
use crate::support::{linewright, root, sandbox};
use serde_json::Value;
use std::path::Path;

fn run(folder: &Path, line: &str) -> Value {
    let (code, run) = document(folder, &format!("recipe run {line}"));
    assert_eq!(code, 0, "{line}: {run}");
    run
}

/// Runs the program with arguments that it refuses. Returns the message.
fn refused(folder: &Path, line: &str) -> String {
    let arguments: Vec<&str> = line.split_whitespace().collect();
    let output = linewright(folder, &arguments);
    assert_eq!(output.status.code(), Some(2));
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The value of the plan of the only statement of a file.
fn planned(folder: &Path, file: &str, least: &str) -> f64 {
    let (code, document) = document(folder, &format!("recipe plan {file} --least {least}"));
    assert_eq!(code, 0, "{document}");
    let entry = &document["plans"][0];
    let value = &entry["schedule"]["value"];
    let value = value
        .as_f64()
        .or_else(|| entry["plan"]["worst_case"].as_f64());
    value.expect("a value")
}

const OUTCOMES: [&str; 3] = [
    "--test b=c --test c=e",
    "--test b=c --test c=d",
    "--test b=d",
];

#[test]
fn runs_take_the_time_of_their_plan() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    for (file, how, least) in [
        ("examples/pad/hinge.lw", "lockstep", "steps"),
        ("examples/pad/times.lw", "lockstep", "steps"),
        ("examples/pad/times.lw", "timed", "time"),
    ] {
        let planned = planned(folder, file, least);
        let times = OUTCOMES.map(|outcomes| {
            let run = run(folder, &format!("{file} --execution {how} {outcomes}"));
            assert_eq!(run["execution"], how);
            assert_eq!(run["is_finished"], true);
            assert_eq!(run["planned"].as_f64(), Some(planned));
            run["makespan"].as_f64().expect("a number")
        });
        assert_eq!(times.into_iter().reduce(f64::max), Some(planned), "{how}");
        assert!(times[2] < times[0], "{times:?}");
    }
    let stored = run(folder, "examples/pad/times.lw --test b=c --test c=e");
    assert_eq!(stored["makespan"], 81.0);
    assert_eq!(stored["energy"], 8_700.0);
    let busy = stored["resources"].as_array().expect("resources").iter();
    let busy: Vec<f64> = busy
        .map(|r| r["busy"].as_f64().expect("a number"))
        .collect();
    assert_eq!(busy, [7.0, 10.0, 20.0, 8.0, 42.0]);
    let outcome = |at: usize| &stored["sections"][at]["outcome"]["transition"];
    assert_eq!(outcome(1), "b -> c when visionOk(h2)");
    assert_eq!(outcome(2), "c -> e when forceOk(h2)");
}

#[test]
fn the_random_seed_decides_tests_that_are_not_given() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let line = |seed: u32| format!("recipe run examples/pad/times.lw --seed {seed}");
    let mut texts: Vec<String> = Vec::new();
    for seed in 1..=12 {
        let (code, first) = text(folder, &line(seed));
        assert_eq!(code, 0, "{first}");
        assert_eq!(text(folder, &line(seed)), (0, first.clone()));
        texts.push(first);
    }
    texts.sort();
    texts.dedup();
    assert_eq!(texts.len(), 3, "{texts:?}");
    let message = refused(folder, "recipe run examples/pad/times.lw --test b=e");
    assert!(
        message.contains("no transition leads from `b` to `e`: its tests are b=c, b=d, c=e, c=d"),
        "{message}"
    );
}

#[test]
fn machines_work_with_their_station_libraries() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let file = "examples/cell/cell.lw";
    let planned = planned(folder, file, "time");
    let reworked = run(folder, &format!("{file} --test measured=reworked"));
    assert_eq!(reworked["makespan"].as_f64(), Some(planned));
    let resources = reworked["resources"].as_array().expect("resources");
    let machine = |name: &str| {
        let entry = resources.iter().find(|r| r["name"] == name);
        let entry = entry.expect("the resource");
        (entry["machine"].as_str(), entry["busy"].as_f64())
    };
    // The comment of the turning center says that one operation takes 94 s. The washer takes half a
    // second more for each part but the first.
    assert_eq!(machine("center"), (Some("TurningCenter"), Some(2.0 * 94.0)));
    assert_eq!(machine("washer"), (Some("PartsWasher"), Some(90.5 + 91.0)));
    assert_eq!(machine("robot").0, None);
    let built = folder.join("examples/cell/.linewright");
    let libraries = std::fs::read_dir(built).expect("a folder").count();
    assert!(libraries >= 3, "{libraries}");
    let (_, plain) = text(
        folder,
        &format!("recipe run {file} --test measured=finished"),
    );
    assert!(plain.contains("TurningCenter"), "{plain}");
}

#[test]
fn the_controller_takes_the_steps_of_the_plan() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let controller = "--coordinator controller";
    let mut steps = Vec::new();
    for outcomes in OUTCOMES {
        let line = format!("examples/pad/hinge.lw --execution lockstep {outcomes}");
        let (by_plan, by_controller) = (
            run(folder, &line),
            run(folder, &format!("{line} {controller}")),
        );
        assert_eq!(by_plan["coordinator"], "plan");
        assert_eq!(by_controller["coordinator"], "controller");
        for field in ["makespan", "planned", "is_finished", "products"] {
            assert_eq!(by_plan[field], by_controller[field], "{field} {outcomes}");
        }
        let outcomes = |run: &Value| -> Vec<Value> {
            let sections = run["sections"].as_array().expect("sections").iter();
            sections
                .map(|s| s["outcome"]["transition"].clone())
                .collect()
        };
        assert_eq!(outcomes(&by_plan), outcomes(&by_controller));
        steps.push(by_controller["makespan"].as_f64().expect("a number"));
    }
    assert_eq!(steps.into_iter().reduce(f64::max), Some(21.0));
    for seed in 1..=6 {
        let line = format!(
            "recipe run examples/pad/hinge.lw --execution lockstep --seed {seed} {controller}"
        );
        let (code, first) = text(folder, &line);
        assert_eq!(code, 0, "{first}");
        assert!(
            first.contains("in lockstep, by the controller: "),
            "{first}"
        );
        assert_eq!(text(folder, &line), (0, first));
    }
    let message = refused(
        folder,
        &format!("recipe run examples/pad/several.lw {controller}"),
    );
    assert!(
        message.contains("a controller coordinates one: leave out `--coordinator controller`"),
        "{message}"
    );
}

/// The sum of the longest durations of a timed run by the controller. A vector begins when all
/// resources have ended the one before it; a transfer begins with the side that gives.
fn sum_of_vectors(run: &Value) -> f64 {
    let sections = run["sections"].as_array().expect("sections").iter();
    let moves = sections.filter_map(|s| s["moves"].as_array()).flatten();
    let mut events: Vec<(u64, f64, f64)> = Vec::new();
    for entry in moves {
        let number = |field: &str| entry[field].as_f64().expect("a number");
        let (event, start, end) = (entry["event"].as_u64(), number("start"), number("end"));
        let event = event.expect("a number");
        match events.last_mut().filter(|e| e.0 == event) {
            Some(known) => (known.1, known.2) = (known.1.min(start), known.2.max(end)),
            None => events.push((event, start, end)),
        }
    }
    let vectors = events.chunk_by(|a, b| a.1.total_cmp(&b.1).is_eq());
    let longest = vectors.map(|v| v.iter().map(|e| e.2 - e.1).fold(0.0, f64::max));
    longest.sum()
}

#[test]
fn the_controller_lets_all_resources_end_a_vector() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let controller = "--coordinator controller";
    for outcomes in OUTCOMES {
        let line = format!("examples/pad/times.lw {outcomes}");
        let by_plan = run(folder, &line);
        let (code, by_controller) = document(folder, &format!("recipe run {line} {controller}"));
        assert!(by_controller["makespan"].as_f64() > by_plan["makespan"].as_f64());
        assert_eq!(by_controller["makespan"], sum_of_vectors(&by_controller));
        let findings = by_controller["findings"].as_array().expect("findings");
        assert!(
            findings.iter().all(|f| f["code"] == "LW612"),
            "{findings:?}"
        );
        assert_eq!(code, i32::from(!findings.is_empty()));
    }
    let file = "examples/cell/cell.lw --test measured=reworked";
    let (by_plan, by_controller) = (
        run(folder, file),
        run(folder, &format!("{file} {controller}")),
    );
    // The second measurement is shorter than planned. A plan waits for its time, a controller for
    // nothing but the vector.
    assert_eq!(by_plan["makespan"], 460.0);
    assert_eq!(by_controller["makespan"], 455.0);
    assert_eq!(by_controller["makespan"], sum_of_vectors(&by_controller));
    // The same machines have done the same work with their libraries.
    assert_eq!(by_controller["resources"], by_plan["resources"]);
    assert_eq!(run(folder, &format!("{file} {controller}")), by_controller);
    let made = format!("{file} {controller} --gantt cell.svg --performance cell.xml");
    run(folder, &made);
    let chart = std::fs::read_to_string(folder.join("cell.svg")).expect("a chart");
    assert!(chart.contains("center"));
}

#[test]
fn a_short_operation_waits_for_a_long_one_of_its_vector() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let model = "layout Cell {
    resource a at s0 {
        s0 -> s1: make in 1 s
        s1 -> s2: heat in 2 s
        s2 -> s0: drop in 1 s
        nop s0
    }
    resource b at s0 {
        s0 -> s0: make2 in 5 s, work in 5 s, drop2 in 1 s
        nop s0
    }
}

recipe Both {
    part p: Part, q: Part
    start x
    x -> y: make()(p) || make2()(q); heat(p)(p) || work(q)(q); drop(p)() || drop2(q)()
    end y
}

realize Both on Cell
";
    std::fs::write(folder.join("both.lw"), model).expect("written");
    let line = "recipe run both.lw --coordinator controller";
    let (code, steps) = document(folder, &format!("{line} --execution lockstep"));
    assert_eq!((code, steps["makespan"].as_f64()), (0, Some(3.0)));
    let (code, timed) = document(folder, line);
    assert_eq!((code, timed["makespan"].as_f64()), (1, Some(11.0)));
    // A plan does not let the resource wait, so there is none.
    assert!(timed["planned"].is_null());
    let findings = timed["findings"].as_array().expect("findings").iter();
    let messages: Vec<&str> = findings.filter_map(|f| f["message"].as_str()).collect();
    assert_eq!(
        messages,
        [
            "`a` waited from 1 s to 5 s in `s1`, where it may not",
            "`a` waited from 7 s to 10 s in `s2`, where it may not"
        ]
    );
}

#[test]
fn what_was_done_is_written_as_b2mml() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let documents = folder.join("documents");
    std::fs::create_dir(&documents).expect("a folder");
    for (file, name) in [
        ("examples/pad/times.lw --test b=c --test c=e", "hinge.xml"),
        ("examples/pad/times.lw --test b=d", "removed.xml"),
        ("examples/pad/several.lw", "several.xml"),
        ("examples/cell/cell.lw --test measured=reworked", "cell.xml"),
    ] {
        let epoch = "--epoch 2026-11-30T06:00:00";
        let made = run(
            folder,
            &format!("{file} --performance documents/{name} {epoch}"),
        );
        let bytes = std::fs::read(documents.join(name)).expect("a document");
        let text = String::from_utf8_lossy(&bytes);
        assert!(text.contains("<StartTime>2026-11-30T06:00:00Z</StartTime>"));
        let reading = linewright::b2mml::read(&bytes).expect("it is valid");
        let linewright::b2mml::Document::Performance(performance) = reading.document else {
            panic!("{name} is no performance");
        };
        let sections = made["sections"].as_array().expect("sections");
        let moves = sections.iter().filter_map(|s| s["moves"].as_array());
        let moves: Vec<&Value> = moves.flatten().collect();
        // Both sides of a transfer are one record.
        let taken = moves.iter().filter(|m| !m["part"].is_null()).count() / 2;
        assert_eq!(performance.records.len(), moves.len() - taken, "{name}");
        let last = performance.records.iter().map(|r| r.end);
        assert_eq!(last.reduce(f64::max), made["makespan"].as_f64(), "{name}");
    }
    if let Some(validator) = Validator::find(root()) {
        let (valid, reasons) = validator.valid(&documents, true);
        assert_eq!(valid.len(), 4, "{reasons}");
    }
    let message = refused(
        folder,
        "recipe run examples/pad/times.lw --execution lockstep --performance x.xml",
    );
    assert!(message.contains("--performance shows times"), "{message}");
}

#[test]
fn a_loop_without_an_end_is_left() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let model = "layout Cell {
    resource a at s {
        s -> s: make in 1 s, work in 2 s
        nop s
    }
}

recipe Loop {
    part p: Part
    start x
    x -> y: make()(p)
    y -> z when good(p)
    y -> y otherwise: work(p)(p)
    end z
    leftover p
}

realize Loop on Cell
";
    std::fs::write(folder.join("loop.lw"), model).expect("written");
    let endless = run(folder, "loop.lw --test y=y");
    assert_eq!(endless["is_finished"], false);
    // One position for each round, and the first that makes the part.
    assert_eq!(endless["makespan"].as_f64(), Some(1.0 + 100.0 * 2.0));
    let controlled = run(folder, "loop.lw --test y=y --coordinator controller");
    assert_eq!(controlled["is_finished"], false);
    assert_eq!(controlled["makespan"], endless["makespan"]);
    let numbers = endless["sections"].as_array().expect("sections").iter();
    let numbers: Vec<&str> = numbers.filter_map(|s| s["number"].as_str()).collect();
    assert_eq!(numbers[..3], ["1", "2", "3"]);
    let (code, plain) = text(folder, "recipe run loop.lw --test y=y");
    assert_eq!(code, 0);
    assert!(
        plain.contains("ended after 100 positions, in a loop of the recipe"),
        "{plain}"
    );
}
