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
