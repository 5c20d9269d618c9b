//! The library as another program uses it: `engine::project`, from files to verdicts, station
//! libraries and runs.

use linewright::engine::pipeline::Verdict;
use linewright::engine::project::{Project, ProjectError};
use linewright::engine::simulation::SimulationOptions;
use linewright::line::{Count, Options};
use std::path::Path;

fn example() -> Project {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/loader/line.lw");
    Project::open(&path.to_string_lossy()).expect("a sound file")
}

fn codes(refused: &ProjectError) -> Vec<&str> {
    refused.0.iter().map(|f| f.code.id).collect()
}

#[test]
fn contracts_are_checked_in_the_order_of_the_library() {
    let project = example();
    let checked = project.check();
    assert_eq!(checked.len(), project.library().contracts.len());
    assert!(!checked.is_empty());
    for contract in checked {
        assert_eq!(contract.verdict, Verdict::Realizable);
        assert!(contract.controller.is_some());
    }
}

#[test]
fn a_machine_is_built_and_a_line_is_run() {
    let project = example();
    let folder = tempfile::tempdir().expect("a folder");
    let machine = project.machine("Loader").expect("it is declared");
    let files = project.build(machine, folder.path()).expect("it is built");
    assert!(files.iter().all(|f| f.is_file()), "{files:?}");

    let line = project.line("Loading").expect("it is declared");
    let how = SimulationOptions {
        speeds: std::collections::BTreeMap::new(),
        is_study: false,
        options: Options {
            parts: Some(5),
            ..Options::default()
        },
        find_warm_up: false,
        replications: Count::Fixed(2),
        rebuild: false,
        ..SimulationOptions::default()
    };
    let run = project.run(line, folder.path(), &how).expect("it runs");
    let products: Vec<u64> = run.traces.iter().map(|t| t.products).collect();
    assert_eq!(products, [5, 5]);
    assert_eq!(run.replications.seeds.len(), 2);
}

/// A machine whose controller takes a step before and one after an action of 0.8 s.
const PRESS: &str = "import std.coordination.single

contract Ram {
    input requested: bool
    output finished: bool
    guarantee reports: always (finished <-> requested)
}
machine Press {
    step 1 s
    coordinator lead: Single {
        job = operation = press
        executed = ram.finished
    }
    action ram: Ram when lead.command {
        requested = lead.command
        time 0.8 s
    }
    operation press: ram
    done lead.done
}
line Hall {
    part Plate
    source stack: Plate every 10 s
    station press: Press { perform press on Plate }
    sink tray
    route Plate: stack -> press -> tray
}
";

/// The compiled library says how much of its time is control, and `step 0 s` makes that none.
#[test]
fn control_takes_the_time_that_the_machine_declares() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("press.lw");
    let how = SimulationOptions {
        options: Options {
            parts: Some(10),
            ..Options::default()
        },
        find_warm_up: false,
        replications: Count::Fixed(1),
        speeds: std::collections::BTreeMap::new(),
        is_study: false,
        rebuild: false,
        ..SimulationOptions::default()
    };
    for (step, control) in [("step 1 s", 2.0), ("step 0 s", 0.0)] {
        std::fs::write(&file, PRESS.replace("step 1 s", step)).expect("a written file");
        let project = Project::open(&file.to_string_lossy()).expect("a sound file");
        let line = project.line("Hall").expect("it is declared");
        let run = project.run(line, folder.path(), &how).expect("it runs");
        let trace = &run.traces[0];
        let press = &trace.stations[0];
        let work = press.work_time.expect("it has worked");
        assert!((work.control_seconds - control).abs() < 1e-9, "{work:?}");
        assert!((work.action_seconds() - 0.8).abs() < 1e-9, "{work:?}");
        assert!(
            (press.busy_seconds - 10.0 * work.seconds).abs() < 1e-9,
            "{press:?}"
        );
        assert!(
            (trace.lead_time.mean - work.seconds).abs() < 1e-9,
            "{trace:?}"
        );
    }
}

#[test]
fn what_is_wrong_is_a_value() {
    let missing = Project::open("no/such/file.lw").expect_err("it is not there");
    assert_eq!(codes(&missing), ["LW001"]);
    assert!(
        missing.to_string().starts_with("LW001: no/such/file.lw"),
        "{missing}"
    );

    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("lost.lw");
    let text = "import std.coordination.single

contract Lost {
    input requested: bool
    output finished: bool
    guarantee report: always (finished <-> requested)
    guarantee stuck: always not finished
}
machine M {
    step 1 s
    coordinator c: Single {
        job = operation = go
        executed = a.finished
    }
    action a: Lost when c.command {
        requested = c.command
        time 1 s
    }
    operation go: a
    done c.done
}
";
    std::fs::write(&file, text).expect("a file");
    let project = Project::open(&file.to_string_lossy()).expect("it can be read");
    let machine = project.machine("M").expect("it is declared");
    let refused = project
        .build(machine, folder.path())
        .expect_err("it cannot be built");
    assert_eq!(codes(&refused), ["LW203"]);
    let lost = project
        .library()
        .contracts
        .iter()
        .position(|c| c.name == "Lost");
    let checked = project.check();
    assert_eq!(
        checked[lost.expect("it is declared")].verdict,
        Verdict::Unrealizable
    );
}

/// A plain conveyor takes a part in every step of pitch/speed, one with the library's `Convey` in
/// every second step, as `docs/reference/language/lines.md` says.
#[test]
fn a_conveyor_with_convey_carries_half_as_much() {
    let folder = tempfile::tempdir().expect("a folder");
    let products = |conveyor: &str| {
        let text = format!(
            "
import std.handling.convey
machine Belt {{
    signal load: bool = false
    signal unload_ready: bool = true
    action belt: Convey(places = 6)
}}
line Conveying {{
    part Plate
    product Plate
    source rack: Plate every 1 s
    conveyor belt{conveyor} pitch 0.5 m speed 0.2 m/s
    sink box
    route Plate: rack -> belt -> box
    limit 1 h
}}
"
        );
        std::fs::write(folder.path().join("line.lw"), text).expect("a file");
        let arguments = ["run", "line.lw", "--format", "json"];
        let output = crate::support::linewright(folder.path(), &arguments);
        let document: serde_json::Value = serde_json::from_slice(&output.stdout)
            .unwrap_or_else(|_| panic!("no document: {output:?}"));
        document["products"].as_u64().expect("a number")
    };
    let (plain, contracted) = (products(" places 6"), products(": Belt"));
    assert!((1430..=1440).contains(&plain), "{plain}");
    assert!((715..=720).contains(&contracted), "{contracted}");
}
